#include <insonify/insonify.hpp>
#include "../support/contest.hpp"
#include <cmath>
#include <cstdio>
#include <utility>

/// What the levels of `b_mode_settings::quality_level` give up and gain: frames a second of one core at 128 x 128 and 256 x 256
/// pixels, by turns, what is traced, and the mean level of the picture beside that of the full one.
namespace {

using namespace insonify;

constexpr std::pair<b_mode_settings::quality_level, const char*> levels[] = {
    {b_mode_settings::quality_level::full, "full"},
    {b_mode_settings::quality_level::fast, "fast"},
    {b_mode_settings::quality_level::draft, "draft"}};

// Mean level of a picture's field of view, dB.
template <class Probe>
double mean_level(const scanner<Probe>& machine) {
    double sum = 0;
    for (const float brightness : machine.lines().values) sum += static_cast<double>(brightness);
    return machine.settings.dynamic_range_db * sum / static_cast<double>(machine.lines().values.size());
}

template <class Probe>
void measure(const char* what, const scene& body, const Probe& probe, b_mode_settings settings) {
    std::printf("%s\n", what);
    std::vector<scanner<Probe>> machines;
    for (const std::uint32_t side : {128U, 256U})
        for (const auto& level : levels) {
            settings.size = {side, side};
            settings.quality = level.first;
            machines.emplace_back(probe, settings);
        }
    std::vector<bench::contender> contenders(machines.size());
    for (std::size_t i = 0; i < machines.size(); ++i)
        contenders[i].work = [&body, &machine = machines[i]] {
            const auto moved = static_cast<float>(machine.settings.frame++ % 100);
            machine.scan(exec::unseq, body, {.translation = {0, 0.2_mm * moved, 0}});
        };
    bench::run(contenders, {.seconds = 20});
    for (std::size_t i = 0; i < machines.size(); ++i) {
        scanner<Probe>& machine = machines[i];
        const std::size_t full = i - i % std::size(levels);
        for (scanner<Probe>* each : {&machine, &machines[full]}) each->scan(exec::unseq, body, pose{});
        const b_mode_sampling traced = sampling_of(probe, machine.settings);
        std::printf(
            "  %-5s %3u: %6.1f frames/s, %5.2f times full; %u looks of %u lines of %u samples, %u planes; %+.1f dB\n",
            levels[i % std::size(levels)].second, machine.settings.size.x, 1 / contenders[i].median(),
            contenders[full].median() / contenders[i].median(), traced.looks, traced.lines, traced.samples,
            traced.planes, mean_level(machine) - mean_level(machines[full]));
    }
}

} // namespace

int main() {
    scene body{tissue::muscle};
    body.add(make_sphere({6_mm, 0, 30_mm}, 8_mm, 5), tissue::bone);
    body.add(make_cylinder({-9_mm, -60_mm, 17_mm}, {-9_mm, 60_mm, 17_mm}, 4_mm, 64), tissue::blood);
    body.build(exec::par);
    measure("linear array, defaults", body, linear_array{}, {});
    measure("linear array, 50 mm", body, linear_array{}, {.depth = 50_mm});
    measure("convex array, 160 mm", body, convex_array{}, {.depth = 160_mm});
    measure("phased array, 160 mm", body, phased_array{}, {.depth = 160_mm});
    measure("presets::nerve_block", body, presets::nerve_block.probe, presets::nerve_block.settings);
}
