#ifndef INSONIFY_ACOUSTICS_PROPAGATION_HPP
#define INSONIFY_ACOUSTICS_PROPAGATION_HPP

#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/line_refraction.hpp>

/// How the state of the wave changes within the layers of a line, by a model's `timing` and `attenuation`.
namespace insonify::inline INSONIFY_ABI::detail {

/// Attenuation there and back in a medium, dB per metre of the line.
template <class Model>
INSONIFY_FN float loss_per_metre(const Model& model, const traced_line& line, const medium& m, const echo_path& path) {
    return path.refraction.length_factor * model.attenuation(m, line.frequency);
}

/// Sound enters a layer, without the transmission of its surface.
template <class Model>
INSONIFY_FN void enter(const Model& model, const traced_line& line, line_refraction<Model>& refraction,
                       const layer& here, echo_path& path) {
    path.refraction = refraction.next();
    if (path.refraction.saved != 0)
        path.lost_db =
            max(path.lost_db - path.refraction.saved * model.attenuation(line.media[here.medium], line.frequency), 0);
}

/// Sound passes through a layer to its end.
template <class Model>
INSONIFY_FN void pass(const Model& model, const traced_line& line, const layer& here, echo_path& path) {
    const medium& m = line.media[here.medium];
    path.shown += (here.end - here.begin) * displayed_stretch(model.timing, m);
    path.lost_db += (here.end - here.begin) * loss_per_metre(model, line, m, path);
}

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
