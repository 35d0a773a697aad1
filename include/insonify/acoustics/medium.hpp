#ifndef INSONIFY_ACOUSTICS_MEDIUM_HPP
#define INSONIFY_ACOUSTICS_MEDIUM_HPP

#include <insonify/core/math.hpp>
#include <insonify/core/units.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The speed that a scanner assumes everywhere: an echo after time t is displayed at depth display_speed * t / 2, m/s.
inline constexpr float display_speed = 1540;

/// Standard deviation along the displayed depth of the echo of a Gaussian pulse, metres: 0.1874 c0 / (B f0).
/// @param bandwidth  B, of the amplitude spectrum at -6 dB, as a share of the frequency
INSONIFY_FN constexpr float axial_sigma(float bandwidth, float frequency) {
    return 0.1874F * display_speed / (bandwidth * frequency);
}

/// Samples for a line that is to be convolved with a pulse: two for each deviation of it, a multiple of 64.
INSONIFY_FN inline std::uint32_t samples_for(float depth, float sigma) {
    return 64 * static_cast<std::uint32_t>(clamped(std::ceil(2 * depth / sigma / 64), 1, 16384));
}

/// What sound meets inside an object. A medium of your own is smooth and silent unless you say otherwise.
struct medium {
    float density = 998;         ///< kg/m^3; the defaults are those of water at 20 degrees Celsius
    float sound_speed = 1482;    ///< m/s
    float attenuation = 0;       ///< dB/m at 1 MHz, one way
    float attenuation_power = 1; ///< attenuation grows as frequency^attenuation_power
    float backscatter = 0;       ///< amplitude of the echo of its texture, relative to liver
    float roughness = 0;         ///< rms height of its surface, metres
    float scatterer_density = 0; ///< in a cubic metre, for `poisson_scatterers`; 0: as many as that field says

    /// Characteristic acoustic impedance, rayl = kg/(m^2 s): density times sound speed, never stored.
    INSONIFY_FN constexpr float impedance() const { return density * sound_speed; }

    friend bool operator==(const medium&, const medium&) = default;
};

/// Metres of displayed depth a metre of the medium: c0 / c, but at most 1e6, for media where sound all but stands still.
INSONIFY_FN inline float displayed_stretch(const medium& m) { return lesser(display_speed / m.sound_speed, 1e6F); }

/// True where every value is finite and in its range: density, speed and impedance above 1e-18 and below 1e18, so that
/// laws may add, multiply and divide any two of them; the others not below 0.
INSONIFY_FN inline bool is_valid(const medium& m) {
    const auto usual = [](float value) { return 1e-18F < value && value < 1e18F; };
    return is_finite(m.density) && is_finite(m.sound_speed) && is_finite(m.attenuation) &&
           is_finite(m.attenuation_power) && is_finite(m.backscatter) && is_finite(m.roughness) &&
           is_finite(m.scatterer_density) && usual(m.density) && usual(m.sound_speed) && usual(m.impedance()) &&
           m.attenuation >= 0 && m.attenuation_power >= 0 && m.backscatter >= 0 && m.roughness >= 0 &&
           m.scatterer_density >= 0;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
