#include <insonify/acoustics/laws.hpp>
#include <doctest/doctest.h>
#include <initializer_list>

using namespace insonify;

TEST_CASE("attenuation: an echo loses 2 alpha0 f^b dB per metre") {
    CHECK(echo_loss({.attenuation = 50}, 5_MHz) ==
          doctest::Approx(500).scale(1e-30)); // 0.5 dB/cm/MHz: 5 dB/cm there and back
    CHECK(echo_loss({.attenuation = 100, .attenuation_power = 1.05F}, 2.5_MHz) ==
          doctest::Approx(200 * std::pow(2.5, 1.05)).scale(1e-30));
    CHECK(echo_loss({.attenuation = 0.217F, .attenuation_power = 2}, 5_MHz) == doctest::Approx(2 * 5.425).scale(1e-30));
}

TEST_CASE("attenuation: a broadband pulse loses less at its peak, and its centre frequency falls") { // V7
    const broadband_echo found = attenuated(echo_loss({.attenuation = 50}, 5_MHz) * 4_cm, 5_MHz, 0.6F);
    MESSAGE("V7: ", found.loss_db, " dB at ", found.frequency / 1e6F, " MHz; expected 18.5 dB at 4.25 MHz");
    CHECK(std::fabs(found.loss_db - 18.5F) < 0.3F);
    CHECK(std::fabs(found.frequency - 4.25_MHz) < 0.05_MHz);
    CHECK(attenuated(20, 5_MHz, 1e-3F).loss_db == doctest::Approx(20).epsilon(1e-4).scale(1e-30));
    CHECK(attenuated(0, 5_MHz, 0.6F).loss_db == 0);
    float before = 0;
    for (float db = 1; db < 400; db += 1) { // the loss never falls, the frequency stays above half
        const broadband_echo deep = attenuated(db, 5_MHz, 0.8F);
        CHECK(deep.loss_db >= before);
        CHECK(deep.frequency >= 2.4999_MHz);
        before = deep.loss_db;
    }
}

TEST_CASE("attenuation: the loss is finite for every valid medium") {
    for (const float attenuation : {0.0F, FLT_TRUE_MIN, 50.0F, FLT_MAX})
        for (const float power : {0.0F, 1.0F, 1.1F, 1e20F, FLT_MAX})
            for (const float frequency : {1e3F, 1e6F, 5e6F}) {
                const medium m{.attenuation = attenuation, .attenuation_power = power};
                REQUIRE(is_valid(m));
                CHECK(is_finite(echo_loss(m, frequency)));
            }
    CHECK(echo_loss({.attenuation = FLT_MAX}, 5e6F) == FLT_MAX);
}

TEST_CASE("attenuation: the broadband closed form equals the integral over the attenuated spectrum") {
    // The peak of the pulse is the integral of its spectrum, all components being in phase.
    const double f0 = 5e6, sigma = 0.6 * f0 / 2.3548, beta = 0.115129255 * 20 / f0;
    double with = 0, without = 0, centre = 0;
    for (double f = -10e6; f < 20e6; f += 1e3) {
        const double spectrum = std::exp(-0.5 * std::pow((f - f0) / sigma, 2));
        without += spectrum;
        with += spectrum * std::exp(-beta * f);
        centre += f * spectrum * std::exp(-beta * f);
    }
    CHECK(broadband_echo{}.loss_db == 0);
    CHECK(broadband_echo{}.frequency == 0);
    const broadband_echo found = attenuated(20, 5_MHz, 0.6F);
    CHECK(static_cast<double>(found.loss_db) ==
          doctest::Approx(-20 * std::log10(with / without)).epsilon(1e-4).scale(1e-30));
    CHECK(static_cast<double>(found.frequency) == doctest::Approx(centre / with).epsilon(1e-4).scale(1e-30));
}

namespace attenuation_test {
namespace {
struct lossless { // a minimal law
    float operator()(const medium&, float) const { return 0; }
};
} // namespace
static_assert(attenuation_law<lossless> && attenuation_law<power_law> && !attenuation_law<int>);
} // namespace attenuation_test
