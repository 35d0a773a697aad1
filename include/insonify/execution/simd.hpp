#ifndef INSONIFY_EXECUTION_SIMD_HPP
#define INSONIFY_EXECUTION_SIMD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>
#if defined(INSONIFY_STD_SIMD)
#include <experimental/simd>
#endif
#if defined(__AVX2__) && !defined(INSONIFY_NO_SIMD)
#include <immintrin.h>
#endif

/// The types behind SIMD, by one of three means: arrays (INSONIFY_NO_SIMD, nvcc), std::experimental::simd (libstdc++),
/// or the vector types of GCC and Clang (other standard libraries).
///
/// `lanes<N>` holds N floats, `lane_mask<N>` N truth values, `bit_lanes<N>` N 32-bit unsigned integers; operators act
/// lane by lane. Each means provides
///
///     load<N>(from), store(value, to), load_bits<N>(from), store_bits<N>(bits, to)
///     each_lane<N>(value)              lane i is value(i)
///     bits_of(mask)                    bit i is set where lane i is
///     select(mask, a, b)               a where the mask is set, b elsewhere
///     min, max, abs, sqrt, multiply_add
///     reduce_min, reduce_max, sum      over all lanes
///     floats_of<N>(bits)               integers to floats; those above 2^31 - 1 become negative
///     bits_of_whole<N>(floats)         floats within +-2^31 to integers, truncated towards zero, in two's complement
namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Floats in the widest register.
#if defined(__AVX512F__) && !defined(INSONIFY_NO_SIMD)
inline constexpr int register_width = 16;
#elif defined(__AVX__) && !defined(INSONIFY_NO_SIMD)
inline constexpr int register_width = 8;
#else
inline constexpr int register_width = 4;
#endif

#if defined(INSONIFY_NO_SIMD)
/// N values with the operators of T, one by one; comparisons give all ones where true, else zero.
template <class T, int N>
struct vector {
    T lane[N];

    vector() = default;
    INSONIFY_FN vector(T value) {
        for (T& l : lane) l = value;
    }
    INSONIFY_FN T& operator[](int i) { return lane[i]; }
    INSONIFY_FN T operator[](int i) const { return lane[i]; }

    INSONIFY_FN friend vector operator-(const vector& a) {
        vector all;
        for (int i = 0; i < N; ++i) all[i] = -a[i];
        return all;
    }
    INSONIFY_FN friend vector operator~(const vector& a) { return a ^ vector(~T{}); }
#define INSONIFY_LANEWISE(result, operation, value)                                                                    \
    INSONIFY_FN friend vector<result, N> operator operation(const vector& a, const vector& b) {                        \
        vector<result, N> all;                                                                                         \
        for (int i = 0; i < N; ++i) all[i] = value(a[i] operation b[i]);                                               \
        return all;                                                                                                    \
    }
    INSONIFY_LANEWISE(T, +, )
    INSONIFY_LANEWISE(T, -, )
    INSONIFY_LANEWISE(T, *, )
    INSONIFY_LANEWISE(T, /, )
    INSONIFY_LANEWISE(T, &, )
    INSONIFY_LANEWISE(T, |, )
    INSONIFY_LANEWISE(T, ^, )
    INSONIFY_LANEWISE(T, <<, )
    INSONIFY_LANEWISE(T, >>, )
    INSONIFY_LANEWISE(std::int32_t, <, -std::int32_t)
    INSONIFY_LANEWISE(std::int32_t, <=, -std::int32_t)
    INSONIFY_LANEWISE(std::int32_t, ==, -std::int32_t)
#undef INSONIFY_LANEWISE
};
#else
template <class T, int N>
struct vector_type {
    using type __attribute__((vector_size(sizeof(T) * N))) = T;
};

/// N values in the compiler's own vector type, with the operators of T lane by lane.
template <class T, int N>
using vector = typename vector_type<T, N>::type;
#endif

/// The same bits as another type of lanes. Those of several registers are not trivially copyable: through memory.
template <class To, class From>
INSONIFY_FN INSONIFY_INLINE To same_bits(const From& from) {
    static_assert(sizeof(To) == sizeof(From));
    if constexpr (std::is_trivially_copyable_v<To> && std::is_trivially_copyable_v<From>) {
        return __builtin_bit_cast(To, from);
    } else {
        To to{};
        std::memcpy(static_cast<void*>(&to), static_cast<const void*>(&from), sizeof to);
        return to;
    }
}

} // namespace detail

/// Floats in one register, 8 at most: the width of trees and packets.
inline constexpr int simd_width = detail::register_width < 8 ? 4 : 8;
/// Floats in the widest register: for long runs.
inline constexpr int max_simd_width = detail::register_width;

#if defined(INSONIFY_STD_SIMD)

namespace stdx = std::experimental;

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

template <int N, class Value>
INSONIFY_INLINE lanes<N> each_lane(const Value& value) {
    return lanes<N>([&value](auto i) { return value(static_cast<int>(i)); });
}

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
#endif
    if constexpr (!detail::has_fma) return a * b + c;
    return stdx::fma(a, b, c);
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

#else // of INSONIFY_STD_SIMD

template <int N>
struct lane_mask {
    detail::vector<std::int32_t, N> bits; ///< all ones where set, else zero

    INSONIFY_FN INSONIFY_INLINE friend lane_mask operator&&(const lane_mask& a, const lane_mask& b) {
        return {a.bits & b.bits};
    }
    INSONIFY_FN INSONIFY_INLINE friend lane_mask operator||(const lane_mask& a, const lane_mask& b) {
        return {a.bits | b.bits};
    }
    INSONIFY_FN INSONIFY_INLINE friend lane_mask operator!(const lane_mask& a) { return {~a.bits}; }
};

template <int N>
struct lanes {
    detail::vector<float, N> values;

    lanes() = default;
    INSONIFY_FN INSONIFY_INLINE lanes(float value) : values(value - detail::vector<float, N>{}) {}
    INSONIFY_FN INSONIFY_INLINE explicit lanes(const detail::vector<float, N>& all) : values(all) {}
    static constexpr std::size_t size() { return N; }
    INSONIFY_FN INSONIFY_INLINE float operator[](int i) const { return values[i]; }

    INSONIFY_FN INSONIFY_INLINE friend lanes operator-(const lanes& a) { return lanes(-a.values); }
#define INSONIFY_LANEWISE(result, operation)                                                                           \
    INSONIFY_FN INSONIFY_INLINE friend result operator operation(const lanes& a, const lanes& b) {                     \
        return result{a.values operation b.values};                                                                    \
    }
    INSONIFY_LANEWISE(lanes, +)
    INSONIFY_LANEWISE(lanes, -)
    INSONIFY_LANEWISE(lanes, *)
    INSONIFY_LANEWISE(lanes, /)
    INSONIFY_LANEWISE(lane_mask<N>, <)
    INSONIFY_LANEWISE(lane_mask<N>, <=)
    INSONIFY_LANEWISE(lane_mask<N>, ==)
#undef INSONIFY_LANEWISE
};

namespace detail {

/// Combines lanes pairwise, halving their number each time.
template <int N, class Operation>
INSONIFY_FN INSONIFY_INLINE float reduce(const lanes<N>& a, const Operation& operation) {
    if constexpr (N == 1) {
        return a[0];
    } else {
        lanes<N / 2> halves[2];
        std::memcpy(halves, &a, sizeof a);
        return reduce(operation(halves[0], halves[1]), operation);
    }
}

} // namespace detail

template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> load(const float* from) {
    lanes<N> result;
    std::memcpy(&result, from, sizeof result);
    return result;
}
template <int N>
INSONIFY_FN INSONIFY_INLINE void store(const lanes<N>& value, float* to) {
    std::memcpy(to, &value, sizeof value);
}

INSONIFY_VISITS
template <int N, class Value>
INSONIFY_FN INSONIFY_INLINE lanes<N> each_lane(const Value& value) {
    lanes<N> result;
    for (int i = 0; i < N; ++i) result.values[i] = value(i);
    return result;
}

template <int N>
INSONIFY_FN INSONIFY_INLINE std::uint32_t bits_of(const lane_mask<N>& mask) {
#if defined(__wasm_simd128__) && !defined(INSONIFY_NO_SIMD)
    if constexpr (N == 4) return static_cast<std::uint32_t>(__builtin_wasm_bitmask_i32x4(mask.bits));
#elif defined(__clang__) && __clang_major__ >= 16 && !defined(INSONIFY_NO_SIMD) // compiled to one instruction on x86
    using flags = bool __attribute__((ext_vector_type(N)));
    if constexpr (N == 4 || N == 8)
        return __builtin_bit_cast(unsigned char, __builtin_convertvector(mask.bits, flags)) & ((1U << N) - 1);
#endif
    std::uint32_t bits = 0;
    for (int i = 0; i < N; ++i) bits |= static_cast<std::uint32_t>(mask.bits[i]) & 1U << i;
    return bits;
}

template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> select(const lane_mask<N>& mask, const lanes<N>& a, const lanes<N>& b) {
#if defined(INSONIFY_NO_SIMD)
    return each_lane<N>([&](int i) { return mask.bits[i] != 0 ? a[i] : b[i]; });
#else
    return lanes<N>(mask.bits ? a.values : b.values);
#endif
}

template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> min(const lanes<N>& a, const lanes<N>& b) {
    return select(a < b, a, b);
}
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> max(const lanes<N>& a, const lanes<N>& b) {
    return select(a < b, b, a);
}
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> abs(const lanes<N>& a) {
    const auto bits = detail::same_bits<detail::vector<std::uint32_t, N>>(a) & 0x7FFFFFFFU;
    return detail::same_bits<lanes<N>>(bits);
}
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> sqrt(const lanes<N>& a) {
#if !defined(INSONIFY_NO_SIMD) && defined(__clang__)
#if __has_builtin(__builtin_elementwise_sqrt)
    return lanes<N>(__builtin_elementwise_sqrt(a.values));
#endif
#endif
    return each_lane<N>([&a](int i) { return std::sqrt(a[i]); });
}
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> multiply_add(const lanes<N>& a, const lanes<N>& b, const lanes<N>& c) {
#if !defined(INSONIFY_NO_SIMD) && defined(__clang__)
    if constexpr (!detail::has_fma) return a * b + c;
#if __has_builtin(__builtin_elementwise_fma)
    return lanes<N>(__builtin_elementwise_fma(a.values, b.values, c.values));
#endif
#endif
    return each_lane<N>([&](int i) { return multiply_add(a[i], b[i], c[i]); });
}

template <int N>
INSONIFY_FN INSONIFY_INLINE float reduce_min(const lanes<N>& a) {
    return detail::reduce(a, [](const auto& x, const auto& y) { return min(x, y); });
}
template <int N>
INSONIFY_FN INSONIFY_INLINE float reduce_max(const lanes<N>& a) {
    return detail::reduce(a, [](const auto& x, const auto& y) { return max(x, y); });
}
template <int N>
INSONIFY_FN INSONIFY_INLINE float sum(const lanes<N>& a) {
    return detail::reduce(a, [](const auto& x, const auto& y) { return x + y; });
}

#endif // INSONIFY_STD_SIMD

// Not std::experimental::simd: some of its integer operations are not inlined.
template <int N>
using bit_lanes = detail::vector<std::uint32_t, N>;

template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> floats_of(bit_lanes<N> bits) {
#if defined(INSONIFY_NO_SIMD)
    return each_lane<N>([&](int i) { return static_cast<float>(static_cast<std::int32_t>(bits[i])); });
#else
    return detail::same_bits<lanes<N>>(
        __builtin_convertvector((detail::vector<std::int32_t, N>)bits, detail::vector<float, N>));
#endif
}
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> bits_of_whole(const lanes<N>& x) {
#if defined(INSONIFY_NO_SIMD)
    bit_lanes<N> bits;
    for (int i = 0; i < N; ++i) bits[i] = static_cast<std::uint32_t>(static_cast<std::int32_t>(x[i]));
    return bits;
#else
    return (bit_lanes<N>)__builtin_convertvector(detail::same_bits<detail::vector<float, N>>(x),
                                                 detail::vector<std::int32_t, N>);
#endif
}
template <int N>
INSONIFY_FN INSONIFY_INLINE void store_bits(bit_lanes<N> bits, std::uint32_t* to) {
    std::memcpy(to, &bits, sizeof bits);
}
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> load_bits(const std::uint32_t* from) {
    bit_lanes<N> bits;
    std::memcpy(&bits, from, sizeof bits);
    return bits;
}

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
    return detail::same_bits<bit_lanes<N>>(floats);
}
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> raw_floats(const bit_lanes<N>& bits) {
    return detail::same_bits<lanes<N>>(bits);
}

/// a where the mask is set, b elsewhere.
template <int N>
INSONIFY_FN INSONIFY_INLINE bit_lanes<N> select_bits(const lane_mask<N>& mask, const bit_lanes<N>& a,
                                                     const bit_lanes<N>& b) {
    return raw_bits<N>(select(mask, raw_floats<N>(a), raw_floats<N>(b)));
}

#if !defined(INSONIFY_NO_SIMD)
namespace detail {
template <class Lanes, class Bits, int... Lane>
INSONIFY_FN INSONIFY_INLINE Lanes multiply_pairs(const Lanes& factor, const Bits& a, const Bits& b,
                                                 std::integer_sequence<int, Lane...>) {
    constexpr Bits sign{(Lane % 2 == 0 ? 0x80000000U : 0U)...};
    const auto real = __builtin_bit_cast(Lanes, __builtin_shufflevector(a, a, (Lane & ~1)...)),
               imaginary = __builtin_bit_cast(Lanes, __builtin_shufflevector(a, a, (Lane | 1)...) ^ sign),
               swapped = __builtin_bit_cast(Lanes, __builtin_shufflevector(b, b, (Lane ^ 1)...));
    return multiply_add(real, factor, imaginary * swapped);
}
} // namespace detail
#endif

/// Products of complex numbers, each in two lanes: its real part, then its imaginary part.
template <int N>
INSONIFY_FN INSONIFY_INLINE lanes<N> complex_products(const lanes<N>& a, const lanes<N>& b) {
#if defined(INSONIFY_NO_SIMD)
    return each_lane<N>(
        [&](int i) { return i % 2 == 0 ? a[i] * b[i] - a[i + 1] * b[i + 1] : a[i - 1] * b[i] + a[i] * b[i - 1]; });
#else
    return detail::multiply_pairs(b, raw_bits<N>(a), raw_bits<N>(b), std::make_integer_sequence<int, N>{});
#endif
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

/// Calls body(i, n) for a range of floats, of which it is to take n from i on. n is a constant: `Width` as long as
/// there are so many, then 1.
template <int Width, class Body>
INSONIFY_INLINE void in_registers(std::size_t begin, std::size_t end, const Body& body) {
    std::size_t i = begin;
    for (; i + Width <= end; i += Width) body(i, std::integral_constant<int, Width>{});
    for (; i < end; ++i) body(i, std::integral_constant<int, 1>{});
}

/// Cosine (x) and sine (y) of 2 pi times each lane, within 2e-7 for numbers of turns within +-0.5.
template <int N>
struct turned_lanes {
    lanes<N> x, y;

    INSONIFY_FN explicit turned_lanes(const lanes<N>& turns) {
        const lanes<N> quarter(0.25F), size = abs(turns);
        const lanes<N> y_of_positive = sine(quarter - abs(size - quarter));
        x = sine(quarter - size);
        y = select(turns < lanes<N>(0.0F), -y_of_positive, y_of_positive);
    }

  private:
    INSONIFY_FN static lanes<N> sine(const lanes<N>& turns) { // of turns within +-0.25, by its series
        const lanes<N> a = lanes<N>(2 * pi) * turns;
        return a *
               polynomial<N>(a * a, -2.5052108e-8F, 2.7557319e-6F, -1.9841270e-4F, 8.3333333e-3F, -1.6666667e-1F, 1.0F);
    }
};

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
