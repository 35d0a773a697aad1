#ifndef INSONIFY_CORE_MATH_HPP
#define INSONIFY_CORE_MATH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>

#if defined(__CUDACC__)
#include <cuda.h> // GLM checks its version
#if !defined(GLM_FORCE_CUDA)
#define GLM_FORCE_CUDA
#endif
#pragma nv_diagnostic push
#pragma nv_diag_suppress 20012 // GLM annotates functions that it defaults
#elif !defined(GLM_FORCE_INLINE)
#define GLM_FORCE_INLINE // otherwise GCC does not inline even operator[] in large files
#endif
#include <glm/glm.hpp>
#if defined(__CUDACC__)
#pragma nv_diagnostic pop
#endif

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// GLM's vectors and matrices, of floats unless the name says otherwise.
/// @{
using vec2 = glm::vec2;
using vec3 = glm::vec3;
using dvec2 = glm::dvec2;
using dvec3 = glm::dvec3;
using uvec2 = glm::uvec2;
using uvec3 = glm::uvec3;
using mat3 = glm::mat3;
using dmat3 = glm::dmat3;
/// @}

static_assert(
    sizeof(vec3) == 12 && sizeof(uvec3) == 12,
    "insonify needs GLM's packed vectors: do not define GLM_FORCE_DEFAULT_ALIGNED_GENTYPES before including it");

using glm::cross;
using glm::determinant;
using glm::dot;
using glm::inverse;
using glm::length;
using glm::normalize;
using glm::outerProduct;
using glm::transpose;

/// Half a turn, radians.
inline constexpr float pi = 3.14159265358979F;

/// False for infinities and NaN. Tests the bits, so it also works under -ffast-math.
INSONIFY_FN inline bool is_finite(float value) {
    return (__builtin_bit_cast(std::uint32_t, value) & 0x7F800000U) != 0x7F800000U;
}
/// True if all three coordinates are finite.
INSONIFY_FN inline bool is_finite(vec3 v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }

/// As std::min, std::max and std::clamp, but also in device code; vectors componentwise. If an argument is NaN, min and
/// max return the first one.
/// @{
INSONIFY_FN constexpr float min(float a, float b) { return b < a ? b : a; }
INSONIFY_FN constexpr float max(float a, float b) { return a < b ? b : a; }
INSONIFY_FN constexpr float clamp(float value, float low, float high) { return min(max(value, low), high); }

INSONIFY_FN constexpr vec2 min(vec2 a, vec2 b) { return {min(a.x, b.x), min(a.y, b.y)}; }
INSONIFY_FN constexpr vec2 max(vec2 a, vec2 b) { return {max(a.x, b.x), max(a.y, b.y)}; }
INSONIFY_FN constexpr vec3 min(vec3 a, vec3 b) { return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}; }
INSONIFY_FN constexpr vec3 max(vec3 a, vec3 b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }
/// @}

/// Componentwise absolute value.
/// @{
INSONIFY_FN inline vec2 abs(vec2 v) { return {std::fabs(v.x), std::fabs(v.y)}; }
INSONIFY_FN inline vec3 abs(vec3 v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }
/// @}

namespace detail {

/// False for NaN; tests the bits, as `is_finite`.
INSONIFY_FN INSONIFY_INLINE bool is_number(float value) {
    return (__builtin_bit_cast(std::uint32_t, value) & 0x7FFFFFFFU) <= 0x7F800000U;
}

INSONIFY_FN constexpr vec2 complex_product(vec2 a, vec2 b) { return {a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x}; }
/// exp(2 pi i turns)
INSONIFY_FN inline vec2 turned(double turns) {
    const auto part = static_cast<float>(turns - std::floor(turns));
    return {std::cos(2 * pi * part), std::sin(2 * pi * part)};
}

/// A place between two neighbouring values of a table.
struct table_place {
    std::size_t above = 0; ///< index of the value before the place
    std::size_t below = 0; ///< of the next one; at the end of the table the same
    float part = 0;        ///< of the way from `above` to `below`

    /// @param place  in values from the first one on; beyond the table, that of its nearest value
    /// @param count  of values, at least 1
    INSONIFY_FN constexpr table_place(float place, std::size_t count) {
        const float within = clamp(place, 0, static_cast<float>(count - 1));
        above = static_cast<std::size_t>(within);
        below = above + 1 < count ? above + 1 : above;
        part = within - static_cast<float>(above);
    }
};

/// Two axes that form an orthonormal basis with a direction.
/// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
struct orthonormal_basis {
    vec3 first{1, 0, 0};
    vec3 second{0, 1, 0};

    /// @param direction  length 1
    INSONIFY_FN explicit orthonormal_basis(vec3 direction) {
        const float side = std::copysign(1.0F, direction.z);
        const float a = -1 / (side + direction.z);
        const float b = direction.x * direction.y * a;
        first = {1 + side * direction.x * direction.x * a, side * b, -side * direction.x};
        second = {b, side + direction.y * direction.y * a, -direction.y};
    }
};

/// Trilinear interpolation of values on a regular grid.
/// @param values  x changes first, z last
/// @param size    values along each axis, at least 2
/// @param place   in values; beyond the grid, its outermost cells go on
INSONIFY_FN inline vec3 interpolated(const vec3* values, uvec3 size, vec3 place) {
    const std::size_t step[3] = {1, size.x, std::size_t{size.x} * size.y};
    float part[3];
    for (int axis = 0; axis < 3; ++axis) {
        const float below = std::floor(clamp(place[axis], 0, static_cast<float>(size[axis]) - 2));
        part[axis] = place[axis] - below;
        values += step[axis] * static_cast<std::size_t>(below);
    }
    const auto along_x = [&](const vec3* at) { return at[0] + part[0] * (at[1] - at[0]); };
    const auto in_plane = [&](const vec3* at) {
        const vec3 low = along_x(at);
        return low + part[1] * (along_x(at + step[1]) - low);
    };
    const vec3 low = in_plane(values);
    return low + part[2] * (in_plane(values + step[2]) - low);
}

/// Index of the lowest set bit; `bits` is not 0.
INSONIFY_FN inline std::uint32_t lowest_bit(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
    return static_cast<std::uint32_t>(__ffs(static_cast<int>(bits)) - 1);
#else
    return static_cast<std::uint32_t>(std::countr_zero(bits));
#endif
}

} // namespace detail

/// a * b + c, fused if the instruction set has fused multiply-add, otherwise rounded twice; not left to the compiler.
INSONIFY_FN inline float multiply_add(float a, float b, float c) {
#if defined(__clang__)
#pragma clang fp contract(off) // otherwise constant expressions are fused everywhere
#endif
    if constexpr (detail::has_fma) return std::fma(a, b, c);
    return a * b + c;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
