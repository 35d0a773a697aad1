#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include "convolve_lines.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <string>
#include <vector>

using namespace insonify;

namespace convolve_test {
namespace {

double amplitude(const iq_lines& lines, std::uint32_t line, std::uint32_t sample) {
    return static_cast<double>(length(lines(line, sample)));
}

/// An echo at a displayed depth, split linearly between its two neighbouring samples.
void add_echo(iq_lines& lines, std::uint32_t line, float depth, float level) {
    const float place = depth / lines.depth * static_cast<float>(lines.samples) - 0.5F;
    const auto above = static_cast<std::uint32_t>(place);
    const float fraction = place - static_cast<float>(above);
    lines(line, above) += vec2{0.6F, -0.8F} * level * (1 - fraction);
    lines(line, above + 1) += vec2{0.6F, -0.8F} * level * fraction;
}

} // namespace

TEST_CASE("convolve: the axial kernel is correct at three sampling rates") {
    const linear_array probe{.lines = 1, .frequency = 5_MHz};
    const double sigma = static_cast<double>(pulse{}.sigma_z(5_MHz));
    for (const std::uint32_t samples : {340U, 600U, 2000U}) { // of 30 mm: 1.01, 1.8 and 6 per sigma
        iq_lines echoes{1, samples, 30_mm};
        const std::uint32_t at = samples / 2;
        echoes(0, at) = {0.6F, -0.8F};
        const iq_lines lines = convolve(exec::unseq, echoes, pulse{}, probe);
        for (std::uint32_t k = 0; k < samples; ++k) {
            const double apart = (static_cast<double>(k) - at) * 30e-3 / samples / sigma;
            const double expected = std::fabs(apart) <= 4 ? std::exp(-apart * apart / 2) : 0;
            REQUIRE(std::fabs(amplitude(lines, 0, k) - expected) < 1e-5);
        }
    }
}

TEST_CASE(
    "convolve: the -6 dB length of a burst's echo is that of the burst, and its peak that of an impulse excitation") {
    const linear_array probe{.lines = 1, .frequency = 5_MHz};
    for (const std::uint32_t samples : {600U, 2000U})
        for (const std::uint32_t decimation : {1U, 2U}) {
            iq_lines echoes{1, samples, 30_mm};
            add_echo(echoes, 0, 15_mm, 1);
            const iq_lines seen = convolve(exec::par_unseq, std::move(echoes), {.burst = 12}, probe,
                                           {.decimation = samples > 1000 ? decimation : 1});
            std::vector<double> envelope(seen.samples);
            for (std::uint32_t k = 0; k < seen.samples; ++k) envelope[k] = amplitude(seen, 0, k);
            const double length = half_width(envelope) * 30e-3 / seen.samples;
            CHECK(length == doctest::Approx(12 * 1540 / (2 * 5e6)).epsilon(2e-3).scale(1e-30)); // 1.848 mm
            CHECK(*std::max_element(envelope.begin(), envelope.end()) == doctest::Approx(1).epsilon(1e-3).scale(1e-30));
        }
}

TEST_CASE("convolve: an echo between two samples loses at most dz^2 / (8 sigma^2)") {
    const linear_array probe{.lines = 1, .frequency = 5_MHz};
    for (const std::uint32_t samples : {600U, 1400U})
        for (const float off : {0.0F, 0.2F, 0.5F}) {
            const float spacing = 30_mm / static_cast<float>(samples);
            iq_lines echoes{1, samples, 30_mm};
            add_echo(echoes, 0, 200.5F * spacing + off * spacing, 1);
            const iq_lines lines = convolve(exec::seq, echoes, pulse{}, probe);
            const double above = std::log(amplitude(lines, 0, 199)), at = std::log(amplitude(lines, 0, 200)),
                         below = std::log(amplitude(lines, 0, 201)); // of a Gaussian: a parabola
            const double peak = std::exp(at - std::pow(below - above, 2) / (8 * (below + above - 2 * at)));
            const double ratio = static_cast<double>(spacing / pulse{}.sigma_z(5_MHz));
            CHECK(peak <= 1.00001);
            CHECK(peak >= 1 - ratio * ratio / 8 * 1.001);
        }
}

TEST_CASE("convolve: a point at the focus has the published lateral and axial widths") { // V12, V13, V14
    struct {
        float fnumber, frequency;
        double lateral, lateral_py_must, axial; // mm
    } const rows[] = {{2, 5_MHz, 0.571, 0.577, 0.2272},
                      {2, 7.5_MHz, 0.389, 0.391, 0.1521},
                      {2.94F, 5_MHz, 0.822, 0.832, 0.2272},
                      {2.94F, 7.5_MHz, 0.554, 0.561, 0.1521}};
    for (const auto& row : rows) {
        const linear_array probe{
            .lines = 1001, .width = 1001 * 0.02_mm, .frequency = row.frequency, .fnumber = row.fnumber, .focus = 30_mm};
        iq_lines echoes{probe.lines, 4001, 60_mm};
        echoes(500, 2000) = {1, 0};
        const iq_lines lines = convolve(exec::par_unseq, echoes, six_tenths, probe);
        std::vector<double> across, along;
        for (std::uint32_t line = 0; line < probe.lines; ++line) across.push_back(amplitude(lines, line, 2000));
        for (std::uint32_t k = 0; k < lines.samples; ++k) along.push_back(amplitude(lines, 500, k));
        const double lateral = half_width(across) * 0.02, axial = half_width(along) * 60 / 4001;
        MESSAGE("F/", row.fnumber, ", ", (row.frequency * 1e-6F), " MHz: lateral ", lateral, " mm, expected ",
                row.lateral, ", ", row.lateral_py_must, "; axial ", axial, " mm, expected ", row.axial);
        CHECK(lateral == doctest::Approx(row.lateral).epsilon(0.05).scale(1e-30));
        CHECK(lateral == doctest::Approx(row.lateral_py_must).epsilon(0.05).scale(1e-30));
        CHECK(axial == doctest::Approx(row.axial).epsilon(0.03).scale(1e-30));
    }
}

TEST_CASE("convolve: a plate keeps its amplitude on 64, 192 and 384 lines, at any sampling, to the last line") {
    const auto check_plate = [](const auto& probe, const std::string& name) {
        double worst = 0;
        for (const std::uint32_t samples : {1200U, 2048U, 4096U})
            for (const std::uint32_t at : {samples / 20, samples / 2, samples - 30}) {
                iq_lines echoes{probe.lines, samples, 80_mm};
                for (std::uint32_t line = 0; line < probe.lines; ++line) echoes(line, at) = {0.18F, -0.24F};
                const iq_lines lines = convolve(exec::par_unseq, echoes, pulse{}, probe);
                for (std::uint32_t line = 0; line < probe.lines; ++line)
                    worst = std::max(worst, std::fabs(decibels(amplitude(lines, line, at) / 0.3)));
            }
        MESSAGE(name, ", ", probe.lines, " lines: at most ", worst, " dB off; expected within 0.1 dB");
        CHECK(worst < 0.1);
    };
    for (const std::uint32_t lines : {64U, 192U, 384U}) {
        check_plate(linear_array{.lines = lines, .frequency = 5_MHz}, "linear");
        check_plate(convex_array{.lines = lines, .frequency = 3.5_MHz}, "convex");
        check_plate(phased_array{.lines = lines, .frequency = 2.5_MHz}, "phased");
        check_plate(radial_array{.lines = lines, .radius = 2_mm, .frequency = 5_MHz}, "radial");
    }
}

TEST_CASE("convolve: a reflector on a single line is attenuated by the ratio of line spacing to beam width") {
    const double two_pi = 2 * std::acos(-1.0);
    for (const std::uint32_t lines : {400U, 800U}) {
        const linear_array probe{.lines = lines, .width = 20_mm, .frequency = 5_MHz, .focus = 20_mm};
        iq_lines echoes{lines, 1500, 40_mm};
        echoes(lines / 2, 750) = {1, 0};
        const iq_lines result = convolve(exec::seq, echoes, pulse{}, probe);
        const double sigma = static_cast<double>(beam_of(probe, 40_mm).lateral_sigma(20_mm));
        const double expected = 20e-3 / lines / (std::sqrt(two_pi) * sigma);
        CHECK(amplitude(result, lines / 2, 750) == doctest::Approx(expected).epsilon(2e-3).scale(1e-30));
    }
}

TEST_CASE("convolve: a full circle has no border") {
    const radial_array probe{.lines = 128, .radius = 2_mm, .frequency = 10_MHz};
    iq_lines echoes{128, 1200, 10_mm}, turned = echoes;
    for (std::uint32_t k = 100; k < 1100; k += 50) {
        echoes(64, k) = {1, 0};
        turned(0, k) = {1, 0};
    }
    const iq_lines expected = convolve(exec::seq, echoes, pulse{}, probe),
                   lines = convolve(exec::seq, turned, pulse{}, probe);
    for (std::uint32_t line = 0; line < 128; ++line)
        for (std::uint32_t k = 0; k < 1200; ++k) REQUIRE(lines((line + 64) % 128, k) == expected(line, k));
}

TEST_CASE("convolve: decimated lines equal the full ones, resampled") {
    const linear_array probe{.lines = 24, .width = 5_mm, .frequency = 5_MHz};
    const iq_lines echoes = white_noise(24, 3600, 30_mm, 3);
    const iq_lines fine = convolve(exec::seq, echoes, pulse{}, probe);
    double largest = 0;
    for (const vec2 v : fine.values) largest = std::max(largest, static_cast<double>(length(v)));
    for (const std::uint32_t decimation : {3U, 5U, 2U, 4U}) {
        const iq_lines coarse = convolve(exec::par_unseq, echoes, pulse{}, probe, {.decimation = decimation});
        CHECK(coarse.count == 24);
        CHECK(coarse.samples == 3600 / decimation);
        CHECK(coarse.depth == 30_mm);
        double worst = 0;
        for (std::uint32_t line = 0; line < 24; ++line)
            for (std::uint32_t k = 1; k + 1 < coarse.samples; ++k) {
                const std::uint32_t middle = k * decimation + decimation / 2;
                const vec2 there = decimation % 2 == 1 ? fine(line, middle) // in between: the cubic through four
                                                       : (9.0F * (fine(line, middle - 1) + fine(line, middle)) -
                                                          (fine(line, middle - 2) + fine(line, middle + 1))) /
                                                             16.0F;
                worst = std::max(worst, static_cast<double>(length(coarse(line, k) - there)));
            }
        CHECK(worst < 5e-3 * largest);
    }
}

TEST_CASE("convolve: bit-equal for any number of threads, scalar and SIMD equal within rounding") {
    for (const std::uint32_t decimation : {1U, 2U}) {
        const phased_array probe{.lines = 67, .frequency = 2.5_MHz};
        const iq_lines echoes = white_noise(67, 1202, 60_mm, 4);
        const convolve_settings settings{.decimation = decimation};
        const iq_lines scalar = convolve(exec::seq, echoes, pulse{}, probe, settings);
        const iq_lines simd = convolve(exec::unseq, echoes, pulse{}, probe, settings);
        for (const std::uint32_t threads : {1U, 2U, 3U, 8U}) {
            CHECK(convolve(exec::par.threads(threads), echoes, pulse{}, probe, settings) == scalar);
            CHECK(convolve(exec::par_unseq.threads(threads), echoes, pulse{}, probe, settings) == simd);
            CHECK(envelope(exec::par.threads(threads), scalar) == envelope(exec::seq, scalar));
            CHECK(envelope(exec::par_unseq.threads(threads), scalar) == envelope(exec::unseq, scalar));
        }
        double worst = 0;
        for (std::size_t i = 0; i < scalar.values.size(); ++i)
            worst = std::max(worst, static_cast<double>(length(scalar.values[i] - simd.values[i])));
        CHECK(worst < 1e-5);
    }
}

TEST_CASE("convolve: undersampled lines are refused with the number of samples needed") {
    const linear_array probe{.lines = 4, .frequency = 5_MHz};
    std::string complaint;
    try {
        convolve(exec::seq, iq_lines{4, 384, 45_mm}, pulse{}, probe);
    } catch (const usage_error& e) {
        complaint = e.what();
    }
    CHECK(complaint.find(" 503 ") != std::string::npos); // 45 mm over 0.1874 c0 / (0.644 f0)
    CHECK_NOTHROW(convolve(exec::seq, iq_lines{4, 503, 45_mm}, pulse{}, probe));
    CHECK_NOTHROW(convolve(exec::seq, iq_lines{4, 1006, 45_mm}, pulse{}, probe, {.decimation = 2}));
    CHECK_THROWS_AS(convolve(exec::seq, iq_lines{4, 1004, 45_mm}, pulse{}, probe, {.decimation = 2}), usage_error);
}

TEST_CASE("convolve: echoes of another probe and settings out of range are refused") {
    const linear_array probe{.lines = 4, .frequency = 5_MHz};
    const iq_lines echoes{4, 1000, 45_mm};
    CHECK_NOTHROW(convolve(exec::seq, echoes, pulse{.frequency = 5_MHz}, probe));
    CHECK_THROWS_AS(convolve(exec::seq, echoes, pulse{.frequency = 7.5_MHz}, probe), usage_error);
    CHECK_THROWS_AS(convolve(exec::seq, echoes, pulse{.cycles = 0}, probe), usage_error);
    CHECK_THROWS_AS(convolve(exec::seq, echoes, pulse{}, linear_array{.lines = 5}), usage_error);
    CHECK_THROWS_AS(convolve(exec::seq, echoes, pulse{}, linear_array{.lines = 4, .width = -1}), usage_error);
    CHECK_THROWS_AS(convolve(exec::seq, iq_lines{}, pulse{}, probe), usage_error);
    CHECK_THROWS_AS(convolve(exec::seq, iq_lines{4, 0, 45_mm}, pulse{}, probe), usage_error);
    for (const float depth : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN()})
        CHECK_THROWS_AS(convolve(exec::seq, iq_lines{4, 1000, depth}, pulse{}, probe), usage_error);
    for (const std::uint32_t bad : {0U, 3U})
        CHECK_THROWS_AS(convolve(exec::seq, echoes, pulse{}, probe, {.decimation = bad}), usage_error);
}

} // namespace convolve_test
