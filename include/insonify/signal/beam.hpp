#ifndef INSONIFY_SIGNAL_BEAM_HPP
#define INSONIFY_SIGNAL_BEAM_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/units.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <cfloat>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// Two-way beam width at each depth: a Gaussian of amplitude in the lateral and in the elevation direction, and side lobes
/// in the lateral direction where the probe has them.
///
/// One transmit focus; on receive the aperture grows with depth (constant F-number). Made by `beam_of`. Depths in
/// metres.
struct beam_model {
    float wavelength = display_speed / 7.5e6F; ///< lambda = c0 / f0, metres
    float min_fnumber = 2;                     ///< F#: depth over active aperture, until the aperture is fully used
    float aperture = FLT_MAX;                  ///< largest active aperture, metres
    float focus = 20_mm;                       ///< z_f, transmit focus, metres
    float elevation_height = 5_mm;             ///< h, height of the aperture, metres
    float elevation_focus = 20_mm;             ///< z_y, focus of the lens in elevation, metres
    float side_lobes = 0;                      ///< amplitude of the first side lobe over that of the main lobe

    /// -6 dB width of a Gaussian over its standard deviation: 2 sqrt(2 ln 2).
    static constexpr float width_of_sigma = 2.3548F;

    /// F#(z) = max(F#, z / aperture).
    INSONIFY_FN float fnumber(float depth) const { return max(min_fnumber, depth / aperture); }

    /// Lateral -6 dB width, metres: k lambda F#(z), where
    ///
    ///     k = 1.26 - 0.41 (1 - 1.05 s^2) exp(-s^2),   s = (q + 2.2) / 3.4 below q = -2.2, (q + 2.2) / 7.2 above
    ///     q = (1 - z_f / z) z_f / (lambda F#(z_f)^2)  defocus at the edge of the transmit aperture, eighths of a wavelength
    ///
    /// The beam is narrowest before the focus, where the near side of the transmitted wave meets the growing aperture.
    /// Source: fit to simulated fields of an array that receives at constant F#: 3.5 to 7.5 MHz, F/2 to F/4, foci of 20 to
    /// 40 mm, depths of 0.4 to 2.2 times the focus; within 10 % in 98 % of 513 cases, 20 % at most.
    INSONIFY_FN float lateral_width(float depth) const {
        const float z = max(max(depth, 0.1F * focus), 1e-6F), sent = fnumber(focus);
        const float defocus = focus * (1 - focus / z) / (wavelength * sent * sent);
        const float from_narrowest = defocus + 2.2F;
        const float s = from_narrowest / (from_narrowest < 0 ? 3.4F : 7.2F);
        const float k = 1.26F - 0.41F * (1 - 1.05F * s * s) * std::exp(-s * s);
        return k * wavelength * fnumber(depth);
    }
    /// Lateral standard deviation of the main lobe, metres.
    INSONIFY_FN float lateral_sigma(float depth) const { return lateral_width(depth) / width_of_sigma; }

    /// Widths of a side lobe to which the side lobes extend on either side.
    static constexpr float side_lobe_extent = 13;

    /// Width of a side lobe, metres: 1.13 times the -6 dB width of the main lobe. Source: sinc^2, the two-way beam of a
    /// rectangular aperture, whose -6 dB width is 0.886 lambda F# and whose side lobes are lambda F# wide.
    INSONIFY_FN float side_lobe_width(float depth) const { return lateral_width(depth) / 0.886F; }

    /// Amplitude of the side lobes over that of the main lobe, at a distance of u side-lobe widths from the middle:
    ///
    ///     +- s 1.43 / u   for 1 < u < 13, of alternate sign from lobe to lobe; 0 elsewhere
    ///
    /// with s = `side_lobes`; a rectangular aperture has its first side lobe at u = 1.43, 26.5 dB below the main lobe. A pulse
    /// has no zeros between them. In the focus, sinc^2 falls faster, with 1 / u^2; that these lobes do not makes up for the
    /// side lobes in elevation, which the elevation planes lack: see `tests/signal/side_lobes.cpp`.
    INSONIFY_FN float side_lobe(float u) const {
        if (!(u > 1) || u > side_lobe_extent) return 0;
        const float lobe = 1.43F * side_lobes / u;
        return static_cast<int>(u) % 2 == 1 ? -lobe : lobe;
    }

    /// F-number in elevation: z_y / h.
    INSONIFY_FN float elevation_fnumber() const { return elevation_focus / elevation_height; }

    /// Standard deviation in elevation at the elevation focus, metres: 0.92 lambda F#y / 2.3548, by diffraction.
    INSONIFY_FN float elevation_diffraction() const {
        return 0.92F * wavelength * elevation_fnumber() / width_of_sigma;
    }
    /// Standard deviation in elevation of the geometric shadow of the aperture, metres: 0.289 h (z/z_y - 1), where
    /// 0.289 = 1 / sqrt(12); negative before the focus.
    INSONIFY_FN float elevation_shadow(float depth) const {
        return 0.289F * elevation_height * (depth / elevation_focus - 1);
    }
    /// Standard deviation in elevation, metres: the root of the sum of the squares of both.
    INSONIFY_FN float elevation_sigma(float depth) const {
        const float diffraction = elevation_diffraction(), geometry = elevation_shadow(depth);
        return std::sqrt(diffraction * diffraction + geometry * geometry);
    }
};

/// The beam of a probe. Members that a user's probe lacks (`fnumber`, `focus`, `elevation_height`, `elevation_focus`,
/// `side_lobes`, and `float aperture() const`) take the defaults of `beam_model`: F/2, half the image depth, 5 mm, 20 mm,
/// none, and unlimited.
/// @param depth  image depth, metres; a focus of 0 is half of it
/// @throws usage_error  for a depth or a setting of the probe out of range
template <transducer Probe>
beam_model beam_of(const Probe& probe, float depth) {
    probe.check();
    check_array(probe);
    check_depth(depth, "beam_of");
    beam_model beam{.wavelength = display_speed / probe.frequency, .focus = depth / 2};
    if constexpr (requires { probe.fnumber; }) beam.min_fnumber = probe.fnumber;
    if constexpr (requires { probe.aperture(); }) beam.aperture = probe.aperture();
    if constexpr (requires { probe.focus; })
        if (probe.focus > 0) beam.focus = probe.focus;
    if constexpr (requires { probe.elevation_height; }) beam.elevation_height = probe.elevation_height;
    if constexpr (requires { probe.elevation_focus; }) beam.elevation_focus = probe.elevation_focus;
    if constexpr (requires { probe.side_lobes; }) beam.side_lobes = probe.side_lobes;
    return beam;
}

/// Distance between neighbouring lines at a depth, in the centre of the field of view, metres: across the lines; along
/// the arc where they diverge.
template <transducer Probe>
INSONIFY_FN float line_spacing(const Probe& probe, float depth) {
    const float middle = 0.5F * static_cast<float>(probe.lines) - 0.5F;
    const ray left = probe.beam(middle - 0.5F), right = probe.beam(middle + 0.5F);
    const vec3 apart = right.at(depth) - left.at(depth), along = probe.beam(middle).direction;
    const float chord = length(apart - dot(apart, along) * along);
    const float half_sine = 0.5F * length(right.direction - left.direction); // of half the angle between them
    return half_sine < 1e-3F ? chord : chord * std::asin(min(half_sine, 1)) / half_sine;
}

/// How much further along the lines the next line begins, metres: 0 where lines leave the face along its normals.
///
/// A wave front across line i at depth r crosses line j at depth r - (j - i) times this. On a round face it is the same
/// at all depths: there R dt sin(a), for lines dt apart that leave the face at an angle a to its normals.
template <transducer Probe>
INSONIFY_FN float line_advance(const Probe& probe) {
    const float middle = 0.5F * static_cast<float>(probe.lines) - 0.5F;
    const ray left = probe.beam(middle - 0.5F), right = probe.beam(middle + 0.5F);
    const float advance = dot(right.origin - left.origin, probe.beam(middle).direction);
    return probe.lines < 2 || std::fabs(advance) < 1e-9F ? 0 : advance; // less is rounding
}

/// Number of lines to trace for each line of the probe, so that at the focus `lines_per_beam_width` lines lie within the
/// beam width or, by default, they are at most half of it apart: from `min_rays` to 4. Within these limits the number of
/// traced lines does not depend on that of the probe.
/// @param min_rays  below 1 where the lines that are left out are interpolated (`resample_lines`) or not shown
template <transducer Probe>
float rays_per_line(const Probe& probe, float depth, float min_rays = 1, float lines_per_beam_width = 2) {
    const beam_model beam = beam_of(probe, depth);
    const float needed = lines_per_beam_width * line_spacing(probe, beam.focus) / beam.lateral_width(beam.focus);
    const auto lines = static_cast<float>(probe.lines);
    return std::ceil(clamp(needed, min_rays, 4) * lines - 0.01F) / lines;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
