// How sound travels: the tracers.
#include "bindings.hpp"

namespace insonify_python {

void bind_tracers(py::module_& module) {
    settings_class<straight_lines>(module, "straight_lines", "Sound that travels straight: the usual tracer.")
        .choice("search", &straight_lines::search,
                {{"best", line_search::best}, {"rays", line_search::rays}, {"slices", line_search::slices}},
                "how surfaces are found")
        .member("directions", &straight_lines::directions, "lines to each point, 1 to 64; 1: only the straight one");
    settings_class<path_settings>(module, "path_settings", "How far sound is followed.")
        .member("bounces", &path_settings::bounces, "reflections before the last echo, at most")
        .member("min_amplitude", &path_settings::min_amplitude, "paths that would return less are dropped")
        .member("face_reflection", &path_settings::face_reflection, "of the probe's face, as pressure amplitude")
        .member("pairs", &path_settings::pairs, "whether sound also returns along a different path");
    settings_class<paths>(module, "paths", "Sound that is refracted, and reflected several times: a tracer.")
        .member("settings", &paths::settings, "how far it is followed");
}

} // namespace insonify_python
