#ifndef INSONIFY_PROBE_PHASED_ARRAY_HPP
#define INSONIFY_PROBE_PHASED_ARRAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/units.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Small flat array that steers its lines from its centre: for the heart, between the ribs.
///
/// Defaults in elevation: P4-2v. Source: the probe table of PyMUST.
struct phased_array {
    std::uint32_t lines = 128;      ///< scan lines of a frame
    float width = 20_mm;            ///< width of the face, metres; all lines start at its centre
    float field_of_view = 90_deg;   ///< angle between the ends of the sector, radians; up to 180_deg
    float frequency = 2.5_MHz;      ///< carrier frequency, hertz
    float fnumber = 2;              ///< depth over active aperture, in the lateral direction
    float focus = 0;                ///< transmit focus, metres; 0: half the depth of the image
    float elevation_height = 14_mm; ///< height of the aperture, metres
    float elevation_focus = 60_mm;  ///< depth of the elevation focus, where the slice is thinnest, metres
    float bandwidth = 0.644F;       ///< fractional bandwidth of echoes at -6 dB
    float side_lobes = 0;           ///< amplitude of the first side lobe; 0: none, 0.047: rectangular aperture

    /// The line as a ray in the probe frame; see `transducer`.
    INSONIFY_FN ray beam(float line) const { return detail::sector{lines, 0, field_of_view}.beam(line); }
    /// From {x, z} to {line, depth along it}; see `transducer`.
    INSONIFY_FN vec2 locate(vec2 point) const { return detail::sector{lines, 0, field_of_view}.locate(point); }

    /// The largest active aperture, metres.
    INSONIFY_FN float aperture() const { return width; }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        check_array(*this);
        check_length(width, "width");
        check_angle(field_of_view, "field_of_view", pi, "phased_array");
    }

    friend bool operator==(const phased_array&, const phased_array&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
