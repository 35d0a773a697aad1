#ifndef INSONIFY_EXECUTION_SIMD_STD_HPP
#define INSONIFY_EXECUTION_SIMD_STD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>

#if defined(INSONIFY_STD_SIMD)
#include <cstdint>
#include <experimental/simd>

/// `lanes<N>` over std::experimental::simd of libstdc++.
namespace insonify::inline INSONIFY_ABI {

namespace stdx = std::experimental;

/// Floats in one register, 8 at most: the width of trees and packets.
inline constexpr int simd_width = stdx::native_simd<float>::size() < 8 ? 4 : 8;
/// Floats in the widest register: for long runs.
inline constexpr int max_simd_width = stdx::native_simd<float>::size() < 16 ? simd_width : 16;

template <int N>
using lanes = stdx::simd<float, stdx::simd_abi::deduce_t<float, N>>;
template <int N>
using lane_mask = typename lanes<N>::mask_type;

using stdx::abs;
using stdx::max;
using stdx::min;

template <int N>
INSONIFY_INLINE lanes<N> load(const float* from) {
    return lanes<N>{from, stdx::element_aligned};
}
template <class Lanes>
INSONIFY_INLINE void store(const Lanes& value, float* to) {
    value.copy_to(to, stdx::element_aligned);
}

/// Lane i is value(i).
template <int N, class Value>
INSONIFY_INLINE lanes<N> each_lane(const Value& value) {
    return lanes<N>([&value](auto i) { return value(static_cast<int>(i)); });
}

/// Bit i is set where lane i is.
template <class Mask>
INSONIFY_INLINE std::uint32_t bits_of(const Mask& mask) {
    if constexpr (requires { mask.__to_bitset().to_ulong(); }) { // one instruction; internal to libstdc++
        return static_cast<std::uint32_t>(mask.__to_bitset().to_ulong());
    } else {
        std::uint32_t bits = 0;
        for (unsigned i = 0; i < Mask::size(); ++i) bits |= std::uint32_t{mask[i]} << i;
        return bits;
    }
}

template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> multiply_add(const stdx::simd<float, Abi>& a, const stdx::simd<float, Abi>& b,
                                                    const stdx::simd<float, Abi>& c) {
#if defined(__FMA__) // stdx::fma of libstdc++ 12 is not inlined at -O2
    if constexpr (requires { static_cast<__m512>(a); })
        return stdx::simd<float, Abi>(
            _mm512_fmadd_ps(static_cast<__m512>(a), static_cast<__m512>(b), static_cast<__m512>(c)));
    else if constexpr (requires { static_cast<__m256>(a); })
        return stdx::simd<float, Abi>(
            _mm256_fmadd_ps(static_cast<__m256>(a), static_cast<__m256>(b), static_cast<__m256>(c)));
    else if constexpr (requires { static_cast<__m128>(a); })
        return stdx::simd<float, Abi>(
            _mm_fmadd_ps(static_cast<__m128>(a), static_cast<__m128>(b), static_cast<__m128>(c)));
    else
        return stdx::fma(a, b, c);
#else
    if constexpr (detail::has_fma)
        return stdx::fma(a, b, c);
    else
        return a * b + c;
#endif
}

template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> sqrt(const stdx::simd<float, Abi>& a) {
#if defined(__AVX512F__) && !defined(__clang__) // GCC 12 warns of _mm512_sqrt_ps
    if constexpr (requires { static_cast<__m512>(a); })
        return stdx::simd<float, Abi>(_mm512_maskz_sqrt_ps(0xFFFF, static_cast<__m512>(a)));
    else
#endif
        return stdx::sqrt(a);
}

/// a where the mask is set, b elsewhere.
template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> select(const stdx::simd_mask<float, Abi>& mask, const stdx::simd<float, Abi>& a,
                                              const stdx::simd<float, Abi>& b) {
#if defined(__clang__) && defined(__AVX512VL__) // where() of libstdc++ 12 assigns nothing there
    const auto all = static_cast<__mmask16>(bits_of(mask));
    const auto bits = static_cast<__mmask8>(all);
    if constexpr (requires { static_cast<__m512>(a); })
        return stdx::simd<float, Abi>(_mm512_mask_blend_ps(all, static_cast<__m512>(b), static_cast<__m512>(a)));
    else if constexpr (requires { static_cast<__m256>(a); })
        return stdx::simd<float, Abi>(_mm256_mask_blend_ps(bits, static_cast<__m256>(b), static_cast<__m256>(a)));
    else if constexpr (requires { static_cast<__m128>(a); })
        return stdx::simd<float, Abi>(_mm_mask_blend_ps(bits, static_cast<__m128>(b), static_cast<__m128>(a)));
#endif
    stdx::simd<float, Abi> result = b;
    stdx::where(mask, result) = a;
    return result;
}

/// The minimum, the maximum and the sum over all lanes.
/// @{
template <class Abi>
INSONIFY_INLINE float reduce_min(const stdx::simd<float, Abi>& a) {
    return stdx::hmin(a);
}
template <class Abi>
INSONIFY_INLINE float reduce_max(const stdx::simd<float, Abi>& a) {
    return stdx::hmax(a);
}
template <class Abi>
INSONIFY_INLINE float sum(const stdx::simd<float, Abi>& a) {
    return stdx::reduce(a);
}
/// @}

} // namespace insonify::inline INSONIFY_ABI
#endif

#include <insonify/core/restore_macros.hpp>

#endif
