#ifndef INSONIFY_SCENE_POINT_BOUNDS_HPP
#define INSONIFY_SCENE_POINT_BOUNDS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <insonify/geometry/aabb.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

/// What one pass over points finds.
struct point_bounds {
    aabb box{};         ///< around them, where all are finite
    bool finite = true; ///< whether all are
};

/// Bounds of two sets of points.
inline point_bounds merged(const point_bounds& a, const point_bounds& b) {
    return {merged(a.box, b.box), a.finite && b.finite};
}

/// Bounds points and copies them, in one pass. @param copy  as many; null: none is made
inline point_bounds bounds_of(view<const vec3> points, vec3* copy) {
    // Coordinates interleave in three registers: x y z x, y z x y, z x y z.
    constexpr int width = simd_width;
    using floats = lanes<width>;
    floats lower[3] = {floats(FLT_MAX), floats(FLT_MAX), floats(FLT_MAX)};
    floats upper[3] = {floats(-FLT_MAX), floats(-FLT_MAX), floats(-FLT_MAX)};
    bit_lanes<width> wild{};
    const std::size_t whole = points.size() / width * width;
    for (std::size_t begin = 0; begin < whole; begin += width) {
        const auto add = [&](std::ptrdiff_t k) {
            const floats p = load<width>(&points[begin].x + k * width);
            wild = wild | not_finite<width>(p);
            lower[k] = min(lower[k], p);
            upper[k] = max(upper[k], p);
            if (copy != nullptr) store(p, &copy[begin].x + k * width);
        };
        add(0), add(1), add(2); // not a loop, which g++ -O2 does not unroll
    }
    float lowest[3 * width], highest[3 * width];
    for (std::ptrdiff_t k = 0; k < 3; ++k) {
        store(lower[k], lowest + k * width);
        store(upper[k], highest + k * width);
    }
    point_bounds found;
    for (int lane = 0, i = 0; lane < width; ++lane, i += 3) {
        found.box = merged(
            found.box, aabb{{lowest[i], lowest[i + 1], lowest[i + 2]}, {highest[i], highest[i + 1], highest[i + 2]}});
        found.finite = found.finite && wild[lane] >> 31 == 0;
    }
    for (std::size_t i = whole; i < points.size(); ++i) {
        found = merged(found, {merged(aabb{}, points[i]), is_finite(points[i])});
        if (copy != nullptr) copy[i] = points[i];
    }
    return found;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
