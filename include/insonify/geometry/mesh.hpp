#ifndef INSONIFY_GEOMETRY_MESH_HPP
#define INSONIFY_GEOMETRY_MESH_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/triangle.hpp>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Triangles over shared vertices. Positions in metres; a face's corners run counter-clockwise seen from outside.
struct mesh {
    std::vector<vec3> positions{}; ///< of the vertices, metres
    std::vector<uvec3> faces{};    ///< three vertices each, from 0
};

/// A mesh that somebody else owns, as a range of triangles.
struct mesh_view {
    view<const vec3> positions{}; ///< metres
    view<const uvec3> faces{};    ///< three vertices each, from 0

    mesh_view() = default;
    /// Of arrays that somebody else keeps alive.
    INSONIFY_FN mesh_view(view<const vec3> vertex_positions, view<const uvec3> corner_indices)
        : positions{vertex_positions}, faces{corner_indices} {}
    /// Of a mesh, which must outlive it.
    mesh_view(const mesh& m)
        : positions{m.positions.data(), m.positions.size()}, faces{m.faces.data(), m.faces.size()} {}

    /// Triangles.
    INSONIFY_FN std::size_t size() const { return faces.size(); }
    /// The corners of a face; neither its index nor those of its vertices are checked.
    INSONIFY_FN triangle operator[](std::size_t face) const {
        const uvec3& corner = faces[face];
        const vec3 &a = positions[corner.x], &b = positions[corner.y], &c = positions[corner.z];
        return {{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}}; // copied whole they would go through memory
    }
    /// Asks for a face, or for the corners of one that is there by now, long before they are looked at.
    /// @{
    INSONIFY_FN INSONIFY_INLINE void prefetch_face(std::size_t face) const { prefetch(faces.first + face); }
    INSONIFY_FN INSONIFY_INLINE void prefetch_corners(std::size_t face) const {
        const uvec3& corner = faces[face];
        prefetch(positions.first + corner.x);
        prefetch(positions.first + corner.y);
        prefetch(positions.first + corner.z);
    }
    /// @}
};

/// @param named  what the sentence begins with: whose mesh it is
/// @throws geometry_error  where a face names a vertex that is not there; it tells of the highest
INSONIFY_LAZY void check_faces(const mesh_view& m, const std::string& named) {
    uvec3 last{0, 0, 0}; // compared once, at the end, so that SIMD can find it
    for (const uvec3& face : m.faces)
        last = {std::max(last.x, face.x), std::max(last.y, face.y), std::max(last.z, face.z)};
    const std::uint32_t vertex = std::max(last.x, std::max(last.y, last.z));
    if (!m.faces.empty() && vertex >= m.positions.size())
        throw geometry_error{named + "a face names vertex " + std::to_string(vertex) + ", but the mesh has " +
                             std::to_string(m.positions.size()) + "; indices start at 0"};
}

/// What a closed mesh encloses, m^3; negative where its faces look inwards. By the divergence theorem, in double,
/// measured from a vertex, so that it does not drown in rounding far from the origin.
INSONIFY_LAZY double enclosed_volume(const mesh_view& m) {
    double volume = 0;
    for (std::size_t i = 0; i < m.size(); ++i) {
        const triangle t = m[i];
        const dvec3 from{m.positions[0]};
        volume += dot(dvec3{t.a} - from, cross(dvec3{t.b} - from, dvec3{t.c} - from)) / 6;
    }
    return volume;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
