#ifndef INSONIFY_SCENE_OBJECT_STATE_HPP
#define INSONIFY_SCENE_OBJECT_STATE_HPP

#include <insonify/acoustics/placed_structure.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/geometry/face_groups.hpp>
#include <insonify/scene/fibre_grid.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/point_bounds.hpp>
#include <insonify/scene/smooth_surface.hpp>
#include <insonify/scene/structure_axes.hpp>
#include <insonify/scene/tetrahedral_mesh.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// World box around a box in object coordinates, enlarged by the rounding error of rays transformed to the object.
inline aabb placed_box(const aabb& local, const pose& at) {
    if (local.empty()) return {};
    const vec3 centre = at.point(local.centre()), half = 0.5F * local.size();
    const mat3& r = at.rotation;
    const vec3 extent = half.x * abs(r[0]) + half.y * abs(r[1]) + half.z * abs(r[2]);
    const vec3 margin = 1e-6F * (abs(centre) + abs(at.translation) + extent + vec3{length(local.centre())});
    return {centre - extent - margin, centre + extent + margin};
}

/// What the scene derives from one object and keeps between frames.
struct object_state {
    bvh_storage<mesh_view> tree{};     ///< in object coordinates
    face_groups groups{};              ///< for slicing while the tree is out of date
    smooth_surface normals{};          ///< of smooth surfaces
    aabb local_box{};                  ///< in object coordinates, as built or updated
    aabb box{};                        ///< in the world
    std::uint32_t medium = 0;          ///< index into the scene's media
    std::uint32_t updates_at_rest = 0; ///< since the vertices last moved
    bool moved = false;                ///< the positions were handed out for writing since the last update
    bool tree_is_current = false;      ///< the tree and the normals fit the positions
    placed_structure structure{};      ///< of the medium, in the axes of the object as built
    fibre_grid fibres{};               ///< where they are curved
    std::vector<vec3> rest{};          ///< positions before the first deformation; empty: there was none
    located_vertices located{};        ///< of the vertices at rest in `tetrahedra`
    pose rest_at{};                    ///< object to world, when it was last deformed
    bool follows = false;              ///< the map that deforms the scene
    bool displaced = false;            ///< some vertices are away from rest

    /// Builds the tree and the normals. @throws std::bad_alloc
    /// @param at_rest  the positions at rest, if these are others
    template <class Policy>
    void build(const Policy& policy, const object& of, view<const vec3> at_rest) {
        tree.build(policy, mesh_view{of.surface});
        normals = smooth_surface{mesh_view{of.surface}, of.crease_angle};
        normals.compute(policy, mesh_view{of.surface});
        tree_is_current = true;
        moved = false;
        local_box = tree.box();
        box = placed_box(local_box, of.at);
        if (of.fibres.varies()) fibres = {of.fibres, local_box, own_axes(of, at_rest)};
        place_structure(of, at_rest);
    }

    /// Takes over what belongs to the deformation of an earlier state.
    void keep_rest(object_state& of) {
        rest = std::move(of.rest);
        located = std::move(of.located);
        rest_at = of.rest_at;
        follows = of.follows;
        displaced = of.displaced;
    }

    /// Takes over the structure of the medium.
    void place_structure(const object& of, view<const vec3> at_rest) {
        if (of.inside.structure.empty())
            structure = {};
        else
            structure = {of.inside.structure, of.fibres.varies() ? mat3{1} : own_axes(of, at_rest)};
    }
    /// The same, with a view of the fibres.
    placed_structure placed() const {
        placed_structure own = structure;
        own.chart = fibres.view_of();
        return own;
    }

    /// Follows vertices that have moved, without touching the tree and the normals.
    template <class Policy>
    void follow(const Policy& policy, const object& of) {
        if (groups.empty()) groups = face_groups{mesh_view{of.surface}};
        local_box = bounds_of(policy, of.surface.positions);
        box = placed_box(local_box, of.at);
        tree_is_current = moved = false;
        updates_at_rest = 0;
    }

    /// Refits the tree, or rebuilds it where refitting has degraded it: see `bvh_storage::update`. Computes the normals.
    template <class Policy>
    void update_tree(const Policy& policy, const object& of) {
        if (tree_is_current) return;
        tree.update(policy, mesh_view{of.surface});
        normals.compute(policy, mesh_view{of.surface});
        tree_is_current = true;
    }

  private:
    mat3 own_axes(const object& of, view<const vec3> at_rest) const {
        mesh_view surface{of.surface};
        if (!at_rest.empty()) surface.positions = at_rest;
        return structure_axes(surface, local_box, of.fibres(local_box.centre()));
    }

    template <class Policy>
    static aabb bounds_of(const Policy& policy, view<const vec3> points) {
        constexpr std::size_t parts = 16;
        aabb part[parts];
        const std::size_t block = std::max(points.size() / parts + 1, std::size_t{8192});
        exec::for_each_block(policy, points.size(), block, 0.5F, [&](std::size_t begin, std::size_t end) {
            part[begin / block] = detail::bounds_of(view<const vec3>{points.data() + begin, end - begin});
        });
        aabb whole;
        for (const aabb& box : part) whole = merged(whole, box);
        return whole;
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
