#ifndef INSONIFY_SIGNAL_KERNEL_KERNEL_TABLE_HPP
#define INSONIFY_SIGNAL_KERNEL_KERNEL_TABLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/bvh/large_array.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/signal/beam.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/signal/kernel/kernel_compensation.hpp>
#include <insonify/signal/kernel/lateral_kernel.hpp>
#include <algorithm>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// `kernel_table` in flat arrays. Trivially copyable.
struct kernel_table_view {
    static constexpr std::uint32_t depths = 128; ///< parts of the displayed depth

    view<const detail::kernel_sample>
        samples{}; ///< by distance of the line from the border, then by depth; empty: no compensation
    view<const std::uint32_t> sets{};   ///< of each line, the number of its set of planes
    view<const float> plane_heights{};  ///< for each set and part those of all planes: see `detail::line_kernels`
    view<const float> plane_weights{};  ///< for each set and part those of all planes
    view<const float> random_weights{}; ///< of each set and plane those of all parts
    view<const vec2> plane_strips{};    ///< of each set and plane those of all parts
    std::uint32_t planes = 1;           ///< elevation planes
    std::uint32_t lines = 0;            ///< of the probe
    std::uint32_t border = 0;           ///< lines further than this from the border share a table
    float spacing = 1;                  ///< metres to each part

    /// The kernels along one line of one plane.
    INSONIFY_FN detail::line_kernels of_line(std::uint32_t line, std::uint32_t plane) const {
        if (samples.empty()) return {};
        const std::uint32_t other_end = lines - 1 - line, nearer = line < other_end ? line : other_end;
        const std::uint32_t row = nearer < border ? nearer : border;
        const std::size_t of_set = std::size_t{planes} * depths, set = sets[line] * of_set,
                          of_plane = set + std::size_t{plane} * depths;
        return {.samples = {samples.data() + std::size_t{row} * depths, depths},
                .spacing = spacing,
                .planes = planes,
                .plane = plane,
                .plane_heights = {plane_heights.data() + set, of_set},
                .plane_weights = {plane_weights.data() + set, of_set},
                .random_weights = {random_weights.data() + of_plane, depths},
                .plane_strips = {plane_strips.data() + of_plane, depths}};
    }
};

/// The kernels of `convolve` and of the planes, for every line of a probe, with the gains that keep the levels.
///
/// Averaging lowers the rms of random echoes, by an amount that depends on the lines and planes. The gain g compensates
/// for it: sum over j, k of w_j g_j w_k g_k C(x_j - x_k) = 1 on every line, with the weights w of the kernels and the
/// planes, and the covariance C of the echoes. Lines near the border have fewer neighbours, hence tables of their own.
class kernel_table {
  public:
    /// Without compensation.
    void clear() { samples_.resize(0); }

    /// Computes the table in the same memory.
    /// @param of_lines          the gains are those of the planes along the middle line
    /// @param speckle, surface  covariance(metres apart in the slice plane and out of it, radians turned, height of the
    ///                          scatterers) of speckle, and of the echoes of rough surfaces
    template <class Policy, transducer Probe, class Speckle, class Surface>
    void compute(const Policy& policy, const Probe& probe, float depth, const planes_of_lines& of_lines,
                 const Speckle& speckle, const Surface& surface) {
        planes_ = of_lines[0].count();
        lines_ = probe.lines;
        spacing_ = depth / depths;
        sets_ = of_lines.set_of_line();
        const elevation_planes& planes = of_lines[sets_[probe.lines / 2]];
        const beam_model beam = beam_of(probe, depth);
        // One step of the kernel for each of the depths.
        kernel_ = make_lateral_kernel(probe, {.depth = depth, .samples = depths * lateral_kernel::depth_step},
                                      std::move(kernel_));
        border_ =
            kernel_.full_circle ? 0 : std::min(static_cast<std::uint32_t>(kernel_.half_width()), (probe.lines - 1) / 2);
        samples_.resize(std::size_t{border_ + 1} * depths);
        for (std::vector<float>* const each : {&plane_heights_, &plane_weights_, &random_weights_})
            each->resize(of_lines.sets() * depths * planes_);
        plane_strips_.resize(plane_heights_.size());
        work_.resize(depths);
        constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
        const float turned = probe.lines < 2 ? 0.0F : angle_between(probe.beam(0).direction, probe.beam(1).direction);
        for_each_index(policy, depths, [&](std::size_t k) {
            const float z = (static_cast<float>(k) + 0.5F) * spacing_;
            const elevation_planes::weights weights = planes.at(z);
            for (std::size_t set = 0; set < of_lines.sets(); ++set) {
                const elevation_planes::weights here = of_lines[set].at(z);
                const std::size_t first = set * depths * planes_;
                for (std::uint32_t i = 0; i < planes_; ++i) {
                    plane_heights_[first + k * planes_ + i] = of_lines[set][i].height(z);
                    plane_weights_[first + k * planes_ + i] = here.coherent[i];
                    plane_strips_[first + std::size_t{i} * depths + k] = here.strip[i];
                    random_weights_[first + std::size_t{i} * depths + k] =
                        min(here.random[i] / max(here.coherent[i], 1e-12F), max_random_weight);
                }
            }
            const lateral_weights across = kernel_.at(static_cast<std::uint32_t>(k) * lateral_kernel::depth_step);
            scratch& work = work_[k];
            const auto levels_with = [&](levels& found, const auto& covariance) {
                const correlations correlated{across, turned, planes, z, covariance, work.of_lines};
                find_levels<width>(across, weights.random, correlated,
                                   max_slope * 4 * pi * probe.frequency / display_speed, work, found);
            };
            levels &of_speckle = work.speckle, &of_surface = work.surface, &uncorrelated = work.uncorrelated;
            levels_with(of_speckle, speckle);
            levels_with(of_surface, surface);
            levels_with(uncorrelated, [](vec2, float) { return 0.0F; });
            for (std::uint32_t line = 0; line <= border_; ++line)
                samples_[std::size_t{line} * depths + k] = {
                    .lateral_sigma = probe.lines > 1 ? beam.lateral_sigma(z) : 0.0F,
                    .elevation_sigma = beam.elevation_sigma(z),
                    .line_spacing = across.spacing,
                    .divergence = across.spacing > 0 ? turned / across.spacing : 0.0F,
                    .speckle_gain = of_speckle.gain[line],
                    .speckle_spread = of_speckle.spread[line],
                    .speckle_loss = of_speckle.loss[line],
                    .surface_gain = of_surface.gain[line],
                    .surface_spread = of_surface.spread[line],
                    .uncorrelated_gain = uncorrelated.gain[line]};
        });
    }

    detail::kernel_table_view view_of() const {
        return {.samples = {samples_.data(), samples_.size()},
                .sets = sets_,
                .plane_heights = plane_heights_,
                .plane_weights = plane_weights_,
                .random_weights = random_weights_,
                .plane_strips = plane_strips_,
                .planes = planes_,
                .lines = lines_,
                .border = border_,
                .spacing = spacing_};
    }

  private:
    static constexpr std::uint32_t depths = detail::kernel_table_view::depths;
    static constexpr float max_slope = 0.25F; // to which the loss of speckle on a slope is fitted: 14 degrees

    // By distance from the border.
    struct levels {
        std::vector<float> gain;
        std::vector<vec2> spread;
        std::vector<float> loss;
    };

    // Memory for one depth.
    struct scratch {
        std::vector<float> of_lines, level, amplitudes;
        levels speckle, surface, uncorrelated;
    };

    // The covariance of the echoes of two planes, and of two lines, at one depth.
    struct correlations {
        std::uint32_t planes;
        float of_planes[max_elevation_planes][max_elevation_planes] = {};
        float apart[max_elevation_planes][max_elevation_planes] = {}; // metres from plane to plane
        std::vector<float>& of_lines;                                 // by distance in lines

        template <class Covariance>
        correlations(const lateral_weights& across, float turned, const elevation_planes& all, float depth,
                     const Covariance& covariance, std::vector<float>& memory)
            : planes{all.count()}, of_lines{memory} {
            of_lines.assign(2 * across.half.size() - 1, 1.0F);
            for (std::uint32_t i = 0; i < planes; ++i)
                for (std::uint32_t j = 0; j < planes; ++j) {
                    apart[i][j] = all[i].height(depth) - all[j].height(depth);
                    of_planes[i][j] =
                        i == j ? 1.0F
                               : covariance(vec2{0, std::fabs(apart[i][j])}, std::fabs(all[i].slope - all[j].slope));
                }
            for (std::size_t lag = 1; lag < of_lines.size(); ++lag) {
                const auto lines = static_cast<float>(lag);
                of_lines[lag] = covariance(vec2{lines * across.spacing, 0}, lines * turned);
            }
        }
    };

    // @param steepest  phase per metre across the lines, at which the loss is exact
    template <int Width>
    void find_levels(const lateral_weights& across, const float (&weight)[max_elevation_planes],
                     const correlations& correlated, float steepest, scratch& work, levels& found) const {
        float power = 0, distance_squared = 0;
        for (std::uint32_t i = 0; i < correlated.planes; ++i)
            for (std::uint32_t j = 0; j < correlated.planes; ++j) {
                const float apart = correlated.apart[i][j];
                const float common = weight[i] * weight[j] * correlated.of_planes[i][j];
                power += common;
                distance_squared += common * apart * apart;
            }
        const auto between_lines = [&](int lag) { return correlated.of_lines[static_cast<std::size_t>(lag)]; };
        const auto lag_squared = [&](int lag) {
            const float apart = static_cast<float>(lag) * across.spacing;
            return between_lines(lag) * apart * apart;
        };
        const auto to_border = [&](std::uint32_t line) { return std::min({line, lines_ - 1 - line, border_}); };
        const auto on_slope = [&](int lag) {
            return between_lines(lag) * std::cos(steepest * static_cast<float>(lag) * across.spacing);
        };
        found.gain.assign(border_ + 1, 1.0F);
        found.spread.resize(border_ + 1);
        found.loss.resize(border_ + 1);
        work.level.resize(border_ + 1);
        const auto gain_of = [&](std::uint32_t line) { return found.gain[to_border(line)]; };
        const auto power_with = [&](std::uint32_t line, const auto& covariance) {
            return power * across.power<Width>(line, covariance, gain_of, work.amplitudes);
        };
        for (int round = 0; round < 5; ++round) { // a line's level depends on its neighbours' gains: a fixed point
            for (std::uint32_t line = 0; line <= border_; ++line) work.level[line] = power_with(line, between_lines);
            for (std::uint32_t line = 0; line <= border_; ++line) found.gain[line] /= std::sqrt(work.level[line]);
        }
        for (std::uint32_t line = 0; line <= border_; ++line) {
            found.spread[line] = {power_with(line, lag_squared), distance_squared / power};
            const float squared = steepest * steepest, lost = -std::log(max(power_with(line, on_slope), 0.1F));
            found.loss[line] = (lost - 0.5F * squared * found.spread[line].x) / (squared * squared);
        }
    }

    static float angle_between(vec3 a, vec3 b) { return 2 * std::asin(min(0.5F * length(a - b), 1)); }

    // Limits the gain of planes with less than a thousandth of the coherent weight: a scatterer that is displayed at a depth
    // where the weight is larger would be too bright.
    static constexpr float max_random_weight = 30;

    std::uint32_t planes_ = 1;
    std::uint32_t lines_ = 0;
    std::uint32_t border_ = 0;
    float spacing_ = 1;
    large_array<detail::kernel_sample> samples_;
    std::vector<std::uint32_t> sets_;
    std::vector<float> plane_heights_, plane_weights_, random_weights_;
    std::vector<vec2> plane_strips_;
    lateral_kernel kernel_;
    std::vector<scratch> work_; // for each depth
};

/// Computes the table for a model that states the covariance of its speckle; no compensation for others.
template <class Policy, transducer Probe, class Model>
void compute_kernel_table(const Policy& policy, const Probe& probe, float depth, const planes_of_lines& planes,
                          const Model& model, kernel_table& table) {
    if constexpr (states_covariance<Model>)
        table.compute(
            policy, probe, depth, planes,
            [&](vec2 apart, float turned) {
                if constexpr (requires { Model::independent_planes; })
                    if (Model::independent_planes && apart.y != 0) return 0.0F;
                return model.covariance(apart.x + apart.y, turned);
            },
            [&](vec2 apart, float turned) {
                if constexpr (states_surface_covariance<Model>)
                    return model.surface_covariance(apart.x + apart.y, turned);
                else
                    return model.covariance(apart.x + apart.y, turned);
            });
    else
        table.clear();
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
