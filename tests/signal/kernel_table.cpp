#include <insonify/acoustics/physical.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/signal/kernel/kernel_table.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace kernel_table_test {
namespace {

// One depth of a probe, line by line, in double precision.
struct lines_at_depth {
    detail::lateral_weights weights{};
    std::vector<double> common{}; // covariance of two lines, by their distance in lines

    // sum_jk w_j g_j w_k g_k C(j - k) f(j - k), over the square of the sum of the weights.
    template <class OfLag>
    double power(std::uint32_t line, const std::vector<double>& gains, const OfLag& of_lag) const {
        const int first = weights.first(line), last = weights.last(line);
        std::vector<double> amplitudes;
        double sum = 0, power = 0;
        for (int offset = first; offset <= last; ++offset) {
            const auto weight = static_cast<double>(weights.half[static_cast<std::size_t>(std::abs(offset))]);
            sum += weight;
            amplitudes.push_back(weight * gains[static_cast<std::size_t>(static_cast<int>(line) + offset)]);
        }
        for (std::size_t i = 0; i < amplitudes.size(); ++i)
            for (std::size_t j = 0; j < amplitudes.size(); ++j) {
                const std::size_t lag = i > j ? i - j : j - i;
                if (common[lag] != 0)
                    power += amplitudes[i] * amplitudes[j] * common[lag] *
                             of_lag(static_cast<double>(lag) * static_cast<double>(weights.spacing));
            }
        return power / (sum * sum);
    }

    // The gains after the five rounds that the table takes.
    std::vector<double> gains() const {
        std::vector<double> found(weights.lines, 1);
        for (int round = 0; round < 5; ++round) {
            std::vector<double> next = found;
            for (std::uint32_t line = 0; line < weights.lines; ++line)
                next[line] /= std::sqrt(power(line, found, [](double) { return 1.0; }));
            found = next;
        }
        return found;
    }
};

struct errors {
    double gain_db = 0;  // of speckle, of rough surfaces, and of independent echoes
    double slope_db = 0; // of the loss of speckle on a surface at 10 degrees
    double level_db = 0; // of the level that the gains of the table give
    int lines_of_groups = 1;
};

// The largest differences of the table from the sums over all lines, on any line at some depths.
template <class Probe>
errors errors_of(const Probe& probe, float depth) {
    const detail::elevation_planes planes{beam_of(probe, depth), 1, depth, detail::lines_follow_depth(probe)};
    detail::planes_of_lines of_lines;
    of_lines.assign(exec::seq, probe, planes);
    detail::kernel_table table;
    detail::compute_kernel_table(exec::par_unseq, probe, depth, of_lines, physical<>{}, table);
    const detail::kernel_table_view found = table.view_of();
    constexpr std::uint32_t step = detail::lateral_kernel::depth_step;
    const detail::lateral_kernel kernel =
        detail::make_lateral_kernel(probe, {.depth = depth, .samples = found.depths * step});
    const float turned = std::acos(min(dot(probe.beam(0).direction, probe.beam(1).direction), 1));
    const double q = 4 * std::acos(-1.0) * static_cast<double>(probe.frequency / display_speed) * std::tan(0.1745);
    errors worst;
    for (const std::uint32_t part : {0U, 1U, 2U, 5U, 20U, 100U}) {
        const auto of_field = [&](const auto& covariance) {
            lines_at_depth all{.weights = detail::weights_at(kernel, part * step)};
            for (std::uint32_t lag = 0; lag < probe.lines; ++lag)
                all.common.push_back(static_cast<double>(
                    covariance(static_cast<float>(lag) * all.weights.spacing, static_cast<float>(lag) * turned)));
            return all;
        };
        const auto speckle = of_field([](float d, float a) { return physical<>{}.covariance(d, a); }),
                   surface = of_field([](float d, float a) { return physical<>{}.surface_covariance(d, a); }),
                   alone = of_field([](float d, float) { return d == 0 ? 1.0F : 0.0F; });
        worst.lines_of_groups = std::max(worst.lines_of_groups,
                                         static_cast<int>(1 / (13 * speckle.weights.half[0]))); // as the table has it
        const std::vector<double> of_speckle = speckle.gains(), of_surface = surface.gains(), of_alone = alone.gains();
        std::vector<double> own;
        for (std::uint32_t line = 0; line < probe.lines; ++line)
            own.push_back(static_cast<double>(found.of_line(line, 0).samples[part].speckle.gain));
        for (std::uint32_t line = 0; line < probe.lines; ++line) {
            const detail::kernel_sample& here = found.of_line(line, 0).samples[part];
            const auto compare = [&](float gain, double expected) {
                const double db = std::fabs(20 * std::log10(static_cast<double>(gain) / expected));
                worst.gain_db = std::max(worst.gain_db, db);
            };
            compare(here.speckle.gain, of_speckle[line]);
            compare(here.surface.gain, of_surface[line]);
            compare(here.uncorrelated_gain, of_alone[line]);
            const double kept = speckle.power(line, of_speckle, [&](double d) { return std::cos(q * d); }),
                         level = speckle.power(line, of_speckle, [](double) { return 1.0; });
            const double spread = static_cast<double>(here.speckle.spread.x),
                         loss = static_cast<double>(here.speckle.loss);
            const double stated = 10 / std::log(10.0) * (0.5 * spread * q * q + loss * q * q * q * q);
            const double expected = -10 * std::log10(std::max(kept / level, 0.15));
            if (expected < 7) worst.slope_db = std::max(worst.slope_db, std::fabs(stated - expected));
            worst.level_db = std::max(worst.level_db,
                                      std::fabs(10 * std::log10(speckle.power(line, own, [](double) { return 1.0; }))));
        }
    }
    return worst;
}

} // namespace
} // namespace kernel_table_test

TEST_CASE("kernel_table: the levels of all lines, also where lines are taken in groups, are those of sums over pairs") {
    using namespace kernel_table_test;
    const auto check = [](const char* name, const errors& found, double gain_db, double slope_db) {
        MESSAGE(std::string{name}, ": gains within ", found.gain_db, " dB, slopes within ", found.slope_db,
                " dB, level within ", found.level_db, " dB; groups of up to ", found.lines_of_groups, " lines");
        CHECK(found.gain_db < gain_db);
        CHECK(found.slope_db < slope_db);
        CHECK(found.level_db < 0.3); // what five rounds of the fixed point leave near the ends of the face
    };
    const errors linear = errors_of(linear_array{.lines = 96, .width = 20_mm, .frequency = 5_MHz}, 50_mm);
    check("linear", linear, 0.01, 0.2);
    CHECK(linear.lines_of_groups == 1);
    check("convex", errors_of(convex_array{.lines = 96, .frequency = 3.5_MHz}, 100_mm), 0.02, 0.2);
    for (const std::uint32_t lines : {64U, 101U, 192U}) {
        const errors phased = errors_of(phased_array{.lines = lines, .frequency = 2.5_MHz}, 150_mm);
        check("phased", phased, 0.2, 0.2);
        CHECK(phased.lines_of_groups > 2);
    }
}
