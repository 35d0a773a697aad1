#ifndef INSONIFY_GEOMETRY_HALF_EDGE_HPP
#define INSONIFY_GEOMETRY_HALF_EDGE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// One side of a face, as half of an edge: the half edges of one edge have equal `ends`, whatever their direction.
struct half_edge {
    std::uint64_t ends = 0; ///< both vertices, the lower index in the upper 32 bits
    std::uint32_t slot = 0; ///< 3 * face + corner at which the half edge starts

    half_edge() = default;
    half_edge(std::uint32_t from, std::uint32_t to, std::uint32_t start)
        : ends{static_cast<std::uint64_t>(std::min(from, to)) << 32U | std::max(from, to)}, slot{start} {}

    std::uint32_t lower() const { return static_cast<std::uint32_t>(ends >> 32U); }
    std::uint32_t upper() const { return static_cast<std::uint32_t>(ends); }
};

/// The vertices from which and to which the half edge that starts at a corner of a face leads.
inline std::pair<std::uint32_t, std::uint32_t> vertices_of_side(const uvec3& face, std::uint32_t corner) {
    const std::uint32_t vertex[] = {face.x, face.y, face.z};
    return {vertex[corner], vertex[(corner + 1) % 3]};
}

/// Makes the half edges of each edge neighbours.
inline void sort_by_ends(std::vector<half_edge>& edges) {
    std::sort(edges.begin(), edges.end(), [](const half_edge& a, const half_edge& b) { return a.ends < b.ends; });
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
