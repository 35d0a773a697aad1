#ifndef INSONIFY_EXECUTION_SIMD_MATH_HPP
#define INSONIFY_EXECUTION_SIMD_MATH_HPP

#include <insonify/execution/simd.hpp>
#include <initializer_list>

namespace insonify::inline INSONIFY_ABI {

/// 2^x for many x at once: relative error below 2e-7 for x in [-126, 126]; clamped outside.
///
/// Splits x into an integer, which becomes the exponent's bits, and a rest in [-1/2, 1/2], whose power is a polynomial
/// (Taylor's of exp(r ln 2), degree 7: its remainder there is below 1e-8).
template <int N>
INSONIFY_INLINE lanes<N> power_of_two(const lanes<N>& x) {
    using floats = lanes<N>;
    const floats limited = lesser(greater(x, floats(-126.0F)), floats(126.0F));
    const floats shift(12582912.0F); // 1.5 * 2^23: adding it rounds to an integer, kept in the low bits
    const floats shifted = limited + shift;
    const floats rest = limited - (shifted - shift);
    floats power(1.5252734e-5F);
    for (const float coefficient :
         {1.5403530e-4F, 1.3333558e-3F, 9.6181291e-3F, 5.5504109e-2F, 2.4022651e-1F, 6.9314718e-1F, 1.0F})
        power = multiply_add(power, rest, floats(coefficient));
    alignas(sizeof(float) * N) float integers[N], scale[N];
    store(shifted, integers);
    for (int i = 0; i < N; ++i)
        scale[i] = __builtin_bit_cast(float, (__builtin_bit_cast(std::uint32_t, integers[i]) + 127U) << 23U);
    return power * load<N>(scale);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
