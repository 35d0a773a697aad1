#ifndef INSONIFY_GEOMETRY_VALIDATE_HPP
#define INSONIFY_GEOMETRY_VALIDATE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/geometry/mesh.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Defects and properties of a mesh, as found by `validate`.
///
/// Faces that share two vertices share an edge. Edges with one face are matched by position as well, so that a mesh
/// that repeats its vertices for every face (as STL files do) does not count as open.
struct mesh_report {
    std::uint32_t vertices = 0;              ///< as stored, duplicates included
    std::uint32_t faces = 0;                 ///< as stored
    std::uint32_t boundary_edges = 0;        ///< edges of one face: the surface has a hole
    std::uint32_t non_manifold_edges = 0;    ///< edges of three faces or more
    std::uint32_t misoriented_edges = 0;     ///< edges of two faces with opposite orientation
    std::uint32_t degenerate_faces = 0;      ///< faces without area: coincident or collinear corners
    std::uint32_t duplicate_faces = 0;       ///< faces with the corners of an earlier face, in any order
    std::uint32_t non_finite_vertices = 0;   ///< vertices with a NaN or infinite coordinate
    std::uint32_t faces_out_of_range = 0;    ///< faces with a vertex index out of range
    std::uint32_t components = 0;            ///< parts connected by edges
    std::uint32_t inside_out_components = 0; ///< closed parts oriented inwards, such as the wall of a cavity
    double volume = 0;                       ///< m^3, less the cavities; meaningful for a closed mesh only

    /// True where every edge has two faces of equal orientation, and all faces and vertices are valid.
    bool closed() const {
        return boundary_edges == 0 && non_manifold_edges == 0 && misoriented_edges == 0 && non_finite_vertices == 0 &&
               faces_out_of_range == 0;
    }

    friend bool operator==(const mesh_report&, const mesh_report&) = default;
};

/// Finds the defects that keep a mesh from being the surface of a body. Accepts any input.
///
/// Faces with an index out of range or with two coincident corners are left out of edges and components.
/// Cost: sorts the vertices, edges and faces; below a second for a million faces.
inline mesh_report validate(const mesh_view& m) {
    using corners = std::array<std::uint32_t, 3>; // ascending
    const auto face_count = static_cast<std::uint32_t>(m.faces.size());
    const std::vector<std::uint32_t> place = detail::weld(m.positions);
    const auto from_to = [&](std::uint32_t slot) { return detail::vertices_of_side(m.faces[slot / 3], slot % 3); };

    mesh_report report;
    report.vertices = static_cast<std::uint32_t>(m.positions.size());
    report.faces = face_count;
    for (const vec3& p : m.positions) report.non_finite_vertices += is_finite(p) ? 0 : 1;

    std::vector<std::uint32_t> usable;
    std::vector<detail::half_edge> edges;
    std::vector<corners> surfaces;
    usable.reserve(face_count);
    edges.reserve(3 * m.faces.size());
    surfaces.reserve(face_count);
    for (std::uint32_t face = 0; face < face_count; ++face) {
        const uvec3 f = m.faces[face];
        if (std::max({f.x, f.y, f.z}) >= m.positions.size()) {
            ++report.faces_out_of_range;
            continue;
        }
        corners corner{place[f.x], place[f.y], place[f.z]};
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) {
            ++report.degenerate_faces;
            continue;
        }
        usable.push_back(face);
        for (std::uint32_t slot = 3 * face; slot < 3 * face + 3; ++slot) {
            const auto [from, to] = from_to(slot);
            edges.emplace_back(from, to, slot);
        }
        std::sort(corner.begin(), corner.end());
        surfaces.push_back(corner);
    }
    std::sort(surfaces.begin(), surfaces.end());
    for (std::size_t i = 1; i < surfaces.size(); ++i) report.duplicate_faces += surfaces[i] == surfaces[i - 1] ? 1 : 0;

    // Faces that share an edge are of one component, represented by its lowest face.
    detail::disjoint_sets components{face_count};
    const auto component = [&](std::uint32_t face) { return components.find(face); };
    std::vector<std::uint32_t> faces_of_faulty_edges;
    const auto match_sides = [&](const auto& visit_single) {
        std::sort(edges.begin(), edges.end());
        detail::for_each_edge(edges, [&](view<const detail::half_edge> sides) {
            const std::uint32_t face = sides[0].slot / 3;
            std::uint32_t forwards = 0;
            for (const detail::half_edge& side : sides) {
                const auto [from, to] = from_to(side.slot);
                forwards += place[from] < place[to] ? 1 : 0;
                components.join(face, side.slot / 3);
            }
            if (sides.size() == 1) {
                visit_single(sides[0].slot);
            } else if (sides.size() > 2 || forwards != 1) {
                ++(sides.size() > 2 ? report.non_manifold_edges : report.misoriented_edges);
                faces_of_faulty_edges.push_back(face);
            }
        });
    };
    std::vector<detail::half_edge> single;
    match_sides([&](std::uint32_t slot) {
        const auto [from, to] = from_to(slot);
        single.emplace_back(place[from], place[to], slot);
    });
    edges.swap(single);
    match_sides([&](std::uint32_t slot) {
        ++report.boundary_edges;
        faces_of_faulty_edges.push_back(slot / 3);
    });

    // Divergence theorem, relative to a corner of the component to avoid cancellation.
    std::vector<double> volume(face_count);
    for (const std::uint32_t face : usable) {
        const triangle t = m[face];
        if (!is_finite(t.a) || !is_finite(t.b) || !is_finite(t.c)) continue;
        const std::uint32_t part = component(face);
        const dvec3 u = dvec3{t.b} - dvec3{t.a}, v = dvec3{t.c} - dvec3{t.a}, w = v - u;
        const dvec3 area = cross(u, v);
        const double longest = std::max({dot(u, u), dot(v, v), dot(w, w)});
        report.degenerate_faces += dot(area, area) <= 1e-14 * longest * longest ? 1 : 0;
        if (const vec3 origin = m[part].a; is_finite(origin)) volume[part] += dot(dvec3{t.a} - dvec3{origin}, area) / 6;
    }
    std::vector<std::uint8_t> faulty(face_count);
    for (const std::uint32_t face : faces_of_faulty_edges) faulty[component(face)] = 1;
    for (const std::uint32_t face : usable) {
        if (component(face) != face) continue;
        ++report.components;
        report.volume += volume[face];
        report.inside_out_components += volume[face] < 0 && !faulty[face] ? 1 : 0;
    }
    return report;
}

/// The defects and their remedies as sentences; empty for a mesh without defects.
inline std::string explain(const mesh_report& report) {
    std::string text;
    const auto tell = [&](std::uint32_t count, const char* before, const char* one, const char* many,
                          const char* after) {
        if (count == 0) return;
        if (!text.empty()) text += ' ';
        text += before + detail::counted(count, one, many) + after;
    };
    if (report.faces == 0) text = "The mesh has no faces: check that the right file or object was read.";
    tell(report.faces_out_of_range, "Vertex indices are out of range in ", "face", "faces",
         ": indices start at 0, and at the first vertex of this mesh.");
    tell(report.non_finite_vertices, "A coordinate is NaN or infinite in ", "vertex", "vertices",
         ": check the computation or file it comes from.");
    tell(report.boundary_edges, "The surface is open along ", "edge", "edges",
         ": fill the hole in a mesh editor, or the medium leaks out.");
    tell(report.non_manifold_edges, "Three faces or more meet at ", "edge", "edges",
         ": remove inner walls and duplicate faces, and make touching bodies separate objects.");
    tell(report.misoriented_edges, "Neighbouring faces have opposite orientations at ", "edge", "edges",
         ": make the normals consistent in a mesh editor.");
    tell(report.degenerate_faces, "The mesh has ", "face", "faces",
         " without area: they are harmless; merging close vertices removes them.");
    tell(report.duplicate_faces, "The mesh has ", "duplicate face", "duplicate faces", ": remove the copies.");
    tell(report.inside_out_components, "The faces point inwards on ", "closed part", "closed parts",
         ": swap two corners of each face, unless it is the wall of a cavity.");
    return text;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
