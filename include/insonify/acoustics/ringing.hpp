#ifndef INSONIFY_ACOUSTICS_RINGING_HPP
#define INSONIFY_ACOUSTICS_RINGING_HPP

#include <insonify/acoustics/echo_line.hpp>
#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/interface_law.hpp>
#include <insonify/core/decibels.hpp>

/// Sound goes to and fro in a thin hard layer, such as a needle, and each time part of it leaves towards the probe: the echo of
/// the layer's far surface repeats at its thickness, a ladder of lines that grow fainter. Straight lines get it from here;
/// `paths` follows the sound itself. Layers more than 20 degrees from across the line do not ring.
namespace insonify::inline INSONIFY_ABI::detail {

/// The surface at which the present layer began.
struct layer_entry {
    float reflected = 0;               ///< there, from outside; 0: the probe's face
    float shown = 0;                   ///< displayed depth, metres
    float lost_db = 0;                 ///< attenuation up to there, there and back, dB
    vec2 slope{0, 0};                  ///< of the surface, as in `layer`
    float sound_speed = display_speed; ///< before it
};

/// Makes an echo repeat that comes from the far surface of a layer.
///
///     ratio = r' r 10^(-loss / 20),   r' = -r of the near surface from outside
///
/// for each time that sound goes to and fro. Where the surfaces are not parallel, each reflection turns it further: the ratio
/// takes the fraction of the first repetition that the aperture collects.
/// @param far_slope  of the far surface, as in `layer`
/// @param path       at the far surface
/// @param reflected  r of the far surface
/// @param least      no layer rings whose ratio is smaller than this
/// @param collects   collects(slope): fractions that the aperture collects of a surface of this slope, as in `curved_echo`
template <class Collects>
INSONIFY_FN void add_repetitions(curved_echo& one, const layer_entry& near, const medium& inside, vec2 far_slope,
                                 const echo_path& path, float reflected, float least, const Collects& collects) {
    constexpr float thickest = 2e-3F; // displayed: beyond, the beam has widened
    const float step = path.shown - near.shown;
    if (near.reflected == 0 || !(step > 0) || step > thickest) return;
    // Beyond 20 degrees, or where a surface reflects totally, repetitions leave beside the line.
    constexpr float steepest = 0.36F, total = 0.9999F;
    if (dot(near.slope, near.slope) > steepest * steepest || dot(far_slope, far_slope) > steepest * steepest) return;
    if (std::fabs(near.reflected) > total || std::fabs(reflected) > total) return;
    const float ratio = -near.reflected * reflected * amplitude_of_decibels(min(near.lost_db - path.lost_db, 0));
    if (!(std::fabs(ratio) >= least)) return;
    // A wedge turns sound in the layer by twice its angle, and refraction changes that outside.
    const vec2 by = (near.sound_speed / inside.sound_speed) * (far_slope - near.slope);
    const vec2 collected = dot(by, by) < 1e-8F ? one.collected : collects(far_slope + by);
    const float whole = one.collected.x * one.collected.y;
    one.repeat_ratio = ratio * (whole > 0 ? min(collected.x * collected.y / whole, 1) : 0);
    one.repeat_step = step;
}

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
