#include <insonify/geometry/repair.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/geometry/triangle.hpp>
#include <insonify/geometry/validate.hpp>
#include "support/meshes.hpp"
#include "support/rays.hpp"
#include <benchmark/benchmark.h>

/// The exact triangle test, one by one; looking over a mesh of 82k triangles; mending one of 328k that has many holes.
namespace {

using namespace insonify;

void triangle_test(benchmark::State& state) {
    const mesh organ = bench::make_organ(3);
    const mesh_view surface{organ};
    const std::vector<ray> rays = bench::fan_rays(1, 64);
    std::size_t i = 0;
    for (auto _ : state) {
        const sheared_ray r{rays[i++ % rays.size()]};
        for (std::size_t k = 0; k < surface.size(); ++k) benchmark::DoNotOptimize(intersect(r, surface[k]));
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(surface.size()));
}
void validation(benchmark::State& state) {
    const mesh organ = bench::organ_82k();
    for (auto _ : state) benchmark::DoNotOptimize(validate(organ));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(organ.faces.size()));
}
void mending(benchmark::State& state) {
    mesh holed = make_sphere({0, 0, 0}, 50_mm, 7);
    std::erase_if(holed.faces, [&](const uvec3& face) { return face.x % 1000 == 0 && face.y % 2 == 0; });
    for (auto _ : state) benchmark::DoNotOptimize(repair(holed));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(holed.faces.size()));
}

} // namespace

BENCHMARK(triangle_test);
BENCHMARK(validation)->Unit(benchmark::kMillisecond);
BENCHMARK(mending)->Unit(benchmark::kMillisecond);
