#ifndef INSONIFY_SCENE_OBJECT_STATE_HPP
#define INSONIFY_SCENE_OBJECT_STATE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/bvh.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <insonify/geometry/aabb.hpp>
#include <insonify/geometry/face_groups.hpp>
#include <insonify/scene/object.hpp>
#include <insonify/scene/smooth_surface.hpp>
#include <insonify/scene/tetrahedral_mesh.hpp>
#include <insonify/tissue/fibres.hpp>
#include <insonify/tissue/structure.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

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

/// The index of the object of each rank: of objects that contain a point the one of lowest rank gives the medium. Ordered
/// by priority, then by smaller enclosed volume, then the later first.
inline std::vector<std::uint32_t> ranked(const std::vector<object>& objects) {
    std::vector<float> volume;
    volume.reserve(objects.size());
    for (const object& one : objects) volume.push_back(static_cast<float>(std::fabs(enclosed_volume(one.surface))));
    std::vector<std::uint32_t> by_rank(objects.size());
    for (std::uint32_t i = 0; i < by_rank.size(); ++i) by_rank[i] = i;
    std::sort(by_rank.begin(), by_rank.end(), [&](std::uint32_t a, std::uint32_t b) {
        if (objects[a].priority != objects[b].priority) return objects[a].priority > objects[b].priority;
        if (volume[a] != volume[b]) return volume[a] < volume[b];
        return objects[a].id > objects[b].id;
    });
    return by_rank;
}

/// The different media, the background first; writes the index of each object's medium into its state.
inline std::vector<medium> distinct_media(const medium& background, const std::vector<object>& objects,
                                          std::vector<object_state>& states) {
    std::vector<medium> media{background};
    media.reserve(1 + objects.size());
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const auto known = std::find(media.begin(), media.end(), objects[i].inside);
        states[i].medium = static_cast<std::uint32_t>(known - media.begin());
        if (known == media.end()) media.push_back(objects[i].inside);
    }
    return media;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
