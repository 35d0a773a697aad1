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
/// where f and g are the auxiliary functions of the Fresnel integrals. Angles are assumed small, and the pulse
/// narrowband.
///
/// Compared with a broadband simulation of a plate at the focus, 30 mm deep, F/2, at 2.5, 5 and 7.5 MHz: above -12 dB
/// `exact` deviates by at most 0.51, 0.19 and 0.23 dB, `aperture` by 1.22, 0.83 and 0.75 dB. The -6 dB angles are 7.71,
/// 7.52 and 7.43 degrees in the simulation, 7.71, 7.39 and 7.37 with `exact`, and 7.02 with `aperture`.
/// Source: the image-source method; Abramowitz & Stegun, section 7.3, for f and g.
struct specular_return {
    /// How the echo decreases with the angle phi between the beam and the surface normal.
    enum class lobe {
        aperture, ///< max(0, 1 - |phi| / psi), psi = atan(1 / (2 F)): overlap of the aperture and its mirror image
        cosine,   ///< cos^power phi, the specularity of Buerger et al. 2013; a plate at F/2 has power 79, at F/4 270
        exact     ///< `aperture` with diffraction at its edges, in closed form
    };

    enum lobe lobe = lobe::aperture; ///< shape of the lobe
    float power = 1;                 ///< exponent of `lobe::cosine`

    /// @param angle        phi: from the beam to the surface normal, in the plane of beam and aperture, radians
    /// @param fnumber      F: depth of the facet over the width of the aperture
    /// @param wavelengths  depth of the facet over the wavelength, above 0; used by `lobe::exact` only
    INSONIFY_FN float operator()(float angle, float fnumber, float wavelengths) const {
        if (lobe == lobe::cosine) return std::pow(max(std::cos(angle), 0), power);
        const float edge = std::atan(1 / (2 * fnumber));
        if (lobe == lobe::aperture) return max(0, 1 - std::fabs(angle) / edge);
        const float scale = 2 * std::sqrt(wavelengths);
        return length(collected(scale * std::fabs(angle), scale * edge)) / length(collected(0, scale * edge));
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
