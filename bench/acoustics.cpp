#include <insonify/insonify.hpp>
#include <benchmark/benchmark.h>

/// What a line costs the acoustic models: items are scatterers, samples or interfaces.
namespace {

using namespace insonify;

void texture(benchmark::State& state) {
    const gaussian_field field;
    std::int64_t scatterers = 0;
    for (auto _ : state)
        field.scatter({}, 0, 40_mm, 25_um, [&](const scatterer_run& run) {
            benchmark::DoNotOptimize(run.real);
            scatterers += run.count;
        });
    state.SetItemsProcessed(scatterers);
}
void echoes_of_a_run(benchmark::State& state) {
    std::vector<vec2> samples(2048);
    const echo_line line{samples, 20_um, 7.5_MHz};
    const std::vector<float> amplitude(128, 0.5F);
    for (auto _ : state) {
        line.scatterers({.depth = 10_mm,
                         .step = 25_um,
                         .count = 128,
                         .real = amplitude.data(),
                         .imaginary = amplitude.data(),
                         .first_level = 1,
                         .last_level = 0.88F});
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * 128);
}
void reflection_of_interface(benchmark::State& state) {
    float cosine = 1, sum = 0;
    for (auto _ : state) {
        sum += fresnel{}({tissue::muscle, tissue::bone, cosine, 5_MHz}).reflected;
        cosine = cosine > 0.1F ? cosine - 1e-3F : 1;
    }
    benchmark::DoNotOptimize(sum);
    state.SetItemsProcessed(state.iterations());
}
template <class Model>
void line_of(benchmark::State& state, const Model& model) {
    const std::vector<medium> media{tissue::muscle, tissue::bone, tissue::blood};
    std::vector<layer> layers;
    for (std::uint32_t i = 0; i < 16; ++i)
        layers.push_back({.begin = 2.5_mm * static_cast<float>(i),
                          .end = 2.5_mm * static_cast<float>(i + 1),
                          .medium = i % 2 == 0 ? 0U : 2U});
    std::vector<typename Model::sample_type> samples(1344);
    for (auto _ : state) {
        model(exec::unseq, traced_line{.layers = layers, .media = media, .frequency = 7.5_MHz}, 40_mm / 1344, samples);
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * 1344);
}
void line_of_physical(benchmark::State& state) { line_of(state, physical<>{}); }
void line_of_law2011(benchmark::State& state) { line_of(state, law2011{}); }

} // namespace

BENCHMARK(texture);
BENCHMARK(echoes_of_a_run);
BENCHMARK(reflection_of_interface);
BENCHMARK(line_of_physical);
BENCHMARK(line_of_law2011);
