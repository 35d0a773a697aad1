// What lies along the lines of a probe.
#include "bindings.hpp"
#include <cstddef>

namespace insonify_python {

namespace {

/// The members of `layer` as the fields of a numpy array.
py::dtype fields_of_layer() {
    py::list names, formats, offsets;
    const auto add = [&](const char* name, const char* format, std::size_t offset) {
        names.append(name);
        formats.append(format);
        offsets.append(offset);
    };
    add("begin", "f4", offsetof(layer, begin));
    add("end", "f4", offsetof(layer, end));
    add("medium", "u4", offsetof(layer, medium));
    add("object", "u4", offsetof(layer, object));
    add("cosine", "f4", offsetof(layer, cosine));
    add("slope", "2f4", offsetof(layer, slope));
    add("curvature", "3f4", offsetof(layer, curvature));
    add("roughness", "f4", offsetof(layer, roughness));
    return {names, formats, offsets, static_cast<py::ssize_t>(sizeof(layer))};
}

/// @throws py::index_error  for a line or a plane that there is not
void check_place(const line_layers& found, std::uint32_t line, std::uint32_t plane) {
    const auto check = [](const std::string& name, std::uint32_t number, std::uint32_t count) {
        if (number >= count)
            throw py::index_error("line_layers: " + name + " " + std::to_string(number) + " is not one of the " +
                                  std::to_string(count) + ", counted from 0");
    };
    check("line", line, found.lines);
    check("plane", plane, found.planes);
}

py::array layers_of(const py::object& self, std::uint32_t line, std::uint32_t plane) {
    const auto& found = py::cast<const line_layers&>(self);
    check_place(found, line, plane);
    const view<const layer> along = found(line, plane);
    py::array made(fields_of_layer(), std::vector<py::ssize_t>{static_cast<py::ssize_t>(along.size())}, along.data(),
                   self);
    made.attr("setflags")(py::arg("write") = false);
    return made;
}

} // namespace

void bind_layers(py::module_& module) {
    py::class_<line_frame>(module, "line_frame", "Where a line runs, in the world.")
        .def_readonly("origin", &line_frame::origin, "on the face of the probe, metres")
        .def_readonly("along", &line_frame::along, "direction of propagation, length 1")
        .def_readonly("elevation", &line_frame::elevation, "normal of the slice plane, length 1")
        .def_readonly("tilt", &line_frame::tilt, "metres out of the slice plane per metre along the line")
        .def_property_readonly("path", &line_frame::path,
                               "displacement per metre of the line, longer than 1 where it tilts")
        .def("at", &line_frame::at, py::arg("distance"), "The point at a distance along the line, metres.");
    py::class_<line_layers> type{module, "line_layers",
                                 "What lies along every line of every elevation plane. A value: the scene may change "
                                 "afterwards."};
    bind_copies(type);
    type.def_readonly("lines", &line_layers::lines, "of the probe")
        .def_readonly("planes", &line_layers::planes, "the slice plane, then pairs to both sides of it")
        .def_property_readonly(
            "media", [](const line_layers& self) -> py::object { return py::tuple(py::cast(self.media)); },
            "of the scene, the background first")
        .def("__call__", &layers_of, py::arg("line"), py::arg("plane") = 0,
             "The layers of a line from the face on: an array with the fields begin, end, medium (an index into "
             "`media`), object, cosine, slope, curvature and roughness. A view without a copy, to be read only.")
        .def(
            "frame",
            [](const line_layers& self, std::uint32_t line, std::uint32_t plane) {
                check_place(self, line, plane);
                return self.frame(line, plane);
            },
            py::arg("line"), py::arg("plane") = 0, "Where a line runs.");
}

} // namespace insonify_python
