#ifndef INSONIFY_ACOUSTICS_LAYER_HPP
#define INSONIFY_ACOUSTICS_LAYER_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/view.hpp>
#include <insonify/geometry/pose.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// The segment of a line inside one object. Consecutive layers are adjacent, and the last one extends to the end of the
/// line.
///
/// Adjacent layers with the same `medium` have no interface between them.
struct layer {
    float begin = 0;            ///< metres from the probe face
    float end = 0;              ///< metres from the probe face
    std::uint32_t medium = 0;   ///< index into the media of the line
    std::uint32_t object = ~0U; ///< id of the object, ~0 for the background
    float cosine = 1;           ///< of the angle of incidence on the surface at `begin`; 1 on the first layer
    vec2 tilt{0, 0}; ///< of that surface's forward normal against the line, radians: in the slice plane, out of it
    std::uint32_t place = 0; ///< index into the poses of the line
};

/// The coordinate frame of a line in the world; axes of length 1.
struct line_frame {
    vec3 origin{0, 0, 0};    ///< on the probe face, metres
    vec3 along{0, 0, 1};     ///< propagation direction
    vec3 elevation{0, 1, 0}; ///< normal of the slice plane
};

/// The receive aperture of a line, as a function of displayed depth.
struct line_aperture {
    view<const float> fnumbers{}; ///< in the slice plane, at equal steps of displayed depth
    float spacing = 1;            ///< length of a step, metres of displayed depth
    float elevation_fnumber = 4;  ///< out of the slice plane

    /// F-number in the slice plane at a displayed depth, metres; 2 if none is given.
    INSONIFY_FN float fnumber(float depth) const {
        if (fnumbers.empty()) return 2;
        return fnumbers[static_cast<std::size_t>(clamp(depth / spacing, 0, static_cast<float>(fnumbers.size() - 1)))];
    }
};

/// One traced line, the input of an acoustic model: its layers, frame, pulse and aperture.
struct traced_line {
    view<const layer> layers{}; ///< from the probe face on, without gaps
    view<const medium> media{}; ///< of the scene, the background first
    float frequency = 0;        ///< of the carrier, hertz
    view<const pose> places{};  ///< object to world: of the background (identity), then of the objects
    line_frame frame{};         ///< in the world
    line_aperture aperture{};   ///< of the receiving array
    float pulse_sigma = 0; ///< standard deviation of the pulse envelope, metres of displayed depth; 0: of 2.5 cycles
};

} // namespace insonify::inline INSONIFY_ABI
#endif
