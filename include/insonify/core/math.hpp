#ifndef INSONIFY_CORE_MATH_HPP
#define INSONIFY_CORE_MATH_HPP

#include <insonify/core/config.hpp>

#if defined(__CUDACC__)
#include <cuda.h> // GLM asks for its version
#if !defined(GLM_FORCE_CUDA)
#define GLM_FORCE_CUDA
#endif
#pragma nv_diagnostic push
#pragma nv_diag_suppress 20012 // GLM annotates functions that it defaults
#elif !defined(GLM_FORCE_INLINE)
#define GLM_FORCE_INLINE // in large files GCC would call even operator[]
#endif
#include <glm/glm.hpp>
#if defined(__CUDACC__)
#pragma nv_diagnostic pop
#endif

#include <bit>
#include <cmath>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Vectors and matrices are those of GLM: floats, unless the name says otherwise.
/// @{
using vec2 = glm::vec2;
using vec3 = glm::vec3;
using dvec3 = glm::dvec3;
using uvec2 = glm::uvec2;
using uvec3 = glm::uvec3;
using mat3 = glm::mat3;
/// @}

static_assert(
    sizeof(vec3) == 12 && sizeof(uvec3) == 12,
    "insonify needs GLM's packed vectors: do not define GLM_FORCE_DEFAULT_ALIGNED_GENTYPES before including it");

using glm::cross;
using glm::determinant;
using glm::dot;
using glm::length;
using glm::normalize;
using glm::transpose;

inline constexpr float pi = 3.14159265358979F; ///< half a turn, radians

/// False for infinities and NaN; reads the bits, so that it holds under -ffast-math too.
INSONIFY_FN inline bool is_finite(float value) {
    return (__builtin_bit_cast(std::uint32_t, value) & 0x7F800000U) != 0x7F800000U;
}
/// True where all three coordinates are.
INSONIFY_FN inline bool is_finite(vec3 v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }

/// The lesser and the greater of two, and a value kept between two: as std::min, max and clamp, but also on a device.
/// Of a NaN and a number the first argument. Vectors coordinate by coordinate.
/// @{
INSONIFY_FN constexpr float lesser(float a, float b) { return b < a ? b : a; }
INSONIFY_FN constexpr float greater(float a, float b) { return a < b ? b : a; }
INSONIFY_FN constexpr float clamped(float value, float low, float high) { return lesser(greater(value, low), high); }

INSONIFY_FN constexpr vec3 lesser(vec3 a, vec3 b) { return {lesser(a.x, b.x), lesser(a.y, b.y), lesser(a.z, b.z)}; }
INSONIFY_FN constexpr vec3 greater(vec3 a, vec3 b) { return {greater(a.x, b.x), greater(a.y, b.y), greater(a.z, b.z)}; }
/// @}

/// Each coordinate without its sign.
INSONIFY_FN inline vec3 absolute(vec3 v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }

/// Two directions across a third of length 1, so that the three make a frame. Source: Duff et al. 2017.
struct axes_across {
    vec3 first{1, 0, 0};  ///< across the direction
    vec3 second{0, 1, 0}; ///< across both

    /// @param direction  of length 1
    INSONIFY_FN explicit axes_across(vec3 direction) {
        const float side = std::copysign(1.0F, direction.z);
        const float a = -1 / (side + direction.z);
        const float b = direction.x * direction.y * a;
        first = {1 + side * direction.x * direction.x * a, side * b, -side * direction.x};
        second = {b, side + direction.y * direction.y * a, -direction.y};
    }
};

/// The place of the lowest bit that is set, of a number that is not 0.
INSONIFY_FN inline std::uint32_t lowest_bit(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
    return static_cast<std::uint32_t>(__ffs(static_cast<int>(bits)) - 1);
#else
    return static_cast<std::uint32_t>(std::countr_zero(bits));
#endif
}

/// a * b + c, rounded once where that is one instruction and twice elsewhere: never the compiler's choice.
INSONIFY_FN inline float multiply_add(float a, float b, float c) {
#if defined(__clang__)
#pragma clang fp contract(off) // or constants are rounded once everywhere
#endif
    if constexpr (has_fma) return std::fma(a, b, c);
    return a * b + c;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
