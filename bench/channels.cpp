#include <insonify/insonify.hpp>
#include <benchmark/benchmark.h>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

/// Channel data of point scatterers in the slice of a linear array of 128 elements, 30 mm deep; the arguments are the
/// number of scatterers and of threads. Beside them a plain sum over scatterers at every frequency of the band, as
/// simulators of fields make it, on one thread.
namespace {

using namespace insonify;

const element_array array = presets::l11_5v_elements;
constexpr float depth = 30_mm;

std::vector<point_scatterer> scatterers(std::size_t count) {
    std::vector<point_scatterer> all(count);
    for (std::size_t i = 0; i < count; ++i)
        all[i] = {.position = {(hash_uniform(1, i) - 0.5F) * 40_mm, 0, 5_mm + hash_uniform(2, i) * 25_mm},
                  .scattering_length = 1e-6F * hash_normal(3, i).x};
    return all;
}

void measure(benchmark::State& state, const std::vector<transmit>& sent, bool wave_fronts) {
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.build(exec::par);
    const std::vector<point_scatterer> points = scatterers(static_cast<std::size_t>(state.range(0)));
    const auto threads = exec::par_unseq.threads(static_cast<std::uint32_t>(state.range(1)));
    for (auto _ : state)
        benchmark::DoNotOptimize(trace_channels(threads, body, array, pose{}, physical{}, sent,
                                                {.depth = depth, .wave_fronts = wave_fronts, .points = points}));
    state.SetItemsProcessed(state.iterations() * state.range(0) * array.elements * static_cast<int>(sent.size()));
}

void full_aperture(benchmark::State& state) { measure(state, full_synthetic_aperture(array), false); }
void eleven_plane_waves(benchmark::State& state) { measure(state, plane_waves(array, 11, 20_deg), false); }
void eleven_wave_fronts(benchmark::State& state) { measure(state, plane_waves(array, 11, 20_deg), true); }

// The spectra of all pairs of elements: sum over scatterers of L P_n P_m, at each of the frequencies that a record of
// this depth has within -60 dB of the pulse.
void frequency_sum(benchmark::State& state) {
    const std::vector<point_scatterer> points = scatterers(static_cast<std::size_t>(state.range(0)));
    const float sigma = array.bandwidth * array.frequency / 2.355F, seconds = 2 * depth / array.sound_speed;
    const auto frequencies = static_cast<std::size_t>(7.4F * sigma * seconds);
    std::vector<std::complex<float>> arrived(array.elements), spectra(array.elements * array.elements);
    for (auto _ : state)
        for (std::size_t f = 0; f < frequencies; ++f) {
            const float frequency = array.frequency +
                                    (static_cast<float>(f) / static_cast<float>(frequencies) - 0.5F) * 7.4F * sigma,
                        k = 2 * pi * frequency / array.sound_speed;
            std::fill(spectra.begin(), spectra.end(), std::complex<float>{});
            for (const point_scatterer& one : points) {
                for (std::uint32_t n = 0; n < array.elements; ++n) {
                    const ray element = array.element(n);
                    const vec3 to = one.position - element.origin;
                    const float range = length(to), cosine = to.z / range,
                                half = 0.5F * k * array.element_width * to.x / range;
                    const float directivity = half == 0 ? 1.0F : std::sin(half) / half;
                    arrived[n] = std::polar(cosine * directivity / range, -k * range);
                }
                for (std::uint32_t n = 0; n < array.elements; ++n) {
                    const std::complex<float> sent = one.scattering_length * arrived[n];
                    std::complex<float>* const to = spectra.data() + std::size_t{n} * array.elements;
                    for (std::uint32_t m = n; m < array.elements; ++m)
                        to[m] += std::complex<float>{sent.real() * arrived[m].real() - sent.imag() * arrived[m].imag(),
                                                     sent.real() * arrived[m].imag() + sent.imag() * arrived[m].real()};
                }
            }
            benchmark::DoNotOptimize(spectra.data());
        }
    state.SetItemsProcessed(state.iterations() * state.range(0) * array.elements * array.elements);
}

} // namespace

BENCHMARK(full_aperture)->ArgsProduct({{10'000, 100'000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(eleven_plane_waves)->Args({100'000, 2})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(eleven_wave_fronts)->ArgsProduct({{10'000, 100'000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(frequency_sum)->Args({100, 1})->UseRealTime()->Unit(benchmark::kMillisecond);
