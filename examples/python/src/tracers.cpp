// How sound travels: the tracers, and the mean of random paths.
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
        .member("paths_per_line", &path_settings::paths_per_line, "random paths; 0: every path")
        .member("rough_power", &path_settings::rough_power,
                "random paths: normals of rough surfaces are distributed as cos^rough_power")
        .member("seed", &path_settings::seed, "of random paths")
        .member("pairs", &path_settings::pairs, "whether sound also returns along a different path");
    settings_class<paths>(module, "paths", "Sound that is refracted, and reflected several times: a tracer.")
        .member("settings", &paths::settings, "how far it is followed");
    py::class_<path_estimate>(module, "path_estimate", "The mean of random estimates of the same lines.")
        .def(py::init<>())
        .def(
            "add",
            [](path_estimate& self, const iq_lines& lines, const std::string& policy) {
                run(policy, [&](const auto& chosen) { self.add(chosen, lines); });
            },
            py::arg("lines"), py::kw_only(), py::arg("policy") = "par", "Adds an estimate, of another seed.")
        .def_property_readonly("frames", &path_estimate::frames, "number of estimates")
        .def_property_readonly("mean", py::cpp_function(&path_estimate::mean, py::return_value_policy::copy),
                               "of all estimates: a copy")
        .def_property_readonly("standard_error", &path_estimate::standard_error, "of the mean, sample by sample");
}

} // namespace insonify_python
