#ifndef INSONIFY_TRACING_PLAN_FRAME_LINES_HPP
#define INSONIFY_TRACING_PLAN_FRAME_LINES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/kernel/elevation.hpp>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// The lines of a frame in all of its elevation planes. Trivially copyable where the probe is.
template <transducer Probe>
struct frame_lines {
    Probe probe{};                                            ///< that sends and receives
    pose at{};                                                ///< probe to world
    float depth = 0;                                          ///< of the last sample's end, metres
    float max_depth = 0;                                      ///< how far lines are followed, metres
    std::uint32_t planes = 1;                                 ///< that represent the thickness of the slice
    detail::elevation_plane plane[max_elevation_planes] = {}; ///< the slice plane, then pairs to both sides of it

    /// A line of the probe in one of the planes, in the world: displaced in elevation alone, so the distance along it stays the
    /// displayed one.
    INSONIFY_FN line_frame line(std::uint32_t number, std::uint32_t of_plane) const {
        const ray beam = probe.beam(static_cast<float>(number));
        const vec3 elevation = at.direction({0, 1, 0});
        line_frame line{at.point(beam.origin) + plane[of_plane].height(beam.origin.z) * elevation,
                        at.direction(beam.direction), elevation, plane[of_plane].slope * beam.direction.z};
        if constexpr (requires { probe.scatterer_axis(0.0F); })
            line.steering = at.direction(beam.direction - probe.scatterer_axis(static_cast<float>(number)));
        return line;
    }
    /// The tilt of a line of any direction in the world that runs in one of the planes: see `line_frame`.
    INSONIFY_FN float tilt(vec3 direction, std::uint32_t of_plane) const {
        return plane[of_plane].slope * dot(direction, at.direction({0, 0, 1}));
    }
};

} // namespace detail

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
