#ifndef INSONIFY_SIGNAL_KERNEL_LATERAL_SLAB_HPP
#define INSONIFY_SIGNAL_KERNEL_LATERAL_SLAB_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/signal/kernel/lateral_kernel.hpp>
#include <algorithm>
#include <utility>

namespace insonify::inline INSONIFY_ABI::detail {

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
