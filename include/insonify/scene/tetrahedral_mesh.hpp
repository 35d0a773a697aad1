#ifndef INSONIFY_SCENE_TETRAHEDRAL_MESH_HPP
#define INSONIFY_SCENE_TETRAHEDRAL_MESH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/storage.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/text.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/scene/nearest_point.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

using tetrahedron = std::array<std::uint32_t, 4>;

/// A point in a tetrahedron.
struct tetrahedral_point {
    std::uint32_t cell = 0;                  ///< index of the tetrahedron
    std::array<float, 4> weight{1, 0, 0, 0}; ///< of its nodes; their sum is 1
};

inline float signed_volume(std::span<const vec3> nodes, const tetrahedron& cell) {
    const vec3 a = nodes[cell[0]];
    return dot(nodes[cell[1]] - a, cross(nodes[cell[2]] - a, nodes[cell[3]] - a)) / 6;
}

/// Barycentric coordinates of a point.
inline std::array<float, 4> barycentric(std::span<const vec3> nodes, const tetrahedron& cell, vec3 point) {
    const vec3 a = nodes[cell[0]];
    const vec3 part = inverse(mat3{nodes[cell[1]] - a, nodes[cell[2]] - a, nodes[cell[3]] - a}) * (point - a);
    return {1 - part.x - part.y - part.z, part.x, part.y, part.z};
}

/// The box of a tetrahedron as a primitive of a tree.
struct tetrahedron_box {
    aabb box{};
};
inline aabb bounds(const tetrahedron_box& one) { return one.box; }
inline hit intersect(const ray&, const tetrahedron_box&) { return {}; } // only points are located

/// Tetrahedra at rest, and what locates points in them.
struct tetrahedral_mesh {
    std::vector<vec3> rest;              ///< nodes, metres
    std::vector<tetrahedron> cells;      ///< four nodes each
    std::vector<float> orientation{};    ///< of each: the sign of its volume
    mesh surface{};                      ///< the faces that belong to one tetrahedron only
    std::vector<std::uint32_t> behind{}; ///< the tetrahedron of each face of the surface

    /// @throws geometry_error  for a node that does not exist or is not finite, or a tetrahedron without volume
    tetrahedral_mesh(std::vector<vec3> nodes, std::vector<tetrahedron> of)
        : rest{std::move(nodes)}, cells{std::move(of)} {
        if (cells.empty()) throw geometry_error{"tetrahedra: there are none; give four nodes for each"};
        for (const vec3& node : rest)
            if (!is_finite(node)) throw geometry_error{"tetrahedra: a node at rest is not finite"};
        boxes_.reserve(cells.size());
        orientation.reserve(cells.size());
        for (std::size_t i = 0; i < cells.size(); ++i) {
            aabb box;
            for (const std::uint32_t node : cells[i]) {
                if (node >= rest.size())
                    throw geometry_error{
                        joined({"tetrahedra: tetrahedron ", std::to_string(i), " names node ", std::to_string(node),
                                ", but there are ", std::to_string(rest.size()), "; indices start at 0"})};
                box = merged(box, rest[node]);
            }
            const float volume = signed_volume(rest, cells[i]);
            if (volume == 0)
                throw geometry_error{
                    joined({"tetrahedra: tetrahedron ", std::to_string(i), " has no volume at rest; remove it"})};
            orientation.push_back(volume > 0 ? 1.0F : -1.0F);
            boxes_.push_back({box});
        }
        find_surface();
        inside_.build(exec::par, view<const tetrahedron_box>{boxes_});
        around_.build(exec::par, mesh_view{surface});
    }
    tetrahedral_mesh(const tetrahedral_mesh&) = delete; // the trees refer to it
    tetrahedral_mesh& operator=(const tetrahedral_mesh&) = delete;
    ~tetrahedral_mesh() = default;

    /// The point itself, or the nearest one of the surface. Of several tetrahedra that contain it, the one it is deepest in.
    tetrahedral_point locate(vec3 point) const {
        constexpr float tolerance = 1e-5F;
        tetrahedral_point best;
        float deepest = -tolerance;
        bool found = false;
        inside_.view_of(view<const tetrahedron_box>{boxes_})
            .for_each_overlap(aabb{point, point}, [&](std::uint32_t cell) {
                const std::array<float, 4> weight = barycentric(rest, cells[cell], point);
                const float depth = *std::min_element(weight.begin(), weight.end());
                if (depth < deepest || (found && depth == deepest && cell > best.cell)) return;
                best = {cell, weight};
                deepest = depth;
                found = true;
            });
        if (found) return best;
        const nearest_point near = find_nearest(around_.view_of(mesh_view{surface}), point);
        const std::uint32_t cell = behind[near.primitive];
        return {cell, barycentric(rest, cells[cell], near.point)};
    }

  private:
    void find_surface() {
        struct face {
            std::array<std::uint32_t, 3> sorted;
            std::uint32_t cell;
            uvec3 corners;
        };
        std::vector<face> faces;
        faces.reserve(4 * cells.size());
        constexpr int sides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
        for (std::uint32_t i = 0; i < cells.size(); ++i)
            for (const auto& side : sides) {
                const uvec3 corners{cells[i][static_cast<std::size_t>(side[0])],
                                    cells[i][static_cast<std::size_t>(side[1])],
                                    cells[i][static_cast<std::size_t>(side[2])]};
                face one{{corners.x, corners.y, corners.z}, i, corners};
                std::sort(one.sorted.begin(), one.sorted.end());
                faces.push_back(one);
            }
        std::sort(faces.begin(), faces.end(), [](const face& a, const face& b) {
            return a.sorted != b.sorted ? a.sorted < b.sorted : a.cell < b.cell;
        });
        surface.positions = rest;
        for (std::size_t i = 0; i < faces.size(); ++i) {
            const bool shared = (i > 0 && faces[i - 1].sorted == faces[i].sorted) ||
                                (i + 1 < faces.size() && faces[i + 1].sorted == faces[i].sorted);
            if (shared) continue;
            surface.faces.push_back(faces[i].corners);
            behind.push_back(faces[i].cell);
        }
    }

    std::vector<tetrahedron_box> boxes_{};
    bvh_storage<view<const tetrahedron_box>> inside_{};
    bvh_storage<mesh_view> around_{};
};

/// The vertices of an object, located in tetrahedra.
struct located_vertices {
    std::shared_ptr<const tetrahedral_mesh> mesh{}; ///< in which; null: not yet
    pose at{};                                      ///< of the object
    std::vector<tetrahedral_point> points{};        ///< of each vertex at rest
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
