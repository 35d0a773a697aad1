#ifndef INSONIFY_ACOUSTICS_SPECULAR_HPP
#define INSONIFY_ACOUSTICS_SPECULAR_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// A specular law: law(angle, fnumber, wavelengths) is the fraction of a specular echo's amplitude that the aperture
/// collects; see `specular_return`.
template <class Law>
concept specular_law = requires(const Law& law, float x) {
    { law(x, x, x) } -> std::convertible_to<float>;
};

/// Fraction of a specular echo's amplitude that a focused aperture collects; 1 at normal incidence.
///
/// Each element receives the mirror images of the others. Seen from a facet at the focus, at depth d, the aperture
/// spans the angles -psi to psi; a facet tilted by phi reflects a ray from angle u to angle 2 phi - u. For elements at
/// angles u and v the path is shorter than the focused one by d (u + v - 2 phi)^2 / 4, so the sum over all pairs of
/// elements is
///
///     L(phi) ~ | integral of max(0, 1 - |a| / psi) exp(-i k d (phi - a)^2) da |,   k d = 2 pi d / wavelength
///
/// the triangle of `lobe::aperture` blurred by the Fresnel zone. `lobe::exact` is this integral, `lobe::aperture` its
/// limit for short wavelengths. With x = 2 phi sqrt(d / wavelength) and p = 2 psi sqrt(d / wavelength), two
/// integrations by parts give the triangle and three edge waves,
///
///     L(phi) = |e(x)| / |e(0)|,   e(x) = (1 - i) max(0, p - |x|) - w(x + p) + 2 w(x) - w(x - p)
///     w(x) = (x g(x) + i (1/pi - x f(x))) exp(-i pi x^2 / 2)   for x >= 0,   w(-x) = w(x)
///
/// where f and g are the auxiliary functions of the Fresnel integrals. Angles are assumed small.
///
/// This is for a single frequency f. `lobe::pulse` averages e(x) / f over the spectrum of a pulse of 2.5 cycles, whatever the
/// probe's own, by Gauss-Hermite quadrature: at the carrier and at 1 +- 0.474 times it.
///
/// Compared with a broadband simulation of a plate at the focus, 30 mm deep, at 2.5, 5 and 7.5 MHz, above -12 dB:
///
///                   F/2                    F/4
///     pulse         0.38  0.21  0.21 dB    0.15  0.14  0.08 dB     largest deviation
///     exact         0.48  0.19  0.22 dB    1.06  0.63  0.24 dB
///     aperture      1.22  0.82  0.70 dB    4.50  1.84  1.42 dB
/// Source: the image-source method; Abramowitz & Stegun, section 7.3, for f and g.
struct specular_return {
    /// How the echo decreases with the angle phi between the beam and the surface normal.
    enum class lobe {
        aperture, ///< max(0, 1 - |phi| / psi), psi = atan(1 / (2 F)): overlap of the aperture and its mirror image
        cosine,   ///< cos^power phi, the specularity of Buerger et al. 2013; a plate at F/2 has power 79, at F/4 270
        exact,    ///< `aperture` with diffraction at its edges, in closed form, at a single frequency
        pulse     ///< `exact` averaged over the spectrum of a short pulse
    };

    enum lobe lobe = lobe::pulse; ///< shape of the lobe
    float power = 1;              ///< exponent of `lobe::cosine`

    /// @param angle        phi: from the beam to the surface normal, in the plane of beam and aperture, radians
    /// @param fnumber      F: depth of the facet over the width of the aperture
    /// @param wavelengths  depth of the facet over the wavelength, above 0; used by `exact` and `pulse` only
    INSONIFY_FN float operator()(float angle, float fnumber, float wavelengths) const {
        if (lobe == lobe::cosine) return std::pow(max(std::cos(angle), 0), power);
        const float edge = std::atan(1 / (2 * fnumber));
        if (lobe == lobe::aperture) return max(0, 1 - std::fabs(angle) / edge);
        if (angle == 0) return 1;
        const auto at_frequency = [&](float relative, vec2& turned, vec2& straight) {
            const float scale = 2 * std::sqrt(wavelengths * relative), weight = 1 / relative;
            turned = weight * collected(scale * std::fabs(angle), scale * edge);
            straight = weight * collected(0, scale * edge);
        };
        vec2 turned, straight;
        at_frequency(1, turned, straight);
        if (lobe == lobe::exact) return length(turned) / length(straight);
        constexpr float deviation = 1.7320508F * 0.644F / 2.3548F; // sqrt(3) sigma of the spectrum, over the carrier
        for (const float relative : {1 - deviation, 1 + deviation}) {
            vec2 also_turned, also_straight;
            at_frequency(relative, also_turned, also_straight);
            turned += 0.25F * also_turned;
            straight += 0.25F * also_straight;
        }
        return length(turned) / length(straight);
    }

    /// @throws usage_error  if `power` is out of range
    void check() const {
        if (!is_finite(power) || !(power >= 0))
            throw usage_error{"specular_return: `power` must be a finite number, 0 or more"};
    }

    friend bool operator==(const specular_return&, const specular_return&) = default;

  private:
    // e(x), as real and imaginary part.
    INSONIFY_FN static vec2 collected(float x, float p) {
        return max(0, p - x) * vec2{1, -1} - edge_wave(x + p) + 2.0F * edge_wave(x) - edge_wave(std::fabs(x - p));
    }

    // w(x) for x >= 0, within 2e-4. The polynomials decay with the same powers of x as x g and 1/pi - x f.
    INSONIFY_FN static vec2 edge_wave(float x) {
        const float t = 1 / (1 + x / 1.4F);
        const float real =
            t * t * (1 - t) *
            (-0.030056F + t * (1.526002F + t * (-7.745051F + t * (21.327281F + t * (-21.792025F + t * 7.412700F)))));
        const float imaginary =
            t * t * t * t *
            (1.004138F + t * (-8.219520F + t * (25.425992F + t * (-31.552853F + t * (16.831362F - t * 3.170665F)))));
        const float cycles = x * x / 4;
        const float phase = 2 * pi * (cycles - std::floor(cycles));
        const float c = std::cos(phase), s = std::sin(phase);
        return {real * c + imaginary * s, imaginary * c - real * s};
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
