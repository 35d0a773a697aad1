#ifndef INSONIFY_PROBE_CONVEX_ARRAY_HPP
#define INSONIFY_PROBE_CONVEX_ARRAY_HPP

#include <insonify/core/units.hpp>
#include <insonify/probe/sector.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Lines that leave a curved face at right angles: the abdomen.
///
/// The elevation defaults are those of a C5-2v. Source: the probe table of PyMUST.
struct convex_array {
    std::uint32_t lines = 192;        ///< of a frame
    float radius = 60_mm;             ///< of the face, metres
    float field_of_view = 60_deg;     ///< between the two ends of the face, radians; up to 360_deg
    float frequency = 3.5_MHz;        ///< of the carrier, hertz
    float fnumber = 2;                ///< depth over the aperture in use, across the lines
    float focus = 0;                  ///< depth in metres; 0: half the depth of the picture
    float elevation_height = 13.5_mm; ///< of the aperture out of the slice plane, metres
    float elevation_focus = 60_mm;    ///< depth at which the slice is thinnest, metres
    float bandwidth = 0.644F;         ///< -6 dB width of the spectrum of its echoes, as a share of the frequency

    /// Line `line` in the frame of the probe: see `transducer`.
    INSONIFY_FN ray beam(float line) const { return sector{lines, radius, field_of_view}.beam(line); }
    /// From {x, z} to {line, metres along it}: see `transducer`.
    INSONIFY_FN vec2 locate(vec2 point) const { return sector{lines, radius, field_of_view}.locate(point); }

    /// The widest aperture that a line can use, metres.
    INSONIFY_FN float aperture() const { return radius * field_of_view; }

    /// @throws usage_error  naming the setting that makes no sense
    INSONIFY_LAZY void check() const {
        check_array(*this);
        check_positive(radius, "radius");
        check_positive(field_of_view, "field_of_view");
        if (field_of_view > 2 * pi)
            throw usage_error{"convex_array: `field_of_view` is in radians and at most 360_deg; write it as 60_deg"};
    }

    friend bool operator==(const convex_array&, const convex_array&) = default;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
