#ifndef INSONIFY_ACOUSTICS_SPECULAR_HPP
#define INSONIFY_ACOUSTICS_SPECULAR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/simd.hpp>
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
            add_collected(scale * std::fabs(angle), scale * edge, weight, turned, straight);
        };
        vec2 turned{0, 0}, straight{0, 0};
        at_frequency(1, turned, straight);
        if (lobe == lobe::pulse) {
            constexpr float deviation =
                1.7320508F * 0.644F / 2.3548F; // sqrt(3) sigma of the spectrum, over the carrier
            turned *= 4.0F;
            straight *= 4.0F;
            at_frequency(1 - deviation, turned, straight);
            at_frequency(1 + deviation, turned, straight);
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
    // Adds weight e(x) and weight e(0), as real and imaginary parts.
    INSONIFY_FN static void add_collected(float x, float p, float weight, vec2& turned, vec2& straight) {
        constexpr float middle = 0.318454F; // w(0), imaginary
        const float places[] = {x + p, x, std::fabs(x - p), p};
        float real[4], imaginary[4];
        edge_waves(load<4>(places), real, imaginary);
        turned += weight * (max(0, p - x) * vec2{1, -1} +
                            vec2{2 * real[1] - real[0] - real[2], 2 * imaginary[1] - imaginary[0] - imaginary[2]});
        straight += weight * (p * vec2{1, -1} + 2.0F * vec2{-real[3], middle - imaginary[3]});
    }

    // w(x) for four x >= 0, within 2e-4. The polynomials decay with the same powers of x as x g and 1/pi - x f.
    INSONIFY_FN static void edge_waves(const lanes<4>& x, float* real, float* imaginary) {
        using floats = lanes<4>;
        const floats one(1.0F), t = one / (one + x * floats(1 / 1.4F)), squared = t * t;
        const floats even = squared * (one - t) *
                            polynomial<4>(t, 7.412700F, -21.792025F, 21.327281F, -7.745051F, 1.526002F, -0.030056F);
        const floats odd = squared * squared *
                           polynomial<4>(t, -3.170665F, 16.831362F, -31.552853F, 25.425992F, -8.219520F, 1.004138F);
        // Sine and cosine of pi x^2 / 2, from those of half the angle, by their series within a quarter turn.
        const floats cycles = x * x * floats(0.25F),
                     fraction = cycles - floats_of<4>(floor_bits<4>(cycles + floats(0.5F)));
        const floats half = floats(pi) * fraction, h = half * half;
        const floats sine = half * polynomial<4>(h, -2.5052108e-8F, 2.7557319e-6F, -1.9841270e-4F, 8.3333333e-3F,
                                                 -0.16666667F, 1.0F),
                     cosine = polynomial<4>(h, 2.0876757e-9F, -2.7557319e-7F, 2.4801587e-5F, -1.3888889e-3F,
                                            4.1666667e-2F, -0.5F, 1.0F);
        const floats s = (sine + sine) * cosine, c = one - (sine + sine) * sine;
        store(even * c + odd * s, real);
        store(odd * c - even * s, imaginary);
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
