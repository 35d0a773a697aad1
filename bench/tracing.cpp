#include "support/chain_scene.hpp"
#include <benchmark/benchmark.h>

/// The tracers on one frame of an organ: 256 lines to 120 mm; one thread.
namespace {

using namespace insonify;

template <class Trace>
void frame(benchmark::State& state, const Trace& trace_frame) {
    const scene body = bench::chain::organ();
    for (auto _ : state) benchmark::DoNotOptimize(trace_frame(body));
    state.SetItemsProcessed(state.iterations() * bench::chain::probe.lines);
}
void by_beams(benchmark::State& state) {
    frame(state, [](const scene& body) {
        return trace(exec::unseq, body, bench::chain::probe, bench::chain::at, law2011{},
                     {.depth = 120_mm, .samples = 512}, straight_lines{line_search::rays});
    });
}
void by_slice(benchmark::State& state) {
    frame(state, [](const scene& body) {
        return trace(exec::unseq, body, bench::chain::probe, bench::chain::at, law2011{},
                     {.depth = 120_mm, .samples = 512}, straight_lines{line_search::slices});
    });
}
void by_pixels(benchmark::State& state) {
    frame(state, [](const scene& body) {
        return trace_pixels(exec::unseq, body, bench::chain::probe, bench::chain::at, law2011{},
                            {.depth = 120_mm, .samples = 512});
    });
}
void physical_lines(benchmark::State& state) {
    frame(state, [](const scene& body) {
        return trace(exec::unseq, body, bench::chain::probe, bench::chain::at, physical<>{}, bench::chain::scan);
    });
}
void by_paths(benchmark::State& state) {
    frame(state, [](const scene& body) {
        return trace(exec::unseq, body, bench::chain::probe, bench::chain::at, physical<>{},
                     {.depth = 120_mm, .samples = 2048}, paths{});
    });
}
void labels(benchmark::State& state) {
    frame(state, [](const scene& body) {
        return label(exec::unseq, body, bench::chain::probe, bench::chain::at, {.depth = 120_mm, .samples = 512});
    });
}

} // namespace

BENCHMARK(by_beams)->Unit(benchmark::kMillisecond);
BENCHMARK(by_slice)->Unit(benchmark::kMillisecond);
BENCHMARK(by_pixels)->Unit(benchmark::kMillisecond);
BENCHMARK(physical_lines)->Unit(benchmark::kMillisecond);
BENCHMARK(by_paths)->Unit(benchmark::kMillisecond);
BENCHMARK(labels)->Unit(benchmark::kMillisecond);
