#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include "convolve_lines.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace convolve_test {
TEST_CASE("convolve: white noise becomes speckle with the statistics of fully developed speckle") { // V9
    const linear_array probe{.lines = 600, .width = 90_mm, .frequency = 5_MHz, .focus = 10_mm};
    const iq_lines echoes = white_noise(600, 1600, 60_mm, 5);
    const scan_lines speckle = envelope(exec::par, convolve(exec::par_unseq, echoes, six_tenths, probe));
    double n = 0, sum = 0, squares = 0, fourth = 0, db = 0, db_squares = 0;
    for (std::uint32_t line = 10; line < 590; ++line)
        for (std::uint32_t k = 700; k < 1590; ++k) { // beyond 26 mm, where the width is constant
            const double a = static_cast<double>(speckle(line, k)), level = decibels(a);
            n += 1;
            sum += a;
            squares += a * a;
            fourth += a * a * a * a;
            db += level;
            db_squares += level * level;
        }
    const double mean = sum / n, power = squares / n;
    const double snr = mean / std::sqrt(power - mean * mean);
    const double intensity_snr = power / std::sqrt(fourth / n - power * power);
    const double db_deviation = std::sqrt(db_squares / n - db / n * (db / n));
    const double db_mean = db / n - 10 * std::log10(power);
    const double cells = 580 * 0.15 / 0.7638 * 890 * 60 / 1600 / 0.2265;
    MESSAGE(cells, " cells: envelope SNR ", snr, ", expected 1.913; intensity SNR ", intensity_snr,
            ", expected 1.000; dB ", db_deviation, ", expected 5.570, and ", db_mean, ", expected -2.507");
    CHECK(cells > 1e4);
    CHECK(snr == doctest::Approx(1.913).epsilon(0.02).scale(1e-30));
    CHECK(intensity_snr == doctest::Approx(1.0).epsilon(0.02).scale(1e-30));
    CHECK(db_deviation == doctest::Approx(5.570).epsilon(0.02).scale(1e-30));
    CHECK(db_mean == doctest::Approx(-2.507).epsilon(0.02).scale(1e-30));
}

TEST_CASE("convolve: the speckle's intensity autocovariance is as wide as the point-spread function") { // V11
    const linear_array probe{.lines = 900, .width = 90_mm, .frequency = 5_MHz, .focus = 10_mm};
    const iq_lines echoes = white_noise(900, 2400, 60_mm, 6);
    const scan_lines speckle = envelope(exec::par, convolve(exec::par_unseq, echoes, six_tenths, probe));
    double mean = 0, n = 0;
    for (std::uint32_t line = 20; line < 880; ++line)
        for (std::uint32_t k = 1100; k < 2380; ++k) {
            mean += std::pow(static_cast<double>(speckle(line, k)), 2);
            n += 1;
        }
    mean /= n;
    const auto covariance = [&](std::uint32_t lines, std::uint32_t samples) {
        double sum = 0, count = 0;
        for (std::uint32_t line = 20; line < 860; ++line)
            for (std::uint32_t k = 1100; k < 2350; ++k) {
                sum += (std::pow(static_cast<double>(speckle(line, k)), 2) - mean) *
                       (std::pow(static_cast<double>(speckle(line + lines, k + samples)), 2) - mean);
                count += 1;
            }
        return sum / count;
    };
    std::vector<double> across(15), along(21); // both sides of the peak, symmetric
    for (std::uint32_t i = 0; i < 8; ++i) across[7 - i] = across[7 + i] = covariance(i, 0);
    for (std::uint32_t i = 0; i < 11; ++i) along[10 - i] = along[10 + i] = covariance(0, i);
    const double lateral = half_width(across) * 0.1, axial = half_width(along) * 60 / 2400;
    const double beam = 1e3 * static_cast<double>(beam_of(probe, 60_mm).lateral_width(40_mm));
    MESSAGE("lateral ", lateral, " mm, expected ", beam, "; axial ", axial, " mm, expected 0.2265");
    CHECK(beam == doctest::Approx(0.8324).epsilon(0.05).scale(1e-30)); // simulated: see the tests of `beam_model`
    CHECK(lateral == doctest::Approx(beam).epsilon(0.03).scale(1e-30));
    CHECK(axial == doctest::Approx(0.2265).epsilon(0.03).scale(1e-30));
}

} // namespace convolve_test
