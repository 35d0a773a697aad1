#ifndef INSONIFY_SCENE_SMOOTH_SURFACE_HPP
#define INSONIFY_SCENE_SMOOTH_SURFACE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/for_each.hpp>
#include <insonify/geometry/smooth_normals.hpp>
#include <insonify/geometry/vertex_groups.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The arrays behind a `detail::smooth_normals_view`. Which edges are smooth is decided once, from the mesh as it is then.
class smooth_surface {
  public:
    smooth_surface() = default;
    /// @param crease_angle  edges where faces meet at more than this are creases, radians; 0: all are
    smooth_surface(const mesh_view& surface, float crease_angle) {
        if (crease_angle > 0) groups_ = vertex_groups{surface, crease_angle};
    }

    /// Computes all normals from where the vertices are now.
    template <class Policy>
    void compute(const Policy& policy, const mesh_view& surface) {
        normals_.resize(groups_.ends.size());
        const detail::smooth_normals_view groups = view_without_normals();
        exec::for_each_block(policy, normals_.size(), 1024, 100, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                normals_[i] = groups.computed(surface, static_cast<std::uint32_t>(i));
        });
    }

    /// While the vertices are where they were for `compute`.
    detail::smooth_normals_view view_of() const { return {groups_.corners, groups_.ends, groups_.slots, normals_}; }
    /// Where they have moved since: normals are computed as they are needed.
    detail::smooth_normals_view view_without_normals() const {
        return {groups_.corners, groups_.ends, groups_.slots, {}};
    }

  private:
    vertex_groups groups_{};
    std::vector<vec3> normals_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
