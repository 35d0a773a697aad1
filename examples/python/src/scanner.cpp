// The scanner, M-mode and callipers.
#include "any_scanner.hpp"

namespace insonify_python {

namespace {

/// The stored frames of a scanner, as a sequence.
struct stored_pictures {
    const any_scanner& of;
};

void bind_cine(py::module_& module) {
    py::class_<stored_picture>(module, "stored_frame",
                               "A frame of the cine loop: amplitudes, before they are displayed.")
        .def_readonly("at", &stored_picture::at, "pose of the probe")
        .def_readonly("time", &stored_picture::time, "time stamp, seconds")
        .def_readonly("amplitudes", &stored_picture::amplitudes, "after time gain and compounding");
    py::class_<stored_pictures>(module, "cine_loop", "The stored frames of a scanner, the newest first.")
        .def("__len__", [](const stored_pictures& self) { return self.of.stored(); })
        .def(
            "__getitem__",
            [](const stored_pictures& self, std::int64_t back) {
                const std::int64_t count = self.of.stored(), place = back < 0 ? back + count : back;
                if (place < 0 || place >= count)
                    throw py::index_error("cine: `back` is " + std::to_string(back) + ", and " + std::to_string(count) +
                                          " frames are stored");
                return self.of.stored(static_cast<std::uint32_t>(place));
            },
            py::arg("back"), "A copy of a frame; 0: the newest.");
    py::class_<stage_times>(module, "stage_times", "How long the stages of a frame took, seconds.")
        .def_readonly("trace", &stage_times::trace, "echoes, with all tables")
        .def_readonly("convolve", &stage_times::convolve, "near field, pulse and beam, electronic noise")
        .def_readonly("detect", &stage_times::detect, "envelope, time gain, compounding")
        .def_readonly("display", &stage_times::display, "logarithm, persistence, gray map, scan conversion")
        .def_readonly("total", &stage_times::total, "of `scan`, or of `show`");
}

void bind_measures(py::module_& module) {
    settings_class<m_mode_settings>(module, "m_mode_settings", "Size of an M-mode image.")
        .member("columns", &m_mode_settings::columns, "moments that are shown")
        .member("rows", &m_mode_settings::rows, "depths; 0: the samples of the lines")
        .member("background", &m_mode_settings::background, "brightness of moments before the first one");
    py::class_<m_mode>(module, "m_mode", "One line against time.")
        .def(py::init<const m_mode_settings&>(), py::arg_v("settings", m_mode_settings{}, "m_mode_settings()"))
        .def("add", &m_mode::add, py::arg("lines"), py::arg("line"), "Adds a line as the newest column.")
        .def_property_readonly("picture", &m_mode::picture, "an image; the newest column is at the right")
        .def_property_readonly("count", &m_mode::count, "columns that have been added")
        .def_property_readonly("depth", &m_mode::depth, "of the lower edge, metres");
    py::class_<outline_measure>(module, "outline_measure", "What is measured of an outline.")
        .def_readonly("area", &outline_measure::area, "square metres")
        .def_readonly("circumference", &outline_measure::circumference, "metres")
        .def_readonly("centroid", &outline_measure::centroid, "of the area, pixel coordinates");
    module.def("distance", &distance, py::arg("map"), py::arg("from_"), py::arg("to"),
               "Distance between two pixels, metres.");
    module.def(
        "measure_outline",
        [](const scan_map& map, const std::vector<vec2>& outline) { return measure_outline(map, outline); },
        py::arg("map"), py::arg("outline"), "Area and circumference of a polygon of pixel coordinates, N x 2.");
}

py::array_t<float> echo_beams(const any_scanner& self) {
    const std::vector<ray> beams = self.echo_beams();
    py::array_t<float> made{std::vector<py::ssize_t>{static_cast<py::ssize_t>(beams.size()), 2, 3}};
    float* to = made.mutable_data();
    for (const ray& beam : beams)
        for (const vec3 part : {beam.origin, beam.direction})
            for (int axis = 0; axis < 3; ++axis) *to++ = part[axis];
    return made;
}

} // namespace

void bind_scanner(py::module_& module) {
    bind_cine(module);
    bind_measures(module);
    const auto settings = py::return_value_policy::reference_internal;
    const auto copy = py::return_value_policy::copy;
    py::class_<any_scanner>(
        module, "scanner",
        "What an application holds: probe, settings and model, which may change between frames, and "
        "the memory of pictures. Not for two threads at once.")
        .def_property(
            "probe", [](const py::object& self) { return py::cast<any_scanner&>(self).probe(self); },
            &any_scanner::set_probe, "the transducer")
        .def_property(
            "settings", py::cpp_function(&any_scanner::settings, settings),
            [](any_scanner& self, const b_mode_settings& given) { self.settings() = given; }, "of the picture")
        .def_property(
            "model", py::cpp_function(&any_scanner::model, settings),
            [](any_scanner& self, const physical<>& given) { self.model() = given; }, "acoustics")
        .def_property(
            "how", [](const py::object& self) { return py::cast<any_scanner&>(self).how(self); }, &any_scanner::set_how,
            "how sound travels: straight_lines or paths")
        .def_property(
            "time", [](any_scanner& self) { return self.time(); },
            [](any_scanner& self, double seconds) { self.time() = seconds; }, "time stamp of the next frame, seconds")
        .def_property(
            "cine_length", [](any_scanner& self) { return self.cine_length(); },
            [](any_scanner& self, std::uint32_t frames) { self.cine_length() = frames; }, "number of stored frames")
        .def(
            "scan",
            [](any_scanner& self, const scene& body, const pose& at, const std::string& policy) {
                return self.scan(policy, body, at);
            },
            py::arg("scene"), py::arg("pose"), py::kw_only(), py::arg("policy") = "par_unseq",
            "Acquires a frame and draws it; shows the stored one while frozen.")
        .def(
            "show",
            [](any_scanner& self, std::uint32_t back, const std::string& policy) { return self.show(policy, back); },
            py::arg("back") = 0, py::kw_only(), py::arg("policy") = "par_unseq",
            "Draws a stored frame with the present gain, time gain, gray map, persistence and size; 0: the newest.")
        .def(
            "labels",
            [](any_scanner& self, const scene& body, const std::string& policy) { return self.labels(policy, body); },
            py::arg("scene"), py::kw_only(), py::arg("policy") = "par_unseq",
            "The object at each pixel of the last picture.")
        .def(
            "colour",
            [](any_scanner& self, const scene& body, const velocity_fields& field, const doppler_settings& with,
               const std::string& policy) { return self.colour(policy, body, field, with); },
            py::arg("scene"), py::arg("field"), py::arg_v("settings", doppler_settings{}, "doppler_settings()"),
            py::kw_only(), py::arg("policy") = "par_unseq",
            "Colour and power Doppler of what the last picture shows: its probe, pose, model and depth.")
        .def(
            "spectrum",
            [](any_scanner& self, const scene& body, const velocity_fields& field, const pulsed_doppler_settings& with,
               const std::string& policy) { return self.spectrum(policy, body, field, with); },
            py::arg("scene"), py::arg("field"),
            py::arg_v("settings", pulsed_doppler_settings{}, "pulsed_doppler_settings()"), py::kw_only(),
            py::arg("policy") = "par_unseq",
            "Pulsed Doppler of what the last picture shows: its probe, pose, model and depth.")
        .def_property_readonly(
            "cine", [](const any_scanner& self) { return stored_pictures{self}; }, py::keep_alive<0, 1>(),
            "the stored frames, the newest first")
        .def("freeze", &any_scanner::freeze, "Stops acquiring.")
        .def("unfreeze", &any_scanner::unfreeze, "Acquires again; persistence and compounding start anew.")
        .def_property_readonly("frozen", &any_scanner::frozen)
        .def("forget", &any_scanner::forget, "Persistence and compounding start anew with the next frame.")
        .def_property_readonly("picture", py::cpp_function(&any_scanner::picture, copy), "a copy of the last picture")
        .def_property_readonly("lines", py::cpp_function(&any_scanner::lines, copy),
                               "a copy of the brightness along the traced lines")
        .def_property_readonly("echoes", py::cpp_function(&any_scanner::echoes, copy),
                               "a copy of the complex echoes of the last frame's straight look, on lines of their own")
        .def_property_readonly("echo_beams", &echo_beams,
                               "origin and direction of each line of the echoes, lines x 2 x 3, in the probe's frame")
        .def_property_readonly("layers", py::cpp_function(&any_scanner::layers, copy),
                               "a copy of what lies along the lines of the look that was acquired last")
        .def_property_readonly("map", py::cpp_function(&any_scanner::map, settings),
                               "pixels of the last picture to points of the slice")
        .def_property_readonly("at", py::cpp_function(&any_scanner::at, copy),
                               "pose of the probe, for the last picture")
        .def_property_readonly("times", py::cpp_function(&any_scanner::times, copy), "of the last picture")
        .def("point", &any_scanner::point, py::arg("pixel"), "The point in the world that a pixel shows.")
        .def("pixel", &any_scanner::pixel, py::arg("point"), "The pixel coordinates of a point in the world.");
}

} // namespace insonify_python
