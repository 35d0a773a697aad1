#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/doppler/pulsed_doppler.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <numbers>

using namespace insonify;

namespace doppler_spectrum_test {
namespace {

std::vector<vec2> tone(std::size_t pulses, double cycles) {
    std::vector<vec2> series;
    for (std::size_t k = 0; k < pulses; ++k) {
        const double turn = 2 * std::numbers::pi * cycles * static_cast<double>(k);
        series.push_back({static_cast<float>(std::cos(turn)), static_cast<float>(std::sin(turn))});
    }
    return series;
}

std::uint32_t peak_of(const doppler_spectrum& spectrum, std::uint32_t window) {
    std::uint32_t peak = 0;
    for (std::uint32_t i = 0; i < spectrum.bins; ++i)
        if (spectrum(window, i) > spectrum(window, peak)) peak = i;
    return peak;
}

} // namespace

TEST_CASE("spectrum: a tone is in the bin of its velocity, with its power; baseline and angle") {
    const float largest = max_doppler_velocity(5_kHz, 5_MHz); // 0.385 m/s
    for (const double cycles : {0.25, -0.125, 0.4375})
        for (const float baseline : {0.0F, 0.25F, -0.5F})
            for (const float angle : {0.0F, 60_deg}) {
                const doppler_spectrum found = spectrum_of(exec::par, tone(1000, cycles), 5_kHz, largest, 2,
                                                           {.baseline = baseline, .angle = angle});
                const double turn = std::floor(cycles - static_cast<double>(baseline) + 0.5),
                             expected = 2 * (cycles - turn) * static_cast<double>(largest / std::cos(angle));
                CHECK(found.velocity(peak_of(found, 5)) == doctest::Approx(expected).epsilon(1e-4).scale(1e-30));
                double power = 0;
                for (std::uint32_t i = 0; i < found.bins; ++i) power += static_cast<double>(found(3, i));
                CHECK(power == doctest::Approx(1).scale(1e-30).epsilon(1e-3));
                CHECK(found.windows == (1000 - 128) / 32 + 1);
                CHECK(found.interval == doctest::Approx(32 / 5000.0).scale(1e-30));
                CHECK(found.first_time == doctest::Approx(2 + 64 / 5000.0).scale(1e-30));
            }
}

TEST_CASE("spectrum: tissue at rest is filtered out of each window; white noise is flat") {
    std::vector<vec2> series = tone(4096, 0.25);
    for (vec2& value : series) value += vec2{1000, -500};
    const doppler_spectrum found = spectrum_of(exec::par, series, 5_kHz, 0.385F, 0, {.window = 64});
    CHECK(found.mean_velocity(0) == doctest::Approx(0.1925).scale(1e-30).epsilon(1e-2));

    for (std::uint64_t i = 0; i < series.size(); ++i) series[i] = hash_normal(5, i);
    const doppler_spectrum noise = spectrum_of(exec::par, series, 5_kHz, 0.385F, 0, {.window = 64, .overlap = 0});
    double low = 0, high = 0;
    for (std::uint32_t window = 0; window < noise.windows; ++window)
        for (std::uint32_t i = 0; i < 64; ++i)
            (i % 32 < 16 ? low : high) += static_cast<double>(noise(window, i)) / noise.windows;
    MESSAGE("power of noise in two halves of the range ", low, " and ", high, ", expected 1 each");
    CHECK(low == doctest::Approx(1).scale(1e-30).epsilon(0.08));
    CHECK(high == doctest::Approx(1).scale(1e-30).epsilon(0.08));
    CHECK(noise == spectrum_of(exec::seq, series, 5_kHz, 0.385F, 0, {.window = 64, .overlap = 0}));
}

TEST_CASE("spectrum: settings out of range are refused") {
    const auto attempt = [](const spectrum_settings& settings, std::size_t pulses = 1000) {
        spectrum_of(exec::seq, tone(pulses, 0.1), 5_kHz, 0.385F, 0, settings);
    };
    CHECK_THROWS_AS(attempt({.window = 100}), usage_error);
    CHECK_THROWS_AS(attempt({.overlap = 1}), usage_error);
    CHECK_THROWS_AS(attempt({.baseline = 0.6F}), usage_error);
    CHECK_THROWS_AS(attempt({.angle = 89_deg}), usage_error);
    CHECK_THROWS_AS(attempt({.wall_order = 20}), usage_error);
    CHECK_THROWS_AS(attempt({.window = 8, .wall_order = 7}), usage_error);
    CHECK_THROWS_WITH(attempt({}, 100),
                      "spectrum_of: 100 pulses are fewer than the window of 128; lower it or raise the "
                      "duration");
    bool asked = false; // before anything is acquired
    const auto flow = [&](object_id, vec3, float) {
        asked = true;
        return vec3{0, 0, 0};
    };
    scene body{tissue::blood};
    body.build(exec::seq);
    CHECK_THROWS_AS(pulsed_doppler(exec::seq, body, linear_array{.lines = 4}, pose{}, flow,
                                   {.line = 1, .gate = 10_mm, .duration = 0.02F}),
                    usage_error);
    CHECK(!asked);
}

} // namespace doppler_spectrum_test
