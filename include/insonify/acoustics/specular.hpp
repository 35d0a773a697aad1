#ifndef INSONIFY_ACOUSTICS_SPECULAR_HPP
#define INSONIFY_ACOUSTICS_SPECULAR_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// What a specular law must say: law(angle, fnumber, wavelengths), the share of a smooth facet's echo that an aperture
/// collects, as amplitude; see `specular_return`.
template <class Law>
concept specular_law = requires(const Law& law, float x) {
    { law(x, x, x) } -> std::convertible_to<float>;
};

/// How the echo of a smooth surface fades as the surface turns away from the beam by an angle phi.
enum class specular_lobe {
    aperture, ///< max(0, 1 - phi / psi), psi = atan(1 / (2 F)): what of the mirrored aperture covers the aperture
    cosine,   ///< cos^power phi, the "specularity" of Buerger et al. 2013; of a plate at F/2: power 79, at F/4: 270
    exact     ///< `aperture` with the diffraction at its edges, in closed form
};

/// Share of a smooth facet's echo that a focused aperture collects: an amplitude, 1 for a facet across the beam.
///
/// Each element of the aperture sees the others mirrored in the facet. An aperture focused on the facet spans the angles
/// -psi to psi from there; a facet turned by phi sends the ray that came at angle u back at 2 phi - u. In the sum over
/// all pairs of elements at angles u and v the path is short of the focused one by d (u + v - 2 phi)^2 / 4, hence
///
///     L(phi) ~ | integral of max(0, 1 - |a| / psi) exp(-i k d (phi - a)^2) da |,   k d = 2 pi depth / wavelength
///
/// the triangle of `aperture` blurred by the Fresnel zone: `exact` is this integral, `aperture` its limit for short
/// waves. With x = 2 phi sqrt(d / wavelength), and p the same of psi, two integrations by parts leave the triangle and
/// three waves from the edges,
///
///     L(phi) = |e(x)| / |e(0)|,   e(x) = (1 - i) max(0, p - |x|) - w(x + p) + 2 w(x) - w(x - p)
///     w(x) = (x g(x) + i (1/pi - x f(x))) exp(-i pi x^2 / 2)   for x >= 0,   w(-x) = w(x)
///
/// where f and g are the auxiliary functions of the Fresnel integrals. Small angles and one frequency are assumed.
/// Against a wide-band simulation of a plate in the focus, 30 mm deep at F/2, for 2.5, 5 and 7.5 MHz: above -12 dB
/// `exact` is within 0.51, 0.19 and 0.23 dB, `aperture` within 1.22, 0.83 and 0.75 dB; -6 dB, there at 7.71, 7.52 and
/// 7.43 degrees, lies at 7.71, 7.39 and 7.37 with `exact` and at 7.02 with `aperture`.
/// Source: the image-source method; Abramowitz & Stegun, section 7.3, for f and g.
struct specular_return {
    specular_lobe lobe = specular_lobe::aperture; ///< how it fades
    float power = 1;                              ///< of `cosine`

    /// @param angle        between the beam and the facet's normal, in the plane of the aperture, radians, any sign
    /// @param fnumber      depth of the facet over the width of the aperture
    /// @param wavelengths  depth of the facet over the wavelength, above 0; read by `exact` alone
    INSONIFY_FN float operator()(float angle, float fnumber, float wavelengths) const {
        if (lobe == specular_lobe::cosine) return std::pow(greater(std::cos(angle), 0), power);
        const float edge = std::atan(1 / (2 * fnumber));
        if (lobe == specular_lobe::aperture) return greater(0, 1 - std::fabs(angle) / edge);
        const float scale = 2 * std::sqrt(wavelengths);
        return length(collected(scale * std::fabs(angle), scale * edge)) / length(collected(0, scale * edge));
    }

    /// @throws usage_error  where the power makes no sense
    void check() const {
        if (!is_finite(power) || !(power >= 0))
            throw usage_error{"specular_return: `power` must be a finite number, 0 or more"};
    }

    friend bool operator==(const specular_return&, const specular_return&) = default;

  private:
    // e(x); real and imaginary part
    INSONIFY_FN static vec2 collected(float x, float p) {
        return greater(0, p - x) * vec2{1, -1} - edge_wave(x + p) + 2.0F * edge_wave(x) - edge_wave(std::fabs(x - p));
    }

    // w(x) for x >= 0, within 2e-4: both polynomials fall off with the powers of x that x g and 1/pi - x f fall off with.
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
