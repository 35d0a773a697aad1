#ifndef INSONIFY_EXECUTION_PACK_HPP
#define INSONIFY_EXECUTION_PACK_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd_bits.hpp>
#include <bit>

#if defined(__AVX2__) && !defined(INSONIFY_NO_SIMD)
#include <immintrin.h>

namespace insonify::inline INSONIFY_ABI::detail {

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

} // namespace insonify::inline INSONIFY_ABI::detail
#endif

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Stores the lanes whose bit is set contiguously, without branches. @return their number
/// @param to  room for N values; those beyond the returned number are unspecified
template <int N>
INSONIFY_FN INSONIFY_INLINE std::uint32_t pack_lanes(const bit_lanes<N>& values, std::uint32_t bits,
                                                     std::uint32_t* to) {
#if defined(__AVX2__) && !defined(INSONIFY_NO_SIMD)
    if constexpr (N == 8) {
        const __m128i from = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(detail::pack_order.of + bits));
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
