#ifndef INSONIFY_PYTHON_PROBE_FUNCTIONS_HPP
#define INSONIFY_PYTHON_PROBE_FUNCTIONS_HPP

#include "any_scanner.hpp"
#include "scene_past.hpp"
#include <algorithm>
#include <optional>

namespace insonify_python {

/// The functions that depend on the type of the probe, as overloads. Each type has a file of its own, for they take the
/// compiler most of its time.
template <class Probe>
void bind_probe_functions(py::module_& module) {
    module.def(
        "b_mode",
        [](const scene& body, const Probe& probe, const pose& at, const b_mode_settings& settings,
           const physical<>& model, const any_tracer& how, const std::string& policy) {
            const auto draw = [&](const auto& own) {
                return run(policy,
                           [&](const auto& chosen) { return b_mode(chosen, body, probe, at, model, settings, own); });
            };
            return std::visit(draw, how);
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"),
        py::arg_v("settings", b_mode_settings{}, "b_mode_settings()"), py::kw_only(),
        py::arg_v("model", physical<>{}, "physical()"), py::arg_v("how", straight_lines{}, "straight_lines()"),
        py::arg("policy") = "par_unseq", "A B-mode image: the whole chain in one call.");
    module.def(
        "sampling_of", [](const Probe& probe, const b_mode_settings& settings) { return sampling_of(probe, settings); },
        py::arg("probe"), py::arg("settings"), "Lines, samples, planes and looks that a picture traces.");
    module.def(
        "trace",
        [](const scene& body, const Probe& probe, const pose& at, const physical<>& model, const acquisition& settings,
           const any_tracer& how, const std::string& policy) {
            const auto follow = [&](const auto& own) {
                return run(policy,
                           [&](const auto& chosen) { return trace(chosen, body, probe, at, model, settings, own); });
            };
            return std::visit(follow, how);
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"), py::arg("model"), py::arg("settings"),
        py::arg_v("how", straight_lines{}, "straight_lines()"), py::kw_only(), py::arg("policy") = "par_unseq",
        "What the probe receives along its lines, before `convolve`.");
    module.def(
        "find_layers",
        [](const scene& body, const Probe& probe, const pose& at, const acquisition& scan, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return find_layers(chosen, body, probe, at, scan); });
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"), py::arg("scan"), py::kw_only(),
        py::arg("policy") = "par_unseq",
        "What lies along the lines of a probe, in every elevation plane; `scan.samples` has no effect.");
    module.def(
        "convolve",
        [](const iq_lines& echoes, const Probe& probe, const std::string& policy) {
            return run(policy,
                       [&](const auto& chosen) { return convolve(chosen, echoes, nominal_pulse(probe), probe); });
        },
        py::arg("echoes"), py::arg("probe"), py::kw_only(), py::arg("policy") = "par_unseq",
        "Convolves traced echoes with the pulse and the beam of the probe.");
    module.def(
        "make_scan_map",
        [](const Probe& probe, const acquisition& scan, const scan_convert_settings& settings,
           const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return make_scan_map(chosen, probe, scan, settings); });
        },
        py::arg("probe"), py::arg("scan"), py::arg_v("settings", scan_convert_settings{}, "scan_convert_settings()"),
        py::kw_only(), py::arg("policy") = "par_unseq", "The interpolation table of scan_convert.");
    module.def(
        "ground_truth",
        [](const scene& body, const Probe& probe, const pose& at, const label_settings& settings,
           const physical<>& model, const std::string& policy) {
            return run(policy,
                       [&](const auto& chosen) { return ground_truth(chosen, body, probe, at, model, settings); });
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"), py::arg("settings"), py::kw_only(),
        py::arg_v("model", physical<>{}, "physical()"), py::arg("policy") = "par_unseq",
        "Labels, surfaces, angles, shadows and depths of a frame.");
    module.def(
        "diagnose",
        [](const scene& body, const Probe& probe, const pose& at, const acquisition& scan) {
            return diagnose(body, probe, at, scan).sentence;
        },
        py::arg("scene"), py::arg("probe"), py::arg("pose"), py::arg("scan"), py::call_guard<py::gil_scoped_release>(),
        "Why a picture is empty, in a sentence; empty where nothing is wrong.");
    if constexpr (!std::is_same_v<Probe, radial_array>) { // it lies within a vessel, on no skin
        module.def(
            "add_skin",
            [](scene& own, const Probe& probe, const pose& at, float thickness, float fat, float gel) {
                const py::object body = py::cast(&own);
                const std::optional<object_id> outer = insonify::detail::find_outer(own); // it is replaced
                if (outer && !insonify::detail::has_skin(own)) check_not_held(body, *outer, "add_skin");
                const skin_place place = add_skin(own, probe, at, {.thickness = thickness, .fat = fat, .gel = gel});
                if (place == skin_place::surface) note_remove(body, *outer);
                return place == skin_place::none ? "none" : place == skin_place::surface ? "surface" : "face";
            },
            py::arg("scene"), py::arg("probe"), py::arg("pose"), py::kw_only(),
            py::arg("thickness") = skin_settings{}.thickness, py::arg("fat") = skin_settings{}.fat,
            py::arg("gel") = skin_settings{}.gel,
            "Covers a body whose meshes begin below the skin, before it is built.\n"
            "`thickness` of skin, `fat` below it and `gel` above it, metres. Returns what was covered:\n"
            "the outer \"surface\" of the body, what lies below the \"face\" of the probe, or \"none\" where it has "
            "skin.");
        module.def(
            "press",
            [](const scene& body, const Probe& probe, const pose& at, const press_settings& settings,
               const std::optional<std::vector<object_id>>& only, const std::vector<object_id>& is_stiff) {
                const auto contains = [](const std::vector<object_id>& ids, object_id id) {
                    return std::find(ids.begin(), ids.end(), id) != ids.end();
                };
                return press(
                    body, probe, at, settings, [&](object_id id) { return !only || contains(*only, id); },
                    [&](object_id id) { return contains(is_stiff, id); });
            },
            py::arg("scene"), py::arg("probe"), py::arg("pose"),
            py::arg_v("settings", press_settings{}, "press_settings()"), py::arg("only") = py::none(), py::kw_only(),
            py::arg("is_stiff") = std::vector<object_id>{}, py::call_guard<py::gil_scoped_release>(),
            "How a probe touches a body at rest. `only`: the ids of the objects that belong to the body; `is_stiff`: "
            "of\n"
            "those that do not give way, such as bone.");
    }
    py::reinterpret_borrow<py::class_<any_scanner>>(module.attr("scanner"))
        .def(
            py::init([](const Probe& probe, const b_mode_settings& settings, const physical<>& model,
                        const any_tracer& how) {
                return std::visit(
                    [&]<class Tracer>(const Tracer& own) {
                        return std::unique_ptr<any_scanner>(new scanner_of<Probe, Tracer>{probe, settings, model, own});
                    },
                    how);
            }),
            py::arg("probe"), py::arg_v("settings", b_mode_settings{}, "b_mode_settings()"),
            py::arg_v("model", physical<>{}, "physical()"), py::arg_v("how", straight_lines{}, "straight_lines()"));
}

} // namespace insonify_python
#endif
