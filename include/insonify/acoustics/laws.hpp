#ifndef INSONIFY_ACOUSTICS_LAWS_HPP
#define INSONIFY_ACOUSTICS_LAWS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/math.hpp>
#include <insonify/execution/simd.hpp>
#include <cfloat>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// A wave incident on the interface between two media.
struct incidence {
    medium before{};      ///< on the side of the incident wave
    medium after{};       ///< on the other side
    float cosine = 1;     ///< of the angle of incidence, 0 to 1
    float frequency = 0;  ///< hertz
    float roughness = -1; ///< rms height of the surface, metres; below 0: the larger one of the two media
};

/// Reflection at an interface, and the factor on echoes that cross it there and back.
struct response {
    float reflected = 0;   ///< signed pressure amplitude of the echo, relative to the incident wave
    float transmitted = 1; ///< fraction of an echo's amplitude that survives crossing there and back
};

/// An interface law: law(incidence) is the `response` of the interface. It is called only where the medium changes.
template <class Law>
concept interface_law = requires(const Law& law, const incidence& at) {
    { law(at) } -> std::same_as<response>;
};

/// Attenuation of an echo per metre of depth, there and back, in dB/m at a frequency in hertz.
///
///     loss = 2 alpha0 f^b
///
/// alpha0 = `attenuation` in dB/m at 1 MHz, f in MHz, b = `attenuation_power`. Valid for a single frequency. The result
/// is finite for every valid medium: it is at most FLT_MAX.
/// Source: the power law of attenuation in tissue, Szabo, Diagnostic Ultrasound Imaging: Inside Out, 2004, chapter 4.
INSONIFY_FN inline float echo_loss(const medium& m, float frequency) {
    const float megahertz = frequency * 1e-6F;
    const float growth = m.attenuation_power == 1 ? megahertz : std::pow(megahertz, m.attenuation_power);
    return min(m.attenuation * min(2 * growth, FLT_MAX), FLT_MAX);
}

/// An attenuation law: law(medium, frequency) is the attenuation of an echo in dB per metre, there and back; the
/// frequency is in hertz.
template <class Law>
concept attenuation_law = requires(const Law& law, const medium& m, float frequency) {
    { law(m, frequency) } -> std::convertible_to<float>;
};

/// The default attenuation law: `echo_loss`.
struct power_law {
    /// dB/m, there and back; the frequency in hertz.
    INSONIFY_FN float operator()(const medium& m, float frequency) const { return echo_loss(m, frequency); }

    friend bool operator==(const power_law&, const power_law&) = default;
};

/// The echo of a pulse of finite bandwidth. Attenuation grows with frequency, so the centre of the spectrum shifts down
/// and the peak loses less than a single frequency would.
struct broadband_echo {
    float loss_db = 0;   ///< of the peak, dB
    float frequency = 0; ///< of the centre of the spectrum, hertz
};

/// A Gaussian pulse after a path, there and back, on which a single frequency would lose `narrowband_db`.
///
///     beta = narrowband_db ln(10) / (20 f0)                       Np/Hz
///     sigma = B f0 / 2.3548                                       Hz, of the amplitude spectrum
///     loss = beta f0 - beta^2 sigma^2 / 2                         Np, of the peak
///     centre = f0 - beta sigma^2                                  Hz
///
/// Valid for attenuation linear in f, as long as the centre is well above 0. beta is limited to the value at which the
/// centre is f0 / 2.
/// @param frequency  f0, of the carrier, hertz
/// @param bandwidth  B, fractional, at -6 dB
/// Source: product of the Gaussian spectrum and exp(-beta f), by completing the square; see also Szabo,
/// Diagnostic Ultrasound Imaging: Inside Out, 2004, chapter 4.
INSONIFY_FN inline broadband_echo attenuated(float narrowband_db, float frequency, float bandwidth) {
    constexpr float neper_per_db = 0.115129255F; // ln(10) / 20
    const float sigma = bandwidth * frequency / 2.3548F;
    const float max_beta = 0.5F * frequency / (sigma * sigma);
    const float beta = min(neper_per_db * narrowband_db / frequency, max_beta);
    return {.loss_db = narrowband_db - 0.5F * beta * beta * sigma * sigma / neper_per_db,
            .frequency = frequency - beta * sigma * sigma};
}

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
/// speed r = (density2 - density1) / (density2 + density1) at every angle, exactly 0 for equal media. R + T = 1 within
/// a few roundings. Source: Kinsler et al., Fundamentals of Acoustics, 4th edition, chapter 6.
struct fresnel {
    /// r: signed pressure of the echo relative to the incident pressure, -1 to 1.
    /// @param cosine  of the angle of incidence, 0 to 1; also below
    INSONIFY_FN float pressure_reflection(const medium& before, const medium& after, float cosine) const {
        const terms at = terms_of(before, after, cosine);
        return at.transmitted == 0 ? 1.0F : (at.incident - at.transmitted) / (at.incident + at.transmitted);
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

/// Rms height of the surface that a wave meets, metres: its own where it is known, else the larger `roughness` of the
/// two media. Tracers give that of the object whose surface it is, of higher priority than what it lies in: polished
/// steel in rough muscle stays a mirror.
INSONIFY_FN inline float rms_height(const incidence& at) {
    return at.roughness < 0 ? max(at.before.roughness, at.after.roughness) : at.roughness;
}

/// A roughness law: law.coherent(incidence) is the factor on the amplitude of the specular echo, and
/// law.diffuse(incidence) the fraction of the reflected energy that is scattered diffusely; both 0 to 1.
template <class Law>
concept roughness_law = requires(const Law& law, const incidence& at) {
    { law.coherent(at) } -> std::convertible_to<float>;
    { law.diffuse(at) } -> std::convertible_to<float>;
};

/// Kirchhoff's approximation for a surface with normally distributed heights.
///
///     phi = 2 k h cos i                  rms phase of the echo, radians
///     coherent = exp(-phi^2 / 2)         amplitude of the specular echo
///     diffuse = 1 - exp(-phi^2)          energy, relative to the reflected energy; coherent^2 + diffuse = 1
///
/// h is the rms height in metres, k = 2 pi f / c the wave number in the medium before the interface in 1/m, and i the
/// angle of incidence.
/// Source: Beckmann & Spizzichino, The Scattering of Electromagnetic Waves from Rough Surfaces, 1963.
struct kirchhoff {
    /// Factor on the amplitude of the specular echo, 0 to 1; exactly 1 between smooth media.
    INSONIFY_FN float coherent(const incidence& at) const {
        const float phase = rms_phase(at);
        return std::exp(-phase * phase / 2);
    }
    /// Fraction of the reflected energy that is scattered diffusely, 0 to 1.
    INSONIFY_FN float diffuse(const incidence& at) const {
        const float phase = rms_phase(at);
        return -std::expm1(-phase * phase);
    }
    /// Rms phase of the echo over the rough surface, radians.
    INSONIFY_FN float rms_phase(const incidence& at) const {
        const float wave_number = 2 * pi * at.frequency / at.before.sound_speed;
        return 2 * wave_number * rms_height(at) * at.cosine;
    }

    friend bool operator==(const kirchhoff&, const kirchhoff&) = default;
};

/// Power that a rough surface scatters back to where the wave comes from, over that of Lambert's law at normal
/// incidence.
///
///     hard: cos^2 i                                   Lambert's law: bone, metal, gas
///     soft: exp(-tan^2 i / (2 s^2)) / (8 s^2 cos^4 i)  facets, whose slopes are normally distributed
///
/// s = tan(15 degrees) is the rms slope of facets along either axis, by convention: side walls of muscles and vessels
/// drop out of real pictures, while those of bone can be followed. Facets that return an echo lie across the wave.
/// Source: Barrick, Rough surface scattering based on the specular point theory, IEEE Trans. Antennas Propag. 1968
/// 16:449, by which the backscattering of a facetted surface is r^2 exp(-tan^2 i / (2 s^2)) / (2 s^2 cos^4 i) for each
/// area, where Lambert's law has 4 r^2 cos^2 i.
/// @param hard  whether one of the media is none of soft tissue
INSONIFY_FN inline float scattered_back(bool hard, float cosine) {
    if (hard) return cosine * cosine;
    constexpr float mean_square_slope = 0.0717968F; // tan^2(15 degrees)
    const float squared = max(cosine * cosine, 1e-6F);
    return std::exp(0.5F * (1 - 1 / squared) / mean_square_slope) / (8 * mean_square_slope * squared * squared);
}

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
/// the triangle of `lobe_shape::aperture` blurred by the Fresnel zone. `lobe_shape::exact` is this integral,
/// `lobe_shape::aperture` its limit for short wavelengths. With x = 2 phi sqrt(d / wavelength) and p = 2 psi sqrt(d /
/// wavelength), two integrations by parts give the triangle and three edge waves,
///
///     L(phi) = |e(x)| / |e(0)|,   e(x) = (1 - i) max(0, p - |x|) - w(x + p) + 2 w(x) - w(x - p)
///     w(x) = (x g(x) + i (1/pi - x f(x))) exp(-i pi x^2 / 2)   for x >= 0,   w(-x) = w(x)
///
/// where f and g are the auxiliary functions of the Fresnel integrals. Angles are assumed small.
///
/// This is for a single frequency f. `lobe_shape::pulse` averages e(x) / f over the spectrum of a pulse of 2.5 cycles,
/// whatever the probe's own, by Gauss-Hermite quadrature: at the carrier and at 1 +- 0.474 times it.
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
    enum class lobe_shape {
        aperture, ///< max(0, 1 - |phi| / psi), psi = atan(1 / (2 F)): overlap of the aperture and its mirror image
        exact,    ///< `aperture` with diffraction at its edges, in closed form, at a single frequency
        pulse     ///< `exact` averaged over the spectrum of a short pulse
    };

    lobe_shape lobe = lobe_shape::pulse; ///< shape of the lobe

    /// @param angle        phi: from the beam to the surface normal, in the plane of beam and aperture, radians
    /// @param fnumber      F: depth of the facet over the width of the aperture
    /// @param wavelengths  depth of the facet over the wavelength, above 0; used by `exact` and `pulse` only
    INSONIFY_FN float operator()(float angle, float fnumber, float wavelengths) const {
        const float edge = std::atan(1 / (2 * fnumber));
        if (lobe == lobe_shape::aperture) return max(0, 1 - std::fabs(angle) / edge);
        if (angle == 0) return 1;
        const auto at_frequency = [&](float relative, vec2& turned, vec2& straight) {
            const float scale = 2 * std::sqrt(wavelengths * relative), weight = 1 / relative;
            add_collected(scale * std::fabs(angle), scale * edge, weight, turned, straight);
        };
        vec2 turned{0, 0}, straight{0, 0};
        at_frequency(1, turned, straight);
        if (lobe == lobe_shape::pulse) {
            constexpr float deviation =
                1.7320508F * 0.644F / 2.3548F; // sqrt(3) sigma of the spectrum, over the carrier
            turned *= 4.0F;
            straight *= 4.0F;
            at_frequency(1 - deviation, turned, straight);
            at_frequency(1 + deviation, turned, straight);
        }
        return length(turned) / length(straight);
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
        const floats cycles = x * x * floats(0.25F); // of pi x^2 / 2
        const detail::turned_lanes<4> turn{cycles - floats_of<4>(floor_bits<4>(cycles + floats(0.5F)))};
        store(even * turn.x + odd * turn.y, real);
        store(odd * turn.x - even * turn.y, imaginary);
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
