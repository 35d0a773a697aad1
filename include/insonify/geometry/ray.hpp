#ifndef INSONIFY_GEOMETRY_RAY_HPP
#define INSONIFY_GEOMETRY_RAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cfloat>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Axis-aligned box from `lower` to `upper`, both included. By default it is empty: merging it changes nothing.
struct aabb {
    vec3 lower{FLT_MAX, FLT_MAX, FLT_MAX};    ///< minimum of each coordinate
    vec3 upper{-FLT_MAX, -FLT_MAX, -FLT_MAX}; ///< maximum of each coordinate

    /// True for a box without points; a box of zero thickness has some.
    INSONIFY_FN bool empty() const { return lower.x > upper.x || lower.y > upper.y || lower.z > upper.z; }
    /// Undefined for an empty box.
    INSONIFY_FN vec3 centre() const { return 0.5F * lower + 0.5F * upper; }
    /// Edge lengths; 0 for an empty box.
    INSONIFY_FN vec3 size() const { return empty() ? vec3{0, 0, 0} : upper - lower; }

    /// Half the surface area, square metres: the cost measure of the surface area heuristic.
    INSONIFY_FN float half_area() const {
        const vec3 d = size();
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
    /// True for a point inside or on the surface.
    INSONIFY_FN bool contains(vec3 p) const {
        return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y && p.z >= lower.z && p.z <= upper.z;
    }
};

/// The smallest box that contains both boxes.
INSONIFY_FN inline aabb merged(const aabb& a, const aabb& b) { return {min(a.lower, b.lower), max(a.upper, b.upper)}; }
/// The smallest box that contains a box and a point.
INSONIFY_FN inline aabb merged(const aabb& a, vec3 p) { return {min(a.lower, p), max(a.upper, p)}; }

/// True for a box that is not empty and has no infinite or NaN coordinate.
INSONIFY_FN inline bool is_finite(const aabb& box) {
    return is_finite(box.lower) && is_finite(box.upper) && !box.empty();
}
/// True where the boxes share a point; never for an empty box.
INSONIFY_FN inline bool overlaps(const aabb& a, const aabb& b) {
    return a.lower.x <= b.upper.x && a.upper.x >= b.lower.x && a.lower.y <= b.upper.y && a.upper.y >= b.lower.y &&
           a.lower.z <= b.upper.z && a.upper.z >= b.lower.z;
}

/// A ray, or a segment of one. Distances are in units of `direction`: metres where its length is 1.
struct ray {
    vec3 origin{0, 0, 0};         ///< metres
    vec3 direction{0, 0, 1};      ///< of any length except 0
    float min_distance = 0;       ///< closer hits are ignored
    float max_distance = FLT_MAX; ///< further hits are ignored

    /// The point at a distance, in units of `direction`.
    INSONIFY_FN vec3 at(float distance) const { return origin + distance * direction; }
};

/// Intersection of a ray with a primitive; converts to false for a miss.
struct hit {
    float distance = FLT_MAX;      ///< along the ray, in units of its direction
    std::uint32_t primitive = ~0U; ///< index into the range that the BVH was built over

    /// False for a miss.
    INSONIFY_FN constexpr explicit operator bool() const { return distance < FLT_MAX; }

    friend bool operator==(const hit&, const hit&) = default;
};

/// Order of hits: by distance, then by index.
INSONIFY_FN constexpr bool nearer(const hit& a, const hit& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.primitive < b.primitive);
}

/// A box as a primitive of a tree: the box itself, and where a ray enters it. Conservative: rounding never misses one.
/// @{
INSONIFY_FN inline aabb bounds(const aabb& box) { return box; }
INSONIFY_FN inline hit intersect(const ray& r, const aabb& box) {
    float in = r.min_distance, out = r.max_distance;
    for (int axis = 0; axis < 3; ++axis) {
        const float to_lower = box.lower[axis] - r.origin[axis], to_upper = box.upper[axis] - r.origin[axis];
        if (!(std::fabs(r.direction[axis]) > 1e-30F)) {
            if (to_lower > 0 || to_upper < 0) return {};
            continue;
        }
        const float a = to_lower / r.direction[axis], b = to_upper / r.direction[axis];
        in = max(in, min(a, b));
        out = min(out, max(a, b));
    }
    return {.distance = in <= out * 1.000001F ? min(in, r.max_distance) : FLT_MAX};
}
/// @}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
