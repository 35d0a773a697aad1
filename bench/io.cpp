#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "support/meshes.hpp"
#include <benchmark/benchmark.h>
#include <cstdio>
#include <fstream>

/// Files: an OBJ of 20,480 triangles read, a picture of 512 x 512 written.
namespace {

using namespace insonify;

void read_obj(benchmark::State& state) {
    const char* const path = "bench_io.obj";
    const mesh organ = bench::make_organ(5);
    {
        std::ofstream file{path};
        for (const vec3& p : organ.positions) file << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
        for (const uvec3& f : organ.faces) file << "f " << f.x + 1 << ' ' << f.y + 1 << ' ' << f.z + 1 << '\n';
    }
    for (auto _ : state) benchmark::DoNotOptimize(load_obj(path, {.unit = 1_m}));
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(organ.faces.size()));
    std::remove(path);
}
void write_picture(benchmark::State& state) {
    const char* const path = "bench_io.png";
    image noise{{512, 512}};
    for (std::size_t i = 0; i < noise.pixels.size(); ++i) noise.pixels[i] = hash_uniform(1, i);
    for (auto _ : state) write_png(path, noise);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(noise.pixels.size()));
    std::remove(path);
}

} // namespace

BENCHMARK(read_obj)->Unit(benchmark::kMillisecond);
BENCHMARK(write_picture)->Unit(benchmark::kMillisecond);
