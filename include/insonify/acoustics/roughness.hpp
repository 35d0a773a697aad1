#ifndef INSONIFY_ACOUSTICS_ROUGHNESS_HPP
#define INSONIFY_ACOUSTICS_ROUGHNESS_HPP

#include <insonify/acoustics/interface_law.hpp>
#include <cfloat>
#include <concepts>

/// What a rough surface takes from the mirror echo and scatters instead: Kirchhoff's approximation for heights that are
/// normally distributed, with the rms height h, the wave number k = 2 pi f / c of the medium before the interface and the
/// angle of incidence i.
///
/// Of the reflected energy R, the mirror keeps R exp(-4 k^2 h^2 cos^2 i); the rest is spread as by Lambert's law.
/// Source: Beckmann & Spizzichino, The Scattering of Electromagnetic Waves from Rough Surfaces, 1963.
namespace insonify::inline INSONIFY_ABI {

/// Rms height of an interface, metres: the larger roughness of the two media.
INSONIFY_FN inline float rms_height(const medium& before, const medium& after) {
    return greater(before.roughness, after.roughness);
}

/// Spread of the echo's phase over a rough interface, radians rms: 2 k h cos i.
INSONIFY_FN inline float phase_spread(const incidence& at) {
    const float wave_number = 2 * pi * at.frequency / at.before.sound_speed;
    return 2 * wave_number * rms_height(at.before, at.after) * at.cosine;
}

/// Factor on the amplitude of the mirror echo, 0 to 1: exp(-2 k^2 h^2 cos^2 i); exactly 1 where both media are smooth.
INSONIFY_FN inline float coherent_amplitude(const incidence& at) {
    const float spread = phase_spread(at);
    return std::exp(-spread * spread / 2);
}

/// Share of the reflected energy that the mirror echo loses and the surface scatters: 1 - exp(-4 k^2 h^2 cos^2 i).
INSONIFY_FN inline float diffuse_energy(const incidence& at) {
    const float spread = phase_spread(at);
    return -std::expm1(-spread * spread);
}

/// What a roughness law must say of a meeting with a surface: law.coherent(at), the factor on the amplitude of the mirror
/// echo, and law.diffuse(at), the share of the reflected energy that is scattered instead; both 0 to 1.
template <class Law>
concept roughness_law = requires(const Law& law, const incidence& at) {
    { law.coherent(at) } -> std::convertible_to<float>;
    { law.diffuse(at) } -> std::convertible_to<float>;
};

/// The usual one: `coherent_amplitude` and `diffuse_energy`.
struct kirchhoff {
    /// Factor on the amplitude of the mirror echo, 0 to 1.
    INSONIFY_FN float coherent(const incidence& at) const { return coherent_amplitude(at); }
    /// Share of the reflected energy that is scattered, 0 to 1.
    INSONIFY_FN float diffuse(const incidence& at) const { return diffuse_energy(at); }

    friend bool operator==(const kirchhoff&, const kirchhoff&) = default;
};

/// How a diffuse surface spreads what it scatters: power per steradian over intensity times area, cos i cos s / pi.
///
/// @param cosine_in   of the angle between the arriving sound and the normal, 0 to 1
/// @param cosine_out  of the angle between the scattered sound and the normal, 0 to 1
/// Source: Lambert's law; summed over the half space it gives the arriving power, cos i.
INSONIFY_FN constexpr float lambert_lobe(float cosine_in, float cosine_out) { return cosine_in * cosine_out / pi; }

/// A normal of the small facets that make up a rough surface, drawn at random: cos a = u^(1 / (s + 1)) from `normal`.
///
/// @param normal    of the surface as a whole, length 1
/// @param exponent  s: the density of directions falls as cos^s a; 0 is the whole half space, infinity a mirror
/// @param uniform   two independent numbers in [0, 1): u, and the share of the turn about `normal`
/// @return          length 1, in the half space of `normal`
/// Source: Mattausch & Goksel, Monte-Carlo ray tracing for ultrasound, 2016.
INSONIFY_FN inline vec3 perturbed_normal(vec3 normal, float exponent, vec2 uniform) {
    // By logarithms, so that sin^2 a = 1 - u^(2 / (s + 1)) keeps its digits for a nearly smooth surface.
    const float logarithm = std::log(greater(uniform.x, FLT_MIN)) / (exponent + 1);
    const float cosine = std::exp(logarithm);
    const float sine = std::sqrt(-std::expm1(2 * logarithm));
    const float azimuth = 2 * pi * uniform.y;
    const axes_across axes{normal};
    return cosine * normal + sine * (std::cos(azimuth) * axes.first + std::sin(azimuth) * axes.second);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
