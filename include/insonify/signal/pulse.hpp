#ifndef INSONIFY_SIGNAL_PULSE_HPP
#define INSONIFY_SIGNAL_PULSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/probe/probe_lines.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Gaussian kernels are truncated at this number of standard deviations: e^-8 or -69 dB.
inline constexpr float kernel_sigmas = 4;
/// The ring-down of a pulse is followed for this many standard deviations more.
inline constexpr float ring_down_sigmas = 5;

} // namespace detail

/// Envelope of an echo along displayed depth: a rectangular burst, smoothed by a Gaussian, whose peak is 1, and what a
/// transducer that rings on adds behind it.
struct pulse_envelope {
    float sigma = 1;     ///< standard deviation of the Gaussian
    float burst = 0;     ///< length of the burst, in the unit of `sigma`; 0: a Gaussian
    float ring_down = 0; ///< amplitude at which the ring-down begins, relative to the peak

    /// The envelope is truncated at this distance before its centre, and behind it.
    /// @{
    INSONIFY_FN float half_length() const { return 0.5F * burst + detail::kernel_sigmas * sigma; }
    INSONIFY_FN float length_behind() const {
        return half_length() + (ring_down > 0 ? detail::ring_down_sigmas * sigma : 0.0F);
    }
    /// @}

    /// At a distance behind the centre: exp(-x^2 / 2 sigma^2) or, with a burst of length L, its integral from x - L/2
    /// to x + L/2, normalized; behind the centre plus `ring_down` (1 - exp(-x^2 / 2 sigma^2)) exp(-x / 2.5 sigma).
    INSONIFY_FN float operator()(float x) const {
        const float within = x / sigma, gaussian = std::exp(-0.5F * within * within);
        const float tail = x > 0 ? ring_down * (1 - gaussian) * std::exp(-within / 2.5F) : 0.0F;
        if (!(burst > 1e-2F * sigma)) return gaussian + tail;
        const float scale = 0.70710678F / sigma, half = 0.5F * burst;
        return (std::erf((x + half) * scale) - std::erf((x - half) * scale)) / (2 * std::erf(half * scale)) + tail;
    }
};

/// Transmit pulse: a burst of the carrier, filtered by a transducer whose impulse response has a Gaussian envelope.
///
///     pulse{.cycles = 2.5F}               impulse excitation, for imaging
///     pulse{.cycles = 2.5F, .burst = 8}   excitation of eight cycles, as for Doppler
struct pulse {
    float frequency = 0; ///< carrier frequency, hertz; 0: that of the probe
    float cycles = 2.5F; ///< length of the impulse response between its -20 dB points, in cycles
    float burst = 0;     ///< length of the excitation, in cycles; 0: impulse excitation
    /// Level at which the transducer begins to ring down behind an echo, relative to its peak, at most 0; by default it
    /// does not. It falls by 3.5 dB for each standard deviation of the pulse.
    float ring_down_db = no_level_db;

    /// Fractional bandwidth B of the transducer at -6 dB: 1.61 / cycles.
    ///
    /// An envelope with the standard deviation s in time falls to -20 dB at +-2.146 s, and s = 0.3748 / (B f0).
    INSONIFY_FN constexpr float bandwidth() const { return 1.61F / cycles; }

    /// Fractional bandwidth of the Gaussian pulse whose peak is as curved, and therefore loses as much to attenuation:
    /// B for impulse excitation, nearly 0 for a long burst, which loses what its carrier does.
    ///
    ///     B_peak^2 = B^2 (L / s) exp(-L^2 / 8 s^2) / (sqrt(2 pi) erf(L / (sqrt(8) s))),   s = 0.3748 / B cycles
    ///
    /// for a burst of L cycles: the second derivative of `envelope` at its peak over its peak. Attenuation multiplies
    /// the spectrum by exp(-beta (f - f0)), whose second-order term is that derivative.
    INSONIFY_FN float bandwidth_at_peak() const {
        const float per_sigma = burst * bandwidth() / 0.3748F;
        if (!(per_sigma > 1e-2F)) return bandwidth();
        return bandwidth() * std::sqrt(per_sigma * std::exp(-per_sigma * per_sigma / 8) /
                                       (2.5066283F * std::erf(per_sigma * 0.35355339F)));
    }

    /// Standard deviation of the pulse envelope along displayed depth, metres: 0.1874 c0 / (B f0).
    ///
    /// The standard deviation of the spectrum is B f0 / 2.3548, that of the envelope in time 1 / (2 pi) over it; depth
    /// is c0 t / 2.
    /// @param carrier  f0, hertz
    INSONIFY_FN constexpr float sigma_z(float carrier) const { return axial_sigma(bandwidth(), carrier); }

    /// Envelope along displayed depth, metres; a cycle is c0 / (2 f0) long.
    INSONIFY_FN constexpr pulse_envelope envelope(float carrier) const {
        return {.sigma = sigma_z(carrier),
                .burst = burst * display_speed / (2 * carrier),
                .ring_down = ring_down_db > no_level_db ? amplitude_of_decibels(ring_down_db) : 0};
    }

    /// @param carrier  frequency of the probe at which the echoes were traced, hertz
    /// @throws usage_error  for a setting out of range, or a frequency other than the carrier
    void check(float carrier) const {
        if (!is_finite(cycles) || !(cycles > 0))
            throw usage_error{"pulse: `cycles` must be finite and above 0, such as 2.5"};
        if (!is_finite(burst) || !(burst >= 0))
            throw usage_error{"pulse: `burst` must be a finite number of cycles, or 0 for impulse excitation"};
        if (!(ring_down_db <= 0))
            throw usage_error{
                "pulse: `ring_down_db` must be 0 or below, such as -16; by default there is no ring-down"};
        if (!is_finite(frequency) || !(frequency >= 0))
            throw usage_error{"pulse: `frequency` must be finite and above 0, or 0 for that of the probe"};
        if (frequency != 0 && !(std::fabs(frequency - carrier) <= 1e-5F * carrier))
            throw usage_error{"pulse: its frequency is ", detail::number_text(frequency, 9), " Hz, that of the probe ",
                              detail::number_text(carrier, 9), " Hz; make them equal, or leave that of the pulse at 0"};
    }
};

/// The shortest pulse that the fractional `bandwidth` of a probe permits; `pulse{}` for a probe without that member.
/// @param burst  see `pulse::burst`
template <transducer Probe>
INSONIFY_FN constexpr pulse nominal_pulse(const Probe& probe, float burst = 0) {
    return {.cycles = 1.61F / fractional_bandwidth(probe), .burst = burst};
}

/// Two-way beam width at each depth: a Gaussian of amplitude in the lateral and in the elevation direction, and side
/// lobes in the lateral direction where the probe has them.
///
/// One transmit focus; on receive the aperture grows with depth (constant F-number). By `beam_of`. In metres.
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
    ///     q = (1 - z_f / z) z_f / (lambda F#(z_f)^2)  defocus at the edge of the transmit aperture, wavelengths / 8
    ///
    /// The beam is narrowest before the focus, where the near side of the transmitted wave meets the growing aperture.
    /// Source: fit to simulated fields of an array that receives at constant F#: 3.5 to 7.5 MHz, F/2 to F/4, foci of 20
    /// to 40 mm, depths of 0.4 to 2.2 times the focus. `bench/studies/beam_width.cpp` simulates them again and prints
    /// the difference: of 513 widths 98.8 % agree within 10 %, all from -10 to +20 %.
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
    /// with s = `side_lobes`; a rectangular aperture has its first side lobe at u = 1.43, 26.5 dB below the main lobe.
    /// In the focus, sinc^2 falls faster; that these lobes do not makes up for those in elevation, which the elevation
    /// planes lack: see `tests/signal/side_lobes.cpp`.
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

namespace detail {

/// @param depth  image depth, metres
inline beam_model make_beam(const stated_settings& probe, float depth) {
    return {.wavelength = display_speed / probe.frequency,
            .min_fnumber = probe.fnumber,
            .aperture = probe.aperture,
            .focus = probe.focus > 0 ? probe.focus : depth / 2,
            .elevation_height = probe.elevation_height,
            .elevation_focus = probe.elevation_focus,
            .side_lobes = probe.side_lobes};
}

} // namespace detail

/// The beam of a probe. Members that a user's probe lacks (`fnumber`, `focus`, `elevation_height`, `elevation_focus`,
/// `side_lobes`, and `float aperture() const`) take the defaults of `beam_model`: F/2, half the image depth, 5 mm, 20
/// mm, none, and unlimited.
/// @param depth  image depth, metres; a focus of 0 is half of it
/// @throws usage_error  for a depth or a setting of the probe out of range
template <transducer Probe>
beam_model beam_of(const Probe& probe, float depth) {
    const detail::probe_settings own{probe};
    check_depth(depth, "beam_of");
    return detail::make_beam(own, depth);
}

/// Distance between neighbouring lines at a depth, in the centre of the field of view, metres: across the lines; along
/// the arc where they diverge. @throws usage_error  for a setting of the probe out of range
template <transducer Probe>
float line_spacing(const Probe& probe, float depth) {
    return detail::probe_settings{probe}.spacing(depth);
}

/// How much further along the lines the next line begins, metres: 0 where lines leave the face along its normals.
///
/// A wave front across line i at depth r crosses line j at depth r - (j - i) times this. On a round face it is the same
/// at all depths: there R dt sin(a), for lines dt apart that leave the face at an angle a to its normals.
/// @throws usage_error  for a setting of the probe out of range
template <transducer Probe>
float line_advance(const Probe& probe) {
    return detail::probe_settings{probe}.advance();
}

/// Number of lines to trace for each line of the probe, so that at the focus `lines_per_beam_width` lines lie within
/// the beam width or, by default, they are at most half of it apart: from `min_rays` to 4. Within these limits the
/// number of traced lines does not depend on that of the probe.
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
