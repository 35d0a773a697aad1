#include <insonify/motion.hpp>
#include <insonify/scanner.hpp>
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

enum class measured { scan, labels };

/// A scanner that is kept, on a body at rest or one that four maps deform anew at each frame; not the deformation itself.
/// Labels are found anew, since lines are interpolated.
void scanned(benchmark::State& state, measured what, bool deforms) {
    scene body = bench::chain::organ();
    const pose at = bench::chain::at;
    const auto probe = bench::chain::probe;
    scanner<std::remove_cv_t<decltype(probe)>> machine{
        probe, {.depth = 120_mm, .planes = 5, .interpolates_lines = what == measured::labels}};
    float time = 0.1F;
    for (auto _ : state) {
        state.PauseTiming();
        time += 0.03F;
        if (deforms)
            body.deform(exec::unseq, compose(indentation{.at = at, .depth = 1_mm},
                                             breathing{.centre = at.point({0, 0, 60_mm}), .time = time},
                                             pulsation{.from = at.translation, .to = at.point({0, 1, 0}), .time = time},
                                             needle_drag{.entry = at.translation, .tip = at.point({0, 0, 30_mm})}));
        if (what == measured::labels) machine.scan(exec::unseq, body, at);
        state.ResumeTiming();
        if (what == measured::scan)
            benchmark::DoNotOptimize(machine.scan(exec::unseq, body, at));
        else
            benchmark::DoNotOptimize(machine.labels(exec::unseq, body));
    }
}

} // namespace

BENCHMARK(by_beams)->Unit(benchmark::kMillisecond);
BENCHMARK(by_slice)->Unit(benchmark::kMillisecond);
BENCHMARK(by_pixels)->Unit(benchmark::kMillisecond);
BENCHMARK(physical_lines)->Unit(benchmark::kMillisecond);
BENCHMARK(by_paths)->Unit(benchmark::kMillisecond);
BENCHMARK(labels)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scanned, at_rest, measured::scan, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scanned, deformed, measured::scan, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scanned, labels_at_rest, measured::labels, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scanned, labels_deformed, measured::labels, true)->Unit(benchmark::kMillisecond);
