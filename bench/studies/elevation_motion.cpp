#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <cstdio>

/// How far the echoes of muscle decorrelate as the probe moves out of the slice, by elevation planes beside the Gaussian beam,
/// exp(-d^2 / (4 sigma^2)): with fibres in the slice and across it, and without structure. Means over 10, 20, 30 and 40 mm of depth.
namespace {

using namespace insonify;

constexpr float depth = 45_mm, rows[] = {10_mm, 20_mm, 30_mm, 40_mm};
constexpr std::uint32_t samples = 1500, seeds = 3;

double beam_correlation(const linear_array& probe, float slide) {
    const beam_model beam = beam_of(probe, depth);
    double sum = 0;
    for (const float row : rows)
        sum += std::exp(-std::pow(static_cast<double>(slide / beam.elevation_sigma(row)), 2) / 4);
    return sum / 4;
}

double correlation(const scene& body, const linear_array& probe, float slide, std::uint32_t planes) {
    double product[4] = {}, before[4] = {}, after[4] = {};
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
        const auto part = static_cast<float>(seed); // other tissue
        const auto seen = [&](float by) {
            const pose at{.translation = {part * 15_mm, part * 20_mm + by, 0}};
            return convolve(exec::par_unseq,
                            trace(exec::par_unseq, body, probe, at, physical<>{.scattering = {.seed = seed}},
                                  {.depth = depth, .samples = samples, .planes = planes},
                                  straight_lines{.directions = 1}),
                            nominal_pulse(probe), probe);
        };
        const iq_lines a = seen(0), b = seen(slide);
        for (int row = 0; row < 4; ++row)
            for (std::uint32_t line = 0; line < a.count; ++line)
                for (std::uint32_t k = 0; k < samples; ++k) {
                    if (std::fabs((static_cast<float>(k) + 0.5F) * depth / samples - rows[row]) > 1_mm) continue;
                    product[row] += static_cast<double>(dot(a(line, k), b(line, k)));
                    before[row] += static_cast<double>(dot(a(line, k), a(line, k)));
                    after[row] += static_cast<double>(dot(b(line, k), b(line, k)));
                }
    }
    double sum = 0;
    for (int row = 0; row < 4; ++row) sum += product[row] / std::sqrt(before[row] * after[row]);
    return sum / 4;
}

void print(const char* name, const scene& body, float frequency) {
    const linear_array probe{.lines = 96, .width = 30_mm, .frequency = frequency};
    for (const float slide : {0.2_mm, 0.4_mm, 0.8_mm}) {
        std::printf("| %.1f MHz, %.1f mm | %s |", static_cast<double>(frequency / 1_MHz),
                    static_cast<double>(slide / 1_mm), name);
        for (const std::uint32_t planes : {1U, 3U, 5U, 7U})
            std::printf(" %.2f |", correlation(body, probe, slide, planes));
        std::printf(" %.2f |\n", beam_correlation(probe, slide));
        std::fflush(stdout);
    }
}

} // namespace

int main() {
    medium muscle = tissue::muscle, plain = tissue::muscle;
    muscle.attenuation = plain.attenuation = 0;
    muscle.sound_speed = plain.sound_speed = display_speed;
    plain.structure = structure{};
    scene along{muscle}, across{muscle}, none{plain};
    along.set_background_fibres({1, 0, 0}, {0, 0, 1});
    across.set_background_fibres({0, 1, 0}, {0, 0, 1});
    for (scene* const body : {&along, &across, &none}) body->build(exec::par);
    std::printf("| moved | fibres | 1 plane | 3 | 5 | 7 | Gaussian beam |\n|---|---|---|---|---|---|---|\n");
    for (const float frequency : {5_MHz, 7.5_MHz}) {
        print("in the slice", along, frequency);
        print("across the slice", across, frequency);
        print("no structure", none, frequency);
    }
}
