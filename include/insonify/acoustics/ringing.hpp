#ifndef INSONIFY_ACOUSTICS_RINGING_HPP
#define INSONIFY_ACOUSTICS_RINGING_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_line.hpp>
#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/interface_law.hpp>
#include <insonify/core/units.hpp>

/// Sound reverberates in a thin hard layer, such as a needle, and each time part of it leaves towards the probe: the echo of
/// the layer's far surface repeats at its thickness, a ladder of lines that grow fainter. Straight lines get it from here;
/// `paths` follows the sound itself. Layers more than 20 degrees from across the line do not ring.
namespace insonify::inline INSONIFY_ABI::detail {

/// The surface at which the present layer began.
struct layer_entry {
    float reflected = 0;             ///< there, from outside; 0: the probe's face
    float shown = 0;                 ///< displayed depth, metres
    float loss_db = 0;               ///< attenuation up to there, there and back, of the peak of the pulse, dB
    const layer* present = nullptr;  ///< which begins there
    const medium* outside = nullptr; ///< before it
};

/// Where the far surface of a layer is nearest to the probe, metres across the line; at most half of the thickness away.
INSONIFY_FN inline vec2 nearest_of(vec2 slope, vec2 curvature, float thickness) {
    const auto along = [&](float s, float bend) {
        return bend == 0 ? 0.0F : clamp(s / bend, -0.5F * thickness, 0.5F * thickness);
    };
    return {along(slope.x, curvature.x), along(slope.y, curvature.y)};
}

/// Makes an echo repeat that comes from the far surface of a layer.
///
///     ratio = r' r 10^(-loss / 20),   r' = -r of the near surface from outside
///
/// for each time that sound crosses the layer and returns. Where the surfaces are not parallel, each reflection turns it further: the ratio
/// takes the fraction of the first repetition that the aperture collects. The echo of a curved surface comes from where that is
/// nearest to the probe, so slopes, angles and thickness are those of that place: a needle rings alike in all planes that cut it.
/// @param far        the layer that begins at the far surface
/// @param inside     medium of the layer
/// @param behind     medium below it
/// @param stretch    displayed depth per metre inside
/// @param shown      displayed depth of the far surface, metres
/// @param loss_db    attenuation down to it, there and back, of the peak of the pulse, dB
/// @param reflected  r of the far surface
/// @param least      no layer rings whose ratio is smaller than this
/// @param collects   collects(slope): fractions that the aperture collects of a surface of this slope, as in `curved_echo`
/// @param reflects   reflects(before, after, cosine): r of an interface
template <class Collects, class Reflects>
INSONIFY_FN void add_repetitions(curved_echo& one, const layer_entry& near, const layer& far, const medium& inside,
                                 const medium& behind, float stretch, float shown, float loss_db, float reflected,
                                 float smallest, const Collects& collects, const Reflects& reflects) {
    constexpr float thickest = 2e-3F; // displayed: beyond, the beam has widened
    float step = shown - near.shown;
    if (near.reflected == 0 || !(step > 0) || step > thickest) return;
    vec2 near_slope = near.present->slope, far_slope = far.slope, whole = one.collected;
    float near_reflected = near.reflected;
    const float speeds = inside.sound_speed / near.outside->sound_speed;
    const vec2 near_bend{near.present->curvature.x, near.present->curvature.y}, bend{far.curvature.x, far.curvature.y},
        nearest = nearest_of(far_slope, bend, step / stretch);
    if (nearest != vec2{0, 0}) {
        step += stretch * dot(near_slope - far_slope + 0.5F * (bend - near_bend) * nearest, nearest);
        near_slope -= near_bend * nearest;
        far_slope -= bend * nearest;
        const float sine = std::sqrt(dot(near_slope, near_slope) / (1 + dot(near_slope, near_slope))),
                    sine_inside = speeds * sine;
        if (sine_inside >= 1) return;
        near_reflected = reflects(*near.outside, inside, std::sqrt(1 - sine * sine));
        reflected = reflects(inside, behind, std::sqrt(1 - sine_inside * sine_inside));
        whole = collects(far_slope);
    }
    // Beyond 20 degrees, or where a surface reflects totally, repetitions leave beside the line.
    constexpr float steepest = 0.36F, total = 0.9999F;
    if (dot(near_slope, near_slope) > steepest * steepest || dot(far_slope, far_slope) > steepest * steepest) return;
    if (std::fabs(near_reflected) > total || std::fabs(reflected) > total) return;
    const float ratio = -near_reflected * reflected * amplitude_of_decibels(min(near.loss_db - loss_db, 0));
    if (!(std::fabs(ratio) >= smallest)) return;
    // A wedge turns sound in the layer by twice its angle, and refraction changes that outside.
    const vec2 by = (far_slope - near_slope) / speeds;
    const vec2 collected = dot(by, by) < 1e-8F ? whole : collects(far_slope + by);
    const float first = whole.x * whole.y;
    one.repeat_ratio = ratio * (first > 0 ? min(collected.x * collected.y / first, 1) : 0);
    one.repeat_step = step;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
