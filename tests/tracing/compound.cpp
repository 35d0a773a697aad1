#include <insonify/acoustics/physical.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/compound.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include "../thread_sanitizer.hpp"
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace compound_speckle_test {
namespace {

constexpr medium echoing{.density = 1000, .sound_speed = 1540, .backscatter = 1};
constexpr acquisition scan{.depth = 40_mm, .samples = 2048};

struct region { // around the focus and in the middle, where all looks count fully
    std::uint32_t first_line, last_line, first_sample, last_sample;
};
region middle_of(const linear_array& probe) {
    return {probe.lines * 3 / 10, probe.lines * 7 / 10, 922, 1127}; // 18 to 22 mm
}

// Mean over standard deviation of the average of looks, and its mean level.
struct statistics {
    double snr, level;
};
statistics compounded(const linear_array& probe, const compound_settings& settings, std::uint32_t planes) {
    const region within = middle_of(probe);
    double sum = 0, squares = 0, n = 0;
    compounding<linear_array> looks;
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        const scene body = scene{echoing}.build(exec::seq);
        const auto model = physical<>{.scattering = {.seed = seed}};
        const scan_lines found =
            looks(exec::par_unseq, probe, {scan.depth, scan.samples, planes}, settings,
                  [&](std::uint32_t, const steered<linear_array>& look, const acquisition& of, scan_lines recycled) {
                      return envelope(exec::par_unseq,
                                      convolve(exec::par_unseq, trace(exec::par_unseq, body, look, pose{}, model, of),
                                               nominal_pulse(look), look),
                                      std::move(recycled));
                  });
        for (std::uint32_t i = within.first_line; i < within.last_line; ++i)
            for (std::uint32_t k = within.first_sample; k < within.last_sample; ++k) {
                const auto a = static_cast<double>(found(i, k));
                sum += a, squares += a * a, ++n;
            }
    }
    const double mean = sum / n;
    return {mean / std::sqrt(squares / n - mean * mean), 20 * std::log10(mean)};
}

// Correlation of the amplitudes of two looks.
//
// Both receive the same scatterers. A look at the angle a weights their spatial frequencies across the line with the two-way
// spectrum of its beam, here a Gaussian of width 1 / sigma, around (4 pi f0 / c) sin(a). The correlation of two complex echoes
// is the overlap of two such spectra,
//
//     r = exp(-(q sigma)^2 / 4),   q = (4 pi f0 / c) 2 sin(|a - b| / 2)
//
// and that of their Rayleigh-distributed amplitudes (Middleton 1960)
//
//     (F(-1/2, -1/2; 1; r^2) - 1) / (4 / pi - 1)
double correlation(const linear_array& probe, double angle) {
    const auto sigma = static_cast<double>(beam_of(probe, scan.depth).lateral_sigma(20_mm));
    const double q = 4 * 3.14159265 * static_cast<double>(probe.frequency) / 1540 * 2 * std::sin(std::fabs(angle) / 2);
    const double squared = std::exp(-0.5 * q * q * sigma * sigma);
    double series = 0, term = 1;
    for (int n = 1; n < 60; ++n) {
        const double factor = (n - 1.5) / n;
        term *= factor * factor * squared;
        series += term;
    }
    return series / (4 / 3.14159265 - 1);
}

// The variance of the mean of equally strong looks is the mean of their correlation matrix.
double expected_snr(const linear_array& probe, const compound_settings& settings) {
    double sum = 0;
    for (std::uint32_t i = 0; i < settings.angles; ++i)
        for (std::uint32_t j = 0; j < settings.angles; ++j)
            sum += correlation(probe, static_cast<double>(settings.steering(i) - settings.steering(j)));
    return 1.913 * settings.angles / std::sqrt(sum);
}

} // namespace

TEST_CASE("compounding raises the SNR of speckle as the correlation of the looks has it, and keeps its level") {
    const auto check = [](const char* name, const linear_array& probe, float spread, std::uint32_t planes) {
        const statistics one = compounded(probe, {}, planes);
        for (const std::uint32_t angles : {1U, 3U, 5U, 9U}) {
            const compound_settings settings{.angles = angles, .spread = spread};
            const statistics found = compounded(probe, settings, planes);
            const double expected = expected_snr(probe, settings);
            MESSAGE(std::string{name}, ", ", angles, " angles over ", (spread / 1_deg), " degrees, ", planes,
                    " planes: SNR ", found.snr, "; expected ", expected, "; level ", found.level - one.level, " dB");
            CHECK(std::fabs(found.snr / expected - 1) < 0.06);
            CHECK(std::fabs(found.level - one.level) < 0.25);
        }
    };
    check("5 MHz, F/3", {.lines = 256, .width = 38_mm, .frequency = 5_MHz, .fnumber = 3}, 20_deg, 1);
    if (thread_sanitizer) return;
    check("9 MHz, F/2", {.lines = 512, .width = 38_mm, .frequency = 9_MHz}, 20_deg, 1);
    check("9 MHz, F/2", {.lines = 512, .width = 38_mm, .frequency = 9_MHz}, 20_deg, 5);
    check("9 MHz, F/2", {.lines = 512, .width = 38_mm, .frequency = 9_MHz}, 10_deg, 1);
}

} // namespace compound_speckle_test
