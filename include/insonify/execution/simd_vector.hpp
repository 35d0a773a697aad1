#ifndef INSONIFY_EXECUTION_SIMD_VECTOR_HPP
#define INSONIFY_EXECUTION_SIMD_VECTOR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/vector_type.hpp>

#if !defined(INSONIFY_NO_SIMD) && !defined(INSONIFY_STD_SIMD)
#include <cmath>
#include <cstddef>
#include <utility>

/// `lanes<N>` over the vector types of GCC and Clang, for standard libraries without std::experimental::simd.
namespace insonify::inline INSONIFY_ABI {

/// Floats in one register, 8 at most: the width of trees and packets.
#if defined(__AVX__)
inline constexpr int simd_width = 8;
#else
inline constexpr int simd_width = 4;
#endif
/// Floats in the widest register: for long runs.
#if defined(__AVX512F__)
inline constexpr int max_simd_width = 16;
#else
inline constexpr int max_simd_width = simd_width;
#endif

namespace detail {

/// Calls body(0) to body(N - 1), unrolled: no lane is indexed at run time.
template <int N, class Body>
INSONIFY_INLINE void for_each_lane(const Body& body) {
    [&body]<int... I>(std::integer_sequence<int, I...>) { (body(I), ...); }
    (std::make_integer_sequence<int, N>{});
}

} // namespace detail

template <int N>
struct lane_mask {
    detail::vector<std::int32_t, N> bits; ///< all ones where set, else zero

    INSONIFY_INLINE friend lane_mask operator&&(const lane_mask& a, const lane_mask& b) { return {a.bits & b.bits}; }
    INSONIFY_INLINE friend lane_mask operator||(const lane_mask& a, const lane_mask& b) { return {a.bits | b.bits}; }
    INSONIFY_INLINE friend lane_mask operator!(const lane_mask& a) { return {~a.bits}; }
};

template <int N>
struct lanes {
    detail::vector<float, N> values;

    lanes() = default;
    INSONIFY_INLINE lanes(float value) : values(value - detail::vector<float, N>{}) {}
    INSONIFY_INLINE explicit lanes(const detail::vector<float, N>& all) : values(all) {}
    static constexpr std::size_t size() { return N; }
    INSONIFY_INLINE float operator[](int i) const { return values[i]; }

    INSONIFY_INLINE friend lanes operator-(const lanes& a) { return lanes(-a.values); }
    INSONIFY_INLINE friend lanes operator+(const lanes& a, const lanes& b) { return lanes(a.values + b.values); }
    INSONIFY_INLINE friend lanes operator-(const lanes& a, const lanes& b) { return lanes(a.values - b.values); }
    INSONIFY_INLINE friend lanes operator*(const lanes& a, const lanes& b) { return lanes(a.values * b.values); }
    INSONIFY_INLINE friend lanes operator/(const lanes& a, const lanes& b) { return lanes(a.values / b.values); }
    INSONIFY_INLINE friend lane_mask<N> operator<(const lanes& a, const lanes& b) { return {a.values < b.values}; }
    INSONIFY_INLINE friend lane_mask<N> operator<=(const lanes& a, const lanes& b) { return {a.values <= b.values}; }
    INSONIFY_INLINE friend lane_mask<N> operator==(const lanes& a, const lanes& b) { return {a.values == b.values}; }
};

namespace detail {

/// Combines lanes pairwise, halving their number each time.
template <int N, class Operation>
INSONIFY_INLINE float reduce(const lanes<N>& a, const Operation& operation) {
    if constexpr (N == 1) {
        return a[0];
    } else {
        lanes<N / 2> halves[2];
        __builtin_memcpy(halves, &a, sizeof a);
        return reduce(operation(halves[0], halves[1]), operation);
    }
}

} // namespace detail

template <int N>
INSONIFY_INLINE lanes<N> load(const float* from) {
    lanes<N> result;
    __builtin_memcpy(&result, from, sizeof result);
    return result;
}
template <int N>
INSONIFY_INLINE void store(const lanes<N>& value, float* to) {
    __builtin_memcpy(to, &value, sizeof value);
}

/// Lane i is value(i).
template <int N, class Value>
INSONIFY_INLINE lanes<N> each_lane(const Value& value) {
    lanes<N> result;
    detail::for_each_lane<N>([&](int i) { result.values[i] = value(i); });
    return result;
}

/// Bit i is set where lane i is.
template <int N>
INSONIFY_INLINE std::uint32_t bits_of(const lane_mask<N>& mask) {
#if defined(__wasm_simd128__)
    if constexpr (N == 4) return static_cast<std::uint32_t>(__builtin_wasm_bitmask_i32x4(mask.bits));
#elif defined(__clang__) && __clang_major__ >= 16 // compiled to one instruction on x86
    using flags = bool __attribute__((ext_vector_type(N)));
    if constexpr (N == 4 || N == 8)
        return __builtin_bit_cast(unsigned char, __builtin_convertvector(mask.bits, flags)) & ((1U << N) - 1);
#endif
    std::uint32_t bits = 0;
    detail::for_each_lane<N>([&](int i) { bits |= static_cast<std::uint32_t>(mask.bits[i]) & 1U << i; });
    return bits;
}

/// a where the mask is set, b elsewhere.
template <int N>
INSONIFY_INLINE lanes<N> select(const lane_mask<N>& mask, const lanes<N>& a, const lanes<N>& b) {
    return lanes<N>(mask.bits ? a.values : b.values);
}

template <int N>
INSONIFY_INLINE lanes<N> min(const lanes<N>& a, const lanes<N>& b) {
    return select(a < b, a, b);
}
template <int N>
INSONIFY_INLINE lanes<N> max(const lanes<N>& a, const lanes<N>& b) {
    return select(a < b, b, a);
}
template <int N>
INSONIFY_INLINE lanes<N> abs(const lanes<N>& a) {
    const auto bits = __builtin_bit_cast(detail::vector<std::uint32_t, N>, a) & 0x7FFFFFFFU;
    return __builtin_bit_cast(lanes<N>, bits);
}
template <int N>
INSONIFY_INLINE lanes<N> sqrt(const lanes<N>& a) {
#if __has_builtin(__builtin_elementwise_sqrt)
    return lanes<N>(__builtin_elementwise_sqrt(a.values));
#else
    return each_lane<N>([&a](int i) { return std::sqrt(a[i]); });
#endif
}
template <int N>
INSONIFY_INLINE lanes<N> multiply_add(const lanes<N>& a, const lanes<N>& b, const lanes<N>& c) {
    if constexpr (!detail::has_fma) return a * b + c;
#if __has_builtin(__builtin_elementwise_fma)
    return lanes<N>(__builtin_elementwise_fma(a.values, b.values, c.values));
#else
    return each_lane<N>([&](int i) { return std::fma(a[i], b[i], c[i]); });
#endif
}

/// The minimum, the maximum and the sum over all lanes.
/// @{
template <int N>
INSONIFY_INLINE float reduce_min(const lanes<N>& a) {
    return detail::reduce(a, [](const auto& x, const auto& y) { return min(x, y); });
}
template <int N>
INSONIFY_INLINE float reduce_max(const lanes<N>& a) {
    return detail::reduce(a, [](const auto& x, const auto& y) { return max(x, y); });
}
template <int N>
INSONIFY_INLINE float sum(const lanes<N>& a) {
    return detail::reduce(a, [](const auto& x, const auto& y) { return x + y; });
}
/// @}

} // namespace insonify::inline INSONIFY_ABI
#endif

#include <insonify/core/restore_macros.hpp>

#endif
