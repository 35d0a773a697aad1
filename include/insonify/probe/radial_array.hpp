#ifndef INSONIFY_PROBE_RADIAL_ARRAY_HPP
#define INSONIFY_PROBE_RADIAL_ARRAY_HPP

#include <insonify/core/units.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Lines all around the axis of a catheter: vessels from inside.
///
/// Here the frame's origin lies on the axis, which is y: line i of N leaves the face at the angle ((i + 1/2) / N - 1/2)
/// of a full turn, from z towards x. Depth counts from the face, and the last line is the neighbour of the first.
struct radial_array {
    std::uint32_t lines = 256;     ///< of a frame
    float radius = 0.5_mm;         ///< of the face, metres
    float frequency = 20_MHz;      ///< of the carrier, hertz
    float fnumber = 2;             ///< depth over the aperture in use, across the lines
    float focus = 0;               ///< depth in metres; 0: half the depth of the picture
    float elevation_height = 1_mm; ///< of the aperture along the axis, metres
    float elevation_focus = 3_mm;  ///< depth at which the slice is thinnest, metres
    float bandwidth = 0.644F;      ///< -6 dB width of the spectrum of its echoes, as a share of the frequency

    /// Line `line` in the frame of the probe: see `transducer`.
    INSONIFY_FN ray beam(float line) const {
        const float angle = share_of_line(line, lines) * 2 * pi;
        const vec3 direction{std::sin(angle), 0, std::cos(angle)};
        return {.origin = radius * direction, .direction = direction};
    }
    /// From {x, z} to {line, metres along it}: see `transducer`.
    INSONIFY_FN vec2 locate(vec2 point) const {
        return {line_of_share(std::atan2(point.x, point.y) / (2 * pi), lines), length(point) - radius};
    }

    /// The widest aperture that a line can use, metres: what of the face looks its way.
    INSONIFY_FN float aperture() const { return 2 * radius; }

    /// @throws usage_error  naming the setting that makes no sense
    INSONIFY_LAZY void check() const {
        check_array(*this);
        check_positive(radius, "radius");
    }

    friend bool operator==(const radial_array&, const radial_array&) = default;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
