#include "support/chain_scene.hpp"
#include <benchmark/benchmark.h>

/// The stages from echoes to decibels, on 256 lines of 4096 samples; the argument is the number of threads.
namespace {

using namespace insonify;

iq_lines noise() {
    iq_lines lines{bench::chain::probe.lines, bench::chain::scan.samples, bench::chain::scan.depth};
    for (std::size_t i = 0; i < lines.values.size(); ++i) lines.values[i] = hash_normal(1, i);
    return lines;
}
auto threads(const benchmark::State& state) {
    return exec::par_unseq.threads(static_cast<std::uint32_t>(state.range(0)));
}
void count_samples(benchmark::State& state) {
    state.SetItemsProcessed(state.iterations() * bench::chain::probe.lines * bench::chain::scan.samples);
}

void convolve_lines(benchmark::State& state) {
    iq_lines lines = noise();
    convolver own;
    for (auto _ : state) lines = own.convolve(threads(state), std::move(lines), pulse{}, bench::chain::probe);
    count_samples(state);
}
void convolve_with_side_lobes(benchmark::State& state) {
    iq_lines lines = noise();
    convex_array probe = bench::chain::probe;
    probe.side_lobes = 0.047F;
    convolver own;
    for (auto _ : state) lines = own.convolve(threads(state), std::move(lines), pulse{}, probe);
    count_samples(state);
}
void envelope_of_iq(benchmark::State& state) {
    const iq_lines iq = noise();
    scan_lines lines;
    for (auto _ : state) lines = envelope(threads(state), iq, std::move(lines));
    count_samples(state);
}
void envelope_of_rf(benchmark::State& state) {
    const scan_lines rf = to_rf(exec::par, noise(), bench::chain::probe.frequency);
    for (auto _ : state) benchmark::DoNotOptimize(envelope(threads(state), rf));
    count_samples(state);
}
void gain(benchmark::State& state) {
    scan_lines lines = envelope(exec::par, noise());
    for (auto _ : state) lines = tgc(threads(state), std::move(lines), bench::chain::probe.frequency);
    count_samples(state);
}
void compression(benchmark::State& state) {
    scan_lines lines = envelope(exec::par, noise());
    for (auto _ : state) lines = log_compress(threads(state), std::move(lines));
    count_samples(state);
}

} // namespace

BENCHMARK(convolve_lines)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(convolve_with_side_lobes)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(envelope_of_iq)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(envelope_of_rf)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(gain)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(compression)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
