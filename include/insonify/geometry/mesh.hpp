#ifndef INSONIFY_GEOMETRY_MESH_HPP
#define INSONIFY_GEOMETRY_MESH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/text.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/triangle.hpp>
#include <algorithm>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Indexed triangle mesh. Faces are counter-clockwise seen from outside.
struct mesh {
    std::vector<vec3> positions{}; ///< vertices, metres
    std::vector<uvec3> faces{};    ///< three vertex indices each, from 0
};

/// Non-owning view of a mesh, as a range of triangles.
struct mesh_view {
    view<const vec3> positions{}; ///< metres
    view<const uvec3> faces{};    ///< three vertex indices each, from 0

    mesh_view() = default;
    /// View of arrays, which must outlive it.
    INSONIFY_FN mesh_view(view<const vec3> vertex_positions, view<const uvec3> corner_indices)
        : positions{vertex_positions}, faces{corner_indices} {}
    /// View of a mesh, which must outlive it.
    mesh_view(const mesh& m)
        : positions{m.positions.data(), m.positions.size()}, faces{m.faces.data(), m.faces.size()} {}

    /// Number of triangles.
    INSONIFY_FN std::size_t size() const { return faces.size(); }
    /// The corners of a face; indices are not checked.
    INSONIFY_FN triangle operator[](std::size_t face) const {
        const uvec3& corner = faces[face];
        const vec3 &a = positions[corner.x], &b = positions[corner.y], &c = positions[corner.z];
        return {{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}}; // copying whole vectors would go through memory
    }
    /// Prefetches a face, or the corners of a face that is in the cache already.
    /// @{
    INSONIFY_FN INSONIFY_INLINE void prefetch_face(std::size_t face) const { detail::prefetch(faces.first + face); }
    INSONIFY_FN INSONIFY_INLINE void prefetch_corners(std::size_t face) const {
        const uvec3& corner = faces[face];
        detail::prefetch(positions.first + corner.x);
        detail::prefetch(positions.first + corner.y);
        detail::prefetch(positions.first + corner.z);
    }
    /// @}
};

namespace detail {

/// @param named  the start of the sentence: whose mesh it is
/// @throws geometry_error  for a vertex index out of range, naming the highest
inline void check_faces(const mesh_view& m, const std::string& named) {
    uvec3 last{0, 0, 0}; // one comparison at the end lets the loop vectorize
    for (const uvec3& face : m.faces)
        last = {std::max(last.x, face.x), std::max(last.y, face.y), std::max(last.z, face.z)};
    const std::uint32_t vertex = std::max(last.x, std::max(last.y, last.z));
    if (!m.faces.empty() && vertex >= m.positions.size())
        throw geometry_error{joined({named, "a face names vertex ", std::to_string(vertex), ", but the mesh has ",
                                     std::to_string(m.positions.size()), "; indices start at 0"})};
}

} // namespace detail

/// Volume enclosed by a closed mesh, m^3; negative where the faces point inwards.
///
/// Divergence theorem in double precision, relative to a vertex, to avoid cancellation far from the origin.
inline double enclosed_volume(const mesh_view& m) {
    double volume = 0;
    for (std::size_t i = 0; i < m.size(); ++i) {
        const triangle t = m[i];
        const dvec3 from{m.positions[0]};
        volume += dot(dvec3{t.a} - from, cross(dvec3{t.b} - from, dvec3{t.c} - from)) / 6;
    }
    return volume;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
