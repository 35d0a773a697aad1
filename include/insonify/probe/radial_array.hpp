#ifndef INSONIFY_PROBE_RADIAL_ARRAY_HPP
#define INSONIFY_PROBE_RADIAL_ARRAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/units.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Catheter that scans a full circle: for vessels, from inside.
///
/// The origin of the probe frame lies on the axis of the catheter, which is y. Line i of N leaves the face at the angle
/// ((i + 1/2) / N - 1/2) * 2 pi, from z towards x. Depth starts at the face; the last line is next to the first.
struct radial_array {
    std::uint32_t lines = 256;     ///< scan lines of a frame
    float radius = 0.5_mm;         ///< radius of the face, metres
    float frequency = 20_MHz;      ///< carrier frequency, hertz
    float fnumber = 2;             ///< depth over active aperture, in the lateral direction
    float focus = 0;               ///< transmit focus, metres; 0: half the depth of the image
    float elevation_height = 1_mm; ///< height of the aperture along the axis, metres
    float elevation_focus = 3_mm;  ///< depth of the elevation focus, where the slice is thinnest, metres
    float bandwidth = 0.644F;      ///< fractional bandwidth of echoes at -6 dB
    float side_lobes = 0;          ///< amplitude of the first side lobe; 0: none, 0.047: rectangular aperture

    /// The line as a ray in the probe frame; see `transducer`.
    INSONIFY_FN ray beam(float line) const { return detail::sector{lines, radius, 2 * pi, 0}.beam(line); }
    /// From {x, z} to {line, depth along it}; see `transducer`.
    INSONIFY_FN vec2 locate(vec2 point) const { return detail::sector{lines, radius, 2 * pi, 0}.locate(point); }

    /// The largest active aperture, metres: the diameter of the face.
    INSONIFY_FN float aperture() const { return 2 * radius; }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        check_array(*this);
        check_length(radius, "radius");
    }

    friend bool operator==(const radial_array&, const radial_array&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
