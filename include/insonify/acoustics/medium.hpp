#ifndef INSONIFY_ACOUSTICS_MEDIUM_HPP
#define INSONIFY_ACOUSTICS_MEDIUM_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/core/units.hpp>
#include <insonify/core/view.hpp>
#include <insonify/tissue/structure.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Sound speed that scanners assume, c0, m/s: an echo that arrives after time t is displayed at depth c0 t / 2.
inline constexpr float display_speed = 1540;

/// Standard deviation of a Gaussian pulse envelope along displayed depth, metres: 0.1874 c0 / (B f0).
/// @param bandwidth  B, of the amplitude spectrum at -6 dB, as a fraction of the frequency
/// @param frequency  f0, hertz
INSONIFY_FN constexpr float axial_sigma(float bandwidth, float frequency) {
    return 0.1874F * display_speed / (bandwidth * frequency);
}

/// Default number of samples of a line: two per standard deviation of the pulse envelope, rounded up to a multiple of
/// 64.
/// @param sigma  standard deviation of the pulse envelope, metres
INSONIFY_FN inline std::uint32_t samples_for(float depth, float sigma) {
    return 64 * static_cast<std::uint32_t>(clamp(std::ceil(2 * depth / sigma / 64), 1, 16384));
}

/// Acoustic properties of an object. By default a medium is lossless, anechoic and specular.
struct medium {
    float density = 998;             ///< kg/m^3; the defaults are those of water at 20 degrees Celsius
    float sound_speed = 1482;        ///< m/s
    float attenuation = 0;           ///< dB/m at 1 MHz, one way
    float attenuation_power = 1;     ///< exponent b of the frequency: attenuation grows as f^b
    float backscatter = 0;           ///< echo amplitude of its speckle relative to liver; 0: anechoic
    float roughness = 0;             ///< rms height of its surface, metres; 0: specular
    float scatterer_density = 0;     ///< scatterers per m^3, for `poisson_scatterers`; 0: that field's default
    insonify::structure structure{}; ///< above the scale of speckle; none by default
    bool flowing = false;            ///< its speckle is independent from frame to frame, as that of flowing blood

    /// Characteristic acoustic impedance, rayl = kg/(m^2 s): density times sound speed.
    INSONIFY_FN constexpr float impedance() const { return density * sound_speed; }

    friend bool operator==(const medium&, const medium&) = default;
};

/// Displayed depth per metre of the medium: c0 / c, but at most 1e6.
INSONIFY_FN inline float displayed_stretch(const medium& m) { return min(display_speed / m.sound_speed, 1e6F); }

/// True if every value is finite and in range: density, sound speed and impedance between 1e-18 and 1e18, so that
/// products and quotients of any two stay finite; the others 0 or more.
INSONIFY_FN inline bool is_valid(const medium& m) {
    const auto in_range = [](float value) { return 1e-18F < value && value < 1e18F; };
    return is_finite(m.density) && is_finite(m.sound_speed) && is_finite(m.attenuation) &&
           is_finite(m.attenuation_power) && is_finite(m.backscatter) && is_finite(m.roughness) &&
           is_finite(m.scatterer_density) && in_range(m.density) && in_range(m.sound_speed) &&
           in_range(m.impedance()) && m.attenuation >= 0 && m.attenuation_power >= 0 && m.backscatter >= 0 &&
           m.roughness >= 0 && m.scatterer_density >= 0 && is_valid(m.structure);
}

namespace detail {

/// Amplitude that an interface reflects at normal incidence: (Z2 - Z1) / (Z2 + Z1).
INSONIFY_FN inline float reflection(const medium& before, const medium& after) {
    return (after.impedance() - before.impedance()) / (after.impedance() + before.impedance());
}

/// Whether almost no sound passes from tissue into a medium of so small an impedance: gas, inflated lung.
INSONIFY_FN inline bool is_gas(const medium& m) { return m.impedance() < 3e5F; }
/// Whether any medium is.
inline bool has_gas(view<const medium> media) { return std::any_of(media.begin(), media.end(), is_gas); }
/// Whether almost no sound passes between tissue and this medium: gas, bone, metal.
INSONIFY_FN inline bool blocks_sound(const medium& m) { return m.impedance() > 3e6F || is_gas(m); }
inline constexpr float max_loss_of_tissue = 200; ///< dB/m at 1 MHz: tendon, the most absorbing soft tissue, has 180
/// Whether a medium is none of soft tissue: tendon, the hardest one, has an impedance of 2.0e6, trabecular bone 2.5e6.
INSONIFY_FN inline bool is_hard(const medium& m) { return m.impedance() > 2.2e6F || is_gas(m); }
/// Whether a medium is hard and absorbs what it does not reflect, as bone does and metal does not.
INSONIFY_FN inline bool is_bone(const medium& m) {
    return is_hard(m) && !is_gas(m) && m.attenuation > max_loss_of_tissue;
}

/// Distance at which the diffuse echoes of a rough surface are independent, metres along the line: an eighth of the
/// wavelength c0 / f0. Convention.
INSONIFY_FN constexpr float surface_grain(float frequency) { return display_speed / (8 * frequency); }

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
