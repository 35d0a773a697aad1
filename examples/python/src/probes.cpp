// Probes and presets.
#include "bindings.hpp"

namespace insonify_python {

namespace {

template <class Probe>
settings_class<Probe> bind_probe(py::module_& module, const char* name, const char* page) {
    settings_class<Probe> bound{module, name, page};
    bound.member("lines", &Probe::lines, "scan lines of a frame")
        .member("frequency", &Probe::frequency, "carrier frequency, hertz")
        .member("fnumber", &Probe::fnumber, "depth over active aperture, in the lateral direction")
        .member("focus", &Probe::focus, "transmit focus, metres; 0: half the depth of the image")
        .member("elevation_height", &Probe::elevation_height, "height of the aperture, metres")
        .member("elevation_focus", &Probe::elevation_focus, "depth of the elevation focus, metres")
        .member("bandwidth", &Probe::bandwidth, "fractional bandwidth of echoes at -6 dB")
        .member("side_lobes", &Probe::side_lobes, "amplitude of the first side lobe; 0: none");
    bound.type()
        .def(
            "beam",
            [](const Probe& self, float line) {
                const ray beam = self.beam(line);
                return std::pair{beam.origin, beam.direction};
            },
            py::arg("line"), "Origin and direction of a line, in the frame of the probe; 0 is the first one.")
        .def("locate", &Probe::locate, py::arg("point"),
             "From {x, z} in the frame of the probe to the line and the depth along it.")
        .def_property_readonly("aperture", &Probe::aperture, "the largest active one, metres");
    return bound;
}

template <class Probe>
py::tuple pair_of(const examination<Probe>& one) {
    return py::make_tuple(one.probe, one.settings);
}

} // namespace

void bind_probes(py::module_& module) {
    bind_probe<linear_array>(module, "linear_array", "Flat array of parallel lines: for vessels, nerves and muscles.")
        .member("width", &linear_array::width, "width of the face, metres");
    bind_probe<convex_array>(module, "convex_array", "Curved array, its lines normal to the face: for the abdomen.")
        .member("radius", &convex_array::radius, "radius of the face, metres")
        .member("field_of_view", &convex_array::field_of_view, "angle between the ends of the face, radians");
    bind_probe<phased_array>(module, "phased_array",
                             "Small flat array that steers its lines from its centre: for the heart.")
        .member("width", &phased_array::width, "width of the face, metres")
        .member("field_of_view", &phased_array::field_of_view, "angle between the ends of the sector, radians");
    bind_probe<radial_array>(module, "radial_array", "Catheter that scans a full circle: for vessels, from inside.")
        .member("radius", &radial_array::radius, "radius of the face, metres");

    const auto copied = py::return_value_policy::copy;
    struct preset_table {};
    py::class_<preset_table>{module, "presets",
                             "Transducers, which are constants: copy.copy makes one that can be changed. Pairs of a "
                             "probe and its settings for an "
                             "examination: copies."}
        .def_property_readonly_static("l11_5v", [](const py::object&) { return constant(presets::l11_5v); })
        .def_property_readonly_static("l12_3v", [](const py::object&) { return constant(presets::l12_3v); })
        .def_property_readonly_static("c5_2v", [](const py::object&) { return constant(presets::c5_2v); })
        .def_property_readonly_static("p4_2v", [](const py::object&) { return constant(presets::p4_2v); })
        .def_property_readonly_static("l11_5v_elements",
                                      [](const py::object&) { return constant(presets::l11_5v_elements); })
        .def_property_readonly_static("l12_3v_elements",
                                      [](const py::object&) { return constant(presets::l12_3v_elements); })
        .def_property_readonly_static("c5_2v_elements",
                                      [](const py::object&) { return constant(presets::c5_2v_elements); })
        .def_property_readonly_static("p4_2v_elements",
                                      [](const py::object&) { return constant(presets::p4_2v_elements); })
        .def_property_readonly_static("nerve_block", [](const py::object&) { return pair_of(presets::nerve_block); })
        .def_property_readonly_static("abdomen", [](const py::object&) { return pair_of(presets::abdomen); })
        .def_property_readonly_static("heart", [](const py::object&) { return pair_of(presets::heart); })
        .def_property_readonly_static("intravascular",
                                      [](const py::object&) { return pair_of(presets::intravascular); })
        .def_property_readonly_static("clinical_grey",
                                      [](const py::object&) { return constant(presets::clinical_grey); })
        .def_static("in_use", &presets::in_use<linear_array>, py::arg("transducer"),
                    "A transducer with the pulse and the aperture of a scanner in use.")
        .def_static("in_use", &presets::in_use<convex_array>, py::arg("transducer"))
        .def_static("in_use", &presets::in_use<phased_array>, py::arg("transducer"))
        .def_static("settings_for", py::overload_cast<const linear_array&>(&presets::settings_for), copied,
                    py::arg("probe"), "Settings of the examination for which a kind of probe is made: a copy.")
        .def_static("settings_for", py::overload_cast<const convex_array&>(&presets::settings_for), copied,
                    py::arg("probe"))
        .def_static("settings_for", py::overload_cast<const phased_array&>(&presets::settings_for), copied,
                    py::arg("probe"))
        .def_static("settings_for", py::overload_cast<const radial_array&>(&presets::settings_for), copied,
                    py::arg("probe"));
}

} // namespace insonify_python
