#ifndef INSONIFY_SCENE_OBJECT_STATE_HPP
#define INSONIFY_SCENE_OBJECT_STATE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/bvh.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/geometry/face_groups.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/point_bounds.hpp>
#include <insonify/scene/smooth_surface.hpp>
#include <insonify/scene/tetrahedral_mesh.hpp>
#include <insonify/tissue/fibre_grid.hpp>
#include <insonify/tissue/placed_structure.hpp>
#include <insonify/tissue/structure_axes.hpp>
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
    double volume = 0;                 ///< enclosed when it was added, m^3; below 0 where faces point inwards
    std::uint32_t medium = 0;          ///< index into the scene's media
    std::uint32_t updates_at_rest = 0; ///< since the vertices last moved
    bool moved = false;                ///< the positions were handed out for writing since the last update
    std::vector<vec3> accepted{};      ///< positions after the last update; empty: they were never handed out
    std::vector<vec3> incoming{};      ///< those that `read` has read, before they are accepted
    aabb incoming_box{};               ///< around them
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

    /// Takes over what does not depend on the build from an earlier state, whose positions were read.
    void keep(object_state& of) {
        volume = of.volume;
        accepted = std::move(of.incoming);
        incoming = std::move(of.accepted);
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

    /// The positions are handed out for writing.
    void hand_out(const object& of) {
        if (accepted.empty()) accepted = of.surface.positions;
        moved = true;
    }
    /// Whether they ever were.
    bool handed_out() const { return !accepted.empty(); }

    /// Reads the positions, which `accept` or `refuse` must follow. One pass. @return  whether all are finite
    template <class Policy>
    bool read(const Policy& policy, const object& of) {
        constexpr std::size_t parts = 16;
        const view<const vec3> points{of.surface.positions};
        incoming.resize(accepted.size());
        point_bounds part[parts];
        const std::size_t block = std::max(points.size() / parts + 1, std::size_t{8192});
        exec::for_each_block(policy, points.size(), block, 0.5F, [&](std::size_t begin, std::size_t end) {
            part[begin / block] =
                bounds_of({points.data() + begin, end - begin}, handed_out() ? incoming.data() + begin : nullptr);
        });
        point_bounds whole;
        for (const point_bounds& one : part) whole = merged(whole, one);
        incoming_box = whole.box;
        return whole.finite;
    }

    /// Follows the positions that were read, without touching the tree and the normals.
    void accept(const object& of) {
        if (groups.empty()) groups = face_groups{mesh_view{of.surface}};
        accepted.swap(incoming);
        local_box = incoming_box;
        box = placed_box(local_box, of.at);
        tree_is_current = moved = false;
        updates_at_rest = 0;
    }

    /// Returns the positions to where they were after the last update.
    void refuse(object& of) {
        std::copy(accepted.begin(), accepted.end(), of.surface.positions.begin());
        moved = false;
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
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
