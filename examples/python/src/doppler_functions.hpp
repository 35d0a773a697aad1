#ifndef INSONIFY_PYTHON_DOPPLER_FUNCTIONS_HPP
#define INSONIFY_PYTHON_DOPPLER_FUNCTIONS_HPP

#include "any_scanner.hpp"

namespace insonify_python {

template <class Probe, class Tracer>
flow_lines scanner_doppler<Probe, Tracer>::colour(machine& own, const std::string& policy, const scene& body,
                                                  const velocity_fields& field, const doppler_settings& settings) {
    return run(policy, [&](const auto& chosen) { return own.colour(chosen, body, field, settings); });
}
template <class Probe, class Tracer>
doppler_spectrum scanner_doppler<Probe, Tracer>::spectrum(machine& own, const std::string& policy, const scene& body,
                                                          const velocity_fields& field,
                                                          const pulsed_doppler_settings& settings) {
    return run(policy, [&](const auto& chosen) { return own.spectrum(chosen, body, field, settings); });
}

/// Doppler functions that depend on the type of the probe, as overloads.
template <class Probe>
void bind_doppler_functions(py::module_& module) {
    module.def(
        "colour_doppler",
        [](const scene& body, const Probe& probe, const pose& at, const velocity_fields& field,
           const doppler_settings& settings, const physical<>& model, const std::string& policy) {
            return run(policy, [&](const auto& chosen) {
                return colour_doppler(chosen, body, probe, at, model, field, settings);
            });
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"), py::arg("field"),
        py::arg_v("settings", doppler_settings{}, "doppler_settings()"), py::kw_only(),
        py::arg_v("model", physical<>{}, "physical()"), py::arg("policy") = "par_unseq",
        "Velocity, power and variance of what moves, along the lines of the probe.");
    module.def(
        "pulsed_doppler",
        [](const scene& body, const Probe& probe, const pose& at, const velocity_fields& field,
           const pulsed_doppler_settings& settings, const physical<>& model, const std::string& policy) {
            return run(policy, [&](const auto& chosen) {
                return pulsed_doppler(chosen, body, probe, at, model, field, settings);
            });
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"), py::arg("field"), py::arg("settings"), py::kw_only(),
        py::arg_v("model", physical<>{}, "physical()"), py::arg("policy") = "par_unseq",
        "The spectrum of a gate on one line against time.");
    module.def(
        "doppler_ensemble",
        [](const scene& body, const Probe& probe, const pose& at, const velocity_fields& field,
           const ensemble_settings& settings, const physical<>& model, const std::string& policy) {
            return run(policy, [&](const auto& chosen) {
                return doppler_ensemble(chosen, body, probe, at, model, field, settings);
            });
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"), py::arg("field"),
        py::arg_v("settings", ensemble_settings{}, "ensemble_settings()"), py::kw_only(),
        py::arg_v("model", physical<>{}, "physical()"), py::arg("policy") = "par_unseq",
        "The echoes of a pulse train, after pulse and beam.");
    module.def(
        "doppler_picture",
        [](const flow_lines& lines, const Probe& probe, const doppler_picture_settings& settings,
           const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return doppler_picture(chosen, lines, probe, settings); });
        },
        py::arg("lines"), py::arg("probe"),
        py::arg_v("settings", doppler_picture_settings{}, "doppler_picture_settings()"), py::kw_only(),
        py::arg("policy") = "par_unseq", "Velocity of each pixel, m/s; 0 where there is no flow.");
    module.def(
        "colour_overlay",
        [](const image& grey, const flow_lines& lines, const Probe& probe, const colour_overlay_settings& settings,
           const std::string& policy) {
            return run(policy,
                       [&](const auto& chosen) { return colour_overlay(chosen, grey, lines, probe, settings); });
        },
        py::arg("grey"), py::arg("lines"), py::arg("probe"),
        py::arg_v("settings", colour_overlay_settings{}, "colour_overlay_settings()"), py::kw_only(),
        py::arg("policy") = "par_unseq", "Colour over a B-mode image of the same probe and depth.");
}

} // namespace insonify_python
#endif
