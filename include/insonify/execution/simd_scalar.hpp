#ifndef INSONIFY_EXECUTION_SIMD_SCALAR_HPP
#define INSONIFY_EXECUTION_SIMD_SCALAR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>

#if defined(INSONIFY_NO_SIMD)
#include <cstddef>
#include <cstdint>

/// `lanes<N>` and `bit_lanes<N>` over arrays: for devices and for INSONIFY_NO_SIMD.
namespace insonify::inline INSONIFY_ABI {

/// The width of trees and packets.
inline constexpr int simd_width = 4;
inline constexpr int max_simd_width = simd_width; ///< for long runs

namespace detail {

/// An array with the operators of T, element by element.
template <class T, int N>
struct array {
    T lane[N] = {};

    array() = default;
    INSONIFY_FN array(T value) {
        for (T& l : lane) l = value;
    }
    static constexpr std::size_t size() { return N; }
    INSONIFY_FN T& operator[](int i) { return lane[i]; }
    INSONIFY_FN T operator[](int i) const { return lane[i]; }

    /// Lane i is value(i).
    INSONIFY_VISITS
    template <class Value>
    INSONIFY_FN static array each(const Value& value) {
        array result;
        for (int i = 0; i < N; ++i) result.lane[i] = value(i);
        return result;
    }

    INSONIFY_FN friend array operator-(const array& a) {
        return each([&](int i) { return -a[i]; });
    }
    INSONIFY_FN friend array operator!(const array& a) {
        return each([&](int i) { return !a[i]; });
    }
    INSONIFY_FN friend array operator+(const array& a, const array& b) {
        return each([&](int i) { return a[i] + b[i]; });
    }
    INSONIFY_FN friend array operator-(const array& a, const array& b) {
        return each([&](int i) { return a[i] - b[i]; });
    }
    INSONIFY_FN friend array operator*(const array& a, const array& b) {
        return each([&](int i) { return a[i] * b[i]; });
    }
    INSONIFY_FN friend array operator/(const array& a, const array& b) {
        return each([&](int i) { return a[i] / b[i]; });
    }
    INSONIFY_FN friend array operator&(const array& a, const array& b) {
        return each([&](int i) { return a[i] & b[i]; });
    }
    INSONIFY_FN friend array operator|(const array& a, const array& b) {
        return each([&](int i) { return a[i] | b[i]; });
    }
    INSONIFY_FN friend array operator^(const array& a, const array& b) {
        return each([&](int i) { return a[i] ^ b[i]; });
    }
    INSONIFY_FN friend array operator&&(const array& a, const array& b) {
        return each([&](int i) { return a[i] && b[i]; });
    }
    INSONIFY_FN friend array operator||(const array& a, const array& b) {
        return each([&](int i) { return a[i] || b[i]; });
    }
    INSONIFY_FN friend array operator<<(const array& a, int by) {
        return each([&](int i) { return a[i] << static_cast<unsigned>(by); });
    }
    INSONIFY_FN friend array operator>>(const array& a, int by) {
        return each([&](int i) { return a[i] >> static_cast<unsigned>(by); });
    }
    INSONIFY_FN friend array<bool, N> operator<(const array& a, const array& b) {
        return array<bool, N>::each([&](int i) { return a[i] < b[i]; });
    }
    INSONIFY_FN friend array<bool, N> operator<=(const array& a, const array& b) {
        return array<bool, N>::each([&](int i) { return a[i] <= b[i]; });
    }
    INSONIFY_FN friend array<bool, N> operator==(const array& a, const array& b) {
        return array<bool, N>::each([&](int i) { return a[i] == b[i]; });
    }
};

} // namespace detail

template <int N>
using lanes = detail::array<float, N>;
template <int N>
using lane_mask = detail::array<bool, N>;
template <int N>
using bit_lanes = detail::array<std::uint32_t, N>;

/// Lane i is value(i).
INSONIFY_VISITS
template <int N, class Value>
INSONIFY_FN lanes<N> each_lane(const Value& value) {
    return lanes<N>::each(value);
}
template <int N>
INSONIFY_FN lanes<N> load(const float* from) {
    return lanes<N>::each([from](int i) { return from[i]; });
}
template <int N>
INSONIFY_FN void store(const lanes<N>& value, float* to) {
    for (int i = 0; i < N; ++i) to[i] = value[i];
}
template <int N>
INSONIFY_FN bit_lanes<N> load_bits(const std::uint32_t* from) {
    return bit_lanes<N>::each([from](int i) { return from[i]; });
}
template <int N>
INSONIFY_FN void store_bits(const bit_lanes<N>& bits, std::uint32_t* to) {
    for (int i = 0; i < N; ++i) to[i] = bits[i];
}
template <int N>
INSONIFY_FN lanes<N> floats_of(const bit_lanes<N>& bits) {
    return lanes<N>::each([&](int i) { return static_cast<float>(static_cast<std::int32_t>(bits[i])); });
}
template <int N>
INSONIFY_FN bit_lanes<N> bits_of_whole(const lanes<N>& x) {
    return bit_lanes<N>::each([&](int i) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(x[i])); });
}

/// Bit i is set where lane i is.
template <int N>
INSONIFY_FN std::uint32_t bits_of(const lane_mask<N>& mask) {
    std::uint32_t bits = 0;
    for (int i = 0; i < N; ++i) bits |= static_cast<std::uint32_t>(mask[i]) << static_cast<unsigned>(i);
    return bits;
}

template <int N>
INSONIFY_FN lanes<N> min(const lanes<N>& a, const lanes<N>& b) {
    return lanes<N>::each([&](int i) { return min(a[i], b[i]); });
}
template <int N>
INSONIFY_FN lanes<N> max(const lanes<N>& a, const lanes<N>& b) {
    return lanes<N>::each([&](int i) { return max(a[i], b[i]); });
}
template <int N>
INSONIFY_FN lanes<N> abs(const lanes<N>& a) {
    return lanes<N>::each([&](int i) { return std::fabs(a[i]); });
}
template <int N>
INSONIFY_FN lanes<N> sqrt(const lanes<N>& a) {
    return lanes<N>::each([&](int i) { return std::sqrt(a[i]); });
}
template <int N>
INSONIFY_FN lanes<N> multiply_add(const lanes<N>& a, const lanes<N>& b, const lanes<N>& c) {
    return lanes<N>::each([&](int i) { return multiply_add(a[i], b[i], c[i]); });
}

/// a where the mask is set, b elsewhere.
template <int N>
INSONIFY_FN lanes<N> select(const lane_mask<N>& mask, const lanes<N>& a, const lanes<N>& b) {
    return lanes<N>::each([&](int i) { return mask[i] ? a[i] : b[i]; });
}

/// The minimum, the maximum and the sum over all lanes.
/// @{
template <int N>
INSONIFY_FN float reduce_min(const lanes<N>& a) {
    float result = a[0];
    for (const float l : a.lane) result = min(result, l);
    return result;
}
template <int N>
INSONIFY_FN float reduce_max(const lanes<N>& a) {
    float result = a[0];
    for (const float l : a.lane) result = max(result, l);
    return result;
}
template <int N>
INSONIFY_FN float sum(const lanes<N>& a) {
    float result = 0;
    for (const float l : a.lane) result += l;
    return result;
}
/// @}

} // namespace insonify::inline INSONIFY_ABI
#endif

#include <insonify/core/restore_macros.hpp>

#endif
