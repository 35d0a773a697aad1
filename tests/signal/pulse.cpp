#include <insonify/core/units.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/pulse.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

TEST_CASE("pulse: `cycles` of the carrier lie between the -20 dB points of the envelope") {
    for (const float cycles : {1.5F, 2.5F, 6.0F})
        for (const float carrier : {2.5_MHz, 7.5_MHz}) {
            const double depth = 1540.0 / 2 * static_cast<double>(cycles) / static_cast<double>(carrier) / 2;
            const double sigmas = depth / static_cast<double>(pulse{.cycles = cycles}.sigma_z(carrier));
            CHECK(std::exp(-sigmas * sigmas / 2) == doctest::Approx(0.1).epsilon(0.005).scale(1e-30));
        }
}

TEST_CASE("pulse: the bandwidth is the -6 dB width of the spectrum") {
    const double pi_d = std::acos(-1.0);
    for (const float cycles : {1.5F, 2.5F, 6.0F}) {
        const pulse sent{.cycles = cycles};
        const double sigma_t = 2 * static_cast<double>(sent.sigma_z(5_MHz)) / 1540;
        const double width = 2 * std::sqrt(2 * std::log(2.0)) / (2 * pi_d * sigma_t);
        CHECK(width / 5e6 == doctest::Approx(static_cast<double>(sent.bandwidth())).epsilon(1e-3).scale(1e-30));
    }
    CHECK(pulse{}.bandwidth() == doctest::Approx(0.644).scale(1e-30));
    CHECK(pulse{}.frequency == 0);
}

TEST_CASE(
    "pulse: the envelope of a burst is a rectangle smoothed by a Gaussian, with peak 1 and the length of the burst") {
    for (const float burst : {0.0F, 0.5F, 4.0F, 16.0F}) {
        const pulse sent{.cycles = 2.5F, .burst = burst};
        const pulse_envelope envelope = sent.envelope(5_MHz);
        const auto sigma = static_cast<double>(sent.sigma_z(5_MHz)), length = 1540 / 2.0 * burst / 5e6;
        const auto smoothed = [&](double x) { // midpoint rule over the rectangle, in double precision
            constexpr int parts = 4000;
            double sum = 0;
            for (int i = 0; i < parts; ++i) {
                const double from = x + length * ((i + 0.5) / parts - 0.5);
                sum += std::exp(-from * from / (2 * sigma * sigma)) / parts;
            }
            return sum;
        };
        for (double x = 0; x < length / 2 + 4 * sigma; x += sigma / 7) {
            const double expected = smoothed(x) / smoothed(0);
            CHECK(std::fabs(static_cast<double>(envelope(static_cast<float>(x))) - expected) < 2e-5);
            CHECK(envelope(static_cast<float>(x)) ==
                  doctest::Approx(envelope(static_cast<float>(-x))).epsilon(1e-4).scale(1e-30));
        }
        CHECK(envelope(0) == doctest::Approx(1).scale(1e-30));
        CHECK(envelope(envelope.half_length()) < 4e-4F);
        if (burst > 10) // a long burst is at -6 dB at its ends
            CHECK(static_cast<double>(envelope(static_cast<float>(length / 2))) ==
                  doctest::Approx(0.5).epsilon(1e-3).scale(1e-30));
    }
}

TEST_CASE("pulse: the envelope ends four standard deviations beyond the ends of the burst") {
    const float sigma = pulse{}.sigma_z(5_MHz), cycle = 1540 / 2.0F / 5_MHz;
    CHECK(pulse{}.burst == 0);
    CHECK(pulse_envelope{}.sigma == 1); // a Gaussian with standard deviation 1
    CHECK(pulse_envelope{}.burst == 0);
    CHECK(pulse{}.envelope(5_MHz).half_length() == doctest::Approx(4 * sigma).scale(1e-30));
    CHECK(pulse{.burst = 3}.envelope(5_MHz).half_length() == doctest::Approx(4 * sigma + 1.5F * cycle).scale(1e-30));
    CHECK(pulse_envelope{.sigma = 1, .burst = 0.012F}(1) == doctest::Approx(std::exp(-0.5)).epsilon(1e-4).scale(1e-30));
}

TEST_CASE("pulse: the bandwidth of a probe determines its nominal pulse; a probe without one has the default pulse") {
    struct pencil {
        std::uint32_t lines = 1;
        float frequency = 1_MHz;
        ray beam(float) const { return {}; }
        vec2 locate(vec2 point) const { return point; }
        void check() const {}
    };
    CHECK(nominal_pulse(pencil{}).cycles == 2.5F);
    CHECK(nominal_pulse(linear_array{}).cycles == doctest::Approx(2.5).scale(1e-30));
    CHECK(nominal_pulse(linear_array{.bandwidth = 0.77F}).bandwidth() == doctest::Approx(0.77).scale(1e-30));
    CHECK(nominal_pulse(linear_array{}).frequency == 0);
}

TEST_CASE("pulse: a frequency other than that of the probe and settings out of range are refused") {
    CHECK_NOTHROW(pulse{}.check(5_MHz));
    CHECK_NOTHROW(pulse{.frequency = 5_MHz}.check(5_MHz));
    CHECK_NOTHROW(pulse{.frequency = 5.00004_MHz}.check(5_MHz)); // rounded on its way
    CHECK_THROWS_AS(pulse{.frequency = 5.00006_MHz}.check(5_MHz), usage_error);
    CHECK_NOTHROW(pulse{.cycles = 0.8F}.check(5_MHz));
    CHECK_THROWS_AS(pulse{.frequency = 7.5_MHz}.check(5_MHz), usage_error);
    CHECK_THROWS_AS(pulse{.frequency = 5.01_MHz}.check(5_MHz), usage_error);
    const float infinite = std::numeric_limits<float>::infinity();
    for (const float bad : {-1.0F, infinite, std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_THROWS_AS(pulse{.cycles = bad}.check(5_MHz), usage_error);
        CHECK_THROWS_AS(pulse{.frequency = bad}.check(5_MHz), usage_error);
        CHECK_THROWS_AS(pulse{.burst = bad}.check(5_MHz), usage_error);
    }
    CHECK_THROWS_AS(pulse{.cycles = 0}.check(5_MHz), usage_error);
}

TEST_CASE("pulse: a ring-down follows an echo, and leaves what is before it and its peak") {
    const float carrier = 7.5_MHz;
    const pulse plain{.cycles = 3.9F}, ringing{.cycles = 3.9F, .ring_down_db = -16};
    const pulse_envelope before = plain.envelope(carrier), after = ringing.envelope(carrier);
    CHECK(after.half_length() == before.half_length());
    float steepest_up = 0, steepest_down = 0, last = 0;
    double power[2] = {};
    for (float x = -before.half_length(); x < after.length_behind(); x += 5_um) {
        const float here = after(x);
        if (x <= 0) CHECK(here == before(x));
        CHECK(here <= 1.001F);
        const float level = 20 * std::log10(max(here, 1e-2F)); // 40 dB of a picture
        if (x > -before.half_length()) {
            steepest_up = max(steepest_up, level - last);
            steepest_down = max(steepest_down, last - level);
        }
        last = level;
        power[0] += double{before(x)} * double{before(x)};
        power[1] += double{here} * double{here};
    }
    // As in clinical pictures: the upper edge of a bright line is 1.07 to 1.34 times as steep as the lower one.
    CHECK(steepest_up > 1.07F * steepest_down);
    CHECK(std::fabs(10 * std::log10(power[1] / power[0])) < 0.25);
    CHECK_THROWS_WITH_AS((pulse{.ring_down_db = 3}.check(carrier)),
                         "pulse: `ring_down_db` must be 0 or below, such as -16; by default there is no ring-down",
                         usage_error);
}
