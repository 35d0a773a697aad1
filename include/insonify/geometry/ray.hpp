#ifndef INSONIFY_GEOMETRY_RAY_HPP
#define INSONIFY_GEOMETRY_RAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/aabb.hpp>
#include <cfloat>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

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

/// A box as a primitive of a tree: the box itself, and where a ray enters it. Conservative, so that rounding never misses one.
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
