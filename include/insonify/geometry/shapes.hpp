#ifndef INSONIFY_GEOMETRY_SHAPES_HPP
#define INSONIFY_GEOMETRY_SHAPES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/centre_line.hpp>
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
        throw geometry_error{"subdivide: the mesh has ", faces, " faces; at most 268435455 can be subdivided"};
    detail::check_faces(coarse, "subdivide: ");

    const std::vector<detail::half_edge> edges = detail::sorted_edges(coarse.faces);
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

/// @throws geometry_error  for more than ten
inline void check_subdivisions(const std::string& shape, std::uint32_t count) {
    if (count > 10)
        throw geometry_error{shape, ": ", count,
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

/// Adds the faces of a closed slab. Its vertices are those of its upper side, row by row, then those of the lower one.
/// The upper side lies to the side of the direction of the columns' numbers cross that of the rows'.
inline void add_slab_faces(mesh& slab, std::uint32_t columns, std::uint32_t rows) {
    const std::uint32_t below = columns * rows, last = columns * (rows - 1);
    const auto add_quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        slab.faces.insert(slab.faces.end(), {{a, b, c}, {a, c, d}});
    };
    for (std::uint32_t row = 0; row + 1 < rows; ++row)
        for (std::uint32_t column = 0; column + 1 < columns; ++column) {
            const std::uint32_t a = row * columns + column, b = a + 1, c = b + columns, d = a + columns;
            add_quad(a, b, c, d);
            // With the same diagonal: otherwise the sides of a thin warped slab cross.
            add_quad(below + c, below + b, below + a, below + d);
        }
    for (std::uint32_t column = 0; column + 1 < columns; ++column) {
        add_quad(column, below + column, below + column + 1, column + 1);
        add_quad(last + column + 1, below + last + column + 1, below + last + column, last + column);
    }
    for (std::uint32_t row = 0; row + 1 < rows; ++row) {
        const std::uint32_t a = row * columns, b = a + columns - 1;
        add_quad(a + columns, below + a + columns, below + a, a);
        add_quad(b, below + b, below + b + columns, b + columns);
    }
}

/// @throws geometry_error  where two corners of a face have rounded to the same point, which would open the surface
inline mesh checked_shape(const std::string& shape, mesh m) {
    for (const uvec3 f : m.faces)
        if (const vec3 a = m.positions[f.x], b = m.positions[f.y], c = m.positions[f.z]; a == b || b == c || c == a)
            throw geometry_error{shape, ": vertices round to the same point; make the shape larger or coarser, ",
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
        throw geometry_error{"make_cylinder: `segments` is ", segments, "; it must be from 3 to 1,000,000"};
    if (segments_along < 1 || segments_along > 1'000'000 || segments > (1U << 27U) / segments_along)
        throw geometry_error{"make_cylinder: `segments_along` is ", segments_along,
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

/// Optional arguments of `make_tube`.
struct tube_settings {
    /// What closes a tube.
    enum class end_shape {
        round, ///< half an ellipsoid, which extends beyond the first and the last point by the smaller radius there
        flat,  ///< a disc
    };
    std::uint32_t segments = 32;       ///< around the line, 3 to 4096
    end_shape ends = end_shape::round; ///< both
    vec3 across{0, 0, 0};              ///< first axis of the first ellipse, as far as it is across; 0: any
};

/// A closed tube around a line, with a ring of vertices at each of its points: a vessel, a nerve.
///
///     const mesh vessel = make_tube({{{0, -20_mm, 15_mm}, vec2{3_mm}}, {{0, 20_mm, 18_mm}, {2_mm, 1.5_mm}}});
///
/// The axes of the ellipses do not twist about the line: they are carried along by parallel transport (Wang et al.
/// 2008, ACM Trans. Graph. 27, 2: double reflection). `turn` is added. Across a bend the ring lies in the plane that
/// halves its angle.
/// @param line  at least 2 points, each different from the one before
/// @throws geometry_error  also where the line bends more sharply than the tube's radius, so that rings would cross
inline mesh make_tube(const std::vector<tube_section>& line, const tube_settings& settings = {}) {
    if (settings.segments < 3 || settings.segments > 4096)
        throw geometry_error{"make_tube: `segments` is ", settings.segments, "; it must be from 3 to 4096"};
    const std::vector<line_place> places = detail::places_along(line, settings.across, "make_tube");
    const std::size_t count = line.size();
    if (count > (1U << 27U) / settings.segments)
        throw geometry_error{"make_tube: ", count, " points of ", settings.segments,
                             " segments are more than 2^27 in all; use fewer"};

    const bool round = settings.ends == tube_settings::end_shape::round;
    const std::uint32_t cap =
        round ? std::max(settings.segments / 4, 1U) : 1; // rings of an end, with that of the point
    const auto rings = static_cast<std::uint32_t>(count) - 2 + 2 * cap;
    const auto beyond = [&](std::size_t i) { return round ? min(line[i].radii.x, line[i].radii.y) : 0.0F; };
    mesh tube;
    tube.positions.reserve(2 + std::size_t{rings} * settings.segments);
    tube.positions = {line.front().centre - beyond(0) * places.front().along,
                      line.back().centre + beyond(count - 1) * places.back().along};
    for (std::uint32_t k = 0; k < settings.segments; ++k) {
        const float angle = 2 * pi * static_cast<float>(k) / static_cast<float>(settings.segments);
        const auto out_at = [&](std::size_t i) {
            return line[i].radii.x * std::cos(angle) * places[i].first_axis +
                   line[i].radii.y * std::sin(angle) * places[i].second_axis;
        };
        const auto add_cap_ring = [&](std::size_t i, float from_rim, float side) {
            tube.positions.push_back(line[i].centre + side * beyond(i) * std::sin(from_rim) * places[i].along +
                                     std::cos(from_rim) * out_at(i));
        };
        const float step = pi / 2 / static_cast<float>(cap);
        for (std::uint32_t ring = 1; ring < cap; ++ring) add_cap_ring(0, step * static_cast<float>(cap - ring), -1);
        for (std::size_t i = 0; i < count; ++i) {
            tube.positions.push_back(line[i].centre + out_at(i));
            if (i == 0) continue;
            const vec3 before = line[i - 1].centre + out_at(i - 1), step_out = tube.positions.back() - before;
            if (!(dot(step_out, line[i].centre - line[i - 1].centre) > 0))
                throw geometry_error{"make_tube: the line bends more sharply than the radius of the tube at point ", i,
                                     "; make the bend wider or the tube thinner"};
        }
        for (std::uint32_t ring = 1; ring < cap; ++ring) add_cap_ring(count - 1, step * static_cast<float>(ring), 1);
    }
    detail::add_tube_faces(tube, settings.segments, rings);
    return detail::checked_shape("make_tube", std::move(tube));
}

/// A point of a sheet, in the middle of its thickness.
struct sheet_point {
    vec3 at{0, 0, 0};          ///< metres
    float thickness = 0.5e-3F; ///< metres
};

/// A closed thin sheet around a grid of points: a fascia, a flat muscle. Towards a border it may taper.
///
/// Its upper side lies to the side of the direction of the columns' numbers cross that of the rows'.
/// @param points   row by row
/// @param columns  points of a row, at least 2; as many rows
/// @throws geometry_error  also where the sheet bends more sharply than half its thickness
inline mesh make_sheet(const std::vector<sheet_point>& points, std::uint32_t columns) {
    const std::size_t count = points.size(), rows = columns > 0 ? count / columns : 0;
    if (columns < 2 || rows < 2 || rows * columns != count || count > (1U << 26U))
        throw geometry_error{"make_sheet: ", count, " points in rows of ", columns,
                             "; give at least 2 full rows of at least 2 points, and at most 2^26 points"};
    for (const sheet_point& one : points) {
        detail::check_shape_point("make_sheet", one.at);
        detail::check_shape_length("make_sheet", "thickness", one.thickness);
    }

    mesh sheet;
    sheet.positions.resize(2 * count);
    std::vector<vec3> normals(count);
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < columns; ++column) {
            const auto at = [&](std::size_t r, std::size_t c) { return points[r * columns + c].at; };
            const vec3 along_row =
                at(row, column + 1 < columns ? column + 1 : column) - at(row, column > 0 ? column - 1 : 0);
            const vec3 along_column = at(row + 1 < rows ? row + 1 : row, column) - at(row > 0 ? row - 1 : 0, column);
            const vec3 normal = cross(along_row, along_column);
            if (!(length(normal) > 1e-4F * length(along_row) * length(along_column)))
                throw geometry_error{"make_sheet: neighbours of the point in row ", row, ", column ", column,
                                     " lie on one line; move the points apart"};
            const std::size_t i = row * columns + column;
            normals[i] = normalize(normal);
            sheet.positions[i] = points[i].at + 0.5F * points[i].thickness * normals[i];
            sheet.positions[count + i] = points[i].at - 0.5F * points[i].thickness * normals[i];
        }
    for (std::size_t row = 0; row + 1 < rows; ++row)
        for (std::size_t column = 0; column + 1 < columns; ++column)
            for (const std::size_t side : {std::size_t{0}, count}) {
                const std::size_t a = row * columns + column, first = side + a;
                const vec3 normal = cross(sheet.positions[first + columns + 1] - sheet.positions[first],
                                          sheet.positions[first + columns] - sheet.positions[first + 1]);
                if (!(dot(normal, normals[a]) > 0))
                    throw geometry_error{"make_sheet: the sheet bends more sharply than half its thickness in row ",
                                         row, ", column ", column, "; make it thinner or the bend wider"};
            }
    detail::add_slab_faces(sheet, columns, static_cast<std::uint32_t>(rows));
    return detail::checked_shape("make_sheet", std::move(sheet));
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
