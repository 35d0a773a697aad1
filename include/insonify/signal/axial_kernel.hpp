#ifndef INSONIFY_SIGNAL_AXIAL_KERNEL_HPP
#define INSONIFY_SIGNAL_AXIAL_KERNEL_HPP

#include <insonify/core/later.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/signal/taps.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// The envelope of a pulse along a line of complex samples, with one result for every `decimation` samples.
///
/// Result k stands in the middle of samples k D to k D + D - 1: for an even D between two of them. A line is laid out
/// by remainder: its samples 0, D, 2 D, ..., then 1, D + 1, ..., each row with zeros around it, so that a tap reads
/// consecutive samples for consecutive results.
class axial_kernel {
  public:
    axial_kernel() = default;
    INSONIFY_LAZY axial_kernel(std::size_t samples, const pulse_envelope& envelope, std::size_t decimation) {
        set(samples, envelope, decimation);
    }

    /// Another kernel in the same memory. @param envelope  in samples
    INSONIFY_LAZY void set(std::size_t samples, const pulse_envelope& envelope, std::size_t decimation) {
        decimation_ = decimation;
        results_ = samples / decimation;
        const auto reach = static_cast<std::size_t>(lesser(envelope.reach(), static_cast<float>(samples)));
        zeros_ = reach / decimation + 1;
        stride_ = results_ + 2 * zeros_ + tap_room;
        taps_.clear();
        const std::size_t begin = zeros_ * decimation; // of the line, in samples, were it not laid out by remainder
        for (std::size_t at = begin - reach; at < begin + reach + decimation; ++at) {
            const float middle = static_cast<float>(begin) + 0.5F * static_cast<float>(decimation - 1);
            const float from_middle = static_cast<float>(at) - middle;
            if (std::fabs(from_middle) > envelope.reach()) continue;
            later<Later>(taps_).push_back(
                {.weight = envelope(from_middle),
                 .offset = static_cast<std::ptrdiff_t>(at % decimation * stride_ + at / decimation)});
        }
    }

    /// Of a laid-out line, in samples.
    std::size_t layout_size() const { return decimation_ * stride_; }

    /// About what a line takes.
    float nanoseconds() const { return static_cast<float>(results_ * (2 + taps_.size() / 8)); }

    /// @param layout  zeros, or a line laid out before
    INSONIFY_LAZY void lay_out(const vec2* line, vec2* layout) const {
        for (std::size_t remainder = 0; remainder < decimation_; ++remainder)
            for (std::size_t i = 0; i < results_; ++i)
                layout[remainder * stride_ + zeros_ + i] = line[i * decimation_ + remainder];
    }

    /// @tparam Width  floats that are worked on at once
    template <int Width>
    void apply(const vec2* layout, vec2* results) const {
        sum_taps<Width>({taps_.data(), taps_.size()}, layout, results, results_);
    }

  private:
    std::size_t decimation_ = 1;
    std::size_t results_ = 0;
    std::size_t zeros_ = 0;  // before the samples of a remainder, and after them
    std::size_t stride_ = 0; // from one remainder to the next
    std::vector<tap> taps_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
