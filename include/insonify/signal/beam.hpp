#ifndef INSONIFY_SIGNAL_BEAM_HPP
#define INSONIFY_SIGNAL_BEAM_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/units.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/probe/transducer.hpp>
#include <cfloat>

namespace insonify::inline INSONIFY_ABI {

/// How wide the beam is, there and back, at each depth: Gaussian in amplitude, across the lines and out of their plane.
///
/// One focus when sending, the aperture opened with depth when receiving. Made by `beam_of`; the depths are metres.
struct beam_model {
    float wavelength = display_speed / 7.5e6F; ///< lambda = c0 / f0, metres
    float least_fnumber = 2;                   ///< F#: the depth over the aperture in use, as long as that is there
    float aperture = FLT_MAX;                  ///< the widest, across the lines, metres
    float focus = 20_mm;                       ///< z_f, of sending
    float elevation_height = 5_mm;             ///< h, of the aperture out of the slice plane, metres
    float elevation_focus = 20_mm;             ///< z_y, of the lens: depth at which the slice is thinnest

    /// Half height (-6 dB) of a Gaussian over its standard deviation: 2 sqrt(2 ln 2).
    static constexpr float width_of_sigma = 2.3548F;

    /// F#(z) = max(F#, z / aperture): deep down the whole aperture is in use.
    INSONIFY_FN float fnumber(float depth) const { return greater(least_fnumber, depth / aperture); }

    /// -6 dB width across the lines, metres: k(z) lambda F#(z), where
    /// k(z) = 0.92 + 0.32 (1 - exp(-((z - z_f) / (4 lambda F#^2))^2)).
    ///
    /// Source: fitted to simulated fields of an array that receives at constant F#; within 12 % from F/2 to F/4.
    INSONIFY_FN float lateral_width(float depth) const {
        const float off_focus = (depth - focus) / (4 * wavelength * least_fnumber * least_fnumber);
        const float k = 0.92F + 0.32F * (1 - std::exp(-off_focus * off_focus));
        return k * wavelength * fnumber(depth);
    }
    /// Standard deviation across the lines, metres.
    INSONIFY_FN float lateral_sigma(float depth) const { return lateral_width(depth) / width_of_sigma; }

    /// F#y = z_y / h.
    INSONIFY_FN float elevation_fnumber() const { return elevation_focus / elevation_height; }

    /// Standard deviation out of the slice plane, metres: sqrt((0.92 lambda F#y / 2.3548)^2 + (0.289 h |1 - z/z_y|)^2),
    /// the width at the focus and, away from it, that of the aperture's shadow (0.289 = 1 / sqrt(12)).
    INSONIFY_FN float elevation_sigma(float depth) const {
        const float diffraction = 0.92F * wavelength * elevation_fnumber() / width_of_sigma;
        const float geometry = 0.289F * elevation_height * (1 - depth / elevation_focus);
        return std::sqrt(diffraction * diffraction + geometry * geometry);
    }
};

/// The beam of a probe. What a probe of your own does not state (`fnumber`, `focus`, `elevation_height`,
/// `elevation_focus`, and `float aperture() const`) is as in `beam_model{}`: F/2, half the depth of the picture, 5 mm,
/// 20 mm, and no bound.
/// @param depth  of the picture, metres: a focus of 0 is half of it
/// @throws usage_error  where the probe or the depth makes no sense
template <transducer Probe>
beam_model beam_of(const Probe& probe, float depth) {
    probe.check();
    if (!is_depth(depth)) throw usage_error{"beam_of: the depth of the picture must be from 1 nm to 1000 km"};
    beam_model beam{.wavelength = display_speed / probe.frequency, .focus = depth / 2};
    if constexpr (requires { probe.fnumber; }) beam.least_fnumber = probe.fnumber;
    if constexpr (requires { probe.aperture(); }) beam.aperture = probe.aperture();
    if constexpr (requires { probe.focus; })
        if (probe.focus > 0) beam.focus = probe.focus;
    if constexpr (requires { probe.elevation_height; }) beam.elevation_height = probe.elevation_height;
    if constexpr (requires { probe.elevation_focus; }) beam.elevation_focus = probe.elevation_focus;
    return beam;
}

/// Metres between neighbouring lines at a depth along them, in the middle of the field; along the arc where they fan
/// out.
template <transducer Probe>
INSONIFY_FN float line_spacing(const Probe& probe, float depth) {
    const float middle = 0.5F * static_cast<float>(probe.lines) - 0.5F;
    const ray left = probe.beam(middle - 0.5F), right = probe.beam(middle + 0.5F);
    const float chord = length(right.at(depth) - left.at(depth));
    const float half_sine = 0.5F * length(right.direction - left.direction); // of half the angle between the two
    return half_sine < 1e-3F ? chord : chord * std::asin(lesser(half_sine, 1)) / half_sine;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
