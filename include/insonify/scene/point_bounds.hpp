#ifndef INSONIFY_SCENE_POINT_BOUNDS_HPP
#define INSONIFY_SCENE_POINT_BOUNDS_HPP

#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/aabb.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

/// The box around all finite points; empty where there are none.
inline aabb bounds_of(view<const vec3> points) {
    // Coordinates interleave in three registers: x y z x, y z x y, z x y z.
    constexpr int width = simd_width;
    using floats = lanes<width>;
    floats lower[3] = {floats(FLT_MAX), floats(FLT_MAX), floats(FLT_MAX)};
    floats upper[3] = {floats(-FLT_MAX), floats(-FLT_MAX), floats(-FLT_MAX)};
    const std::size_t whole = points.size() / width * width;
    for (std::size_t begin = 0; begin < whole; begin += width)
        for (std::ptrdiff_t k = 0; k < 3; ++k) {
            const floats p = load<width>(&points[begin].x + k * width);
            lower[k] = select(p < lower[k], p, lower[k]); // a NaN is never taken
            upper[k] = select(upper[k] < p, p, upper[k]);
        }
    float lowest[3 * width], highest[3 * width];
    for (std::ptrdiff_t k = 0; k < 3; ++k) {
        store(lower[k], lowest + k * width);
        store(upper[k], highest + k * width);
    }
    aabb box;
    for (int i = 0; i < 3 * width; i += 3)
        box =
            merged(box, aabb{{lowest[i], lowest[i + 1], lowest[i + 2]}, {highest[i], highest[i + 1], highest[i + 2]}});
    for (std::size_t i = whole; i < points.size(); ++i) box = merged(box, points[i]);
    if (is_finite(box) || points.empty()) return box;
    box = {};
    for (const vec3& p : points)
        if (is_finite(p)) box = merged(box, p);
    return box;
}

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
