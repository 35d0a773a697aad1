#include <insonify/acoustics/physical.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include "echoes.hpp"
#include "physical_scenes.hpp"
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("a tilted plate, traced and convolved, fades as a simulated aperture's does") { // V19, the whole way
    // Published for a plate in the focus, 30 mm deep, F/2: decibels against the plate across the beam.
    struct {
        float frequency;
        double level[5]; // at 2, 4, 6, 8 and 10 degrees
    } const rows[] = {{2.5_MHz, {-0.376, -1.714, -4.031, -6.397, -10.26}},
                      {5_MHz, {-0.536, -2.334, -4.245, -6.671, -10.053}},
                      {7.5_MHz, {-0.662, -2.503, -4.359, -6.778, -10.107}}};
    for (const auto& row : rows) {
        const linear_array probe{.lines = 301, .width = 30.1_mm, .frequency = row.frequency, .focus = 30_mm};
        double level[6];
        for (int i = 0; i <= 5; ++i) {
            const float tilt = static_cast<float>(2 * i) * 1_deg;
            const pose turned = look_at({0, 0, 30_mm}, {std::sin(tilt), 0, 30_mm + std::cos(tilt)},
                                        {std::cos(tilt), 0, -std::sin(tilt)});
            scene body{medium{.density = 1000, .sound_speed = 1540}};
            body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 40_mm}), medium{.density = 1200, .sound_speed = 1540},
                     {.at = turned});
            body.build(exec::par);
            const physical<> model{.specular = {.lobe = specular_return::lobe_shape::exact}};
            const acquisition scan{.depth = 40_mm, .samples = 4000};
            const scan_lines seen = envelope(
                exec::par, convolve(exec::par, trace(exec::par, body, probe, pose{}, model, scan), pulse{}, probe));
            float largest = 0;
            for (std::uint32_t k = 0; k < seen.samples; ++k) largest = std::max(largest, seen(150, k));
            level[i] = 20 * std::log10(static_cast<double>(largest));
        }
        for (int i = 1; i <= 5; ++i) {
            MESSAGE("V19 at ", row.frequency / 1e6F, " MHz, ", 2 * i, " degrees: ", level[i] - level[0],
                    " dB, simulated ", row.level[i - 1]);
            CHECK(std::fabs(level[i] - level[0] - row.level[i - 1]) < 1);
        }
    }
}

TEST_CASE("a plate that is tilted out of the slice fades by the aperture's height, however many planes there are") {
    const linear_array probe{.lines = 61,
                             .width = 12.2_mm,
                             .frequency = 5_MHz,
                             .focus = 30_mm,
                             .elevation_height = 7.5_mm,
                             .elevation_focus = 30_mm}; // F/4
    const specular_return lobe{.lobe = specular_return::lobe_shape::exact};
    for (const std::uint32_t planes : {1U, 5U, 7U}) {
        double level[4];
        for (int i = 0; i < 4; ++i) {
            const float tilt = static_cast<float>(i) * 1.5_deg;
            const pose turned = look_at({0, 0, 30_mm}, {0, std::sin(tilt), 30_mm + std::cos(tilt)}, {1, 0, 0});
            scene body{medium{.density = 1000, .sound_speed = 1540}};
            body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 40_mm}), medium{.density = 1200, .sound_speed = 1540},
                     {.at = turned});
            body.build(exec::par);
            const acquisition scan{.depth = 40_mm, .samples = 4000, .planes = planes};
            const iq_lines echoes = trace(exec::par, body, probe, pose{}, physical<>{.specular = lobe}, scan);
            const scan_lines seen = envelope(exec::par, convolve(exec::par, echoes, pulse{}, probe));
            float largest = 0;
            for (std::uint32_t k = 0; k < seen.samples; ++k) largest = std::max(largest, seen(30, k));
            level[i] = 20 * std::log10(static_cast<double>(largest));
            const double expected = 20 * std::log10(static_cast<double>(lobe(tilt, 4, 30e-3F * 5e6F / 1540)));
            MESSAGE(planes, " planes, ", (1.5 * i), " degrees: ", level[i] - level[0], " dB, expected ", expected);
            if (i > 0 && expected > -12) CHECK(std::fabs(level[i] - level[0] - expected) < 1);
        }
    }
}

TEST_CASE("a rough surface scatters at its calibrated level, at any tilt, with any texture beside it") {
    // RMS sqrt(R (1 - exp(-4 k^2 h^2 cos^2 i)) cos^2 i 0.166 / (F#x F#y)); 200 um leave nothing of the mirror echo.
    const linear_array probe{.lines = 300, .width = 30_mm, .frequency = 5_MHz, .focus = 20_mm}; // F/2, F/4 in elevation
    const medium rough{.density = 1500, .sound_speed = 1540, .roughness = 200_um};
    for (const float degrees : {0.0F, 5.0F, 20.0F})
        for (const float cell : {0.2_mm, 0.5_mm}) {
            const float tilt = degrees * 1_deg;
            double power = 0, count = 0;
            for (std::uint32_t seed = 1; seed <= 12; ++seed) {
                const pose turned = look_at({0, 0, 20_mm}, {std::sin(tilt), 0, 20_mm + std::cos(tilt)},
                                            {std::cos(tilt), 0, -std::sin(tilt)});
                scene body{medium{.density = 1000, .sound_speed = 1540}};
                body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 60_mm}), rough, {.at = turned});
                body.build(exec::par);
                const physical<> model{.scattering = {.cell = cell}, .seed = seed};
                const iq_lines echoes =
                    trace(exec::par, body, probe, pose{}, model, {.depth = 30_mm, .samples = 3000, .planes = 3});
                const iq_lines seen = convolve(exec::par, echoes, pulse{}, probe);
                for (std::uint32_t line = 30; line < 270; ++line) { // where the line meets the plate
                    const double x = (line + 0.5) / 300 * 30 - 15;
                    const double z = 20 - x * std::tan(static_cast<double>(tilt));
                    const auto k = static_cast<std::uint32_t>(z / 30 * 3000);
                    power += std::pow(static_cast<double>(length(seen(line, k))), 2), count += 1;
                }
            }
            const double r = 0.2, cosine = std::cos(static_cast<double>(tilt)); // (1500 - 1000) / 2500 at any angle
            const double expected = 10 * std::log10(r * r * cosine * cosine * 0.166 / (2 * 4));
            MESSAGE(degrees, " degrees, cells of ", (cell * 1e3F), " mm: ", 10 * std::log10(power / count),
                    " dB, expected ", expected);
            CHECK(std::fabs(10 * std::log10(power / count) - expected) < 1);
        }
}
