#ifndef INSONIFY_EXECUTION_SIMD_BITS_HPP
#define INSONIFY_EXECUTION_SIMD_BITS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd.hpp>
#include <insonify/execution/vector_type.hpp>

/// `bit_lanes<N>` holds N 32-bit unsigned integers beside the floats of `lanes<N>`, for hashes and exponents, with the
/// operators of one; `load_bits`, `store_bits`, and conversions to and from floats.
namespace insonify::inline INSONIFY_ABI {

#if !defined(INSONIFY_NO_SIMD) // else in simd_scalar.hpp

// Not std::experimental::simd: some of its integer operations are not inlined.
template <int N>
using bit_lanes = detail::vector<std::uint32_t, N>;

/// Integers to floats; those above 2^31 - 1 become negative.
template <int N>
INSONIFY_INLINE lanes<N> floats_of(bit_lanes<N> bits) {
    return __builtin_bit_cast(lanes<N>,
                              __builtin_convertvector((detail::vector<std::int32_t, N>)bits, detail::vector<float, N>));
}

/// Floats within +-2^31 to integers, truncated towards zero, negative ones in two's complement.
template <int N>
INSONIFY_INLINE bit_lanes<N> bits_of_whole(const lanes<N>& x) {
    return (bit_lanes<N>)__builtin_convertvector(__builtin_bit_cast(detail::vector<float, N>, x),
                                                 detail::vector<std::int32_t, N>);
}

template <int N>
INSONIFY_INLINE void store_bits(bit_lanes<N> bits, std::uint32_t* to) {
    __builtin_memcpy(to, &bits, sizeof bits);
}
template <int N>
INSONIFY_INLINE bit_lanes<N> load_bits(const std::uint32_t* from) {
    bit_lanes<N> bits;
    __builtin_memcpy(&bits, from, sizeof bits);
    return bits;
}

#endif

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

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
