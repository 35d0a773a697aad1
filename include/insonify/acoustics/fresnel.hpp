#ifndef INSONIFY_ACOUSTICS_FRESNEL_HPP
#define INSONIFY_ACOUSTICS_FRESNEL_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/interface_law.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Cosine of the angle of refraction t; 0 at and beyond the critical angle.
///
///     sin t = (c2 / c1) sin i
///     cos^2 t = ((c1 - c2)(c1 + c2) + c2^2 cos^2 i) / c1^2
///
/// The second form equals 1 - sin^2 t but does not cancel at grazing incidence between nearly equal speeds.
/// Source: Snell's law; c1 and c2 are the sound speeds of the two media, m/s.
/// @param cosine  of the angle of incidence i, 0 to 1
INSONIFY_FN inline float refracted_cosine(const medium& before, const medium& after, float cosine) {
    const float c1 = before.sound_speed, c2 = after.sound_speed;
    if (c1 == c2) return cosine;
    const float eta = c2 / c1;
    const float squared = (c1 - c2) / c1 * (1 + eta) + eta * eta * cosine * cosine;
    return squared > 0 ? std::sqrt(squared) : 0.0F;
}

/// Propagation direction behind an interface; {0, 0, 0} for total reflection.
///
///     d_t = eta d + (eta cos i - cos t) n,   eta = c2 / c1,   cos i = -n.d
///
/// @param direction  d, of the incident wave, length 1; returned unchanged if the two speeds are equal
/// @param normal     n, of the surface, length 1, on either side
/// Source: Snell's law in vector form.
INSONIFY_FN inline vec3 refracted(vec3 direction, vec3 normal, const medium& before, const medium& after) {
    if (before.sound_speed == after.sound_speed) return direction;
    const float along = dot(normal, direction);
    const float cosine_in = std::fabs(along);
    const float cosine_out = refracted_cosine(before, after, cosine_in);
    if (cosine_out == 0) return {0, 0, 0};
    const float eta = after.sound_speed / before.sound_speed;
    const float turn = along < 0 ? eta * cosine_in - cosine_out : cosine_out - eta * cosine_in;
    return eta * direction + turn * normal;
}

/// Reflection and transmission at the plane interface between two fluids, at any angle of incidence. Roughness and
/// shear waves are neglected.
///
///     r = (Z2 cos i - Z1 cos t) / (Z2 cos i + Z1 cos t)              reflected pressure
///     p = 2 Z2 cos i / (Z2 cos i + Z1 cos t) = 1 + r                 transmitted pressure
///     R = r^2,  T = 4 Z1 Z2 cos i cos t / (Z2 cos i + Z1 cos t)^2    energy; R + T = 1
///
/// Z = density times sound speed in rayl; i and t are the angles of incidence and of refraction. At and beyond the
/// critical angle r = 1 and T = 0; the phase of the echo and the evanescent wave are neglected. T is also the product
/// of p there and back: the fraction of an echo's amplitude that survives both crossings. For media of equal sound
/// speed r = (density2 - density1) / (density2 + density1) at every angle, exactly 0 for equal media.
///
/// r and T are quotients of the same two terms, so R + T = 1 within a few roundings. The rounding error of these terms
/// is equivalent to that of the angle; it is noticeable only near the critical angle, where the slope of r is infinite.
/// Source: Kinsler et al., Fundamentals of Acoustics, 4th edition, chapter 6.
struct fresnel {
    /// r: signed pressure of the echo relative to the incident pressure, -1 to 1.
    /// @param cosine  of the angle of incidence, 0 to 1; also below
    INSONIFY_FN float pressure_reflection(const medium& before, const medium& after, float cosine) const {
        const terms at = terms_of(before, after, cosine);
        return at.transmitted == 0 ? 1.0F : (at.incident - at.transmitted) / (at.incident + at.transmitted);
    }

    /// p: pressure behind the interface relative to the incident pressure, 0 to 2; 0 for total reflection.
    INSONIFY_FN float pressure_transmission(const medium& before, const medium& after, float cosine) const {
        const terms at = terms_of(before, after, cosine);
        return at.transmitted == 0 ? 0.0F : 2 * (at.incident / (at.incident + at.transmitted));
    }

    /// R: fraction of the energy that is reflected, 0 to 1.
    INSONIFY_FN float energy_reflection(const medium& before, const medium& after, float cosine) const {
        const float r = pressure_reflection(before, after, cosine);
        return r * r;
    }

    /// T: fraction of the energy that is transmitted, 0 to 1; the same for the reversed ray.
    INSONIFY_FN float energy_transmission(const medium& before, const medium& after, float cosine) const {
        const terms at = terms_of(before, after, cosine);
        const float sum = at.incident + at.transmitted;
        return at.transmitted == 0 ? 0.0F : 4 * (at.incident / sum) * (at.transmitted / sum);
    }

    /// Critical angle of total reflection, radians: asin(c1 / c2); pi / 2 if there is none.
    INSONIFY_FN float critical_angle(const medium& before, const medium& after) const {
        return before.sound_speed < after.sound_speed ? std::asin(before.sound_speed / after.sound_speed) : pi / 2;
    }

    /// The interface law: r and T.
    INSONIFY_FN response operator()(const incidence& at) const {
        return {.reflected = pressure_reflection(at.before, at.after, at.cosine),
                .transmitted = energy_transmission(at.before, at.after, at.cosine)};
    }

    friend bool operator==(const fresnel&, const fresnel&) = default;

  private:
    // Z2 cos i and Z1 cos t, up to a factor that cancels; the second is 0 for total reflection.
    struct terms {
        float incident = 0;
        float transmitted = 0;
    };

    INSONIFY_FN static terms terms_of(const medium& before, const medium& after, float cosine) {
        if (before.sound_speed == after.sound_speed) return {after.density, before.density};
        return {after.impedance() * cosine, before.impedance() * refracted_cosine(before, after, cosine)};
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
