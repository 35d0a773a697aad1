#ifndef INSONIFY_GEOMETRY_FACE_GROUPS_HPP
#define INSONIFY_GEOMETRY_FACE_GROUPS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/geometry/mesh.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// `face_groups` in flat arrays. Trivially copyable.
struct face_groups_view {
    static constexpr std::size_t size = 64; ///< faces in each group but the last

    view<const std::size_t> ends{};       ///< where the vertices of each group end, in `vertices`
    view<const std::uint32_t> vertices{}; ///< of all groups, one after the other

    /// Number of groups.
    std::size_t count() const { return ends.size(); }
    /// The vertices of a group, each once.
    view<const std::uint32_t> operator[](std::size_t group) const {
        const std::size_t begin = group == 0 ? 0 : ends[group - 1];
        return {vertices.data() + begin, ends[group] - begin};
    }
};

/// The distinct vertices of every 64 consecutive faces, so that a pass over a mesh reads each vertex once instead of three
/// to six times.
///
/// Consecutive faces are mostly neighbours: a group then has about 45 vertices, and most groups lie on one side of a plane,
/// so that their faces can be skipped. Depends on the faces alone, not on where the vertices are.
class face_groups {
  public:
    face_groups() = default;
    explicit face_groups(const mesh_view& surface)
        : ends_((surface.faces.size() + detail::face_groups_view::size - 1) / detail::face_groups_view::size) {
        std::vector<std::uint32_t> last_group(surface.positions.size(), ~0U);
        vertices_.reserve(surface.faces.size());
        for (std::size_t i = 0; i < surface.faces.size(); ++i) {
            const auto group = static_cast<std::uint32_t>(i / detail::face_groups_view::size);
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
    detail::face_groups_view view_of() const { return {ends_, vertices_}; }

  private:
    std::vector<std::size_t> ends_;
    std::vector<std::uint32_t> vertices_;
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
