#ifndef INSONIFY_GEOMETRY_SHAPES_HPP
#define INSONIFY_GEOMETRY_SHAPES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// Procedural meshes: closed, oriented outwards, with shared vertices.
///
/// All lengths are metres. Every function throws geometry_error for an argument that is not finite, for a length
/// outside 0 to 1000 km, and for a shape so small for its distance from the origin, or so finely subdivided, that
/// neighbouring vertices round to the same point.
namespace insonify::inline INSONIFY_ABI {

/// Splits every face into four at the midpoints of its edges; midpoints are shared between faces.
///
/// Vertices keep their indices, the midpoints follow; face i becomes faces 4 i to 4 i + 3.
/// @throws geometry_error  for a vertex index out of range, or more than 2^28 faces
inline mesh subdivide(const mesh& coarse) {
    const std::size_t faces = coarse.faces.size();
    if (faces > 0x0FFFFFFFU)
        throw geometry_error{"subdivide: the mesh has " + std::to_string(faces) +
                             " faces; at most 268435455 can be subdivided"};
    detail::check_faces(coarse, "subdivide: ");

    std::vector<detail::half_edge> edges(3 * faces);
    for (std::uint32_t slot = 0; slot < edges.size(); ++slot) {
        const auto [from, to] = detail::vertices_of_side(coarse.faces[slot / 3], slot % 3);
        edges[slot] = {from, to, slot};
    }
    detail::sort_by_ends(edges);

    mesh fine;
    fine.positions.reserve(coarse.positions.size() + edges.size() / 2);
    fine.positions = coarse.positions;
    std::vector<std::uint32_t> midpoint(edges.size());
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (i == 0 || edges[i].ends != edges[i - 1].ends)
            fine.positions.push_back(0.5F * coarse.positions[edges[i].lower()] +
                                     0.5F * coarse.positions[edges[i].upper()]);
        midpoint[edges[i].slot] = static_cast<std::uint32_t>(fine.positions.size() - 1);
    }
    fine.faces.reserve(4 * faces);
    for (std::size_t i = 0; i < faces; ++i) {
        const uvec3 f = coarse.faces[i];
        const uvec3 m{midpoint[3 * i], midpoint[3 * i + 1], midpoint[3 * i + 2]};
        fine.faces.insert(fine.faces.end(), {{f.x, m.x, m.z}, {f.y, m.y, m.x}, {f.z, m.z, m.y}, m});
    }
    return fine;
}

namespace detail {

/// A unit vector orthogonal to a unit vector: the least parallel coordinate axis, orthogonalized.
inline vec3 unit_across(vec3 direction) {
    const vec3 size = abs(direction);
    const vec3 axis = size.x <= size.y && size.x <= size.z ? vec3{1, 0, 0}
                      : size.y <= size.z                   ? vec3{0, 1, 0}
                                                           : vec3{0, 0, 1};
    return normalize(axis - dot(axis, direction) * direction);
}

/// @throws geometry_error  for a point that is not finite or too far away
inline void check_shape_point(const std::string& shape, vec3 p) {
    if (!is_finite(p) || abs(p) != min(abs(p), vec3{max_translation}))
        throw geometry_error{shape + ": coordinates must be finite and within 1000 km of the origin"};
}

/// @throws geometry_error  for a length that is not above 0, or too large; `what` names it
inline void check_shape_length(const std::string& shape, const std::string& what, float value) {
    if (!is_finite(value) || !(value > 0) || value > max_translation)
        throw geometry_error{shape + ": the " + what + " must be above 0 and at most 1000 km"};
}

/// @throws geometry_error  for more than ten
inline void check_subdivisions(const std::string& shape, std::uint32_t count) {
    if (count > 10)
        throw geometry_error{shape + ": " + std::to_string(count) +
                             " subdivisions are more than 10; each makes four times as many triangles"};
}

/// Adds the faces of a closed tube. Its vertices are the middles of both ends, then one of every ring for each segment.
inline void add_tube_faces(mesh& tube, std::uint32_t segments, std::uint32_t rings) {
    for (std::uint32_t i = 0; i < segments; ++i) {
        const std::uint32_t a = 2 + rings * i, b = 2 + rings * ((i + 1) % segments);
        tube.faces.insert(tube.faces.end(), {{0, b, a}, {1, a + rings - 1, b + rings - 1}});
        for (std::uint32_t ring = 0; ring + 1 < rings; ++ring)
            tube.faces.insert(tube.faces.end(),
                              {{a + ring, b + ring, b + ring + 1}, {a + ring, b + ring + 1, a + ring + 1}});
    }
}

/// @throws geometry_error  where two corners of a face have rounded to the same point, which would open the surface
inline mesh checked_shape(const std::string& shape, mesh m) {
    for (const uvec3 f : m.faces)
        if (const vec3 a = m.positions[f.x], b = m.positions[f.y], c = m.positions[f.z]; a == b || b == c || c == a)
            throw geometry_error{shape + ": vertices round to the same point; make the shape larger or coarser, " +
                                 "or build it at the origin and place it with a pose"};
    return m;
}

} // namespace detail

/// An axis-aligned box of 12 * 4^subdivisions triangles.
inline mesh make_box(vec3 lower, vec3 upper, std::uint32_t subdivisions = 0) {
    detail::check_shape_point("make_box", lower);
    detail::check_shape_point("make_box", upper);
    for (int axis = 0; axis < 3; ++axis)
        detail::check_shape_length("make_box", std::string{"extent from `lower` to `upper` along "} + "xyz"[axis],
                                   upper[axis] - lower[axis]);
    detail::check_subdivisions("make_box", subdivisions);

    mesh box;
    for (unsigned i = 0; i < 8; ++i) // the bits of i select `upper` in x, y, z
        box.positions.push_back(
            {(i & 1U) ? upper.x : lower.x, (i & 2U) ? upper.y : lower.y, (i & 4U) ? upper.z : lower.z});
    box.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (std::uint32_t i = 0; i < subdivisions; ++i) box = subdivide(box);
    return detail::checked_shape("make_box", std::move(box));
}

/// An icosphere of 20 * 4^subdivisions triangles; all vertices lie on the sphere.
///
/// From the first subdivision on, six of them lie exactly on the axes through the centre.
inline mesh make_sphere(vec3 centre, float radius, std::uint32_t subdivisions) {
    detail::check_shape_point("make_sphere", centre);
    detail::check_shape_length("make_sphere", "radius", radius);
    detail::check_subdivisions("make_sphere", subdivisions);

    const float p = (1 + std::sqrt(5.0F)) / 2; // corners of the icosahedron: (0, +-1, +-p) and cyclic permutations
    mesh sphere;
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
            sphere.positions[j] /= length(sphere.positions[j]); // exact on the axes, unlike GLM's normalize
    }
    for (vec3& v : sphere.positions) v = centre + radius * v;
    return detail::checked_shape("make_sphere", std::move(sphere));
}

/// A cylinder between the centres of its two end caps: 2 * segments * (segments_along + 1) triangles.
///
/// The vertices lie on the circle, so the flat sides lie inside it. A cylinder that is to be bent needs rings of
/// vertices along its axis: `segments_along` - 1 of them, evenly spaced between the caps.
/// @param segments        around the axis, 3 to 1,000,000
/// @param segments_along  along the axis, 1 to 1,000,000; at most 2^27 segments in all
inline mesh make_cylinder(vec3 from, vec3 to, float radius, std::uint32_t segments, std::uint32_t segments_along = 1) {
    detail::check_shape_point("make_cylinder", from);
    detail::check_shape_point("make_cylinder", to);
    detail::check_shape_length("make_cylinder", "radius", radius);
    detail::check_shape_length("make_cylinder", "distance between `from` and `to`", length(to - from));
    if (segments < 3 || segments > 1'000'000)
        throw geometry_error{"make_cylinder: `segments` is " + std::to_string(segments) +
                             "; it must be from 3 to 1,000,000"};
    if (segments_along < 1 || segments_along > 1'000'000 || segments > (1U << 27U) / segments_along)
        throw geometry_error{"make_cylinder: `segments_along` is " + std::to_string(segments_along) +
                             "; it must be from 1 to 1,000,000, with at most 2^27 segments in all"};

    const vec3 size = abs(to - from);
    const vec3 axis = normalize((to - from) / max(max(size.x, size.y), size.z)); // without overflow or underflow
    const vec3 u = detail::unit_across(axis);
    const vec3 v = cross(axis, u);

    mesh cylinder;
    cylinder.positions = {from, to};
    for (std::uint32_t i = 0; i < segments; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / segments;
        const vec3 out = radius * (static_cast<float>(std::cos(angle)) * u + static_cast<float>(std::sin(angle)) * v);
        for (std::uint32_t ring = 0; ring < segments_along; ++ring)
            cylinder.positions.push_back(
                from + static_cast<float>(ring) / static_cast<float>(segments_along) * (to - from) + out);
        cylinder.positions.push_back(to + out);
    }
    detail::add_tube_faces(cylinder, segments, segments_along + 1);
    return detail::checked_shape("make_cylinder", std::move(cylinder));
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
