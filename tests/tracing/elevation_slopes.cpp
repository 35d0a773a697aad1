#include <insonify/acoustics/physical.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/tracing/trace.hpp>
#include "../thread_sanitizer.hpp"
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace elevation_slopes_test {
namespace {

const linear_array probe{.lines = 300, .width = 30_mm, .frequency = 7.5_MHz};
constexpr float image_depth = 50_mm, steep = 40_deg;
constexpr std::uint32_t samples = 2500; // 20 um

/// Mean power by depth of a rough surface that the slice meets at one depth, turned out of it.
std::vector<double> power_by_depth(float depth, float turned, std::uint32_t planes) {
    const medium rough{.density = 1500, .sound_speed = 1540, .roughness = 200_um};
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 60_mm}), rough,
             {.at = look_at({0, 0, depth}, {0, std::sin(turned), depth + std::cos(turned)}, {1, 0, 0})});
    body.build(exec::par);
    std::vector<double> power(samples);
    for (std::uint32_t seed = 1; seed <= 24; ++seed) {
        const physical<> model{.seed = seed};
        const iq_lines seen = convolve(exec::par_unseq,
                                       trace(exec::par_unseq, body, probe, pose{}, model,
                                             {.depth = image_depth, .samples = samples, .planes = planes}),
                                       pulse{}, probe);
        for (std::uint32_t line = 30; line < 270; ++line)
            for (std::uint32_t k = 0; k < samples; ++k)
                power[k] += static_cast<double>(dot(seen(line, k), seen(line, k)));
    }
    return power;
}

} // namespace
} // namespace elevation_slopes_test

TEST_CASE("a rough surface that is steep out of the slice is as thick as the beam, without gaps between planes") {
    using namespace elevation_slopes_test;
    const beam_model beam = beam_of(probe, image_depth);
    for (const float turned : {-steep, steep})
        for (const float depth : {10_mm, 20_mm, 35_mm})
            for (const std::uint32_t planes : {5U, 7U}) {
                if (thread_sanitizer && (depth != 20_mm || planes != 5)) continue;
                const std::vector<double> found = power_by_depth(depth, turned, planes);
                // Of the power exp(-y^2 / sigma^2) of the beam, y tan(turned) deeper, and of the pulse.
                const auto wide = static_cast<double>(beam.elevation_sigma(depth) * std::tan(steep)),
                           pulse_wide = static_cast<double>(pulse{}.sigma_z(probe.frequency)),
                           variance = wide * wide + pulse_wide * pulse_wide;
                double sum = 0, expected_sum = 0, mean = 0, square = 0, smallest = 1e30, largest = 0;
                const auto shape = [&](std::uint32_t k) {
                    const double away = (k + 0.5) * 20e-6 - static_cast<double>(depth);
                    return std::pair{away, std::exp(-away * away / variance)};
                };
                for (std::uint32_t k = 0; k < samples; ++k) {
                    const auto [away, expected] = shape(k);
                    sum += found[k];
                    expected_sum += expected;
                    mean += found[k] * away;
                    square += found[k] * away * away;
                }
                for (std::uint32_t k = 0; k < samples; ++k) {
                    const auto [away, expected] = shape(k);
                    if (away * away > variance) continue; // where the beam has 0.37 of its power or more
                    const double level = found[k] / sum / (expected / expected_sum);
                    smallest = std::fmin(smallest, level);
                    largest = std::fmax(largest, level);
                }
                const double rms = std::sqrt(square / sum), expected_rms = std::sqrt(variance / 2);
                MESSAGE((turned / 1_deg), " degrees, ", (depth * 1e3F), " mm deep, ", planes, " planes: rms thickness ",
                        (1e3 * rms), " mm, expected ", (1e3 * expected_rms), "; middle ", (1e3 * mean / sum),
                        " mm from where the slice meets it; levels within ", (10 * std::log10(smallest)), " and ",
                        (10 * std::log10(largest)), " dB of the beam's");
                CHECK(std::fabs(rms / expected_rms - 1) < 0.15);
                CHECK(std::fabs(mean / sum) < 0.25 * expected_rms);
                CHECK(10 * std::log10(smallest) > -4);
                CHECK(10 * std::log10(largest) < 3);
            }
}
