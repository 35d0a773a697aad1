#include <insonify/acoustics/tissue.hpp>
#include <insonify/scene/scene.hpp>
#include "support/meshes.hpp"
#include <benchmark/benchmark.h>

/// What a frame of a moving scene costs before anything is traced: 82k triangles; the argument is the number of threads.
namespace {

using namespace insonify;

auto threads(const benchmark::State& state) { return exec::par.threads(static_cast<std::uint32_t>(state.range(0))); }

void build(benchmark::State& state) {
    scene body{tissue::fat};
    body.add(bench::organ_82k(), tissue::liver);
    for (auto _ : state) body.build(threads(state));
}
void update_of_moved(benchmark::State& state) {
    scene body{tissue::fat};
    const object_id organ = body.add(bench::organ_82k(), tissue::liver);
    body.build(exec::par);
    float scale = 1.001F;
    for (auto _ : state) {
        for (vec3& p : body.positions(organ)) p *= scale;
        scale = 1 / scale;
        body.update(threads(state));
    }
}
void place(benchmark::State& state) {
    scene body{tissue::fat};
    const object_id organ = body.add(bench::organ_82k(), tissue::liver);
    body.build(exec::par);
    for (auto _ : state) body.place(organ, {.translation = {1_mm, 0, 0}});
}
void copy(benchmark::State& state) {
    scene body{tissue::fat};
    body.add(bench::organ_82k(), tissue::liver);
    body.build(exec::par);
    for (auto _ : state) benchmark::DoNotOptimize(scene{body});
}

} // namespace

BENCHMARK(build)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(update_of_moved)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(place);
BENCHMARK(copy)->Unit(benchmark::kMillisecond);
