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
    if constexpr (has_fma)
        return stdx::fma(a, b, c);
    else
        return a * b + c;
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
};

template <int N>
INSONIFY_FN lane_mask<N> operator&&(const lane_mask<N>& a, const lane_mask<N>& b) {
    lane_mask<N> result;
    for (int i = 0; i < N; ++i) result.lane[i] = a.lane[i] && b.lane[i];
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
template <int N>
INSONIFY_FN std::uint32_t bits_of(const lane_mask<N>& mask) {
    std::uint32_t bits = 0;
    for (int i = 0; i < N; ++i) bits |= static_cast<std::uint32_t>(mask.lane[i]) << static_cast<unsigned>(i);
    return bits;
}

#endif

} // namespace insonify::inline INSONIFY_ABI
#endif
