#ifndef INSONIFY_PROBE_LINEAR_ARRAY_HPP
#define INSONIFY_PROBE_LINEAR_ARRAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/units.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Flat array of parallel lines: for vessels, nerves and muscles.
///
/// Defaults: L12-3v. Source: the probe table of PyMUST.
struct linear_array {
    std::uint32_t lines = 192;     ///< scan lines of a frame
    float width = 38_mm;           ///< width of the face, metres
    float frequency = 7.5_MHz;     ///< carrier frequency, hertz
    float fnumber = 2;             ///< depth over active aperture, in the lateral direction
    float focus = 0;               ///< transmit focus, metres; 0: half the depth of the image
    float elevation_height = 5_mm; ///< height of the aperture, metres
    float elevation_focus = 20_mm; ///< depth of the elevation focus, where the slice is thinnest, metres
    float bandwidth = 0.644F;      ///< fractional bandwidth of echoes at -6 dB
    float side_lobes = 0;          ///< amplitude of the first side lobe; 0: none, 0.047: rectangular aperture

    /// The line as a ray in the probe frame; see `transducer`.
    INSONIFY_FN ray beam(float line) const { return {.origin = {aperture_fraction(line, lines) * width, 0, 0}}; }
    /// From {x, z} to {line, depth along it}; see `transducer`.
    INSONIFY_FN vec2 locate(vec2 point) const { return {line_at_fraction(point.x / width, lines), point.y}; }

    /// The largest active aperture, metres.
    INSONIFY_FN float aperture() const { return width; }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        check_array(*this);
        check_length(width, "width");
    }

    friend bool operator==(const linear_array&, const linear_array&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
