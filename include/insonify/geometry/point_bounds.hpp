#ifndef INSONIFY_GEOMETRY_POINT_BOUNDS_HPP
#define INSONIFY_GEOMETRY_POINT_BOUNDS_HPP

#include <insonify/core/view.hpp>
#include <insonify/geometry/aabb.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The box around all points that are finite; empty for none.
inline aabb bounds_of(view<const vec3> points) {
    // Eight points at a time, coordinate by coordinate: the inner loops are SIMD wherever the compiler has any.
    constexpr std::size_t step = 8;
    float lower[3 * step], upper[3 * step];
    for (std::size_t i = 0; i < 3 * step; ++i) lower[i] = FLT_MAX, upper[i] = -FLT_MAX;
    const std::size_t whole = points.size() / step * step;
    for (std::size_t begin = 0; begin < whole; begin += step) {
        const float* const p = &points[begin].x;
        for (std::size_t i = 0; i < 3 * step; ++i) lower[i] = p[i] < lower[i] ? p[i] : lower[i]; // never takes a NaN
        for (std::size_t i = 0; i < 3 * step; ++i) upper[i] = upper[i] < p[i] ? p[i] : upper[i];
    }
    aabb box;
    for (std::size_t i = 0; i < 3 * step; i += 3)
        box = merged(box, aabb{{lower[i], lower[i + 1], lower[i + 2]}, {upper[i], upper[i + 1], upper[i + 2]}});
    for (std::size_t i = whole; i < points.size(); ++i) box = merged(box, points[i]);
    if (is_finite(box) || points.empty()) return box;
    box = {};
    for (const vec3& p : points)
        if (is_finite(p)) box = merged(box, p);
    return box;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
