#ifndef INSONIFY_EXECUTION_SIMD_HPP
#define INSONIFY_EXECUTION_SIMD_HPP

#include <insonify/core/math.hpp>
#include <cstddef>
#include <cstdint>

#if !defined(INSONIFY_NO_SIMD)
#include <experimental/simd>
#endif

/// Several floats at once. With <experimental/simd> a `lanes<N>` is its type; elsewhere (a device, another standard
/// library, INSONIFY_NO_SIMD) it is an array with the same operators, so that the code above knows only one way.
namespace insonify::inline INSONIFY_ABI {

#if !defined(INSONIFY_NO_SIMD)

namespace stdx = std::experimental;

/// Floats that one register holds, 8 at most: the width that trees and packets are built for.
inline constexpr int simd_width = stdx::native_simd<float>::size() < 8 ? 4 : 8;

template <int N>
using lanes = stdx::simd<float, stdx::simd_abi::deduce_t<float, N>>;
template <int N>
using lane_mask = typename lanes<N>::mask_type;

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
    return static_cast<std::uint32_t>(mask.__to_bitset().to_ulong());
}

template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> lesser(const stdx::simd<float, Abi>& a, const stdx::simd<float, Abi>& b) {
    return stdx::min(a, b);
}
template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> greater(const stdx::simd<float, Abi>& a, const stdx::simd<float, Abi>& b) {
    return stdx::max(a, b);
}
template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> absolute(const stdx::simd<float, Abi>& a) {
    return stdx::abs(a);
}
template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> square_root(const stdx::simd<float, Abi>& a) {
    return stdx::sqrt(a);
}
template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> multiply_add(const stdx::simd<float, Abi>& a, const stdx::simd<float, Abi>& b,
                                                    const stdx::simd<float, Abi>& c) {
#if defined(__FMA__) // stdx::fma of libstdc++ 12 is not inlined at -O2
    if constexpr (requires { static_cast<__m256>(a); })
        return stdx::simd<float, Abi>(
            _mm256_fmadd_ps(static_cast<__m256>(a), static_cast<__m256>(b), static_cast<__m256>(c)));
    else if constexpr (requires { static_cast<__m128>(a); })
        return stdx::simd<float, Abi>(
            _mm_fmadd_ps(static_cast<__m128>(a), static_cast<__m128>(b), static_cast<__m128>(c)));
    else
        return stdx::fma(a, b, c);
#else
    if constexpr (has_fma)
        return stdx::fma(a, b, c);
    else
        return a * b + c;
#endif
}

/// a where the mask is set, b elsewhere.
template <class Abi>
INSONIFY_INLINE stdx::simd<float, Abi> select(const stdx::simd_mask<float, Abi>& mask, const stdx::simd<float, Abi>& a,
                                              const stdx::simd<float, Abi>& b) {
#if defined(__clang__) && defined(__AVX512VL__) // where() of libstdc++ 12 assigns nothing there
    const auto bits = static_cast<__mmask8>(bits_of(mask));
    if constexpr (requires { static_cast<__m256>(a); })
        return stdx::simd<float, Abi>(_mm256_mask_blend_ps(bits, static_cast<__m256>(b), static_cast<__m256>(a)));
    else if constexpr (requires { static_cast<__m128>(a); })
        return stdx::simd<float, Abi>(_mm_mask_blend_ps(bits, static_cast<__m128>(b), static_cast<__m128>(a)));
#endif
    stdx::simd<float, Abi> result = b;
    stdx::where(mask, result) = a;
    return result;
}

/// The least and the greatest of the lanes.
template <class Abi>
INSONIFY_INLINE float least(const stdx::simd<float, Abi>& a) {
    return stdx::hmin(a);
}
template <class Abi>
INSONIFY_INLINE float greatest(const stdx::simd<float, Abi>& a) {
    return stdx::hmax(a);
}
template <class Abi>
INSONIFY_INLINE float sum(const stdx::simd<float, Abi>& a) {
    return stdx::reduce(a);
}

#else

inline constexpr int simd_width = 4;

template <int N>
struct lane_mask {
    bool lane[N] = {};
};

template <int N>
struct lanes {
    float lane[N] = {};

    lanes() = default;
    INSONIFY_FN lanes(float value) {
        for (float& l : lane) l = value;
    }
    static constexpr std::size_t size() { return N; }
    INSONIFY_FN float operator[](int i) const { return lane[i]; }

    template <class Result, class Operation>
    INSONIFY_FN static Result each(Operation operation) {
        Result result;
        for (int i = 0; i < N; ++i) result.lane[i] = operation(i);
        return result;
    }

    INSONIFY_FN friend lanes operator-(const lanes& a) {
        return each<lanes>([&](int i) { return -a.lane[i]; });
    }
    INSONIFY_FN friend lanes operator+(const lanes& a, const lanes& b) {
        return each<lanes>([&](int i) { return a.lane[i] + b.lane[i]; });
    }
    INSONIFY_FN friend lanes operator-(const lanes& a, const lanes& b) {
        return each<lanes>([&](int i) { return a.lane[i] - b.lane[i]; });
    }
    INSONIFY_FN friend lanes operator*(const lanes& a, const lanes& b) {
        return each<lanes>([&](int i) { return a.lane[i] * b.lane[i]; });
    }
    INSONIFY_FN friend lanes operator/(const lanes& a, const lanes& b) {
        return each<lanes>([&](int i) { return a.lane[i] / b.lane[i]; });
    }
    INSONIFY_FN friend lane_mask<N> operator<(const lanes& a, const lanes& b) {
        return each<lane_mask<N>>([&](int i) { return a.lane[i] < b.lane[i]; });
    }
    INSONIFY_FN friend lane_mask<N> operator<=(const lanes& a, const lanes& b) {
        return each<lane_mask<N>>([&](int i) { return a.lane[i] <= b.lane[i]; });
    }
    INSONIFY_FN friend lane_mask<N> operator==(const lanes& a, const lanes& b) {
        return each<lane_mask<N>>([&](int i) { return a.lane[i] == b.lane[i]; });
    }
    INSONIFY_FN friend lanes lesser(const lanes& a, const lanes& b) {
        return each<lanes>([&](int i) { return insonify::lesser(a.lane[i], b.lane[i]); });
    }
    INSONIFY_FN friend lanes greater(const lanes& a, const lanes& b) {
        return each<lanes>([&](int i) { return insonify::greater(a.lane[i], b.lane[i]); });
    }
    INSONIFY_FN friend lanes absolute(const lanes& a) {
        return each<lanes>([&](int i) { return std::fabs(a.lane[i]); });
    }
    INSONIFY_FN friend lanes square_root(const lanes& a) {
        return each<lanes>([&](int i) { return std::sqrt(a.lane[i]); });
    }
    INSONIFY_FN friend lanes multiply_add(const lanes& a, const lanes& b, const lanes& c) {
        return each<lanes>([&](int i) { return insonify::multiply_add(a.lane[i], b.lane[i], c.lane[i]); });
    }
    INSONIFY_FN friend lanes select(const lane_mask<N>& mask, const lanes& a, const lanes& b) {
        return each<lanes>([&](int i) { return mask.lane[i] ? a.lane[i] : b.lane[i]; });
    }
    INSONIFY_FN friend float least(const lanes& a) {
        float result = a.lane[0];
        for (float l : a.lane) result = insonify::lesser(result, l);
        return result;
    }
    INSONIFY_FN friend float sum(const lanes& a) {
        float result = 0;
        for (float l : a.lane) result += l;
        return result;
    }
    INSONIFY_FN friend float greatest(const lanes& a) {
        float result = a.lane[0];
        for (float l : a.lane) result = insonify::greater(result, l);
        return result;
    }
};

template <int N>
INSONIFY_FN lane_mask<N> operator&&(const lane_mask<N>& a, const lane_mask<N>& b) {
    lane_mask<N> result;
    for (int i = 0; i < N; ++i) result.lane[i] = a.lane[i] && b.lane[i];
    return result;
}
template <int N>
INSONIFY_FN lane_mask<N> operator!(const lane_mask<N>& a) {
    lane_mask<N> result;
    for (int i = 0; i < N; ++i) result.lane[i] = !a.lane[i];
    return result;
}
template <int N>
INSONIFY_FN lane_mask<N> operator||(const lane_mask<N>& a, const lane_mask<N>& b) {
    lane_mask<N> result;
    for (int i = 0; i < N; ++i) result.lane[i] = a.lane[i] || b.lane[i];
    return result;
}

template <int N>
INSONIFY_FN lanes<N> load(const float* from) {
    return lanes<N>::template each<lanes<N>>([&](int i) { return from[i]; });
}
template <int N>
INSONIFY_FN void store(const lanes<N>& value, float* to) {
    for (int i = 0; i < N; ++i) to[i] = value.lane[i];
}
template <int N, class Value>
INSONIFY_FN lanes<N> each_lane(const Value& value) {
    return lanes<N>::template each<lanes<N>>(value);
}
template <int N>
INSONIFY_FN std::uint32_t bits_of(const lane_mask<N>& mask) {
    std::uint32_t bits = 0;
    for (int i = 0; i < N; ++i) bits |= static_cast<std::uint32_t>(mask.lane[i]) << static_cast<unsigned>(i);
    return bits;
}

#endif

/// 1 / a, rounded as scalars are.
template <class Lanes>
    requires requires { Lanes::size(); }
INSONIFY_FN INSONIFY_INLINE Lanes inverse(const Lanes& a) {
#if __FINITE_MATH_ONLY__ > 0 && !defined(__CUDACC__) // -ffast-math, or a part of it
    constexpr int n = static_cast<int>(Lanes::size());
    float each[n];
    store(a, each);
    for (float& one : each) {
        one = 1 / one;
        asm("" : "+m"(one)); // or the compiler divides several at once, which is less precise here
    }
    return load<n>(each);
#else
    return Lanes(1.0F) / a;
#endif
}

/// a * b - c * d with a sign that is certain, whatever the order of the factors, where the result is not tiny: the
/// rounding of one product is found by a fused multiply-add and taken off. Without such an instruction: the difference
/// of two rounded products.
///
/// Source: Kahan; error below 1.5 units in the last place: Jeannerod, Louvet & Muller 2013, Mathematics of Computation.
template <class Lanes>
INSONIFY_FN INSONIFY_INLINE Lanes difference_of_products(const Lanes& a, const Lanes& b, const Lanes& c,
                                                         const Lanes& d) {
    const Lanes product = c * d;
    if constexpr (!has_fma) return a * b - product;
    return multiply_add(a, b, -product) - multiply_add(c, d, -product);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
