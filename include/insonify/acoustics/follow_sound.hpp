#ifndef INSONIFY_ACOUSTICS_FOLLOW_SOUND_HPP
#define INSONIFY_ACOUSTICS_FOLLOW_SOUND_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/line_refraction.hpp>
#include <insonify/acoustics/narrow_obstacle.hpp>
#include <insonify/acoustics/propagation.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

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
