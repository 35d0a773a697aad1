#include <insonify/bvh/bvh.hpp>
#include "support/meshes.hpp"
#include "support/rays.hpp"
#include <algorithm>
#include <benchmark/benchmark.h>
#include <limits>

/// The tree: built, moved, asked. Where an argument says `threads`, it is their number; else one thread.
namespace {

using namespace insonify;

auto threads(const benchmark::State& state) { return exec::par.threads(static_cast<std::uint32_t>(state.range(0))); }

void tell_size(benchmark::State& state, const bvh_statistics& told) {
    const auto primitives = static_cast<double>(told.primitives);
    state.counters["bytes_a_triangle"] = static_cast<double>(told.bytes) / primitives;
    state.counters["cost"] = told.cost;
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(told.primitives));
}

// The Builder's own trees.
template <class Builder>
void build(benchmark::State& state) {
    const mesh m = bench::organ_82k();
    bvh<mesh_view, simd_width, Builder> tree{threads(state), m};
    for (auto _ : state) tree.rebuild(threads(state));
    tell_size(state, tree.statistics());
}
void refit(benchmark::State& state, const mesh& m) {
    bvh tree{exec::par, m};
    for (auto _ : state) tree.refit(threads(state));
    tell_size(state, tree.statistics());
}

// Builds over ten million triangles; the memory they take and that of the whole program at its peak.
void build_ten_million(benchmark::State& state) {
    const mesh m = bench::soup(10'000'000);
    for (auto _ : state) {
        const bvh tree{threads(state), m};
        tell_size(state, tree.statistics());
    }
}

template <class Ask>
void ask(benchmark::State& state, const std::vector<ray>& rays, const mesh& m, const Ask& all) {
    const bvh tree{exec::par, m};
    for (auto _ : state) all(tree, rays);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}

const auto closest_together = [](const auto& tree, const std::vector<ray>& rays) {
    static std::vector<hit> hits;
    hits.resize(rays.size());
    tree.closest(exec::unseq, rays, hits);
};
const auto closest_alone = [](const auto& tree, const std::vector<ray>& rays) {
    for (const ray& r : rays) benchmark::DoNotOptimize(tree.closest(r));
};
const auto any_together = [](const auto& tree, const std::vector<ray>& rays) {
    static std::vector<std::uint8_t> met;
    met.resize(rays.size());
    tree.any(exec::unseq, rays, met);
};
const auto any_alone = [](const auto& tree, const std::vector<ray>& rays) {
    for (const ray& r : rays) benchmark::DoNotOptimize(tree.any(r));
};
const auto all_together = [](const auto& tree, const std::vector<ray>& rays) {
    static std::vector<std::vector<hit>> hits;
    hits.resize(rays.size());
    tree.all(exec::unseq, rays, hits);
};
const auto all_alone = [](const auto& tree, const std::vector<ray>& rays) {
    static std::vector<hit> hits;
    for (const ray& r : rays) tree.all(r, hits);
};

// Rays that begin nowhere: each is a miss at once.
std::vector<ray> nan_rays() {
    std::vector<ray> rays = bench::fan_rays();
    for (ray& r : rays) r.origin.x = std::numeric_limits<float>::quiet_NaN();
    return rays;
}

void on_one_thread_and_two(benchmark::internal::Benchmark* one) {
    one->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
}

} // namespace

BENCHMARK(build<build_sah>)->Apply(on_one_thread_and_two);
BENCHMARK(build<build_morton>)->Apply(on_one_thread_and_two);
BENCHMARK_CAPTURE(refit, small, bench::organ_82k())->Apply(on_one_thread_and_two);
BENCHMARK_CAPTURE(refit, large, bench::organ_1_3m())->Apply(on_one_thread_and_two);
BENCHMARK(build_ten_million)->ArgName("threads")->Arg(2)->Iterations(1)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ask, fan_closest_together, bench::fan_rays(), bench::organ_82k(), closest_together);
BENCHMARK_CAPTURE(ask, fan_closest_alone, bench::fan_rays(), bench::organ_82k(), closest_alone);
BENCHMARK_CAPTURE(ask, fan_any_together, bench::fan_rays(), bench::organ_82k(), any_together);
BENCHMARK_CAPTURE(ask, fan_any_alone, bench::fan_rays(), bench::organ_82k(), any_alone);
BENCHMARK_CAPTURE(ask, fan_all_together, bench::fan_rays(), bench::organ_82k(), all_together);
BENCHMARK_CAPTURE(ask, fan_all_alone, bench::fan_rays(), bench::organ_82k(), all_alone);
BENCHMARK_CAPTURE(ask, large_fan_closest_together, bench::fan_rays(), bench::organ_1_3m(), closest_together);
BENCHMARK_CAPTURE(ask, large_fan_closest_alone, bench::fan_rays(), bench::organ_1_3m(), closest_alone);
BENCHMARK_CAPTURE(ask, incoherent_closest_together, bench::incoherent_rays(), bench::organ_82k(), closest_together);
BENCHMARK_CAPTURE(ask, incoherent_closest_alone, bench::incoherent_rays(), bench::organ_82k(), closest_alone);
BENCHMARK_CAPTURE(ask, incoherent_any_together, bench::incoherent_rays(), bench::organ_82k(), any_together);
BENCHMARK_CAPTURE(ask, incoherent_any_alone, bench::incoherent_rays(), bench::organ_82k(), any_alone);
BENCHMARK_CAPTURE(ask, nan_closest_together, nan_rays(), bench::organ_82k(), closest_together);
BENCHMARK_CAPTURE(ask, nothing_closest_alone, bench::fan_rays(), mesh{}, closest_alone);
