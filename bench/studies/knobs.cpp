#include <insonify/insonify.hpp>
#include "../support/contest.hpp"
#include <cstdio>

/// What it costs to turn a knob at every frame: a scanner whose knob turns, and scanners of which each rests at one of the
/// knob's values, by turns.
namespace {

using namespace insonify;

template <class Probe, class Turn>
void measure(const char* knob, const scene& body, const scanner<Probe>& machine, const Turn& turn) {
    constexpr std::size_t values = 4;
    scanner<Probe> turned = machine;
    std::vector<scanner<Probe>> resting(values, machine);
    for (std::size_t i = 0; i < values; ++i) turn(resting[i], static_cast<float>(i));
    std::vector<bench::contender> both(2);
    std::size_t rests = 0, turns = 0;
    both[0].work = [&] { resting[rests++ % values].scan(exec::par_unseq, body, pose{}); };
    both[1].work = [&] {
        turn(turned, static_cast<float>(turns++ % values));
        turned.scan(exec::par_unseq, body, pose{});
    };
    bench::run(both, {.seconds = 4});
    const double at_rest = both[0].median(), moving = both[1].median();
    std::printf("%-22s %6.1f ms at rest, %6.1f ms turned at every frame: %.2f\n", knob, 1e3 * at_rest, 1e3 * moving,
                moving / at_rest);
}

} // namespace

int main() {
    scene body{tissue::muscle};
    body.add(make_cylinder({0, -30_mm, 18_mm}, {0, 30_mm, 18_mm}, 4_mm, 64), tissue::blood);
    body.add(make_sphere({8_mm, 0, 20_mm}, 5_mm, 5), tissue::fat);
    body.build(exec::par);
    const auto all = [&](const char* what, const scanner<linear_array>& machine) {
        std::printf("%s\n", what);
        measure("  gain", body, machine, [](auto& m, float value) { m.settings.gain_db = value; });
        measure("  depth", body, machine, [](auto& m, float value) { m.settings.depth = 40_mm + value * 0.1_mm; });
        measure("  focus", body, machine, [](auto& m, float value) { m.probe.focus = 15_mm + value * 1_mm; });
        measure("  frequency", body, machine,
                [](auto& m, float value) { m.probe.frequency = 7.5_MHz - value * 0.01_MHz; });
        measure("  picture's width", body, machine, [](auto& m, float value) {
            m.settings.size = {500 + static_cast<std::uint32_t>(value), 0};
        });
    };
    scanner machine{presets::nerve_block.probe, presets::nerve_block.settings};
    all("nerve block: 256 lines, 40 mm, 7 planes", machine);
    machine.settings.planes = 1;
    all("one plane", machine);
}
