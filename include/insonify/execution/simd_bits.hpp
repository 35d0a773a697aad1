#ifndef INSONIFY_EXECUTION_SIMD_BITS_HPP
#define INSONIFY_EXECUTION_SIMD_BITS_HPP

#include <insonify/execution/simd.hpp>

/// Several 32-bit numbers at once, beside the floats of `lanes`, with the operators of one: for hashes and exponents.
namespace insonify::inline INSONIFY_ABI {

#if !defined(INSONIFY_NO_SIMD)

// The compiler's own vectors: not all operations of std::experimental::simd on integers are inlined.
template <int N>
struct bit_vector {
    using type __attribute__((vector_size(sizeof(std::uint32_t) * N))) = std::uint32_t;
    using whole __attribute__((vector_size(sizeof(std::int32_t) * N))) = std::int32_t;
    using floats __attribute__((vector_size(sizeof(float) * N))) = float;
};
template <int N>
using bit_lanes = typename bit_vector<N>::type;

/// The numbers as floats, those above 2^31 - 1 as negative ones.
template <int N>
INSONIFY_INLINE lanes<N> floats_of(bit_lanes<N> bits) {
    return __builtin_bit_cast(
        lanes<N>, __builtin_convertvector((typename bit_vector<N>::whole)bits, typename bit_vector<N>::floats));
}

/// Floats within +-2^31 as numbers, cut off towards zero, negative ones in two's complement.
template <int N>
INSONIFY_INLINE bit_lanes<N> bits_of_whole(const lanes<N>& x) {
    return (bit_lanes<N>)__builtin_convertvector(__builtin_bit_cast(typename bit_vector<N>::floats, x),
                                                 typename bit_vector<N>::whole);
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

#else

template <int N>
struct bit_lanes {
    std::uint32_t lane[N] = {};

    bit_lanes() = default;
    INSONIFY_FN bit_lanes(std::uint32_t value) {
        for (std::uint32_t& l : lane) l = value;
    }
    INSONIFY_FN std::uint32_t& operator[](int i) { return lane[i]; }
    INSONIFY_FN std::uint32_t operator[](int i) const { return lane[i]; }

    template <class Operation>
    INSONIFY_FN static bit_lanes each(Operation operation) {
        bit_lanes result;
        for (int i = 0; i < N; ++i) result.lane[i] = operation(i);
        return result;
    }
    INSONIFY_FN friend bit_lanes operator+(const bit_lanes& a, const bit_lanes& b) {
        return each([&](int i) { return a.lane[i] + b.lane[i]; });
    }
    INSONIFY_FN friend bit_lanes operator-(const bit_lanes& a, const bit_lanes& b) {
        return each([&](int i) { return a.lane[i] - b.lane[i]; });
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
    INSONIFY_FN friend bit_lanes operator|(const bit_lanes& a, const bit_lanes& b) {
        return each([&](int i) { return a.lane[i] | b.lane[i]; });
    }
    INSONIFY_FN friend bit_lanes operator<<(const bit_lanes& a, int by) {
        return each([&](int i) { return a.lane[i] << static_cast<unsigned>(by); });
    }
    INSONIFY_FN friend bit_lanes operator>>(const bit_lanes& a, int by) {
        return each([&](int i) { return a.lane[i] >> static_cast<unsigned>(by); });
    }
};

template <int N>
INSONIFY_FN lanes<N> floats_of(const bit_lanes<N>& bits) {
    return lanes<N>::template each<lanes<N>>(
        [&](int i) { return static_cast<float>(static_cast<std::int32_t>(bits.lane[i])); });
}
template <int N>
INSONIFY_FN bit_lanes<N> bits_of_whole(const lanes<N>& x) {
    return bit_lanes<N>::each([&](int i) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(x.lane[i])); });
}
template <int N>
INSONIFY_FN void store_bits(const bit_lanes<N>& bits, std::uint32_t* to) {
    for (int i = 0; i < N; ++i) to[i] = bits.lane[i];
}
template <int N>
INSONIFY_FN bit_lanes<N> load_bits(const std::uint32_t* from) {
    return bit_lanes<N>::each([from](int i) { return from[i]; });
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

/// Negative where an exponent has all its bits: infinities and NaN; reads the bits, so that it holds under -ffast-math.
/// The results of several may be joined by |.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> not_finite(const lanes<N>& floats) {
    return (raw_bits<N>(floats) & 0x7F800000U) + 0x00800000U;
}

/// Likewise, of NaN alone.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> not_number(const lanes<N>& floats) {
    return bit_lanes<N>{} + 0x7F800000U - (raw_bits<N>(floats) & 0x7FFFFFFFU);
}

/// `mix_bits` of many numbers: 32 well-mixed bits of each.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> mix_lanes(bit_lanes<N> h) {
    h = (h ^ (h >> 16)) * 0x7FEB352DU;
    h = (h ^ (h >> 15)) * 0x846CA68BU;
    return h ^ (h >> 16);
}

/// The largest whole numbers not above, within +-2^31, as numbers.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> floor_bits(const lanes<N>& x) {
    const bit_lanes<N> cut = bits_of_whole<N>(x);
    const lanes<N> left = x - floats_of<N>(cut) + lanes<N>(0.0F); // -0 becomes 0
    return cut - (raw_bits<N>(left) >> 31);                       // one less where that lies above x
}

} // namespace insonify::inline INSONIFY_ABI
#endif
