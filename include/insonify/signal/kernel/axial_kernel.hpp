#ifndef INSONIFY_SIGNAL_KERNEL_AXIAL_KERNEL_HPP
#define INSONIFY_SIGNAL_KERNEL_AXIAL_KERNEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/signal/kernel/taps.hpp>
#include <insonify/signal/pulse.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// FIR filter with the envelope of a pulse along a line of complex samples, with one result for every D samples, the
/// decimation.
///
/// Result k is at the centre of samples k D to k D + D - 1; for an even D this is between two samples. A line is stored
/// as D polyphase rows (samples 0, D, 2 D, ..., then 1, D + 1, ...), each padded with zeros, so that a tap reads
/// consecutive samples for consecutive results.
class axial_kernel {
  public:
    axial_kernel() = default;
    axial_kernel(std::size_t samples, const pulse_envelope& envelope, std::size_t decimation) {
        set(samples, envelope, decimation);
    }

    /// Recomputes the kernel in the same memory. @param envelope  in units of samples
    void set(std::size_t samples, const pulse_envelope& envelope, std::size_t decimation) {
        decimation_ = decimation;
        results_ = samples / decimation;
        const auto half_length = static_cast<std::size_t>(min(envelope.half_length(), static_cast<float>(samples)));
        zeros_ = half_length / decimation + 1;
        stride_ = results_ + 2 * zeros_ + tap_room;
        taps_.clear();
        const std::size_t begin = zeros_ * decimation; // of the line in one padded row, before it is split into phases
        for (std::size_t at = begin - half_length; at < begin + half_length + decimation; ++at) {
            const float centre = static_cast<float>(begin) + 0.5F * static_cast<float>(decimation - 1);
            const float from_centre = static_cast<float>(at) - centre;
            if (std::fabs(from_centre) > envelope.half_length()) continue;
            taps_.push_back({.weight = envelope(from_centre),
                             .offset = static_cast<std::ptrdiff_t>(at % decimation * stride_ + at / decimation)});
        }
    }

    /// Size of a polyphase line, in samples.
    std::size_t layout_size() const { return decimation_ * stride_; }

    /// Approximate time for a line.
    float nanoseconds() const { return static_cast<float>(results_ * (2 + taps_.size() / 8)); }

    /// Stores a line as polyphase rows. @param layout  zeros, or an earlier line
    void lay_out(const vec2* line, vec2* layout) const {
        for (std::size_t phase = 0; phase < decimation_; ++phase)
            for (std::size_t i = 0; i < results_; ++i)
                layout[phase * stride_ + zeros_ + i] = line[i * decimation_ + phase];
    }

    /// @tparam Width  floats in a SIMD register
    template <int Width>
    void apply(const vec2* layout, vec2* results) const {
        sum_taps<Width>({taps_.data(), taps_.size()}, layout, results, results_);
    }

  private:
    std::size_t decimation_ = 1;
    std::size_t results_ = 0;
    std::size_t zeros_ = 0;  // padding before and after each row
    std::size_t stride_ = 0; // from row to row
    std::vector<tap> taps_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
