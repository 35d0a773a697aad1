#ifndef INSONIFY_SCENE_SCENE_VIEW_HPP
#define INSONIFY_SCENE_SCENE_VIEW_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/bvh/traverse.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/face_groups.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/smooth_normals.hpp>
#include <insonify/tissue/displacement_view.hpp>
#include <insonify/tissue/structure.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// An object as tracers see it. Trivially copyable; refers to the scene's arrays.
struct object_view {
    mesh_view surface{};                   ///< in object coordinates
    bvh_view<mesh_view> tree{};            ///< over `surface`; without nodes where it is out of date
    detail::face_groups_view groups{};     ///< for slicing where the tree is out of date
    detail::smooth_normals_view normals{}; ///< of `surface`
    pose at{};                             ///< object to world
    aabb box{};                            ///< in the world
    std::uint32_t id = 0;                  ///< its `object_id` as a number
    std::uint32_t medium = 0;              ///< index into `scene_view::media`
    bool tree_is_current = false;          ///< rays can be traced

    /// A world ray in object coordinates; distances along it are the same.
    INSONIFY_FN ray local(const ray& r) const {
        return {at.local_point(r.origin), at.local_direction(r.direction), r.min_distance, r.max_distance};
    }
};

namespace detail {

/// The world box of an object as a primitive of the scene's own tree.
struct object_box {
    aabb box{}; ///< in the world
};

/// The box itself.
INSONIFY_FN inline aabb bounds(const object_box& o) { return o.box; }
/// Where the ray enters the box; conservative, so that rounding never misses one.
INSONIFY_FN inline hit intersect(const ray& r, const object_box& o) {
    float in = r.min_distance, out = r.max_distance;
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = std::fabs(r.direction[axis]) > 1e-30F ? 1 / r.direction[axis] : 1e30F;
        const float a = (o.box.lower[axis] - r.origin[axis]) * inverse;
        const float b = (o.box.upper[axis] - r.origin[axis]) * inverse;
        in = max(in, min(a, b));
        out = min(out, max(a, b));
    }
    return {.distance = in <= out * 1.000001F ? min(in, r.max_distance) : FLT_MAX};
}

} // namespace detail

/// A scene in flat arrays, as tracers and devices see it. Trivially copyable; valid until the scene changes.
///
/// Objects are ordered by rank: where several contain a point, the first one's medium applies.
struct scene_view {
    view<const object_view> objects{};                ///< by rank
    bvh_view<view<const detail::object_box>> boxes{}; ///< the objects' world boxes, by rank
    view<const medium> media{};                       ///< the background first
    view<const pose> places{};                        ///< object to world: of the background (identity), then by rank
    view<const placed_structure> structures{};        ///< of the medium of each place
    view<const displacement_view> displacements{};    ///< of the tissue of each place, for one frame; empty: at rest
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
