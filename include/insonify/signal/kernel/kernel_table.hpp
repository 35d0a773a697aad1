#ifndef INSONIFY_SIGNAL_KERNEL_KERNEL_TABLE_HPP
#define INSONIFY_SIGNAL_KERNEL_KERNEL_TABLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/bvh/large_array.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/signal/kernel/compensated_echoes.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Lateral weights at one depth; normalized over the lines that exist.
struct lateral_weights {
    view<const float> half{}; ///< by distance in lines, 0 to `half_width`; both sides sum to 1
    std::uint32_t lines = 1;  ///< number of lines of the probe
    bool full_circle = false; ///< the last line is next to the first
    float spacing = 0;        ///< distance between lines at this depth, metres

    INSONIFY_FN int half_width() const { return static_cast<int>(half.size()) - 1; }

    /// Offsets of the first and the last neighbour that exist.
    INSONIFY_FN int first(std::uint32_t line) const {
        const int before = static_cast<int>(line);
        return full_circle || before > half_width() ? -half_width() : -before;
    }
    INSONIFY_FN int last(std::uint32_t line) const {
        const int after = static_cast<int>(lines - 1 - line);
        return full_circle || after > half_width() ? half_width() : after;
    }

    /// Sum of the weights over the lines that exist, by which they are divided: 1 except near the ends.
    INSONIFY_FN float existing(std::uint32_t line) const {
        const int begin = first(line), end = last(line);
        if (begin == -half_width() && end == half_width()) return 1;
        float sum = 0;
        for (int offset = begin; offset <= end; ++offset) sum += weight(offset);
        return sum;
    }

    /// Power of incoherent echoes on a line after weighting: sum_jk w_j g_j w_k g_k C(x_j - x_k).
    /// @tparam Width       floats in a SIMD register
    /// @param covariance   C of the echoes on two lines, by their distance in lines, for all of the kernel; 0 from some on
    /// @param gain         g(line), amplitude of the echoes of a line before weighting
    /// @param amplitudes   scratch memory
    template <int Width, class Gain>
    float power(std::uint32_t line, view<const float> covariance, const Gain& gain,
                std::vector<float>& amplitudes) const {
        const int begin = first(line), end = last(line), here = static_cast<int>(line), count = static_cast<int>(lines);
        amplitudes.resize(static_cast<std::size_t>(end - begin) + 1);
        float* to = amplitudes.data();
        for (int offset = begin; offset <= end; ++offset) {
            int neighbour = here + offset;
            if (full_circle) neighbour = (neighbour + count) % count;
            *to++ = weight(offset) * gain(static_cast<std::uint32_t>(neighbour));
        }
        const auto neighbours = static_cast<std::ptrdiff_t>(amplitudes.size());
        const float* const a = amplitudes.data();
        float sum = 0;
        for (std::ptrdiff_t lag = 0; lag < neighbours; ++lag) {
            const float correlated = covariance[static_cast<std::size_t>(lag)];
            if (lag > 0 && !(std::fabs(correlated) > 0)) break;
            const float* const b = a + lag;
            const std::ptrdiff_t products = neighbours - lag, whole = products - products % Width;
            lanes<Width> in_lanes(0.0F);
            for (std::ptrdiff_t i = 0; i < whole; i += Width)
                in_lanes = multiply_add(load<Width>(a + i), load<Width>(b + i), in_lanes);
            float parts[Width], of_lag = 0;
            store(in_lanes, parts);
            for (const float part : parts) of_lag += part;
            for (std::ptrdiff_t i = whole; i < products; ++i) of_lag += a[i] * b[i];
            sum += (lag == 0 ? 1 : 2) * correlated * of_lag;
        }
        const float all = existing(line);
        return sum / (all * all);
    }

  private:
    INSONIFY_FN float weight(int offset) const { return half[static_cast<std::size_t>(offset < 0 ? -offset : offset)]; }
};

/// Those at the centre of the depth step that contains a sample.
inline lateral_weights weights_at(const lateral_kernel& kernel, std::uint32_t sample) {
    const lateral_kernel::entry& e = kernel.entries[sample / lateral_kernel::depth_step];
    return {.half = {kernel.weights.data() + e.begin, e.count},
            .lines = kernel.lines,
            .full_circle = kernel.full_circle,
            .spacing = e.spacing};
}

/// `kernel_table` in flat arrays. Trivially copyable.
struct kernel_table_view {
    static constexpr std::uint32_t depths = 128; ///< parts of the displayed depth

    view<const kernel_sample> samples{}; ///< by distance from the border in lines, then by part; empty: no compensation
    view<const std::uint32_t> sets{};    ///< of each line, the number of its set of planes
    view<const plane_sample> of_planes{};         ///< by set, then by part, then by plane
    std::uint32_t planes = 1;                     ///< elevation planes
    std::uint32_t lines = 0;                      ///< of the probe
    std::uint32_t border = 0;                     ///< lines further than this from the border share a table
    float spacing = 1;                            ///< metres to each part
    float speckle_length = 0, surface_length = 0; ///< as in `line_kernels`

    /// The kernels along one line of one plane.
    INSONIFY_FN line_kernels of_line(std::uint32_t line, std::uint32_t plane) const {
        if (samples.empty()) return {};
        const std::uint32_t other_end = lines - 1 - line, nearer = line < other_end ? line : other_end;
        const std::size_t row = nearer < border ? nearer : border, of_set = std::size_t{planes} * depths;
        return {.samples = {samples.data() + row * depths, depths},
                .of_planes = {of_planes.data() + sets[line] * of_set, of_set},
                .spacing = spacing,
                .planes = planes,
                .plane = plane,
                .speckle_length = speckle_length,
                .surface_length = surface_length};
    }
};

/// The kernels of `convolve` and of the planes, for every line of a probe, with the gains that keep the levels.
///
/// Averaging lowers the rms of random echoes. The gain g compensates for it: sum over j, k of w_j g_j w_k g_k C(x_j -
/// x_k) = 1 on every line, with the weights w of the kernels and the planes, and the covariance C of the echoes. Lines
/// near the border have fewer neighbours, hence tables of their own.
class kernel_table {
  public:
    /// Covariance of two echoes, by metres apart in the slice plane and out of it, and radians turned.
    using covariance = function_ref<float(vec2 apart, float turned)>;

    /// Computes the table in the same memory.
    /// @param of_lines          the gains are those of the planes along the middle line
    /// @param speckle, surface  of speckle, and of the echoes of rough surfaces
    template <class Policy>
    void compute(const Policy& policy, const probe_lines& all, float depth, const planes_of_lines& of_lines,
                 const covariance& speckle, const covariance& surface) {
        const probe_settings& probe = all.settings();
        planes_ = of_lines[0].count();
        lines_ = probe.lines;
        spacing_ = depth / depths;
        sets_ = of_lines.set_of_line();
        const elevation_planes& planes = of_lines[sets_[probe.lines / 2]];
        const beam_model beam = make_beam(probe, depth);
        // One step of the kernel for each of the depths.
        kernel_ = make_lateral_kernel(probe, {.depth = depth, .samples = depths * lateral_kernel::depth_step},
                                      std::move(kernel_));
        border_ =
            kernel_.full_circle ? 0 : std::min(static_cast<std::uint32_t>(kernel_.half_width()), (probe.lines - 1) / 2);
        samples_.resize(std::size_t{border_ + 1} * depths);
        of_planes_.resize(of_lines.sets() * depths * planes_);
        work_.resize(depths);
        speckle_length_ = correlation_length(speckle);
        surface_length_ = correlation_length(surface);
        constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
        const float chord = probe.lines < 2 ? 0.0F : length(all[0].direction - all[1].direction),
                    turned = 2 * std::asin(min(0.5F * chord, 1));
        for_each_index(policy, depths, [&](std::size_t k) {
            const float z = (static_cast<float>(k) + 0.5F) * spacing_;
            const elevation_planes::weights weights = planes.at(z);
            for (std::size_t set = 0; set < of_lines.sets(); ++set) {
                const elevation_planes::weights here = of_lines[set].at(z);
                for (std::uint32_t i = 0; i < planes_; ++i)
                    of_planes_[(set * depths + k) * planes_ + i] = {
                        .height = of_lines[set][i].height(z),
                        .weight = here.coherent[i],
                        .random_weight = min(here.random[i] / max(here.coherent[i], 1e-12F), max_random_weight),
                        .strip = here.strip[i]};
            }
            const lateral_weights across =
                weights_at(kernel_, static_cast<std::uint32_t>(k) * lateral_kernel::depth_step);
            scratch& work = work_[k];
            const auto levels_with = [&](levels& found, const covariance& of) {
                find_levels<width>(across, turned, planes, z, weights.random,
                                   max_slope * 4 * pi * probe.frequency / display_speed, of, work, found);
            };
            levels_with(work.speckle, speckle);
            levels_with(work.surface, surface);
            levels_with(work.uncorrelated, [](vec2, float) { return 0.0F; });
            for (std::uint32_t line = 0; line <= border_; ++line)
                samples_[std::size_t{line} * depths + k] = {
                    .lateral_sigma = probe.lines > 1 ? beam.lateral_sigma(z) : 0.0F,
                    .elevation_sigma = beam.elevation_sigma(z),
                    .line_spacing = across.spacing,
                    .divergence = across.spacing > 0 ? turned / across.spacing : 0.0F,
                    .speckle = work.speckle[line],
                    .surface = work.surface[line],
                    .uncorrelated_gain = work.uncorrelated[line].gain};
        });
    }

    kernel_table_view view_of() const {
        return {.samples = {samples_.data(), samples_.size()},
                .sets = sets_,
                .of_planes = of_planes_,
                .planes = planes_,
                .lines = lines_,
                .border = border_,
                .spacing = spacing_,
                .speckle_length = speckle_length_,
                .surface_length = surface_length_};
    }

  private:
    static constexpr std::uint32_t depths = kernel_table_view::depths;
    static constexpr float max_slope = 0.25F; // to which the loss of speckle on a slope is fitted: 14 degrees

    using levels = std::vector<kernel_level>; // by distance from the border

    // Memory for one depth.
    struct scratch {
        std::vector<float> of_lags;                  // covariance of two lines, by their distance
        std::vector<float> half;                     // weights of groups
        std::vector<float> common, squared, sloping; // of two groups, by their distance
        std::vector<float> power, amplitudes;
        levels of_groups, speckle, surface, uncorrelated;
    };

    // The integral of a covariance over the distance in the slice plane, to either side, metres.
    static float correlation_length(const covariance& of) {
        constexpr float step = 10e-6F; // metres
        constexpr int steps = 200;
        float sum = 1;
        for (int i = 1; i < steps; ++i) sum += 2 * of(vec2{step * static_cast<float>(i), 0}, 0);
        return step * max(sum, 0);
    }

    // Lines that lie much closer together than the kernel is wide are taken in groups, each as one line: near the apex
    // of a sector the kernel reaches over all of them.
    static constexpr float groups_under_kernel = 13;          // of its integral over its peak
    static constexpr std::uint32_t border_in_half_widths = 2; // from there on the ends of the face do not matter

    static lateral_weights grouped(const lateral_weights& across, int size, std::vector<float>& half) {
        if (size == 1) return across;
        half.clear();
        float sum = 0;
        for (int offset = 0; offset <= across.half_width(); offset += size) {
            half.push_back(across.half[static_cast<std::size_t>(offset)]);
            sum += (offset == 0 ? 1.0F : 2.0F) * half.back();
        }
        for (float& weight : half) weight /= sum;
        const auto lines = static_cast<std::uint32_t>(size);
        return {.half = half,
                .lines = (across.lines + lines / 2) / lines,
                .full_circle = across.full_circle,
                .spacing = across.spacing * static_cast<float>(size)};
    }
    // The mean of a function of the distance of two lines, over the lines of two groups, by the distance of these.
    template <class OfLag>
    static void mean_over_groups(const OfLag& of_lag, int size, std::vector<float>& means) {
        for (std::size_t lag = 0; lag < means.size(); ++lag) {
            float sum = 0;
            for (int more = 1 - size; more < size; ++more)
                sum += static_cast<float>(size - std::abs(more)) *
                       of_lag(static_cast<std::size_t>(std::abs(static_cast<int>(lag) * size + more)));
            means[lag] = sum / static_cast<float>(size * size);
        }
    }

    // @param turned      radians from line to line
    // @param weight      of independent echoes, of each plane
    // @param steepest    phase per metre across the lines, at which the loss is exact
    template <int Width>
    void find_levels(const lateral_weights& lines, float turned, const elevation_planes& planes, float depth,
                     const float (&weight)[max_elevation_planes], float steepest, const covariance& common_of,
                     scratch& work, levels& found) const {
        float power = 0, distance_squared = 0;
        for (std::uint32_t i = 0; i < planes_; ++i)
            for (std::uint32_t j = 0; j < planes_; ++j) {
                const float apart = std::fabs(planes[i].height(depth) - planes[j].height(depth));
                const float common =
                    weight[i] * weight[j] *
                    (i == j ? 1 : common_of(vec2{0, apart}, std::fabs(planes[i].slope - planes[j].slope)));
                power += common;
                distance_squared += common * apart * apart;
            }
        const int size =
            lines.full_circle ? 1 : std::max(static_cast<int>(1 / (lines.half[0] * groups_under_kernel)), 1);
        const lateral_weights across = grouped(lines, size, work.half);
        const std::size_t lags = 2 * across.half.size() - 1;
        work.of_lags.assign((lags + 1) * static_cast<std::size_t>(size), 1.0F);
        for (std::size_t lag = 1; lag < work.of_lags.size(); ++lag) {
            const auto distance = static_cast<float>(lag);
            work.of_lags[lag] = common_of(vec2{distance * lines.spacing, 0}, distance * turned);
        }
        const auto metres = [&](std::size_t lag) { return static_cast<float>(lag) * lines.spacing; };
        for (std::vector<float>* const each : {&work.common, &work.squared, &work.sloping}) each->resize(lags);
        mean_over_groups([&](std::size_t lag) { return work.of_lags[lag]; }, size, work.common);
        mean_over_groups([&](std::size_t lag) { return work.of_lags[lag] * metres(lag) * metres(lag); }, size,
                         work.squared);
        mean_over_groups([&](std::size_t lag) { return work.of_lags[lag] * std::cos(steepest * metres(lag)); }, size,
                         work.sloping);

        const std::uint32_t border =
            std::min({border_ / static_cast<std::uint32_t>(size), (across.lines - 1) / 2,
                      border_in_half_widths * static_cast<std::uint32_t>(across.half_width())});
        levels& own = work.of_groups;
        own.assign(border + 1, kernel_level{});
        work.power.resize(border + 1);
        const auto gain_of = [&](std::uint32_t line) {
            return own[std::min({line, across.lines - 1 - line, border})].gain;
        };
        const auto power_with = [&](std::uint32_t line, const std::vector<float>& of_lag) {
            return power * across.power<Width>(line, view<const float>{of_lag}, gain_of, work.amplitudes);
        };
        for (int round = 0; round < 5; ++round) { // a line's level depends on its neighbours' gains: a fixed point
            for (std::uint32_t line = 0; line <= border; ++line) work.power[line] = power_with(line, work.common);
            for (std::uint32_t line = 0; line <= border; ++line) own[line].gain /= std::sqrt(work.power[line]);
        }
        for (std::uint32_t line = 0; line <= border; ++line) {
            own[line].spread = {power_with(line, work.squared), distance_squared / power};
            const float squared = steepest * steepest, lost = -std::log(max(power_with(line, work.sloping), 0.1F));
            own[line].loss = (lost - 0.5F * squared * own[line].spread.x) / (squared * squared);
        }

        found.resize(border_ + 1);
        for (std::uint32_t line = 0; line <= border_; ++line) {
            // At the end of the face extrapolated.
            const float place =
                min((static_cast<float>(line) + 0.5F) / static_cast<float>(size) - 0.5F, static_cast<float>(border));
            const auto before = static_cast<std::uint32_t>(max(place, 0));
            const kernel_level &a = own[before], &b = own[std::min(before + 1, border)];
            const float part = place - static_cast<float>(before);
            found[line] = {a.gain + part * (b.gain - a.gain), a.spread + part * (b.spread - a.spread),
                           a.loss + part * (b.loss - a.loss)};
        }
    }

    // Limits the gain of planes with less than a thousandth of the coherent weight: a scatterer that is displayed at a
    // depth where the weight is larger would be too bright.
    static constexpr float max_random_weight = 30;

    std::uint32_t planes_ = 1;
    std::uint32_t lines_ = 0;
    std::uint32_t border_ = 0;
    float spacing_ = 1;
    float speckle_length_ = 0, surface_length_ = 0;
    large_array<kernel_sample> samples_;
    std::vector<std::uint32_t> sets_;
    std::vector<plane_sample> of_planes_;
    lateral_kernel kernel_;
    std::vector<scratch> work_; // for each depth
};

/// Computes the table for a model that states the covariance of its speckle; that of others stays empty.
template <class Policy, class Model>
void compute_kernel_table(const Policy& policy, const probe_lines& probe, float depth, const planes_of_lines& planes,
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
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
