#include <insonify/insonify.hpp>
#include "../support/contest.hpp"
#include "../support/meshes.hpp"
#include <cstdio>

/// What the aperture costs: `b_mode` of 5 planes with the default number of directions and with a single one, by turns, on one
/// thread. The rest of the frame is the same, but for the speckle that shadows leave out.
namespace {

using namespace insonify;

template <class Probe>
void measure(const char* what, const scene& body, const Probe& probe, const pose& at) {
    const b_mode_settings settings{.depth = 100_mm, .size = {512, 512}};
    const scanner<Probe> machine{probe, settings};
    scanner<Probe> machines[2] = {machine, machine};
    std::vector<bench::contender> both(2);
    for (std::size_t i = 0; i < 2; ++i) {
        if (i == 0) machines[i].how.directions = 1;
        both[i].work = [&, i] { machines[i].scan(exec::unseq, body, at); };
    }
    bench::run(both, {.seconds = 6});
    const double without = both[0].median(), with = both[1].median();
    std::printf("%-28s %6.1f ms without, %6.1f ms with the aperture: %.2f\n", what, 1e3 * without, 1e3 * with,
                with / without);
}

} // namespace

int main() {
    const convex_array convex{};
    const pose before{.translation = {0, 0, -52_mm}};
    scene organ{tissue::fat}, shells{tissue::fat}, pieces{tissue::fat};
    organ.add(bench::make_organ(5), tissue::liver);
    for (int shell = 18; shell >= 1; --shell) // a line crosses 36 surfaces
        shells.add(make_sphere({0, 0, 0}, 45_mm * static_cast<float>(shell) / 18, 4),
                   shell % 2 == 0 ? tissue::liver : tissue::muscle);
    for (std::uint32_t i = 0; i < 24; ++i) // and bones, which cast shadows
        pieces.add(
            make_sphere({12_mm * (static_cast<float>(i % 6) - 2.5F), 0, 20_mm * static_cast<float>(i / 6) - 40_mm},
                        4_mm, 4),
            i % 5 == 0 ? tissue::bone : tissue::liver);
    for (scene* const each : {&organ, &shells, &pieces}) each->build(exec::par);
    measure("an organ, convex array", organ, convex, before);
    measure("24 pieces, convex array", pieces, convex, before);
    measure("24 pieces, linear array", pieces, linear_array{.frequency = 5_MHz}, before);
    measure("24 pieces, phased array", pieces, phased_array{}, before);
    measure("36 surfaces, convex array", shells, convex, before);
}
