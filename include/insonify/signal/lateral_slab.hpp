#ifndef INSONIFY_SIGNAL_LATERAL_SLAB_HPP
#define INSONIFY_SIGNAL_LATERAL_SLAB_HPP

#include <insonify/signal/lateral_kernel.hpp>
#include <algorithm>
#include <utility>

namespace insonify::inline INSONIFY_ABI::detail {

/// A copy of a few consecutive samples of every line, for filtering across the lines. H is the half width of the
/// kernel:
///
///     line  -H ... -1 | 0 ... lines - 1 | lines ... lines - 1 + H
///           zeros, or for a full circle the lines from the other end
///
/// The samples of a line are contiguous and each has its own weights, so that SIMD works along the line.
class lateral_slab {
  public:
    static constexpr std::size_t samples = 32;

    /// @param memory  scratch memory; grows as needed
    lateral_slab(const lateral_kernel& kernel, std::vector<vec2>& memory)
        : kernel_{kernel}, lines_{kernel.lines}, half_width_{kernel.half_width()} {
        const std::size_t rows = 2 * (half_width_ + 1) + lines_ + 2 * half_width_;
        memory.resize(rows * samples);
        weights_ = memory.data();
        tails_ = weights_ + (half_width_ + 1) * samples;
        values_ = tails_ + (half_width_ + 1) * samples;
        std::fill(values_, values_ + half_width_ * samples, vec2{0, 0});
        std::fill(row(lines_), row(lines_) + half_width_ * samples, vec2{0, 0});
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

    /// Copies samples of all lines. @param stride  from line to line
    void copy(const vec2* from, std::size_t stride, std::size_t count) {
        for (std::size_t line = 0; line < lines_; ++line) std::copy_n(from + line * stride, count, row(line));
        if (!kernel_.full_circle) return;
        std::copy_n(row(lines_ - half_width_), half_width_ * samples, values_);
        std::copy_n(row(0), half_width_ * samples, row(lines_));
    }

    /// Filters across the lines; the weights are normalized over the lines that exist.
    /// @tparam Width  floats in a SIMD register
    template <int Width>
    void apply(vec2* to, std::size_t stride, std::size_t count) const {
        vec2 sums[samples];
        for (std::size_t line = 0; line < lines_; ++line) {
            const std::size_t after = lines_ - 1 - line;
            const bool whole = kernel_.full_circle || (line >= half_width_ && after >= half_width_);
            vec2* out = whole && count == samples ? to + line * stride : sums;
            for (std::size_t part = 0; part < samples; part += std::size_t{4} * Width)
                sum_neighbours<Width>(row(line) + part, weights_ + part, out + part, std::make_index_sequence<8>{});
            if (!whole)
                for (std::size_t k = 0; k < count; ++k)
                    sums[k] /= 1 - (line < half_width_ ? tails_[line * samples + k].x : 0) -
                               (after < half_width_ ? tails_[after * samples + k].x : 0);
            if (out == sums) std::copy_n(sums, count, to + line * stride);
        }
    }

  private:
    vec2* row(std::size_t line) const { return values_ + (half_width_ + line) * samples; }

    // As many samples as eight SIMD registers hold; the sums stay in registers.
    template <int Width, std::size_t... I>
    INSONIFY_INLINE void sum_neighbours(const vec2* here, const vec2* weights, vec2* to,
                                        std::index_sequence<I...>) const {
        const auto floats = [](const vec2* at) { return reinterpret_cast<const float*>(at); };
        lanes<Width> sums[] = {load<Width>(floats(here) + I * Width) * load<Width>(floats(weights) + I * Width)...};
        for (std::size_t apart = samples; apart <= half_width_ * samples; apart += samples) {
            const float *left = floats(here - apart), *right = floats(here + apart), *weight = floats(weights + apart);
            ((sums[I] = multiply_add(load<Width>(left + I * Width) + load<Width>(right + I * Width),
                                     load<Width>(weight + I * Width), sums[I])),
             ...);
        }
        (store(sums[I], reinterpret_cast<float*>(to) + I * Width), ...);
    }

    const lateral_kernel& kernel_;
    std::size_t lines_ = 0;
    std::size_t half_width_ = 0;
    vec2* weights_ = nullptr; // by distance in lines, that of each sample twice: for x and y
    vec2* tails_ = nullptr;   // by distance in lines: sum of the weights beyond
    vec2* values_ = nullptr;
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
