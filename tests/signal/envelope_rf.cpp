#include <insonify/core/units.hpp>
#include <insonify/signal/envelope.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <string>

using namespace insonify;

TEST_CASE("to_rf: an echo oscillates at 2 f0 / c0 cycles per metre of displayed depth, with its peak at the echo") {
    constexpr double pi_d = 3.14159265358979324;
    constexpr double echo = 20.013e-3, sigma = 0.09e-3, cycles_a_metre = 2 * 5e6 / 1540;
    for (const std::uint32_t samples : {1040U, 2000U, 5000U}) { // of 40 mm: 4 to 19 per cycle
        iq_lines iq{2, samples, 40_mm};
        for (std::uint32_t k = 0; k < samples; ++k) {
            const double z = (k + 0.5) * 40e-3 / samples;
            const double level = std::exp(-std::pow((z - echo) / sigma, 2) / 2);
            iq(1, k) = {static_cast<float>(level * std::cos(2 * pi_d * cycles_a_metre * echo)),
                        static_cast<float>(-level * std::sin(2 * pi_d * cycles_a_metre * echo))};
        }
        const scan_lines rf = to_rf(exec::par, iq, 5_MHz);
        CHECK(rf.count == 2);
        CHECK(rf.samples == samples);
        CHECK(rf.depth == 40_mm);
        for (std::uint32_t k = 0; k < samples; ++k) {
            const double z = (k + 0.5) * 40e-3 / samples;
            const double expected =
                std::exp(-std::pow((z - echo) / sigma, 2) / 2) * std::cos(2 * pi_d * cycles_a_metre * (z - echo));
            REQUIRE(std::fabs(static_cast<double>(rf(1, k)) - expected) < 2e-4);
            REQUIRE(rf(0, k) == 0);
        }
    }
}

TEST_CASE("to_rf: fewer than four samples per cycle are refused with the number of samples needed") {
    const iq_lines coarse{1, 1000, 40_mm};
    std::string complaint;
    try {
        to_rf(exec::seq, coarse, 5_MHz);
    } catch (const usage_error& e) {
        complaint = e.what();
    }
    CHECK(complaint.find("1039") != std::string::npos); // 8 f0 / c0 * 40 mm = 1038.96
    CHECK_NOTHROW(to_rf(exec::seq, iq_lines{1, 1039, 40_mm}, 5_MHz));
    CHECK_THROWS_AS(to_rf(exec::seq, iq_lines{}, 5_MHz), usage_error);
    for (const float bad : {0.0F, -1.0F, std::numeric_limits<float>::infinity()})
        CHECK_THROWS_AS(to_rf(exec::seq, coarse, bad), usage_error);
}
