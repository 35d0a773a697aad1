#include <insonify/acoustics/physical.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/signal/kernel/kernel_compensation.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace {

// The power of speckle on a line, over all pairs of lines, where each is raised by its gain.
template <class Gain>
double power_of_pairs(const detail::lateral_weights& weights, std::uint32_t line, float turned, const Gain& gain) {
    const auto here = static_cast<int>(line);
    std::vector<double> amplitudes;
    double sum = 0, power = 0;
    for (int offset = weights.first(line); offset <= weights.last(line); ++offset) {
        const auto weight = static_cast<double>(weights.half[static_cast<std::size_t>(std::abs(offset))]);
        sum += weight;
        amplitudes.push_back(weight * static_cast<double>(gain(static_cast<std::uint32_t>(here + offset))));
    }
    for (std::size_t i = 0; i < amplitudes.size(); ++i)
        for (std::size_t j = 0; j < amplitudes.size(); ++j) {
            const auto lag = static_cast<float>(i > j ? i - j : j - i);
            power += amplitudes[i] * amplitudes[j] *
                     static_cast<double>(physical{}.covariance(lag * weights.spacing, lag * turned));
        }
    return power / (sum * sum);
}

// By how much the level of speckle differs from the model's, in decibels, on any line at some depths.
template <class Probe>
double worst_error(const Probe& probe, float depth) {
    const detail::elevation_planes planes{beam_of(probe, depth), 1, depth, detail::lines_follow_depth(probe)};
    detail::planes_of_lines of_lines;
    of_lines.assign(exec::seq, probe, planes);
    detail::kernel_table table;
    detail::compute_kernel_table(exec::par_unseq, probe, depth, of_lines, physical{}, table);
    const detail::kernel_table_view found = table.view_of();
    constexpr std::uint32_t step = detail::lateral_kernel::depth_step;
    const detail::lateral_kernel kernel =
        detail::make_lateral_kernel(probe, {.depth = depth, .samples = found.depths * step});
    const float turned = std::acos(min(dot(probe.beam(0).direction, probe.beam(1).direction), 1));
    double worst = 0;
    for (const std::uint32_t part : {0U, 1U, 2U, 5U, 20U, 100U}) {
        const detail::lateral_weights weights = kernel.at(part * step);
        for (std::uint32_t line = 0; line < probe.lines; ++line) {
            const auto gain = [&](std::uint32_t of) { return found.of_line(of, 0).samples[part].speckle_gain; };
            worst = std::max(worst, std::fabs(10 * std::log10(power_of_pairs(weights, line, turned, gain))));
        }
    }
    return worst;
}

} // namespace

TEST_CASE("kernel_table: the level of speckle is kept on every line, also where lines are taken in groups") {
    // The five rounds of the fixed point leave 0.3 dB near the ends of the face; groups add less than 0.01 dB.
    CHECK(worst_error(linear_array{.lines = 96, .width = 20_mm, .frequency = 5_MHz}, 50_mm) < 0.2);
    CHECK(worst_error(convex_array{.lines = 96, .frequency = 3.5_MHz}, 100_mm) < 0.02);
    for (const std::uint32_t lines : {64U, 101U, 192U}) {
        CAPTURE(lines);
        CHECK(worst_error(phased_array{.lines = lines, .frequency = 2.5_MHz}, 150_mm) < 0.3);
    }
}
