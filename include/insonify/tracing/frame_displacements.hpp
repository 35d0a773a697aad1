#ifndef INSONIFY_TRACING_FRAME_DISPLACEMENTS_HPP
#define INSONIFY_TRACING_FRAME_DISPLACEMENTS_HPP

#include <insonify/geometry/aabb.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/frame_plan.hpp>
#include <cmath>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// How the tissue along the lines of one frame is displaced: see `scene::deform`. Sampled in the box of these lines alone, in
/// axes of the probe.
class frame_displacements {
  public:
    template <class Policy, transducer Probe>
    view<const displacement_view> compute(const Policy& policy, const scene& body, const frame_view<Probe>& frame) {
        return body.displacements(policy, lattice_of(frame), nodes_, places_);
    }

  private:
    static constexpr float min_spacing = 1e-3F; // metres
    static constexpr float max_cells = 64;      // along an axis

    template <transducer Probe>
    static displacement_lattice lattice_of(const frame_view<Probe>& frame) {
        aabb box;
        for (std::uint32_t plane = 0; plane < frame.planes; ++plane)
            for (std::uint32_t i = 0; i < frame.probe.lines; ++i) {
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
#endif
