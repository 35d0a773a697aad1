#ifndef INSONIFY_GEOMETRY_VALIDATE_HPP
#define INSONIFY_GEOMETRY_VALIDATE_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/geometry/mesh.hpp>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What `validate` found.
///
/// An edge is where faces share two vertices. Edges of one face only are then compared by position, so that a mesh that
/// repeats its vertices for every face (as STL files do) is not taken for open.
struct mesh_report {
    std::uint32_t vertices = 0;              ///< as stored, repeated ones included
    std::uint32_t faces = 0;                 ///< as stored
    std::uint32_t boundary_edges = 0;        ///< with one face only: the surface has a hole there
    std::uint32_t non_manifold_edges = 0;    ///< with three faces or more
    std::uint32_t misoriented_edges = 0;     ///< with two faces, of which one looks out and the other in
    std::uint32_t degenerate_faces = 0;      ///< without area: two corners at one point, or all three on a line
    std::uint32_t duplicate_faces = 0;       ///< with the same three corners as an earlier face, in any order
    std::uint32_t non_finite_vertices = 0;   ///< NaN or infinite
    std::uint32_t faces_out_of_range = 0;    ///< that name a vertex that is not there
    std::uint32_t components = 0;            ///< parts that hang together by edges
    std::uint32_t inside_out_components = 0; ///< closed parts whose faces look inwards, as the wall of a cavity does
    double volume = 0;                       ///< m^3, less the cavities; it means something for a closed mesh only

    /// True where every edge has two faces that agree about the outside, and all faces and vertices can be used.
    bool closed() const {
        return boundary_edges == 0 && non_manifold_edges == 0 && misoriented_edges == 0 && non_finite_vertices == 0 &&
               faces_out_of_range == 0;
    }

    friend bool operator==(const mesh_report&, const mesh_report&) = default;
};

/// For each vertex the number of its place: vertices at exactly the same position (-0 is 0) share one.
INSONIFY_LAZY std::vector<std::uint32_t> weld(view<const vec3> positions) {
    struct place {
        std::uint32_t x, y, z, vertex; // the bits of the coordinates: they order NaN as well
        bool operator==(const place& o) const { return x == o.x && y == o.y && z == o.z; }
        bool operator<(const place& o) const { return x != o.x ? x < o.x : y != o.y ? y < o.y : z < o.z; }
    };
    const auto bits = [](float value) {
        const auto raw = __builtin_bit_cast(std::uint32_t, value);
        return raw == 0x80000000U ? 0U : raw;
    };
    std::vector<place> places;
    places.reserve(positions.size());
    for (const vec3& p : positions)
        places.push_back({bits(p.x), bits(p.y), bits(p.z), static_cast<std::uint32_t>(places.size())});
    std::sort(places.begin(), places.end());

    std::vector<std::uint32_t> number(places.size());
    std::uint32_t distinct = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (i > 0 && !(places[i] == places[i - 1])) ++distinct;
        number[places[i].vertex] = distinct;
    }
    return number;
}

/// Looks for all that keeps a mesh from being the surface of a body. Any input is legal, and nothing is changed.
///
/// Faces out of range and faces with two corners at one point take no part in edges and components.
/// Cost: sorting the vertices, edges and faces; below a second for a million faces.
INSONIFY_LAZY mesh_report validate(const mesh_view& m) {
    struct half_edge {
        std::uint64_t ends; // both vertices, the lower one first: equal for all faces at an edge
        std::uint32_t slot; // 3 * face + corner from which the face walks it

        static half_edge between(std::uint32_t from, std::uint32_t to, std::uint32_t slot) {
            return {static_cast<std::uint64_t>(std::min(from, to)) << 32U | std::max(from, to), slot};
        }
    };
    struct corners {
        std::uint32_t a, b, c; // ascending
        auto operator<=>(const corners&) const = default;
    };
    const auto face_count = static_cast<std::uint32_t>(m.faces.size());
    const std::vector<std::uint32_t> place = weld(m.positions);
    const auto from_to = [&](std::uint32_t slot) {
        const uvec3 f = m.faces[slot / 3];
        const std::uint32_t corner[3] = {f.x, f.y, f.z};
        return std::pair{corner[slot % 3], corner[(slot + 1) % 3]};
    };

    mesh_report report;
    report.vertices = static_cast<std::uint32_t>(m.positions.size());
    report.faces = face_count;
    for (const vec3& p : m.positions) report.non_finite_vertices += is_finite(p) ? 0 : 1;

    std::vector<std::uint32_t> usable;
    std::vector<half_edge> edges;
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
        std::uint32_t corner[3] = {place[f.x], place[f.y], place[f.z]};
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) {
            ++report.degenerate_faces;
            continue;
        }
        usable.push_back(face);
        for (std::uint32_t slot = 3 * face; slot < 3 * face + 3; ++slot) {
            const auto [from, to] = from_to(slot);
            edges.push_back(half_edge::between(from, to, slot));
        }
        std::sort(later<Later>(corner), later<Later>(corner) + 3);
        surfaces.push_back({corner[0], corner[1], corner[2]});
    }
    std::sort(surfaces.begin(), surfaces.end());
    for (std::size_t i = 1; i < surfaces.size(); ++i) report.duplicate_faces += surfaces[i] == surfaces[i - 1] ? 1 : 0;

    // Faces that share an edge belong to one component, which its lowest face stands for.
    std::vector<std::uint32_t> parent(face_count);
    for (std::uint32_t i = 0; i < parent.size(); ++i) parent[i] = i;
    const auto component = [&](std::uint32_t face) {
        while (parent[face] != face) face = parent[face] = parent[parent[face]];
        return face;
    };
    std::vector<std::uint32_t> faces_of_faulty_edges;
    const auto go_through_edges = [&](const auto& treat_single) {
        std::sort(edges.begin(), edges.end(), [](const half_edge& a, const half_edge& b) { return a.ends < b.ends; });
        for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
            const std::uint32_t face = edges[begin].slot / 3;
            std::uint32_t forwards = 0;
            for (end = begin; end < edges.size() && edges[end].ends == edges[begin].ends; ++end) {
                const auto [from, to] = from_to(edges[end].slot);
                forwards += place[from] < place[to] ? 1 : 0;
                const std::uint32_t a = component(face), b = component(edges[end].slot / 3);
                parent[std::max(a, b)] = std::min(a, b);
            }
            const std::size_t sharing = end - begin;
            if (sharing == 1) {
                treat_single(edges[begin].slot);
            } else if (sharing > 2 || forwards != 1) {
                ++(sharing > 2 ? report.non_manifold_edges : report.misoriented_edges);
                faces_of_faulty_edges.push_back(face);
            }
        }
    };
    std::vector<half_edge> single;
    go_through_edges([&](std::uint32_t slot) {
        const auto [from, to] = from_to(slot);
        single.push_back(half_edge::between(place[from], place[to], slot));
    });
    edges.swap(single);
    go_through_edges([&](std::uint32_t slot) {
        ++report.boundary_edges;
        faces_of_faulty_edges.push_back(slot / 3);
    });

    // Volume by the divergence theorem, measured from a corner of the component, so that it does not drown in rounding.
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

/// In plain sentences, what is wrong and what to do about it; empty where nothing is.
INSONIFY_LAZY std::string explain(const mesh_report& report) {
    std::string text;
    const auto tell = [&](std::uint32_t count, const char* before, const char* one, const char* many,
                          const char* after) {
        if (count == 0) return;
        if (!text.empty()) text += ' ';
        text += before + std::to_string(count) + ' ' + (count == 1 ? one : many) + after;
    };
    if (report.faces == 0)
        text = "The mesh has no faces, so there is nothing to see: was the right file or object read?";
    tell(report.faces_out_of_range, "The indices run past the last vertex in ", "face", "faces",
         ": count vertices from 0, and from the start of this mesh.");
    tell(report.non_finite_vertices, "A coordinate is NaN or infinite in ", "vertex", "vertices",
         ": look for the computation that made it.");
    tell(report.boundary_edges, "The surface is open along ", "edge", "edges",
         ": fill the hole in a mesh editor, or the medium leaks out.");
    tell(report.non_manifold_edges, "Three faces or more meet at ", "edge", "edges",
         ": remove inner walls and repeated faces, and make bodies that touch objects of their own.");
    tell(report.misoriented_edges, "Neighbouring faces disagree about the outside at ", "edge", "edges",
         ": make the normals consistent in a mesh editor.");
    tell(report.degenerate_faces, "The mesh has ", "face", "faces",
         " without area: they do no harm, but merging close vertices removes them.");
    tell(report.duplicate_faces, "The mesh repeats ", "face", "faces", ": remove the copies.");
    tell(report.inside_out_components, "The faces look inwards on ", "closed part", "closed parts",
         ": swap two corners of each of its faces, unless it is the wall of a cavity.");
    return text;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
