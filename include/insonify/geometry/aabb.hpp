#ifndef INSONIFY_GEOMETRY_AABB_HPP
#define INSONIFY_GEOMETRY_AABB_HPP

#include <insonify/core/math.hpp>
#include <cfloat>

namespace insonify::inline INSONIFY_ABI {

/// Axis-aligned box from `lower` to `upper`, both included. The default is empty: it holds nothing and extends nothing.
struct aabb {
    vec3 lower{FLT_MAX, FLT_MAX, FLT_MAX};    ///< the corner of least coordinates
    vec3 upper{-FLT_MAX, -FLT_MAX, -FLT_MAX}; ///< the corner of greatest coordinates

    /// True where it holds no point; a box of no thickness holds some.
    INSONIFY_FN bool empty() const { return lower.x > upper.x || lower.y > upper.y || lower.z > upper.z; }
    /// Means nothing for an empty box.
    INSONIFY_FN vec3 centre() const { return 0.5F * lower + 0.5F * upper; }
    /// The lengths of its edges; 0 for an empty box.
    INSONIFY_FN vec3 size() const { return empty() ? vec3{0, 0, 0} : upper - lower; }

    /// Half the surface, in square metres: the measure of the surface area heuristic.
    INSONIFY_FN float half_area() const {
        const vec3 d = size();
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
    /// Its surface belongs to it.
    INSONIFY_FN bool contains(vec3 p) const {
        return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y && p.z >= lower.z && p.z <= upper.z;
    }
};

/// The smallest box that holds both.
INSONIFY_FN inline aabb merged(const aabb& a, const aabb& b) {
    return {lesser(a.lower, b.lower), greater(a.upper, b.upper)};
}
/// The smallest box that holds a box and a point.
INSONIFY_FN inline aabb merged(const aabb& a, vec3 p) { return {lesser(a.lower, p), greater(a.upper, p)}; }

/// Neither infinite nor NaN anywhere, and not empty.
INSONIFY_FN inline bool is_finite(const aabb& box) {
    return is_finite(box.lower) && is_finite(box.upper) && !box.empty();
}
/// True where the boxes share a point. An empty one shares none.
INSONIFY_FN inline bool overlaps(const aabb& a, const aabb& b) {
    return a.lower.x <= b.upper.x && a.upper.x >= b.lower.x && a.lower.y <= b.upper.y && a.upper.y >= b.lower.y &&
           a.lower.z <= b.upper.z && a.upper.z >= b.lower.z;
}

/// The points p with dot(normal, p) = offset.
struct plane {
    vec3 normal{0, 0, 1}; ///< of any length
    float offset = 0;     ///< from the origin, metres times the length of the normal
};

/// True where the box has points on both sides of the plane, or on it.
INSONIFY_FN inline bool overlaps(const plane& p, const aabb& box) {
    if (box.empty()) return false;
    const vec3 half = 0.5F * (box.upper - box.lower);
    const float reach =
        std::fabs(p.normal.x) * half.x + std::fabs(p.normal.y) * half.y + std::fabs(p.normal.z) * half.z;
    const float rounding = 4e-7F * (std::fabs(p.offset) + reach + dot(absolute(p.normal), absolute(box.centre())));
    return std::fabs(dot(p.normal, box.centre()) - p.offset) <= reach + rounding;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
