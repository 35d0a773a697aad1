#ifndef INSONIFY_ACOUSTICS_FRESNEL_HPP
#define INSONIFY_ACOUSTICS_FRESNEL_HPP

#include <insonify/acoustics/interface_law.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Cosine of the angle t of the transmitted ray; 0 at and beyond the critical angle, where there is none.
///
///     sin t = (c2 / c1) sin i
///     cos^2 t = ((c1 - c2)(c1 + c2) + c2^2 cos^2 i) / c1^2
///
/// The second form, equal to 1 - sin^2 t, keeps its digits at grazing incidence, where speeds that are nearly equal
/// would leave a difference of two ones. Source: Snell's law, with the speeds of sound c of the two media in m/s.
/// @param cosine  of the angle of incidence i, 0 to 1
INSONIFY_FN inline float refracted_cosine(const medium& before, const medium& after, float cosine) {
    const float c1 = before.sound_speed, c2 = after.sound_speed;
    if (c1 == c2) return cosine;
    const float eta = c2 / c1;
    const float squared = (c1 - c2) / c1 * (1 + eta) + eta * eta * cosine * cosine;
    return squared > 0 ? std::sqrt(squared) : 0.0F;
}

/// Direction in which sound goes on behind an interface; {0, 0, 0} where it is totally reflected.
///
///     d_t = eta d + (eta cos i - cos t) n,   eta = c2 / c1,   cos i = -n.d
///
/// @param direction  of the arriving sound, length 1; unchanged where the two speeds are equal
/// @param normal     of the surface, length 1, towards either side
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

/// The plane interface between two fluids, at any angle: the law of nature where roughness and shear are left out.
///
///     r = (Z2 cos i - Z1 cos t) / (Z2 cos i + Z1 cos t)              pressure reflected
///     p = 2 Z2 cos i / (Z2 cos i + Z1 cos t) = 1 + r                 pressure transmitted
///     R = r^2,  T = 4 Z1 Z2 cos i cos t / (Z2 cos i + Z1 cos t)^2    energy; R + T = 1
///
/// Z = density times speed in rayl, i and t the angles of incidence and of refraction. At and beyond the critical angle
/// r = 1 and nothing is transmitted (its phase and the evanescent wave are left out). T is also the product of the
/// pressures p of the ways there and back, hence what an echo keeps when it crosses twice.
///
/// All is computed in float: r and T are quotients of the same two terms, so R + T = 1 within a few roundings whatever
/// the error of those. That error is as if the angle had been given a rounding away: it matters near the critical angle
/// alone, where r changes infinitely fast.
/// Source: Kinsler et al., Fundamentals of Acoustics, oblique incidence on a fluid; for media of equal speed of sound
/// r = (density2 - density1) / (density2 + density1) at every angle: exactly 0 for equal media.
struct fresnel {
    /// Signed pressure of the echo, relative to the pressure that arrives: -1 to 1.
    /// @param cosine  of the angle of incidence, 0 to 1; here and below
    INSONIFY_FN float pressure_reflection(const medium& before, const medium& after, float cosine) const {
        const terms at = terms_of(before, after, cosine);
        return at.transmitted == 0 ? 1.0F : (at.incident - at.transmitted) / (at.incident + at.transmitted);
    }

    /// Pressure behind the interface, relative to the pressure that arrives: 0 to 2; 0 where nothing is transmitted.
    INSONIFY_FN float pressure_transmission(const medium& before, const medium& after, float cosine) const {
        const terms at = terms_of(before, after, cosine);
        return at.transmitted == 0 ? 0.0F : 2 * (at.incident / (at.incident + at.transmitted));
    }

    /// Share of the energy that is reflected, 0 to 1.
    INSONIFY_FN float energy_reflection(const medium& before, const medium& after, float cosine) const {
        const float r = pressure_reflection(before, after, cosine);
        return r * r;
    }

    /// Share of the energy that is transmitted, 0 to 1: the same in both directions of one ray.
    INSONIFY_FN float energy_transmission(const medium& before, const medium& after, float cosine) const {
        const terms at = terms_of(before, after, cosine);
        const float sum = at.incident + at.transmitted;
        return at.transmitted == 0 ? 0.0F : 4 * (at.incident / sum) * (at.transmitted / sum);
    }

    /// Angle of incidence from which on everything is reflected, radians: asin(c1 / c2); pi / 2 where there is none.
    INSONIFY_FN float critical_angle(const medium& before, const medium& after) const {
        return before.sound_speed < after.sound_speed ? std::asin(before.sound_speed / after.sound_speed) : pi / 2;
    }

    /// As `interface_law` asks: r, and what an echo keeps there and back, T.
    INSONIFY_FN response operator()(const incidence& at) const {
        return {.reflected = pressure_reflection(at.before, at.after, at.cosine),
                .transmitted = energy_transmission(at.before, at.after, at.cosine)};
    }

    friend bool operator==(const fresnel&, const fresnel&) = default;

  private:
    // Z2 cos i and Z1 cos t, up to a factor that cancels; the second is 0 where sound is totally reflected.
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
#endif
