#ifndef INSONIFY_EXECUTION_SIMD_BITS_HPP
#define INSONIFY_EXECUTION_SIMD_BITS_HPP

#include <insonify/execution/simd.hpp>

/// Several 32-bit numbers at once, beside the floats of `lanes`: for hashes.
namespace insonify::inline INSONIFY_ABI {

#if !defined(INSONIFY_NO_SIMD)

template <int N>
using bit_lanes = stdx::simd<std::uint32_t, stdx::simd_abi::deduce_t<std::uint32_t, N>>;

/// first, first + step, first + 2 step, ...
template <int N>
INSONIFY_INLINE bit_lanes<N> steps_of_bits(std::uint32_t first, std::uint32_t step) {
    return bit_lanes<N>{[=](auto i) { return first + static_cast<std::uint32_t>(i) * step; }};
}

/// The numbers as floats, those above 2^31 - 1 as negative ones.
template <int N>
INSONIFY_INLINE lanes<N> floats_of(const bit_lanes<N>& bits) {
    using integers = stdx::simd<std::int32_t, stdx::simd_abi::deduce_t<std::int32_t, N>>;
    return stdx::static_simd_cast<lanes<N>>(stdx::static_simd_cast<integers>(bits));
}

/// Whole floats within +-2^31 as numbers, negative ones in two's complement.
template <int N>
INSONIFY_INLINE bit_lanes<N> bits_of_whole(const lanes<N>& whole) {
    using integers = stdx::simd<std::int32_t, stdx::simd_abi::deduce_t<std::int32_t, N>>;
    return stdx::static_simd_cast<bit_lanes<N>>(stdx::static_simd_cast<integers>(whole));
}

template <int N>
INSONIFY_INLINE void store_bits(const bit_lanes<N>& bits, std::uint32_t* to) {
    bits.copy_to(to, stdx::element_aligned);
}

#else

template <int N>
struct bit_lanes {
    std::uint32_t lane[N] = {};

    bit_lanes() = default;
    INSONIFY_FN bit_lanes(std::uint32_t value) {
        for (std::uint32_t& l : lane) l = value;
    }
    template <class Operation>
    INSONIFY_FN static bit_lanes each(Operation operation) {
        bit_lanes result;
        for (int i = 0; i < N; ++i) result.lane[i] = operation(i);
        return result;
    }
    INSONIFY_FN friend bit_lanes operator+(const bit_lanes& a, const bit_lanes& b) {
        return each([&](int i) { return a.lane[i] + b.lane[i]; });
    }
    INSONIFY_FN friend bit_lanes operator*(const bit_lanes& a, const bit_lanes& b) {
        return each([&](int i) { return a.lane[i] * b.lane[i]; });
    }
    INSONIFY_FN friend bit_lanes operator^(const bit_lanes& a, const bit_lanes& b) {
        return each([&](int i) { return a.lane[i] ^ b.lane[i]; });
    }
    INSONIFY_FN friend bit_lanes operator&(const bit_lanes& a, const bit_lanes& b) {
        return each([&](int i) { return a.lane[i] & b.lane[i]; });
    }
    INSONIFY_FN friend bit_lanes operator>>(const bit_lanes& a, int by) {
        return each([&](int i) { return a.lane[i] >> static_cast<unsigned>(by); });
    }
};

template <int N>
INSONIFY_FN bit_lanes<N> steps_of_bits(std::uint32_t first, std::uint32_t step) {
    return bit_lanes<N>::each([=](int i) { return first + static_cast<std::uint32_t>(i) * step; });
}
template <int N>
INSONIFY_FN lanes<N> floats_of(const bit_lanes<N>& bits) {
    return lanes<N>::template each<lanes<N>>(
        [&](int i) { return static_cast<float>(static_cast<std::int32_t>(bits.lane[i])); });
}
template <int N>
INSONIFY_FN bit_lanes<N> bits_of_whole(const lanes<N>& whole) {
    return bit_lanes<N>::each(
        [&](int i) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(whole.lane[i])); });
}
template <int N>
INSONIFY_FN void store_bits(const bit_lanes<N>& bits, std::uint32_t* to) {
    for (int i = 0; i < N; ++i) to[i] = bits.lane[i];
}

#endif

/// `mix_bits` of many numbers: 32 well-mixed bits of each.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> mix_lanes(bit_lanes<N> h) {
    h = (h ^ (h >> 16)) * bit_lanes<N>(0x7FEB352DU);
    h = (h ^ (h >> 15)) * bit_lanes<N>(0x846CA68BU);
    return h ^ (h >> 16);
}

/// The largest whole numbers not above, within +-2^31. By conversions, for not every machine rounds in one instruction.
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> floor_lanes(const lanes<N>& x) {
#if !defined(INSONIFY_NO_SIMD)
    lanes<N> whole = floats_of<N>(bits_of_whole<N>(x));
    where(x < whole, whole) -= lanes<N>(1.0F);
    return whole;
#else
    return lanes<N>::template each<lanes<N>>([&](int i) { return std::floor(x.lane[i]); });
#endif
}

} // namespace insonify::inline INSONIFY_ABI
#endif
