#ifndef INSONIFY_GEOMETRY_SHAPES_HPP
#define INSONIFY_GEOMETRY_SHAPES_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/later.hpp>
#include <insonify/geometry/mesh.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// Shapes to scan without a file: closed, outward, watertight, each vertex stored once.
///
/// All lengths are metres. Every shape throws geometry_error for an argument that is not finite, a size that is not
/// above 0 or reaches further than 1000 km, and a shape so small for its distance from the origin, or so finely
/// divided, that neighbouring vertices round to one point.
namespace insonify::inline INSONIFY_ABI {

/// Splits every face into four at the middles of its edges; a middle that two faces share is one vertex.
///
/// The old vertices come first and keep their indices; face i becomes faces 4 i to 4 i + 3.
/// @throws geometry_error  where a face names a vertex that is not there
INSONIFY_LAZY mesh subdivide(const mesh& coarse) {
    struct half_edge {
        std::uint64_t ends; // both vertices, the lower one first: equal for the two faces that share the edge
        std::uint32_t slot; // 3 * face + corner
    };
    const std::size_t faces = coarse.faces.size();
    if (faces > 0x0FFFFFFFU) throw geometry_error{"subdivide: this mesh has too many faces to be divided once more"};

    later_t<Later, std::vector<half_edge>> edges(3 * faces);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const uvec3 f = coarse.faces[i / 3];
        const std::uint32_t ends[3] = {f.x, f.y, f.z};
        const std::uint32_t a = ends[i % 3], b = ends[(i + 1) % 3];
        if (std::max(a, b) >= coarse.positions.size())
            throw geometry_error{"subdivide: face " + std::to_string(i / 3) + " names a vertex that is not there; " +
                                 "check the mesh with `validate`"};
        edges[i] = {static_cast<std::uint64_t>(std::min(a, b)) << 32U | std::max(a, b), static_cast<std::uint32_t>(i)};
    }
    std::sort(edges.begin(), edges.end(), [](const half_edge& a, const half_edge& b) { return a.ends < b.ends; });

    later_t<Later, mesh> fine;
    fine.positions.reserve(coarse.positions.size() + edges.size() / 2);
    fine.positions = coarse.positions;
    later_t<Later, std::vector<std::uint32_t>> middle(edges.size());
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (i == 0 || edges[i].ends != edges[i - 1].ends)
            fine.positions.push_back(0.5F * coarse.positions[edges[i].ends >> 32U] +
                                     0.5F * coarse.positions[edges[i].ends & 0xFFFFFFFFU]);
        middle[edges[i].slot] = static_cast<std::uint32_t>(fine.positions.size() - 1);
    }
    fine.faces.reserve(4 * faces);
    for (std::size_t i = 0; i < faces; ++i) {
        const uvec3 f = coarse.faces[i];
        const uvec3 m{middle[3 * i], middle[3 * i + 1], middle[3 * i + 2]};
        fine.faces.insert(fine.faces.end(), {{f.x, m.x, m.z}, {f.y, m.y, m.x}, {f.z, m.z, m.y}, m});
    }
    return fine;
}

/// The same direction with length 1, however long or short it was.
INSONIFY_LAZY vec3 unit_along(vec3 direction) {
    const vec3 size = absolute(direction);
    return normalize(direction / greater(greater(size.x, size.y), size.z));
}

/// Some direction of length 1 across a direction of length 1: as far from parallel as an axis can be, made orthogonal.
INSONIFY_LAZY vec3 unit_across(vec3 direction) {
    const vec3 size = absolute(direction);
    const vec3 axis = size.x <= size.y && size.x <= size.z ? vec3{1, 0, 0}
                      : size.y <= size.z                   ? vec3{0, 1, 0}
                                                           : vec3{0, 0, 1};
    return normalize(axis - dot(axis, direction) * direction);
}

/// What every shape asks of its arguments and of its result.
namespace shape_check {

inline constexpr float furthest = 1e6F; ///< metres from the origin

/// @throws geometry_error  where a point is not finite or too far away
INSONIFY_LAZY void point(const std::string& shape, vec3 p) {
    if (!is_finite(p) || absolute(p).x > furthest || absolute(p).y > furthest || absolute(p).z > furthest)
        throw geometry_error{shape + ": every coordinate must be a number of metres within 1000 km of the origin"};
}

/// @throws geometry_error  where a length is not above 0, or too large; `what` names it
INSONIFY_LAZY void length(const std::string& shape, const std::string& what, float value) {
    if (!is_finite(value) || !(value > 0) || value > furthest)
        throw geometry_error{shape + ": the " + what + " must be above 0 and at most 1000 km"};
}

/// @throws geometry_error  for more than ten
INSONIFY_LAZY void subdivisions(const std::string& shape, std::uint32_t count) {
    if (count > 10) throw geometry_error{shape + ": at most 10 subdivisions, each makes four times as many triangles"};
}

/// Rounding must not have pulled the corners of a face together: that would open the surface.
INSONIFY_LAZY mesh result(const std::string& shape, mesh m) {
    for (const uvec3 f : m.faces)
        if (const vec3 a = m.positions[f.x], b = m.positions[f.y], c = m.positions[f.z]; a == b || b == c || c == a)
            throw geometry_error{shape + ": vertices round to the same point; make the shape larger or coarser, " +
                                 "or build it at the origin and place it with a pose"};
    return m;
}

} // namespace shape_check

/// An axis-aligned box of 12 * 4^subdivisions triangles.
INSONIFY_LAZY mesh make_box(vec3 lower, vec3 upper, std::uint32_t subdivisions = 0) {
    shape_check::point("make_box", lower);
    shape_check::point("make_box", upper);
    shape_check::length("make_box", "extent from `lower` to `upper` along x", upper.x - lower.x);
    shape_check::length("make_box", "extent from `lower` to `upper` along y", upper.y - lower.y);
    shape_check::length("make_box", "extent from `lower` to `upper` along z", upper.z - lower.z);
    shape_check::subdivisions("make_box", subdivisions);

    later_t<Later, mesh> box;
    for (unsigned i = 0; i < 8; ++i) // bits of i: upper in x, y, z
        box.positions.push_back(
            {(i & 1U) ? upper.x : lower.x, (i & 2U) ? upper.y : lower.y, (i & 4U) ? upper.z : lower.z});
    box.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (std::uint32_t i = 0; i < subdivisions; ++i) box = subdivide(box);
    return shape_check::result("make_box", std::move(box));
}

/// An icosphere of 20 * 4^subdivisions triangles, every vertex on the sphere.
///
/// From the first subdivision on, vertices lie exactly on the axes through the centre.
INSONIFY_LAZY mesh make_sphere(vec3 centre, float radius, std::uint32_t subdivisions) {
    shape_check::point("make_sphere", centre);
    shape_check::length("make_sphere", "radius", radius);
    shape_check::subdivisions("make_sphere", subdivisions);

    const float p = (1 + std::sqrt(5.0F)) / 2; // the icosahedron's corners are (0, +-1, +-p) and its cyclic shifts
    later_t<Later, mesh> sphere;
    sphere.positions = {{-1, p, 0},  {1, p, 0},  {-1, -p, 0}, {1, -p, 0}, {0, -1, p},  {0, 1, p},
                        {0, -1, -p}, {0, 1, -p}, {p, 0, -1},  {p, 0, 1},  {-p, 0, -1}, {-p, 0, 1}};
    sphere.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (vec3& v : sphere.positions) v /= length(v);
    for (std::uint32_t i = 0; i < subdivisions; ++i) {
        const std::size_t kept = sphere.positions.size();
        sphere = subdivide(sphere);
        for (std::size_t j = kept; j < sphere.positions.size(); ++j)
            sphere.positions[j] /= length(sphere.positions[j]); // exact on the axes, as GLM's normalize is not
    }
    for (vec3& v : sphere.positions) v = centre + radius * v;
    return shape_check::result("make_sphere", std::move(sphere));
}

/// A cylinder between the middles of its two end caps: 4 * segments triangles, `segments` around (3 to 1,000,000).
///
/// The vertices lie on the circle, so the flat sides lie within it.
INSONIFY_LAZY mesh make_cylinder(vec3 from, vec3 to, float radius, std::uint32_t segments) {
    shape_check::point("make_cylinder", from);
    shape_check::point("make_cylinder", to);
    shape_check::length("make_cylinder", "radius", radius);
    shape_check::length("make_cylinder", "distance between `from` and `to`", length(to - from));
    if (segments < 3 || segments > 1000000)
        throw geometry_error{"make_cylinder: it takes 3 to 1,000,000 segments to go around"};

    const vec3 axis = unit_along(to - from);
    const vec3 u = unit_across(axis);
    const vec3 v = cross(axis, u);

    later_t<Later, mesh> cylinder;
    cylinder.positions = {from, to}; // then, for each segment, a vertex of the first ring and one of the second
    for (std::uint32_t i = 0; i < segments; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / segments;
        const vec3 out = radius * (static_cast<float>(std::cos(angle)) * u + static_cast<float>(std::sin(angle)) * v);
        cylinder.positions.insert(cylinder.positions.end(), {from + out, to + out});
        const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % segments);
        cylinder.faces.insert(cylinder.faces.end(), {{0, b, a}, {1, a + 1, b + 1}, {a, b, b + 1}, {a, b + 1, a + 1}});
    }
    return shape_check::result("make_cylinder", std::move(cylinder));
}

/// A square slab, 12 triangles: the middle of its front is at `centre`, the front faces along `normal` (of any length),
/// and the thickness lies behind it.
INSONIFY_LAZY mesh make_plane(vec3 centre, vec3 normal, float width, float thickness) {
    shape_check::point("make_plane", centre);
    shape_check::length("make_plane", "width", width);
    shape_check::length("make_plane", "thickness", thickness);
    if (!is_finite(normal) || normal == vec3{0, 0, 0})
        throw geometry_error{"make_plane: `normal` must be a direction: finite, and not zero"};

    const vec3 z = unit_along(normal);
    const vec3 x = unit_across(z);
    const vec3 y = cross(z, x);
    mesh slab = make_box({-width / 2, -width / 2, -thickness}, {width / 2, width / 2, 0});
    for (vec3& p : slab.positions) p = centre + p.x * x + p.y * y + p.z * z;
    return shape_check::result("make_plane", std::move(slab));
}

} // namespace insonify::inline INSONIFY_ABI
#endif
