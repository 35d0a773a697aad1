#ifndef INSONIFY_TRACING_PLAN_FRAME_DISPLACEMENTS_HPP
#define INSONIFY_TRACING_PLAN_FRAME_DISPLACEMENTS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/ray.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// How the tissue along the lines of one frame is displaced: see `scene::deform`. Sampled in the box of these lines
/// alone, in axes of the probe.
class frame_displacements {
  public:
    /// @throws geometry_error  where the map that deforms the scene folds over in the field of view
    template <class Policy>
    view<const displacement_view> compute(const Policy& policy, const scene& body, const frame_view& frame) {
        if (!body.is_deformed()) return {};
        const displacement_lattice where = lattice_of(frame);
        const view<const displacement_view> found = body.displacements(policy, where, nodes_, places_);
        for (std::size_t i = 0; !found.empty() && i < where.count(); ++i)
            if (nodes_[4 * i + 3] != 0 && is_seen(frame, where, where.point(i))) throw_folded(where.point(i));
        return found;
    }

  private:
    static constexpr float min_spacing = 1e-3F; // metres
    static constexpr float max_cells = 64;      // along an axis

    // Whether some line passes a node so closely that it is interpolated from it.
    static bool is_seen(const frame_view& frame, const displacement_lattice& where, vec3 node) {
        vec3 local = frame.at.local_point(node);
        local.y = 0;
        return std::any_of(frame.lines.begin(), frame.lines.end(), [&](const probe_line& line) {
            const vec3 from = local - line.origin;
            const float depth = dot(from, line.direction);
            return depth > 0 && depth < frame.depth && length(from - depth * line.direction) < where.spacing.x;
        });
    }

    static displacement_lattice lattice_of(const frame_view& frame) {
        aabb box;
        for (std::uint32_t plane = 0; plane < frame.planes; ++plane)
            for (std::uint32_t i = 0; i < frame.count(); ++i) {
                const line_frame line = frame.line(i, plane);
                box = merged(merged(box, frame.at.local_point(line.origin)),
                             frame.at.local_point(line.at(frame.max_depth)));
            }
        const vec3 extent = box.size();
        const float spacing = max(min_spacing, max(extent.x, max(extent.y, extent.z)) / max_cells);
        displacement_lattice lattice;
        vec3 cells;
        for (int axis = 0; axis < 3; ++axis) {
            cells[axis] = max(std::ceil(extent[axis] / spacing), 1);
            lattice.size[axis] = static_cast<std::uint32_t>(cells[axis]) + 1;
        }
        lattice.spacing = vec3{spacing};
        lattice.at = {frame.at.rotation, frame.at.point(box.centre() - 0.5F * spacing * cells)};
        return lattice;
    }

    std::vector<float> nodes_{};
    std::vector<displacement_view> places_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
