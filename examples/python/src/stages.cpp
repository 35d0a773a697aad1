// The stages that do not depend on the type of the probe.
#include "bindings.hpp"

namespace insonify_python {

void bind_stages(py::module_& module) {
    module.def(
        "add_electronic_noise",
        [](const iq_lines& lines, const electronic_noise_settings& settings, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return add_electronic_noise(chosen, lines, settings); });
        },
        py::arg("lines"), py::arg_v("settings", electronic_noise_settings{}, "electronic_noise_settings()"),
        py::kw_only(), py::arg("policy") = "par_unseq", "Adds the noise of the receiver.");
    module.def(
        "to_rf",
        [](const iq_lines& lines, float frequency, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return to_rf(chosen, lines, frequency); });
        },
        py::arg("lines"), py::arg("frequency"), py::kw_only(), py::arg("policy") = "par_unseq",
        "The RF signal of complex echoes; needs four samples per cycle.");
    module.def(
        "envelope",
        [](const iq_lines& lines, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return envelope(chosen, lines); });
        },
        py::arg("lines"), py::kw_only(), py::arg("policy") = "par_unseq", "Amplitude of complex echoes.");
    module.def(
        "tgc",
        [](const scan_lines& lines, float frequency, const tgc_settings& settings, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return tgc(chosen, lines, frequency, settings); });
        },
        py::arg("lines"), py::arg("frequency"), py::arg_v("settings", tgc_settings{}, "tgc_settings()"), py::kw_only(),
        py::arg("policy") = "par_unseq", "Time-gain compensation.");
    module.def(
        "log_compress",
        [](const scan_lines& lines, const log_compress_settings& settings, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return log_compress(chosen, lines, settings); });
        },
        py::arg("lines"), py::arg_v("settings", log_compress_settings{}, "log_compress_settings()"), py::kw_only(),
        py::arg("policy") = "par_unseq", "From amplitude to brightness, 0 black to 1 white.");
    module.def(
        "map_grey",
        [](const scan_lines& lines, const grey_map& map, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return map_grey(chosen, lines, map); });
        },
        py::arg("lines"), py::arg("map"), py::kw_only(), py::arg("policy") = "par_unseq", "Applies a tone curve.");
    module.def(
        "scan_convert",
        [](const scan_lines& lines, const scan_map& map, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return scan_convert(chosen, lines, map); });
        },
        py::arg("lines"), py::arg("map"), py::kw_only(), py::arg("policy") = "par_unseq", "From lines to pixels.");
    module.def(
        "scan_convert",
        [](const label_lines& lines, const scan_map& map, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return scan_convert(chosen, lines, map); });
        },
        py::arg("lines"), py::arg("map"), py::kw_only(), py::arg("policy") = "par_unseq");
    module.def(
        "scan_convert_nearest",
        [](const scan_lines& lines, const scan_map& map, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return scan_convert_nearest(chosen, lines, map); });
        },
        py::arg("lines"), py::arg("map"), py::kw_only(), py::arg("policy") = "par_unseq",
        "Of values that must not be interpolated, such as angles.");

    py::class_<ground_truth_lines>(module, "ground_truth_lines", "Ground truth of every sample, as maps on one grid.")
        .def_readonly("label", &ground_truth_lines::label, "id of the object; background_label outside all")
        .def_readonly("medium", &ground_truth_lines::medium, "number of the medium")
        .def_readonly("surface", &ground_truth_lines::surface, "id of the object whose surface lies in the sample")
        .def_readonly("incidence", &ground_truth_lines::incidence, "radians between the beam and that surface's normal")
        .def_readonly("transmitted", &ground_truth_lines::transmitted,
                      "amplitude that arrives there and returns, 0 to 1")
        .def_readonly("depth", &ground_truth_lines::depth, "metres along the line");
}

} // namespace insonify_python
