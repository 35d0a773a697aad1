#ifndef INSONIFY_ACOUSTICS_PROPAGATION_HPP
#define INSONIFY_ACOUSTICS_PROPAGATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_path.hpp>

/// How the state of the wave changes within the layers of a line, by a model's `timing` and `attenuation`.
namespace insonify::inline INSONIFY_ABI::detail {

/// The loss at the peak of the pulse of a line by a model, dB; that of the carrier for models that state no other.
/// @param lost_db  that of the carrier
template <class Model>
INSONIFY_FN float pulse_loss(const Model& model, const traced_line& line, float lost_db) {
    if constexpr (requires { model.pulse_loss(line, lost_db); })
        return model.pulse_loss(line, lost_db);
    else
        return lost_db;
}

/// Sound passes through a layer to its end.
template <class Model>
INSONIFY_FN void pass(const Model& model, const traced_line& line, const layer& here, echo_path& path) {
    const medium& m = line.media[here.medium];
    path.shown += (here.end - here.begin) * displayed_stretch(model.timing, m);
    path.lost_db = path.lost_at(here.end - here.begin, model.attenuation(m, line.frequency));
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
