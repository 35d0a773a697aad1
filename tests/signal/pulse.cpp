#include <insonify/core/units.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/pulse.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

TEST_CASE("pulse: so many cycles of the carrier lie between the points where the envelope is a tenth") {
    for (const float cycles : {1.5F, 2.5F, 6.0F})
        for (const float carrier : {2.5_MHz, 7.5_MHz}) {
            const double depth = 1540.0 / 2 * static_cast<double>(cycles) / static_cast<double>(carrier) / 2;
            const double sigmas = depth / static_cast<double>(pulse{.cycles = cycles}.sigma_z(carrier));
            CHECK(std::exp(-sigmas * sigmas / 2) == doctest::Approx(0.1).epsilon(0.005));
        }
}

TEST_CASE("pulse: the bandwidth is the width of the spectrum at half its height") {
    const double pi_d = std::acos(-1.0);
    for (const float cycles : {1.5F, 2.5F, 6.0F}) {
        const pulse sent{.cycles = cycles};
        const double sigma_t = 2 * static_cast<double>(sent.sigma_z(5_MHz)) / 1540;
        const double width = 2 * std::sqrt(2 * std::log(2.0)) / (2 * pi_d * sigma_t);
        CHECK(width / 5e6 == doctest::Approx(static_cast<double>(sent.bandwidth())).epsilon(1e-3));
    }
    CHECK(pulse{}.bandwidth() == doctest::Approx(0.644));
    CHECK(pulse{}.frequency == 0);
}

TEST_CASE("pulse: a probe's bandwidth makes its nominal pulse, and a probe without one has the usual pulse") {
    struct pencil {
        std::uint32_t lines = 1;
        float frequency = 1_MHz;
        ray beam(float) const { return {}; }
        vec2 locate(vec2 point) const { return point; }
        void check() const {}
    };
    CHECK(nominal_pulse(pencil{}).cycles == 2.5F);
    CHECK(nominal_pulse(linear_array{}).cycles == doctest::Approx(2.5));
    CHECK(nominal_pulse(linear_array{.bandwidth = 0.77F}).bandwidth() == doctest::Approx(0.77));
    CHECK(nominal_pulse(linear_array{}).frequency == 0);
}

TEST_CASE("pulse: what is not at the probe's frequency, or makes no sense, is refused") {
    CHECK_NOTHROW(pulse{}.check(5_MHz));
    CHECK_NOTHROW(pulse{.frequency = 5_MHz}.check(5_MHz));
    CHECK_THROWS_AS(pulse{.frequency = 7.5_MHz}.check(5_MHz), usage_error);
    CHECK_THROWS_AS(pulse{.frequency = 5.01_MHz}.check(5_MHz), usage_error);
    const float infinite = std::numeric_limits<float>::infinity();
    for (const float bad : {-1.0F, infinite, std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_THROWS_AS(pulse{.cycles = bad}.check(5_MHz), usage_error);
        CHECK_THROWS_AS(pulse{.frequency = bad}.check(5_MHz), usage_error);
    }
    CHECK_THROWS_AS(pulse{.cycles = 0}.check(5_MHz), usage_error);
}
