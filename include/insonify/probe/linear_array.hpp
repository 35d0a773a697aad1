#ifndef INSONIFY_PROBE_LINEAR_ARRAY_HPP
#define INSONIFY_PROBE_LINEAR_ARRAY_HPP

#include <insonify/core/units.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Parallel lines from a flat face: vessels, nerves, muscles.
///
/// The defaults are those of an L12-3v. Source: the probe table of PyMUST.
struct linear_array {
    std::uint32_t lines = 192;     ///< of a frame
    float width = 38_mm;           ///< of the face, metres; the lines stand in the middle of `lines` equal parts of it
    float frequency = 7.5_MHz;     ///< of the carrier, hertz
    float fnumber = 2;             ///< depth over the aperture in use, across the lines
    float focus = 0;               ///< depth in metres; 0: half the depth of the picture
    float elevation_height = 5_mm; ///< of the aperture out of the slice plane, metres
    float elevation_focus = 20_mm; ///< depth at which the slice is thinnest, metres
    float bandwidth = 0.644F;      ///< -6 dB width of the spectrum of its echoes, as a share of the frequency

    /// Line `line` in the frame of the probe: see `transducer`.
    INSONIFY_FN ray beam(float line) const { return {.origin = {share_of_line(line, lines) * width, 0, 0}}; }
    /// From {x, z} to {line, metres along it}: see `transducer`.
    INSONIFY_FN vec2 locate(vec2 point) const { return {line_of_share(point.x / width, lines), point.y}; }

    /// The widest aperture that a line can use, metres.
    INSONIFY_FN float aperture() const { return width; }

    /// @throws usage_error  naming the setting that makes no sense
    INSONIFY_LAZY void check() const {
        check_array(*this);
        check_positive(width, "width");
    }

    friend bool operator==(const linear_array&, const linear_array&) = default;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
