#include <insonify/core/units.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/line_fan.hpp>
#include <benchmark/benchmark.h>

/// What scan conversion asks a probe for each pixel, and what slices ask once a frame.
namespace {

using namespace insonify;

constexpr convex_array probe{.lines = 256};

void place_of_a_point(benchmark::State& state) {
    float x = 0;
    for (auto _ : state) {
        x = x < 40_mm ? x + 0.01_mm : -40_mm;
        benchmark::DoNotOptimize(probe.locate({x, 50_mm}));
    }
    state.SetItemsProcessed(state.iterations());
}
void beam_of_a_line(benchmark::State& state) {
    float line = 0;
    for (auto _ : state) {
        line = line < 255 ? line + 0.3F : 0;
        benchmark::DoNotOptimize(probe.beam(line));
    }
    state.SetItemsProcessed(state.iterations());
}
void fan_of_all_lines(benchmark::State& state) {
    detail::line_fan fan;
    for (auto _ : state) benchmark::DoNotOptimize(fan.assign(probe));
    state.SetItemsProcessed(state.iterations() * probe.lines);
}

} // namespace

BENCHMARK(place_of_a_point);
BENCHMARK(beam_of_a_line);
BENCHMARK(fan_of_all_lines)->Unit(benchmark::kMicrosecond);
