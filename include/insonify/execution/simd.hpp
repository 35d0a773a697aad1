#ifndef INSONIFY_EXECUTION_SIMD_HPP
#define INSONIFY_EXECUTION_SIMD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd_lanes.hpp>
#include <bit>
#include <cfloat>
#include <cstdint>
#if defined(__AVX2__) && !defined(INSONIFY_NO_SIMD)
#include <immintrin.h>
#endif

namespace insonify::inline INSONIFY_ABI {

/// 1 / a, correctly rounded also under -ffast-math.
template <class Lanes>
    requires requires { Lanes::size(); }
INSONIFY_FN INSONIFY_INLINE Lanes inverse(const Lanes& a) {
#if __FINITE_MATH_ONLY__ > 0 && !defined(__CUDACC__) // -ffast-math, or a part of it
    constexpr int n = static_cast<int>(Lanes::size());
    float each[n];
    store(a, each);
    for (float& one : each) {
        one = 1 / one;
        asm("" : "+m"(one)); // prevents a vector division, which is approximate here
    }
    return load<n>(each);
#else
    return Lanes(1.0F) / a;
#endif
}

/// a * b - c * d with an exact sign, independent of the order of the factors, where the result is not tiny: a fused
/// multiply-add recovers the rounding error of one product. Without that instruction, the difference of two rounded
/// products.
///
/// Source: Kahan; error below 1.5 units in the last place: Jeannerod, Louvet & Muller 2013, Mathematics of Computation.
template <class Lanes>
INSONIFY_FN INSONIFY_INLINE Lanes difference_of_products(const Lanes& a, const Lanes& b, const Lanes& c,
                                                         const Lanes& d) {
    const Lanes product = c * d;
    if constexpr (!detail::has_fma) return a * b - product;
    return multiply_add(a, b, -product) - multiply_add(c, d, -product);
}

/// first, first + step, first + 2 step, ...
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> steps_of_bits(std::uint32_t first, std::uint32_t step) {
    bit_lanes<N> numbers{};
    for (int i = 0; i < N; ++i) numbers[i] = static_cast<std::uint32_t>(i);
    return numbers * step + first;
}

/// The 32 bits of each float, and back.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> raw_bits(const lanes<N>& floats) {
    return __builtin_bit_cast(bit_lanes<N>, floats);
}
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> raw_floats(const bit_lanes<N>& bits) {
    return __builtin_bit_cast(lanes<N>, bits);
}

/// a where the mask is set, b elsewhere.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> select_bits(const lane_mask<N>& mask, const bit_lanes<N>& a,
                                                     const bit_lanes<N>& b) {
    return raw_bits<N>(select(mask, raw_floats<N>(a), raw_floats<N>(b)));
}

/// Highest bit set for infinities and NaN. Tests the bits, so it holds under -ffast-math; several results combine by |.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> not_finite(const lanes<N>& floats) {
    return (raw_bits<N>(floats) & 0x7F800000U) + 0x00800000U;
}

/// Likewise, for NaN only.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> not_number(const lanes<N>& floats) {
    return bit_lanes<N>{} + 0x7F800000U - (raw_bits<N>(floats) & 0x7FFFFFFFU);
}

/// `mix_bits` of each lane.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> mix_lanes(bit_lanes<N> h) {
    h = (h ^ (h >> 16)) * 0x7FEB352DU;
    h = (h ^ (h >> 15)) * 0x846CA68BU;
    return h ^ (h >> 16);
}

/// floor(x) as integers, for x within +-2^31.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> floor_bits(const lanes<N>& x) {
    const bit_lanes<N> cut = bits_of_whole<N>(x);
    const lanes<N> left = x - floats_of<N>(cut) + lanes<N>(0.0F); // turns -0 into 0
    return cut - (raw_bits<N>(left) >> 31);                       // one less where truncation rounded up
}

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

namespace detail {

#if defined(__AVX2__) && !defined(INSONIFY_NO_SIMD)
/// For each set of eight lanes, given as bits: their indices in order, one byte each.
struct pack_orders {
    std::uint64_t of[256] = {};

    constexpr pack_orders() {
        for (std::uint32_t bits = 0; bits < 256; ++bits) {
            std::uint32_t shift = 0;
            for (std::uint64_t lane = 0; lane < 8; ++lane) {
                if ((bits >> lane & 1U) == 0) continue;
                of[bits] |= lane << shift;
                shift += 8;
            }
        }
    }
};
inline constexpr pack_orders pack_order{};
#endif

/// Stores the lanes whose bit is set contiguously, without branches. @return their number
/// @param to  room for N values; those beyond the returned number are unspecified
template <int N>
INSONIFY_FN INSONIFY_INLINE std::uint32_t pack_lanes(const bit_lanes<N>& values, std::uint32_t bits,
                                                     std::uint32_t* to) {
#if defined(__AVX2__) && !defined(INSONIFY_NO_SIMD)
    if constexpr (N == 8) {
        const __m128i from = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(pack_order.of + bits));
        const __m256i packed = _mm256_permutevar8x32_epi32((__m256i)values, _mm256_cvtepu8_epi32(from));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), packed);
        return static_cast<std::uint32_t>(std::popcount(bits));
    }
#endif
    std::uint32_t count = 0;
    for (int i = 0; i < N; ++i) {
        to[count] = std::uint32_t{values[i]};
        count += bits >> static_cast<unsigned>(i) & 1U;
    }
    return count;
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
