#ifndef INSONIFY_DOPPLER_POISEUILLE_HPP
#define INSONIFY_DOPPLER_POISEUILLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// Velocity over the heart beat, relative to its peak.
///
///     w(t) = 1 - RI (1 - s),   s = (x exp(1 - x))^2,   x = phase / systole
///
/// The phase is the fraction of the beat that has passed. w is 1 in systole and 1 - RI at the end of diastole, where
/// RI = (peak systolic - end diastolic velocity) / peak systolic velocity is the resistive index: about 0.6 to 0.8 in
/// carotid and renal arteries, above 1 where the flow reverses in diastole.
/// Source: Pourcelot 1974 for the index; the shape is by convention.
struct pulsatile {
    float heart_rate = 0;         ///< beats per second, such as 1.2_Hz; 0: steady flow
    float resistive_index = 0.7F; ///< 0: steady flow
    float systole = 0.15F;        ///< phase of the peak, 0.05 to 0.2
    float delay = 0;              ///< the first beat begins at this time, seconds

    /// Velocity at a time in seconds over that of the peak.
    float operator()(float time) const {
        if (heart_rate == 0) return 1;
        const float beats = (time - delay) * heart_rate, x = (beats - std::floor(beats)) / systole;
        const float rise = x * std::exp(1 - x);
        return 1 - resistive_index * (1 - rise * rise);
    }
    /// The mean over a beat.
    float mean() const {
        if (heart_rate == 0) return 1;
        // The integral of x^2 exp(2 - 2 x) to x = 1 / systole.
        const float end = 1 / systole;
        const float area = systole * 0.25F * (std::exp(2.0F) - (2 * end * end + 2 * end + 1) * std::exp(2 - 2 * end));
        return 1 - resistive_index * (1 - area);
    }

    /// @throws usage_error  for a setting out of range
    void check() const {
        if (!is_finite(heart_rate) || !(heart_rate >= 0) || !(heart_rate <= 20))
            throw usage_error{"pulsatile: `heart_rate` is " + detail::number_text(heart_rate) +
                              " Hz; it must be 0 (steady flow) to 20 beats per second, such as 1.2_Hz"};
        if (!(resistive_index >= 0 && resistive_index <= 2))
            throw usage_error{"pulsatile: `resistive_index` must be 0 (steady flow) to 2, such as 0.7"};
        if (!(systole >= 0.05F && systole <= 0.2F) || !is_finite(delay))
            throw usage_error{"pulsatile: `systole` must be a phase of 0.05 to 0.2, and `delay` finite"};
    }

    friend bool operator==(const pulsatile&, const pulsatile&) = default;
};

/// Laminar flow in a straight tube: v = peak_velocity w(t) (1 - r^2 / radius^2) towards `to`; 0 outside the radius.
///
/// Every beat is quasi-steady: the profile stays a parabola, as in small vessels (Womersley number below 3).
/// Source: Hagen-Poiseuille law.
struct poiseuille {
    object_id object{};      ///< whose blood flows
    vec3 from{0, 0, 0};      ///< on the axis, in coordinates of the object, metres
    vec3 to{0, 0, 0};        ///< on the axis; blood flows from `from` to `to`
    float radius = 0;        ///< of the tube, metres
    float peak_velocity = 0; ///< on the axis in systole, m/s; below 0: towards `from`
    pulsatile waveform{};    ///< steady by default

    /// See `velocity_field`.
    vec3 operator()(object_id of, vec3 point, float time) const {
        if (of != object) return {0, 0, 0};
        const vec3 along = normalize(to - from), from_axis = point - from - dot(point - from, along) * along;
        const float fraction = 1 - dot(from_axis, from_axis) / (radius * radius);
        return fraction > 0 ? peak_velocity * waveform(time) * fraction * along : vec3{0, 0, 0};
    }
    /// Volume per second at a time, m^3/s: pi radius^2 / 2 times the velocity on the axis.
    float volume_flow(float time) const { return 0.5F * pi * radius * radius * peak_velocity * waveform(time); }

    /// @throws usage_error  for a setting out of range
    void check() const {
        if (!is_finite(from) || !is_finite(to) || !(length(to - from) > 0))
            throw usage_error{"poiseuille: `from` and `to` must be two different points on the axis of the tube"};
        if (!is_finite(radius) || !(radius > 0))
            throw usage_error{"poiseuille: `radius` must be a finite number of metres above 0, such as 4_mm"};
        if (!is_finite(peak_velocity) || !(std::fabs(peak_velocity) <= 100))
            throw usage_error{"poiseuille: `peak_velocity` must be at most 100 m/s, such as 0.4_m_per_s"};
        waveform.check();
    }

    friend bool operator==(const poiseuille&, const poiseuille&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
