#ifndef INSONIFY_SCENE_FACE_GROUPS_HPP
#define INSONIFY_SCENE_FACE_GROUPS_HPP

#include <insonify/bvh/large_array.hpp>
#include <insonify/core/later.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/mesh.hpp>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Which vertices every 64 consecutive faces share: to look at each once, where looking at the faces would be thrice to six
/// times.
///
/// Faces that follow one another mostly lie side by side: then a group has some 45 vertices, and most groups lie on one
/// side of a slice, so that their faces need not be looked at. Depends on the faces alone, not on where vertices are.
class face_groups {
  public:
    static constexpr std::size_t size = 64; ///< faces in each but the last

    face_groups() = default;
    INSONIFY_LAZY explicit face_groups(const mesh_view& surface) : end_((surface.faces.size() + size - 1) / size) {
        later_t<Later, std::vector<std::uint32_t>> last_group(surface.positions.size(), ~0U);
        vertices_.reserve(surface.faces.size());
        for (std::size_t i = 0; i < surface.faces.size(); ++i) {
            const auto group = static_cast<std::uint32_t>(i / size);
            for (const std::uint32_t vertex : {surface.faces[i].x, surface.faces[i].y, surface.faces[i].z})
                if (last_group[vertex] != group) {
                    last_group[vertex] = group;
                    vertices_.push_back(vertex);
                }
            end_[group] = vertices_.size();
        }
        later<Later>(vertices_).shrink_to_fit();
    }

    INSONIFY_LAZY bool empty() const { return end_.empty(); }

    /// How many groups there are.
    INSONIFY_LAZY std::size_t count() const { return end_.size(); }

    /// The vertices of a group, each once.
    INSONIFY_LAZY view<const std::uint32_t> operator[](std::size_t group) const {
        const std::size_t begin = group == 0 ? 0 : end_[group - 1];
        return {vertices_.data() + begin, end_[group] - begin};
    }

  private:
    large_array<std::size_t> end_; // where each group's end, in `vertices_`
    std::vector<std::uint32_t> vertices_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
