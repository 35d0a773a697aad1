#ifndef INSONIFY_ACOUSTICS_ROUGHNESS_HPP
#define INSONIFY_ACOUSTICS_ROUGHNESS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/interface_law.hpp>
#include <cfloat>
#include <concepts>

namespace insonify::inline INSONIFY_ABI {

/// Rms height of a surface of which only the two media are known, metres: the larger `roughness` of the two.
INSONIFY_FN inline float rms_height(const medium& before, const medium& after) {
    return max(before.roughness, after.roughness);
}
/// Rms height of the surface that a wave meets, metres: its own where it is known. Tracers give the roughness of the object
/// whose surface it is, of higher priority than what it lies in: polished steel in rough muscle stays a mirror.
INSONIFY_FN inline float rms_height(const incidence& at) {
    return at.roughness < 0 ? rms_height(at.before, at.after) : at.roughness;
}

namespace detail {

/// Distance at which the diffuse echoes of a rough surface are independent, metres along the line: an eighth of the wavelength
/// c0 / f0. Convention.
INSONIFY_FN constexpr float surface_grain(float frequency) { return display_speed / (8 * frequency); }

} // namespace detail

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

namespace detail {

/// Power that a diffuse surface scatters per steradian, over incident intensity times area: cos i cos s / pi.
///
/// @param cosine_in   of the angle of incidence i, 0 to 1
/// @param cosine_out  of the angle s between the scattered wave and the normal, 0 to 1
/// Source: Lambert's law; the integral over the half space is the incident power, cos i.
INSONIFY_FN constexpr float lambert_lobe(float cosine_in, float cosine_out) { return cosine_in * cosine_out / pi; }

} // namespace detail

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
