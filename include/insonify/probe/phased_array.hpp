#ifndef INSONIFY_PROBE_PHASED_ARRAY_HPP
#define INSONIFY_PROBE_PHASED_ARRAY_HPP

#include <insonify/core/units.hpp>
#include <insonify/probe/sector.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Lines steered from the middle of a small flat face: the heart between the ribs.
///
/// The elevation defaults are those of a P4-2v. Source: the probe table of PyMUST.
struct phased_array {
    std::uint32_t lines = 128;      ///< of a frame
    float width = 20_mm;            ///< of the face, metres: the whole aperture; every line starts in its middle
    float field_of_view = 90_deg;   ///< between the two ends of the fan, radians; up to 180_deg
    float frequency = 2.5_MHz;      ///< of the carrier, hertz
    float fnumber = 2;              ///< depth over the aperture in use, across the lines
    float focus = 0;                ///< depth in metres; 0: half the depth of the picture
    float elevation_height = 14_mm; ///< of the aperture out of the slice plane, metres
    float elevation_focus = 60_mm;  ///< depth at which the slice is thinnest, metres
    float bandwidth = 0.644F;       ///< -6 dB width of the spectrum of its echoes, as a share of the frequency

    /// Line `line` in the frame of the probe: see `transducer`.
    INSONIFY_FN ray beam(float line) const { return sector{lines, 0, field_of_view}.beam(line); }
    /// From {x, z} to {line, metres along it}: see `transducer`.
    INSONIFY_FN vec2 locate(vec2 point) const { return sector{lines, 0, field_of_view}.locate(point); }

    /// The widest aperture that a line can use, metres.
    INSONIFY_FN float aperture() const { return width; }

    /// @throws usage_error  naming the setting that makes no sense
    INSONIFY_LAZY void check() const {
        check_array(*this);
        check_positive(width, "width");
        check_positive(field_of_view, "field_of_view");
        if (field_of_view > pi)
            throw usage_error{"phased_array: `field_of_view` is in radians and at most 180_deg; write it as 90_deg"};
    }

    friend bool operator==(const phased_array&, const phased_array&) = default;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
