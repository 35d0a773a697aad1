#ifndef INSONIFY_GEOMETRY_MESH_HPP
#define INSONIFY_GEOMETRY_MESH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/triangle.hpp>
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
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
    mesh_view(const mesh& m) : positions{m.positions}, faces{m.faces} {}

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

namespace detail {

/// @param named  the start of the sentence: whose mesh it is
/// @throws geometry_error  for a vertex index out of range, naming the highest
inline void check_faces(const mesh_view& m, const std::string& named) {
    uvec3 last{0, 0, 0}; // one comparison at the end lets the loop vectorize
    for (const uvec3& face : m.faces)
        last = {std::max(last.x, face.x), std::max(last.y, face.y), std::max(last.z, face.z)};
    const std::uint32_t vertex = std::max(last.x, std::max(last.y, last.z));
    if (!m.faces.empty() && vertex >= m.positions.size())
        throw geometry_error{
            named, "a face names vertex ", vertex, ", but the mesh has ", m.positions.size(), "; indices start at 0"};
}

/// One side of a face, as half of an edge: the half edges of one edge have equal `ends`, whatever their direction.
struct half_edge {
    std::uint64_t ends = 0; ///< both vertices, the lower index in the upper 32 bits
    std::uint32_t slot = 0; ///< 3 * face + corner at which the half edge starts

    half_edge() = default;
    half_edge(std::uint32_t from, std::uint32_t to, std::uint32_t start)
        : ends{static_cast<std::uint64_t>(std::min(from, to)) << 32U | std::max(from, to)}, slot{start} {}

    /// By ends, then by slot.
    friend bool operator<(const half_edge& a, const half_edge& b) {
        return a.ends != b.ends ? a.ends < b.ends : a.slot < b.slot;
    }
    std::uint32_t lower() const { return static_cast<std::uint32_t>(ends >> 32U); }
    std::uint32_t upper() const { return static_cast<std::uint32_t>(ends); }
};

/// The vertices from which and to which the half edge that starts at a corner of a face leads.
inline std::pair<std::uint32_t, std::uint32_t> vertices_of_side(const uvec3& face, std::uint32_t corner) {
    const std::uint32_t vertex[] = {face.x, face.y, face.z};
    return {vertex[corner], vertex[(corner + 1) % 3]};
}

/// Merges each vertex with the nearest of those before it that were kept, if it lies within a distance.
/// @param within   metres; 0 merges vertices at exactly equal positions (-0 equals 0)
/// @param is_some  whether a vertex takes part; empty: all do
/// @return  for each vertex the one that it is merged with, or itself
inline std::vector<std::uint32_t> weld(view<const vec3> positions, double within = 0,
                                       view<const std::uint8_t> is_some = {}) {
    constexpr std::uint32_t none = ~0U;
    const double cell = std::max(8 * within, 1e-60);                                 // different floats differ by more
    std::vector<std::uint32_t> first(std::bit_ceil(2 * positions.size() + 1), none); // kept in a cell: a hash table
    std::vector<std::uint32_t> following(positions.size(), none), number(positions.size());
    const auto cell_of = [&](const dvec3& point) { return floor(point / cell); };
    const auto first_in = [&](const dvec3& one) -> std::uint32_t& {
        std::uint64_t hash = 0;
        for (int i = 0; i < 3; ++i) // -0 is 0
            hash = hash_bits(hash, one[i] == 0 ? 0 : __builtin_bit_cast(std::uint64_t, one[i]));
        return first[hash & (first.size() - 1)];
    };
    for (std::uint32_t vertex = 0; vertex < number.size(); ++vertex) {
        number[vertex] = vertex;
        if (!is_some.empty() && is_some[vertex] == 0) continue;
        const dvec3 here{positions[vertex]}, low = cell_of(here - within), high = cell_of(here + within);
        double nearest = within * within;
        for (int corner = 0; corner < 8; ++corner) { // of the box around it, which lies in one to eight cells
            dvec3 own = low;
            bool is_other_cell = true;
            for (int i = 0; i < 3; ++i) {
                if ((corner >> i & 1) == 0) continue;
                is_other_cell = is_other_cell && low[i] != high[i];
                own[i] = high[i];
            }
            if (!is_other_cell) continue;
            for (std::uint32_t other = first_in(own); other != none; other = following[other])
                if (const dvec3 apart = dvec3{positions[other]} - here; dot(apart, apart) <= nearest) {
                    nearest = dot(apart, apart);
                    number[vertex] = other;
                }
        }
        if (number[vertex] == vertex) following[vertex] = std::exchange(first_in(cell_of(here)), vertex);
    }
    return number;
}

/// For each vertex the first one that lies at the same place, among those of open edges; the others stand for
/// themselves. So vertices that are repeated, for each face as in STL files or along the seams of a texture, are one.
inline std::vector<std::uint32_t> joined_at_seams(const mesh_view& surface) {
    // Around a vertex of a closed surface, as many half edges come from each neighbour as lead to it.
    std::vector<std::uint32_t> difference(surface.positions.size(), 0); // of the sums of the neighbours' numbers
    for (const uvec3& face : surface.faces) {
        difference[face.x] += face.y - face.z;
        difference[face.y] += face.z - face.x;
        difference[face.z] += face.x - face.y;
    }
    std::vector<std::uint8_t> is_open(difference.size());
    for (std::size_t i = 0; i < is_open.size(); ++i) is_open[i] = difference[i] != 0;
    return weld(surface.positions, 0, is_open);
}

/// The half edges of all faces, those of one edge next to one another.
inline std::vector<half_edge> sorted_edges(const std::vector<uvec3>& faces) {
    std::vector<half_edge> edges(3 * faces.size());
    for (std::uint32_t slot = 0; slot < edges.size(); ++slot) {
        const auto [from, to] = vertices_of_side(faces[slot / 3], slot % 3);
        edges[slot] = {from, to, slot};
    }
    std::sort(edges.begin(), edges.end());
    return edges;
}

/// Calls visit(its half edges) for each edge.
/// @param edges  sorted
template <class Visit>
void for_each_edge(const std::vector<half_edge>& edges, const Visit& visit) {
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end].ends == edges[begin].ends) ++end;
        visit(view<const half_edge>{edges.data() + begin, end - begin});
    }
}

/// Numbers in sets that can be joined; the lowest number stands for its set. Source: union-find; Cormen et al.,
/// Introduction to Algorithms, chapter 21.
class disjoint_sets {
  public:
    explicit disjoint_sets(std::size_t count) : parent_(count) {
        for (std::size_t i = 0; i < count; ++i) parent_[i] = static_cast<std::uint32_t>(i);
    }
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t i, std::uint32_t j) {
        const std::uint32_t a = find(i), b = find(j);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

/// `face_groups` in flat arrays. Trivially copyable.
struct face_groups_view {
    static constexpr std::size_t size = 64; ///< faces in each group but the last

    view<const std::size_t> ends{};       ///< where the vertices of each group end, in `vertices`
    view<const std::uint32_t> vertices{}; ///< of all groups, one after the other

    std::size_t count() const { return ends.size(); }
    /// The vertices of a group, each once.
    view<const std::uint32_t> operator[](std::size_t group) const {
        const std::size_t begin = group == 0 ? 0 : ends[group - 1];
        return {vertices.data() + begin, ends[group] - begin};
    }
};

/// The distinct vertices of every 64 consecutive faces, so that a pass over a mesh reads each vertex once instead of
/// three to six times.
///
/// Consecutive faces are mostly neighbours: a group then has about 45 vertices, and most groups lie on one side of a
/// plane, so that their faces can be skipped. Depends on the faces alone, not on where the vertices are.
class face_groups {
  public:
    face_groups() = default;
    explicit face_groups(const mesh_view& surface)
        : ends_((surface.faces.size() + face_groups_view::size - 1) / face_groups_view::size) {
        std::vector<std::uint32_t> last_group(surface.positions.size(), ~0U);
        vertices_.reserve(surface.faces.size());
        for (std::size_t i = 0; i < surface.faces.size(); ++i) {
            const auto group = static_cast<std::uint32_t>(i / face_groups_view::size);
            for (const std::uint32_t vertex : {surface.faces[i].x, surface.faces[i].y, surface.faces[i].z})
                if (last_group[vertex] != group) {
                    last_group[vertex] = group;
                    vertices_.push_back(vertex);
                }
            ends_[group] = vertices_.size();
        }
        vertices_.shrink_to_fit();
    }

    bool empty() const { return ends_.empty(); }
    face_groups_view view_of() const { return {ends_, vertices_}; }

  private:
    std::vector<std::size_t> ends_;
    std::vector<std::uint32_t> vertices_;
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
