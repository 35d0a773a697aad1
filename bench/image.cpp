#include "support/chain_scene.hpp"
#include <benchmark/benchmark.h>

/// From lines to pixels: 256 lines of 4096 samples, 500 x 500; the argument is the number of threads.
namespace {

using namespace insonify;

auto threads(const benchmark::State& state) {
    return exec::par_unseq.threads(static_cast<std::uint32_t>(state.range(0)));
}

void map_of_probe(benchmark::State& state) {
    for (auto _ : state)
        benchmark::DoNotOptimize(
            make_scan_map(threads(state), bench::chain::probe, bench::chain::scan, bench::chain::picture));
    state.SetItemsProcessed(state.iterations() * 500 * 500);
}
void conversion(benchmark::State& state) {
    const scan_lines lines{bench::chain::probe.lines, bench::chain::scan.samples, bench::chain::scan.depth};
    const scan_map map = make_scan_map(exec::par, bench::chain::probe, bench::chain::scan, bench::chain::picture);
    image seen;
    for (auto _ : state) seen = scan_convert(threads(state), lines, map, std::move(seen));
    state.SetItemsProcessed(state.iterations() * 500 * 500);
}

} // namespace

BENCHMARK(map_of_probe)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(conversion)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
