#include <insonify/core/random.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("envelope: the amplitude of each complex sample") {
    iq_lines iq{3, 1001, 10_mm};
    for (std::size_t i = 0; i < iq.values.size(); ++i) iq.values[i] = hash_normal(1, i);
    iq(1, 7) = {-3, 4};
    iq(1, 8) = {0, 0};
    for (const scan_lines& lines : {envelope(exec::seq, iq), envelope(exec::par_unseq, iq)}) {
        CHECK(lines.count == 3);
        CHECK(lines.samples == 1001);
        CHECK(lines.depth == 10_mm);
        CHECK(lines(1, 7) == doctest::Approx(5).scale(1e-30));
        CHECK(lines(1, 8) == 0);
        for (std::size_t i = 0; i < iq.values.size(); ++i)
            REQUIRE(lines.values[i] == doctest::Approx(std::hypot(static_cast<double>(iq.values[i].x),
                                                                  static_cast<double>(iq.values[i].y)))
                                           .scale(1e-30));
    }
    CHECK(envelope(exec::par, iq_lines{}).values.empty());
}

TEST_CASE("envelope: that of RF lines by Hilbert transform equals that of IQ lines") { // V24
    const linear_array probe{.lines = 33, .width = 8_mm, .frequency = 5_MHz};
    for (const std::uint32_t samples : {1400U, 2048U, 5000U}) {
        iq_lines echoes{33, samples, 50_mm};
        for (std::uint32_t line = 0; line < 33; ++line)
            for (std::uint32_t k = samples / 20; k < samples - samples / 20; ++k)
                echoes(line, k) = hash_normal(line, k);
        const iq_lines iq = convolve(exec::par_unseq, echoes, pulse{}, probe);
        const scan_lines expected = envelope(exec::seq, iq);
        double largest = 0;
        for (const float value : expected.values) largest = std::max(largest, static_cast<double>(value));
        const scan_lines rf = to_rf(exec::par, iq, 5_MHz);
        double worst = 0;
        for (const scan_lines& lines : {envelope(exec::seq, rf), envelope(exec::par_unseq, rf)})
            for (std::size_t i = 0; i < lines.values.size(); ++i)
                worst = std::max(
                    worst, std::fabs(static_cast<double>(lines.values[i]) - static_cast<double>(expected.values[i])));
        MESSAGE(samples, " samples: at most ", worst / largest, " of the largest; expected below 1e-3");
        CHECK(worst < 1e-3 * largest);
        for (const std::uint32_t threads : {1U, 2U, 3U, 8U}) {
            CHECK(envelope(exec::par.threads(threads), rf) == envelope(exec::seq, rf));
            CHECK(envelope(exec::par_unseq.threads(threads), rf) == envelope(exec::unseq, rf));
        }
    }
    CHECK(envelope(exec::par, scan_lines{}).values.empty());
    scan_lines torn{3, 4, 1_mm};
    torn.values.pop_back();
    CHECK_THROWS_AS(envelope(exec::seq, torn), usage_error);
}
