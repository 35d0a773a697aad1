#ifndef INSONIFY_BVH_PREPARED_RAY_HPP
#define INSONIFY_BVH_PREPARED_RAY_HPP

#include <insonify/bvh/node.hpp>
#include <insonify/geometry/triangle.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A ray with what every box and triangle asks of it worked out once.
///
/// Along an axis across which the ray does not move, it passes every box whose sides it stands between or on: a ray in
/// the plane that two boxes share must meet both, for the triangle test alone knows whose the edge between them is.
/// So there the inverse is huge, and the origin is taken a rounding further in.
struct prepared_ray {
    ray source{};
    vec3 entry_origin{0, 0, 0}, exit_origin{0, 0, 0};
    vec3 inverse{0, 0, 0};  ///< 1 / direction, finite
    int entry_side[3] = {}; ///< per axis: the side of a box that the ray meets first, 0 lower, 1 upper
    sheared_ray sheared{};
    bool legal = false; ///< finite, with a direction; a ray that is not meets nothing

    INSONIFY_FN explicit prepared_ray(const ray& r) : source{r} {
        for (int axis = 0; axis < 3; ++axis) {
            float& along = source.direction[axis];
            const bool moves = std::fabs(along) > 1e-30F;
            if (!moves) along = 0;
            const float room = moves ? 0.0F : greater(1.2e-7F * std::fabs(r.origin[axis]), 1e-20F);
            entry_origin[axis] = r.origin[axis] + room;
            exit_origin[axis] = r.origin[axis] - room;
            inverse[axis] = moves ? 1 / along : 1e30F;
            entry_side[axis] = along < 0;
        }
        legal = is_finite(r.origin) && is_finite(r.direction) && source.direction != vec3{0, 0, 0};
        if (legal) sheared = sheared_ray{source};
    }
};

/// Where the ray enters the boxes of a node's children; `met` has a bit for each box that it meets within its limits.
template <int Width>
struct box_entries {
    lanes<Width> distance{};
    std::uint32_t met = 0;
};

/// Slab test of all children at once. Conservative: rounding never loses a box.
///
/// Source: Ize 2013, "Robust BVH ray traversal": every rounding is relative to a slab distance, so widening the exit
/// by a few units in the last place covers them.
template <int Width>
INSONIFY_FN INSONIFY_INLINE box_entries<Width> enter(const node_bounds<Width>& bounds, const prepared_ray& r,
                                                     float max_distance) {
    using floats = lanes<Width>;
    floats in(r.source.min_distance), out(max_distance);
    for (int axis = 0; axis < 3; ++axis) {
        const floats from(r.entry_origin[axis]), to(r.exit_origin[axis]), inverse(r.inverse[axis]);
        const int entry = r.entry_side[axis];
        in = greater((load<Width>(bounds.side[entry][axis]) - from) * inverse, in);
        out = lesser((load<Width>(bounds.side[1 - entry][axis]) - to) * inverse, out);
    }
    const floats widened = multiply_add(absolute(out), floats(1e-6F), out);
    return {in, bits_of(in <= widened)};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
