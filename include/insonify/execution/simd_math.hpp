#ifndef INSONIFY_EXECUTION_SIMD_MATH_HPP
#define INSONIFY_EXECUTION_SIMD_MATH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd_bits.hpp>
#include <cfloat>

namespace insonify::inline INSONIFY_ABI {

/// A polynomial by Horner's rule. @param lower  the remaining coefficients, highest power first
template <int N, class... Lower>
INSONIFY_FN INSONIFY_INLINE lanes<N> polynomial(const lanes<N>& x, float highest, Lower... lower) {
    lanes<N> sum(highest);
    ((sum = multiply_add(sum, x, lanes<N>(lower))), ...);
    return sum;
}

/// 2^x, with a relative error below 2e-7 for x in [-126, 126]; x is clamped to that range.
///
/// Splits x into an integer, which becomes the exponent field, and a remainder r in [-1/2, 1/2], for which the Taylor
/// polynomial of exp(r ln 2) of degree 7 has an error below 1e-8.
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> power_of_two(const lanes<N>& x) {
    using floats = lanes<N>;
    const floats clamped = min(max(x, floats(-126.0F)), floats(126.0F));
    const bit_lanes<N> whole = floor_bits<N>(clamped + floats(0.5F));
    const floats remainder = clamped - floats_of<N>(whole);
    const floats power = polynomial<N>(remainder, 1.5252734e-5F, 1.5403530e-4F, 1.3333558e-3F, 9.6181291e-3F,
                                       5.5504109e-2F, 2.4022651e-1F, 6.9314718e-1F, 1.0F);
    return power * raw_floats<N>((whole + 127U) << 23);
}

/// log2(x), with an error below 3e-7, absolute or relative, whichever is larger; x is clamped to FLT_MIN from below,
/// and infinity gives 128.
///
/// Splits x into a power of two and a mantissa m in [sqrt(1/2), sqrt(2)], for which
/// ln m = 2 artanh(s) = 2 (s + s^3/3 + s^5/5 + ...) with s = (m - 1) / (m + 1); the terms after s^9 are below 2e-9.
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> logarithm_of_two(const lanes<N>& x) {
    using floats = lanes<N>;
    constexpr std::uint32_t root_half = 0x3F3504F3U, one = 0x3F800000U;
    const bit_lanes<N> moved = raw_bits<N>(max(x, floats(FLT_MIN))) + (one - root_half);
    const floats exponent = floats_of<N>(moved >> 23) - floats(127.0F);
    const floats m = raw_floats<N>((moved & 0x7FFFFFU) + root_half);
    const floats s = (m - floats(1.0F)) / (m + floats(1.0F));
    constexpr float two = 2.8853901F; // 2 / ln 2
    const floats sum = polynomial<N>(s * s, two / 9, two / 7, two / 5, two / 3, two);
    return multiply_add(s, sum, exponent);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
