#ifndef INSONIFY_ACOUSTICS_ECHO_PATH_HPP
#define INSONIFY_ACOUSTICS_ECHO_PATH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/attenuation.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/acoustics/line_refraction.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Depth at which an echo is displayed: by its travel time through the media, or as if all had `display_speed`.
enum class timing { sound_speed, uniform };

/// Angle of incidence on surfaces: the actual one, or normal incidence throughout.
enum class angle { oblique, normal };

/// Bandwidth of the pulse under attenuation: a single frequency, as of a long burst, or the spectrum of the pulse, which loses
/// less (`attenuated`). The downshift of its centre is neglected.
enum class pulse_bandwidth { narrow, broad };

/// State of the wave at a point of its path.
struct echo_path {
    float shown = 0;                      ///< displayed depth, metres
    float loss_db = 0;                    ///< attenuation so far, there and back, dB
    float passed = 1;                     ///< factor on amplitude of the interfaces so far, there and back
    detail::refracted_layer refraction{}; ///< of the present layer
    detail::layer_gains gains{};          ///< of the present layer

    /// Attenuation there and back, down to a point of the line, dB.
    /// @param along      metres below the beginning of the present layer
    /// @param per_metre  attenuation of its medium, there and back, dB/m
    INSONIFY_FN float lost_at(float along, float per_metre) const {
        return loss_db + per_metre * refraction.length(along);
    }
};

namespace detail {

/// Displayed depth per metre of a medium.
INSONIFY_FN inline float displayed_stretch(timing how, const medium& m) {
    return how == timing::sound_speed ? insonify::displayed_stretch(m) : 1.0F;
}

/// Standard deviation of the envelope of a pulse of 2.5 cycles, whose fractional bandwidth is 1.61 / 2.5; metres of displayed
/// depth.
INSONIFY_FN inline float nominal_sigma(float frequency) { return axial_sigma(0.644F, frequency); }

/// The same of the pulse of a line.
INSONIFY_FN inline float sigma_of(const traced_line& line) {
    return line.pulse_sigma > 0 ? line.pulse_sigma : nominal_sigma(line.frequency);
}

/// The loss at the peak of the pulse, dB; that of the carrier for a line that states neither bandwidth nor pulse.
/// @param loss_db  that of the carrier
INSONIFY_FN inline float peak_loss(pulse_bandwidth bandwidth, const traced_line& line, float loss_db) {
    if (bandwidth == pulse_bandwidth::narrow || !(max(line.bandwidth, line.pulse_sigma) > 0)) return loss_db;
    const float fractional =
        line.bandwidth > 0 ? line.bandwidth : axial_sigma(line.pulse_sigma, line.frequency); // its own inverse
    return attenuated(loss_db, line.frequency, fractional).loss_db;
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
