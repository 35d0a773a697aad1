#include <insonify/acoustics/tissue.hpp>
#include <insonify/doppler/pulsed_doppler.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

namespace pulsed_doppler_test {
namespace {

constexpr float peak = 0.4F;
const linear_array probe{.lines = 96, .width = 30_mm, .frequency = 5_MHz, .focus = 20_mm};

struct tube {
    scene body{tissue_around()};
    vec3 along;
    poiseuille stream;

    explicit tube(float angle) : along{std::sin(angle), 0, std::cos(angle)} {
        const vec3 middle{0, 0, 20_mm};
        stream = {.from = middle - 60_mm * along, .to = middle + 60_mm * along, .radius = 4_mm, .peak_velocity = peak};
        medium blood = tissue::blood;
        blood.sound_speed = display_speed;
        stream.object = body.add(make_cylinder(stream.from, stream.to, 4_mm, 96), blood);
        body.build(exec::par);
    }
    static medium tissue_around() {
        medium around = tissue::liver;
        around.structure = {};
        around.sound_speed = display_speed;
        return around;
    }
};

/// Mean of all windows.
std::vector<double> mean_of(const doppler_spectrum& spectrum) {
    std::vector<double> mean(spectrum.bins);
    for (std::uint32_t window = 0; window < spectrum.windows; ++window)
        for (std::uint32_t i = 0; i < spectrum.bins; ++i)
            mean[i] += static_cast<double>(spectrum(window, i)) / spectrum.windows;
    return mean;
}

/// Mean and standard deviation of the velocity between two velocities.
struct moments {
    double mean = 0, deviation = 0;

    moments(const doppler_spectrum& spectrum, float lowest, float highest) {
        const std::vector<double> power = mean_of(spectrum);
        double all = 0, squares = 0;
        for (std::uint32_t i = 0; i < spectrum.bins; ++i) {
            const float velocity = spectrum.velocity(i);
            if (velocity < lowest || velocity > highest) continue;
            all += power[i];
            mean += power[i] * static_cast<double>(velocity);
            squares += power[i] * static_cast<double>(velocity * velocity);
        }
        mean /= all;
        deviation = std::sqrt(squares / all - mean * mean);
    }
};

} // namespace

TEST_CASE("pulsed Doppler: the spectrum of a gate on the axis is that of the peak velocity") {
    for (const float angle : {30_deg, 45_deg, 60_deg}) {
        const tube t{angle};
        const doppler_spectrum found = pulsed_doppler(exec::par_unseq, t.body, probe, pose{}, t.stream,
                                                      {.line = 48,
                                                       .gate = 20_mm,
                                                       .gate_length = 0.5_mm,
                                                       .prf = 8_kHz,
                                                       .duration = 0.5F,
                                                       .spectrum = {.angle = angle},
                                                       .burst = 3,
                                                       .depth = 40_mm});
        // The velocity at which a parabola around the peak of the mean spectrum is largest.
        const std::vector<double> mean = mean_of(found);
        std::uint32_t top = 0;
        for (std::uint32_t i = 0; i < found.bins; ++i)
            if (mean[i] > mean[top]) top = i;
        double all = 0, peak_velocity = 0;
        for (std::uint32_t i = 0; i < found.bins; ++i)
            if (mean[i] > 0.5 * mean[top]) {
                all += mean[i];
                peak_velocity += mean[i] * static_cast<double>(found.velocity(i));
            }
        peak_velocity /= all;
        MESSAGE(std::lround(angle * 180 / pi), " degrees: the peak is at ", -peak_velocity, " m/s, expected ", peak,
                " (", 100 * (-peak_velocity / static_cast<double>(peak) - 1), " %)");
        CHECK(-peak_velocity == doctest::Approx(static_cast<double>(peak)).epsilon(0.05).scale(1e-30));
    }
}

TEST_CASE("pulsed Doppler: the spectrum is as wide as the aperture is seen from the gate") {
    // Plug flow: all blood moves alike, so the width is that of the beam and of the pulse alone.
    for (const float angle : {45_deg, 75_deg}) {
        const tube t{angle};
        const auto plug = [&](object_id of, vec3, float) {
            return of == t.stream.object ? peak * t.along : vec3{0, 0, 0};
        };
        const doppler_spectrum found = pulsed_doppler(exec::par_unseq, t.body, probe, pose{}, plug,
                                                      {.line = 48,
                                                       .gate = 20_mm,
                                                       .gate_length = 1_mm,
                                                       .prf = 8_kHz,
                                                       .duration = 0.5F,
                                                       .spectrum = {.window = 256},
                                                       .burst = 24,
                                                       .depth = 40_mm});
        const auto axial = -peak * std::cos(angle), across = peak * std::sin(angle);
        const double width = moments{found, axial - 0.12F, min(axial + 0.12F, -0.02F)}.deviation;
        // Echoes arrive and leave within +-1 / (2 F): the amplitude of a rectangular aperture is a triangle of velocities,
        // +- across / (2 F), whose square has the standard deviation across / (2 F sqrt(10)).
        const double aperture = static_cast<double>(across) / (2 * 2 * std::sqrt(10.0));
        MESSAGE(std::lround(angle * 180 / pi), " degrees: width ", width, " m/s, expected ", aperture, " (",
                100 * (width / aperture - 1), " %)");
        CHECK(std::fabs(width / aperture - 1) < 0.2);
    }
}

TEST_CASE("pulsed Doppler: the spectrum of sheared flow ends where that of plug flow of its peak velocity does") {
    for (const float angle : {45_deg, 63_deg}) {
        const tube t{angle};
        const auto fastest = [&](const auto& field) { // where the mean spectrum is 20 dB below its peak
            const doppler_spectrum found = pulsed_doppler(
                exec::par_unseq, t.body, probe, pose{}, field,
                {.line = 48, .gate = 20_mm, .gate_length = 0.5_mm, .prf = 12_kHz, .duration = 0.3F, .depth = 40_mm});
            const std::vector<double> mean = mean_of(found);
            const double top = *std::max_element(mean.begin(), mean.end());
            std::uint32_t first = 0;
            while (mean[first] < 0.01 * top) ++first;
            return static_cast<double>(-found.velocity(first));
        };
        const double sheared = fastest(t.stream), plug = fastest([&](object_id of, vec3, float) {
                                                      return of == t.stream.object ? peak * t.along : vec3{0, 0, 0};
                                                  });
        MESSAGE(std::lround(angle * 180 / pi), " degrees: ", sheared, " m/s, plug flow ", plug);
        CHECK(sheared < 1.12 * plug);
        CHECK(sheared > 0.9 * plug);
    }
}

TEST_CASE("pulsed Doppler: a beat has its peak in systole and its end-diastolic velocity before; the level stays") {
    tube t{45_deg};
    t.stream.waveform = {.heart_rate = 2_Hz, .resistive_index = 0.6F};
    const doppler_spectrum found = pulsed_doppler(exec::par_unseq, t.body, probe, pose{}, t.stream,
                                                  {.line = 48,
                                                   .gate = 20_mm,
                                                   .gate_length = 0.5_mm,
                                                   .prf = 8_kHz,
                                                   .duration = 0.5F,
                                                   .spectrum = {.window = 64, .angle = 45_deg},
                                                   .burst = 4,
                                                   .depth = 40_mm});
    const auto mean_at = [&](float from, float to) {
        double sum = 0, count = 0;
        for (std::uint32_t window = 0; window < found.windows; ++window) {
            const float time = found.first_time + found.interval * static_cast<float>(window), beat = time * 2;
            const float phase = beat - std::floor(beat);
            if (phase < from || phase > to) continue;
            sum += static_cast<double>(found.mean_velocity(window));
            ++count;
        }
        return -sum / count;
    };
    const double systole = mean_at(0.12F, 0.18F), diastole = mean_at(0.9F, 1.0F);
    MESSAGE("systole ", systole, " m/s, expected 0.4; end of diastole ", diastole,
            " m/s, expected 0.16; resistive index ", 1 - diastole / systole, ", expected 0.6");
    CHECK(systole == doctest::Approx(0.4).epsilon(0.08).scale(1e-30));
    CHECK(diastole == doctest::Approx(0.16).epsilon(0.15).scale(1e-30));
}

TEST_CASE("pulsed Doppler: threads do not matter; the gate's blood stays at one level over a long series") {
    const tube t{60_deg};
    const pulsed_doppler_settings settings{.line = 48, .gate = 22_mm, .prf = 4_kHz, .duration = 0.4F, .depth = 40_mm};
    gate_scanner<> gate;
    const std::vector<vec2> series =
        gate.gate_echoes(exec::par_unseq, t.body, probe, pose{}, physical{}, t.stream, settings);
    CHECK(series == gate.gate_echoes(exec::unseq, t.body, probe, pose{}, physical{}, t.stream, settings));
    CHECK(series.size() == 1600);
    vec2 middle{0, 0};
    for (const vec2 value : series) middle += value / static_cast<float>(series.size());
    double first = 0, last = 0;
    for (std::size_t k = 0; k < series.size(); ++k)
        (k < series.size() / 2 ? first : last) += static_cast<double>(dot(series[k] - middle, series[k] - middle));
    MESSAGE("level of the second half over the first: ", 10 * std::log10(last / first), " dB, expected 0");
    CHECK(std::fabs(10 * std::log10(last / first)) < 2);
}

TEST_CASE("pulsed Doppler: memory of another gate changes nothing") {
    const tube t{60_deg};
    gate_scanner<> own;
    const auto drawn = [&](const pulsed_doppler_settings& settings) {
        return own.acquire(exec::par_unseq, t.body, probe, pose{}, physical{}, t.stream, settings);
    };
    const pulsed_doppler_settings settings{.line = 48, .gate = 22_mm, .prf = 4_kHz, .duration = 0.1F, .depth = 40_mm},
        other{.line = 20, .gate = 12_mm, .gate_length = 3_mm, .prf = 6_kHz, .duration = 0.05F, .depth = 30_mm};
    const doppler_spectrum first = drawn(settings);
    CHECK(drawn(other) != first);
    CHECK(drawn(settings) == first);
    CHECK(first == pulsed_doppler(exec::par_unseq, t.body, probe, pose{}, t.stream, settings));
}

TEST_CASE("pulsed Doppler: settings out of range are refused") {
    const tube t{60_deg};
    const auto attempt = [&](const pulsed_doppler_settings& settings) {
        pulsed_doppler(exec::seq, t.body, probe, pose{}, t.stream, settings);
    };
    CHECK_THROWS_WITH(attempt({.line = 96}), "pulsed_doppler: line 96 is not one of the probe, which has 96");
    CHECK_THROWS_AS(attempt({.gate = 22}), usage_error);
    CHECK_THROWS_AS(attempt({.gate_length = -1}), usage_error);
    CHECK_THROWS_AS(attempt({.duration = 1e6F}), usage_error);
    CHECK_THROWS_AS(attempt({.depth = 40}), usage_error);
    CHECK_THROWS_AS(attempt({.spectrum = {.window = 100}}), usage_error);
    CHECK_THROWS_WITH(attempt({.burst = std::numeric_limits<float>::infinity()}),
                      "pulse: `burst` must be a finite number of cycles, or 0 for impulse excitation");
}

} // namespace pulsed_doppler_test
