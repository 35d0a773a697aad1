#ifndef INSONIFY_ACOUSTICS_FOLLOW_SOUND_HPP
#define INSONIFY_ACOUSTICS_FOLLOW_SOUND_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/acoustics/line_refraction.hpp>
#include <insonify/core/units.hpp>
#include <cmath>
#include <cstddef>

/// How the state of the wave changes within the layers of a line, by a model's `timing` and `attenuation`.
namespace insonify::inline INSONIFY_ABI::detail {

/// The loss at the peak of the pulse of a line by a model, dB; that of the carrier for models that state no other.
/// @param loss_db  that of the carrier
template <class Model>
INSONIFY_FN float pulse_loss(const Model& model, const traced_line& line, float loss_db) {
    if constexpr (requires { model.pulse_loss(line, loss_db); })
        return model.pulse_loss(line, loss_db);
    else
        return loss_db;
}

/// Sound passes through a layer to its end.
template <class Model>
INSONIFY_FN void pass(const Model& model, const traced_line& line, const layer& here, echo_path& path) {
    const medium& m = line.media[here.medium];
    path.shown += (here.end - here.begin) * displayed_stretch(model.timing, m);
    path.loss_db = path.lost_at(here.end - here.begin, model.attenuation(m, line.frequency));
}

/// The fraction of the power of a strip of the beam that passes beside a layer which is narrow out of the slice plane, such as
/// a needle, a wire or a small ball; 0 where it is wide, as bone and plates are.
///
/// The layer's section out of the slice plane is the ellipse that has, at the line, its thickness T and the first and second
/// derivatives T' and T'' of that by the height y, which follow from slope and curvature of the two surfaces. T(y)^2 is then a
/// polynomial of degree two, and its zeros are the sides of the section:
///
///     y = T (T' +- sqrt(-T T'')) / -(T'^2 + T T'')
///
/// Of a strip with the power exp(-y^2 / s^2), what lies outside them passes. Facets do not curve: an obstacle whose normals are
/// not smooth lets nothing pass.
/// @param obstacle  a layer between two surfaces that are the object's own
/// @param behind    the next one
/// @param strip     s, metres
INSONIFY_FN inline float power_beside(const layer& obstacle, const layer& behind, float strip) {
    const float thickness = obstacle.end - obstacle.begin;
    const float first = obstacle.slope.y - behind.slope.y; // a slope is the negative derivative of the depth
    const float bend = thickness * (obstacle.curvature.y - behind.curvature.y), open = bend - first * first;
    if (!(strip > 0) || !(open > 0)) return 0;
    const float root = std::sqrt(bend), per_strip = thickness / (open * strip);
    return 0.5F * (std::erfc((root + first) * per_strip) + std::erfc((root - first) * per_strip));
}

/// Adds the sound that passes beside a narrow obstacle in the strip of the beam that the line stands for to what passes through
/// it: by power, and at the mean time. What lets half of the amplitude through is no obstacle.
/// @param above  in front of the obstacle
/// @param below  behind it
/// @return       whether any was added
template <class Model>
INSONIFY_FN bool add_sound_beside(const Model& model, const traced_line& line, const layer& obstacle,
                                  const layer& behind, const echo_path& above, echo_path& below) {
    if (!(obstacle.own_surfaces.x > 0) || !(obstacle.own_surfaces.y > 0) || above.passed == 0) return false;
    layer tissue = obstacle; // beside it
    tissue.medium = behind.medium;
    echo_path around = above; // straight on
    around.refraction.enters_at = 0;
    pass(model, line, tissue, around);
    const float through = below.passed / above.passed *
                          amplitude_of_decibels(min(
                              pulse_loss(model, line, around.loss_db) - pulse_loss(model, line, below.loss_db), 300));
    if (!(through < 0.5F)) return false;
    const float beside = power_beside(obstacle, behind, line.aperture.strip(0.5F * (above.shown + around.shown)));
    if (beside == 0) return false;
    const float power = (1 - beside) * through * through + beside;
    below.shown += beside / power * (around.shown - below.shown);
    below.loss_db = around.loss_db;
    below.refraction.enters_at = 0; // what passes beside it arrives straight
    below.passed = above.passed * std::sqrt(power);
    return true;
}

/// Follows sound along a line from layer to layer: for the echoes that a model emits, and for what arrives at each depth.
/// @param at_surface  at_surface(i, here, path): the transmission into layer i, there and back; called where it is of another
///                    medium than the layer above, at whose end `path` lies
/// @param in_layer    in_layer(i, here, path): called at the beginning of each layer; false ends the walk
template <class Model, class AtSurface, class InLayer>
INSONIFY_FN void follow_sound(const Model& model, const traced_line& line, const AtSurface& at_surface,
                              const InLayer& in_layer) {
    echo_path path{}, above{}; // at the end of the layer before, and of the one before that
    line_refraction<Model> refraction{model, line};
    for (std::size_t i = 0; i < line.layers.size(); ++i) {
        layer here = line.layers[i];
        echo_path entered = path;
        entered.refraction = refraction.next();
        entered.gains = path.gains.next(line.gains, here, line.media[here.medium]);
        if (here.medium != entered.refraction.before) {
            here.cosine = entered.refraction.cosine;
            entered.passed *= at_surface(i, here, path);
            if (add_sound_beside(model, line, line.layers[i - 1], here, above, entered) &&
                entered.gains.at_steps.empty())
                entered.gains.before = {}; // the gains within an obstacle do not hold for what passes beside it
        }
        above = path;
        path = entered;
        if (!in_layer(i, here, path)) return;
        pass(model, line, here, path);
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
