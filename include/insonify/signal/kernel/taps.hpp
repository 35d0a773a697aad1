#ifndef INSONIFY_SIGNAL_KERNEL_TAPS_HPP
#define INSONIFY_SIGNAL_KERNEL_TAPS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <cstddef>
#include <utility>

namespace insonify::inline INSONIFY_ABI::detail {

/// Gaussian kernels are truncated at this number of standard deviations: e^-8 or -69 dB.
inline constexpr float kernel_sigmas = 4;

/// One coefficient of an FIR filter.
struct tap {
    float weight = 0;
    std::ptrdiff_t offset = 0; ///< of its input sample relative to the result, in complex samples
};

/// Number of samples that `sum_taps` may read beyond those that its results need.
inline constexpr std::size_t tap_room = std::size_t{4} * simd_width;

/// Computes as many results as eight SIMD registers hold; the sums stay in registers.
template <int Width, std::size_t... I>
INSONIFY_INLINE void sum_taps_of_block(view<const tap> taps, const float* from, float* to, std::index_sequence<I...>) {
    lanes<Width> sums[] = {lanes<Width>(static_cast<float>(I - I))...};
    for (const tap& one : taps) {
        const lanes<Width> weight(one.weight);
        const float* at = from + 2 * one.offset;
        ((sums[I] = multiply_add(load<Width>(at + I * Width), weight, sums[I])), ...);
    }
    (store(sums[I], to + I * Width), ...);
}

/// Filters complex samples: to[i] = sum over the taps of weight * from[i + offset].
///
/// @tparam Width  floats in a SIMD register
/// @param from  read up to `tap_room` samples beyond what `count` results need
/// @param to    must not overlap the samples read
template <int Width>
void sum_taps(view<const tap> taps, const vec2* from, vec2* to, std::size_t count) {
    constexpr std::size_t block = std::size_t{4} * Width;
    constexpr auto registers = std::make_index_sequence<8>{};
    std::size_t begin = 0;
    for (; begin + block <= count; begin += block)
        sum_taps_of_block<Width>(taps, reinterpret_cast<const float*>(from + begin),
                                 reinterpret_cast<float*>(to + begin), registers);
    if (begin == count) return;
    vec2 last[block];
    sum_taps_of_block<Width>(taps, reinterpret_cast<const float*>(from + begin), reinterpret_cast<float*>(last),
                             registers);
    for (std::size_t i = 0; begin + i < count; ++i) to[begin + i] = last[i];
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
