#ifndef INSONIFY_SIGNAL_KERNEL_LATERAL_KERNEL_HPP
#define INSONIFY_SIGNAL_KERNEL_LATERAL_KERNEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/beam.hpp>
#include <insonify/signal/kernel/taps.hpp>
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
    /// @param covariance   C(lag) of the echoes on two lines, the lag in lines; 1 at lag 0, and 0 from some lag on
    /// @param gain         g(line), amplitude of the echoes of a line before weighting
    /// @param amplitudes   scratch memory
    template <int Width, class Covariance, class Gain>
    float power(std::uint32_t line, const Covariance& covariance, const Gain& gain,
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
            const float correlated = covariance(static_cast<int>(lag));
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

/// Lateral weights of `convolve` at every depth. Made by `make_lateral_kernel`.
///
/// Computed at the centre of every depth step and interpolated linearly, since steps would add noise.
struct lateral_kernel {
    static constexpr std::uint32_t depth_step = 4; ///< samples

    /// Range of the weights of a depth step in `weights`.
    struct entry {
        std::size_t begin = 0;
        std::size_t count = 0;
        float spacing = 0; ///< distance between lines, metres
    };
    std::uint32_t lines = 1;
    bool full_circle = false;   ///< the last line is next to the first
    double cycles_per_line = 0; ///< `line_advance` of the probe, cycles of the carrier of an echo
    std::vector<entry> entries;
    std::vector<float> weights;
    std::vector<std::ptrdiff_t> less; ///< by distance in lines: samples by which a wave front is less deep there

    /// Weights at the centre of the depth step that contains a sample.
    lateral_weights at(std::uint32_t sample) const { return of(entries[sample / depth_step]); }

    /// Weights at a sample: (1 - fraction) of the weights `above` plus `fraction` of those `below`.
    struct blend {
        view<const float> above{};
        view<const float> below{};
        float fraction = 0;
    };
    blend blend_at(std::uint32_t sample) const {
        const auto last = static_cast<float>(entries.size() - 1);
        const float place = clamp((static_cast<float>(sample) + 0.5F) / depth_step - 0.5F, 0, last);
        const auto first = static_cast<std::size_t>(place);
        const entry &above = entries[first], &below = entries[first + (place < last ? 1 : 0)];
        return {.above = {weights.data() + above.begin, above.count},
                .below = {weights.data() + below.begin, below.count},
                .fraction = place - static_cast<float>(first)};
    }

    /// The largest of all depths, in lines.
    std::size_t half_width() const {
        std::size_t longest = 1;
        for (const entry& e : entries) longest = std::max(longest, e.count);
        return longest - 1;
    }

    bool steered() const { return cycles_per_line != 0; }
    /// Phase of an echo on a line relative to that on line 0, at the same wave front.
    vec2 phase(std::ptrdiff_t line) const {
        const double cycles = cycles_per_line * static_cast<double>(line);
        const auto angle = 2 * pi * static_cast<float>(cycles - std::floor(cycles));
        return {std::cos(angle), std::sin(angle)};
    }

  private:
    lateral_weights of(const entry& e) const {
        return {.half = {weights.data() + e.begin, e.count},
                .lines = lines,
                .full_circle = full_circle,
                .spacing = e.spacing};
    }
};

/// @param scan      depth and samples of the lines; `samples` must not be 0
/// @param recycled  a kernel whose memory is reused
/// @throws usage_error  for a setting of the probe or acquisition out of range
template <transducer Probe>
lateral_kernel make_lateral_kernel(const Probe& probe, const acquisition& scan, lateral_kernel recycled = {}) {
    const beam_model beam = beam_of(probe, scan.depth);
    if (scan.samples == 0) throw usage_error{"make_lateral_kernel: `samples` is 0; it must be that of the lines"};
    constexpr std::uint32_t step = lateral_kernel::depth_step;
    lateral_kernel kernel = std::move(recycled);
    kernel.lines = probe.lines;
    kernel.full_circle = is_full_circle(probe);
    const float advance = line_advance(probe);
    kernel.cycles_per_line = 2.0 * static_cast<double>(probe.frequency) * static_cast<double>(advance / display_speed);
    auto& entries = kernel.entries;
    auto& weights = kernel.weights;
    entries.clear();
    weights.clear();
    const std::uint32_t last = kernel.full_circle ? (probe.lines - 1) / 2 : probe.lines - 1;
    for (std::uint32_t sample = 0; sample < scan.samples; sample += step) {
        const float depth = (static_cast<float>(sample) + 0.5F * step) * scan.depth / static_cast<float>(scan.samples);
        const float sigma = beam.lateral_sigma(depth), lobe = beam.side_lobe_width(depth);
        const float spacing = line_spacing(probe, depth);
        const float max_sigmas =
            max(kernel_sigmas, beam.side_lobes > 0 ? beam_model::side_lobe_extent * lobe / sigma : 0);
        const std::size_t begin = weights.size();
        double sum = 0;
        for (std::uint32_t offset = 0; offset <= last; ++offset) {
            const float apart = static_cast<float>(offset) * spacing, sigmas = apart / sigma;
            if (sigmas > max_sigmas) break;
            weights.push_back(std::exp(-0.5F * sigmas * sigmas) + beam.side_lobe(apart / lobe));
            sum += (offset == 0 ? 1 : 2) * static_cast<double>(weights.back());
        }
        const std::size_t end = weights.size();
        for (std::size_t i = begin; i < end; ++i)
            weights[i] = static_cast<float>(static_cast<double>(weights[i]) / sum);
        entries.push_back({.begin = begin, .count = end - begin, .spacing = spacing});
    }
    const float samples_per_line = advance * static_cast<float>(scan.samples) / scan.depth;
    kernel.less.resize(kernel.half_width() + 1);
    for (std::size_t i = 0; i < kernel.less.size(); ++i)
        kernel.less[i] = static_cast<std::ptrdiff_t>(std::lround(samples_per_line * static_cast<float>(i)));
    return kernel;
}

/// A copy of a few consecutive samples of every line, for filtering across the lines. H is the half width of the
/// kernel:
///
///     line  -H ... -1 | 0 ... lines - 1 | lines ... lines - 1 + H
///           zeros, or for a full circle the lines from the other end
///
/// The samples of a line are contiguous and each has its own weights, so that SIMD works along the line. Across steered
/// lines the filter follows the wave front: it reads neighbours a few samples above or below, which are copied too, and
/// with the phase that they have at the same wave front.
class lateral_slab {
  public:
    static constexpr std::size_t samples = 32;

    /// @param memory  scratch memory; grows as needed
    lateral_slab(const lateral_kernel& kernel, std::vector<vec2>& memory)
        : kernel_{kernel}, lines_{kernel.lines}, half_width_{kernel.half_width()},
          margin_{static_cast<std::size_t>(std::abs(kernel.less.back()))}, stride_{samples + 2 * margin_} {
        memory.resize(2 * (half_width_ + 1) * samples + (lines_ + 2 * half_width_) * stride_);
        weights_ = memory.data();
        tails_ = weights_ + (half_width_ + 1) * samples;
        values_ = tails_ + (half_width_ + 1) * samples;
        std::fill(values_, values_ + (lines_ + 2 * half_width_) * stride_, vec2{0, 0});
    }

    /// Computes the weights of samples `first` to `first` + `count` - 1.
    void weigh(std::size_t first, std::size_t count) {
        std::fill(weights_, values_, vec2{0, 0});
        for (std::size_t k = 0; k < count; ++k) {
            const lateral_kernel::blend at = kernel_.blend_at(static_cast<std::uint32_t>(first + k));
            for (std::size_t i = 0; i < at.above.size(); ++i)
                weights_[i * samples + k] += (1 - at.fraction) * at.above[i];
            for (std::size_t i = 0; i < at.below.size(); ++i) weights_[i * samples + k] += at.fraction * at.below[i];
        }
        for (std::size_t i = half_width_; i-- > 0;) // sum of the weights of the neighbours beyond the i-th
            for (std::size_t k = 0; k < samples; ++k)
                tails_[i * samples + k] = tails_[(i + 1) * samples + k] + weights_[(i + 1) * samples + k];
    }

    /// Copies samples of all lines.
    /// @param stride  from line to line
    /// @param before  samples of the lines before `from`
    /// @param after   samples of the lines after these
    void copy(const vec2* from, std::size_t stride, std::size_t count, std::size_t before = 0, std::size_t after = 0) {
        const std::size_t above = std::min(before, margin_), below = std::min(after, margin_);
        const auto beyond = static_cast<std::ptrdiff_t>(kernel_.full_circle ? half_width_ : 0);
        const auto lines = static_cast<std::ptrdiff_t>(lines_);
        for (std::ptrdiff_t line = -beyond; line < lines + beyond; ++line) {
            const vec2* source = from + static_cast<std::size_t>((line + lines) % lines) * stride - above;
            vec2* const to = row(line);
            std::fill(to - margin_, to - above, vec2{0, 0});
            std::copy_n(source, above + count + below, to - above);
            std::fill(to + count + below, to + samples + margin_, vec2{0, 0});
            if (kernel_.steered()) turn(to - above, above + count + below, kernel_.phase(-line));
        }
    }

    /// Filters across the lines; the weights are normalized over the lines that exist.
    /// @tparam Width  floats in a SIMD register
    /// @param to      in place only where lines are not steered
    template <int Width>
    void apply(vec2* to, std::size_t stride, std::size_t count) const {
        vec2 sums[samples];
        for (std::size_t line = 0; line < lines_; ++line) {
            const std::size_t after = lines_ - 1 - line;
            const bool whole = kernel_.full_circle || (line >= half_width_ && after >= half_width_);
            vec2* out = whole && count == samples ? to + line * stride : sums;
            const vec2* const here = row(static_cast<std::ptrdiff_t>(line));
            for (std::size_t part = 0; part < samples; part += std::size_t{4} * Width)
                sum_neighbours<Width>(here + part, weights_ + part, out + part, std::make_index_sequence<8>{});
            if (!whole)
                for (std::size_t k = 0; k < count; ++k)
                    sums[k] /= 1 - (line < half_width_ ? tails_[line * samples + k].x : 0) -
                               (after < half_width_ ? tails_[after * samples + k].x : 0);
            if (out == sums) std::copy_n(sums, count, to + line * stride);
            if (kernel_.steered()) turn(to + line * stride, count, kernel_.phase(static_cast<std::ptrdiff_t>(line)));
        }
    }

  private:
    vec2* row(std::ptrdiff_t line) const {
        return values_ + (static_cast<std::ptrdiff_t>(half_width_) + line) * static_cast<std::ptrdiff_t>(stride_) +
               margin_;
    }

    static void turn(vec2* values, std::size_t count, vec2 phase) {
        for (std::size_t k = 0; k < count; ++k)
            values[k] = {values[k].x * phase.x - values[k].y * phase.y, values[k].x * phase.y + values[k].y * phase.x};
    }

    // As many samples as eight SIMD registers hold; the sums stay in registers.
    template <int Width, std::size_t... I>
    INSONIFY_INLINE void sum_neighbours(const vec2* here, const vec2* weights, vec2* to,
                                        std::index_sequence<I...>) const {
        const auto floats = [](const vec2* at) { return reinterpret_cast<const float*>(at); };
        lanes<Width> sums[] = {load<Width>(floats(here) + I * Width) * load<Width>(floats(weights) + I * Width)...};
        const std::ptrdiff_t* const less_deep = kernel_.less.data();
        for (std::size_t apart = 1; apart <= half_width_; ++apart) {
            const std::ptrdiff_t less = less_deep[apart];
            const float *left = floats(here - apart * stride_ + less), *right = floats(here + apart * stride_ - less),
                        *weight = floats(weights + apart * samples);
            ((sums[I] = multiply_add(load<Width>(left + I * Width) + load<Width>(right + I * Width),
                                     load<Width>(weight + I * Width), sums[I])),
             ...);
        }
        (store(sums[I], reinterpret_cast<float*>(to) + I * Width), ...);
    }

    const lateral_kernel& kernel_;
    std::size_t lines_ = 0;
    std::size_t half_width_ = 0;
    std::size_t margin_ = 0;  // samples above and below that steered lines need
    std::size_t stride_ = 0;  // from line to line of the copy
    vec2* weights_ = nullptr; // by distance in lines, that of each sample twice: for x and y
    vec2* tails_ = nullptr;   // by distance in lines: sum of the weights beyond
    vec2* values_ = nullptr;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
