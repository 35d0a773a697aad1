// Lines of tubes, and the meshes made of arrays of points: tubes and sheets.
#include "tube_lines.hpp"

namespace insonify_python {

namespace {

void require_line(const sectioned_line& line) {
    if (line.own.empty())
        throw usage_error{
            "centre_line: there is no line yet; make one of the sections of a tube: centre_line(sections)"};
}

mesh tube_of(const float_array& line, std::uint32_t segments, const std::string& ends, vec3 across) {
    using end_shape = tube_settings::end_shape;
    if (ends != "round" && ends != "flat")
        throw usage_error{"make_tube: `ends` cannot be '" + ends + "'; it is one of round, flat"};
    return make_tube(
        sections_of(line, "make_tube: the line"),
        {.segments = segments, .ends = ends == "flat" ? end_shape::flat : end_shape::round, .across = across});
}

/// @param thickness  one number, or one for each point
mesh sheet_of(float_array points, const float_array& thickness) {
    if (points.ndim() != 3 || points.shape(2) != 3)
        throw usage_error{"make_sheet: the points must be an array of rows x columns x 3 numbers"};
    const bool is_even = thickness.ndim() == 0;
    if (!is_even &&
        (thickness.ndim() != 2 || thickness.shape(0) != points.shape(0) || thickness.shape(1) != points.shape(1)))
        throw usage_error{
            "make_sheet: the thickness must be one number, or an array of rows x columns like the points"};
    const auto columns = static_cast<std::uint32_t>(points.shape(1));
    std::vector<sheet_point> sheet;
    for (const vec3& at : rows_of(points.reshape({-1, 3}), "make_sheet: the points"))
        sheet.push_back({at, thickness.data()[is_even ? 0 : sheet.size()]});
    return make_sheet(sheet, columns);
}

} // namespace

std::vector<tube_section> sections_of(const float_array& rows, const char* what) {
    if (rows.ndim() != 2 || rows.shape(1) < 4 || rows.shape(1) > 6)
        throw usage_error{std::string{what} + " must be an array of N x 4 numbers: x, y and z of the centre and the "
                                              "radius; of N x 5 with both radii; or of N x 6 with the turn, too"};
    const auto row = rows.unchecked<2>();
    std::vector<tube_section> sections;
    for (py::ssize_t i = 0; i < rows.shape(0); ++i)
        sections.push_back({.centre = {row(i, 0), row(i, 1), row(i, 2)},
                            .radii = {row(i, 3), row(i, rows.shape(1) > 4 ? 4 : 3)},
                            .turn = rows.shape(1) > 5 ? row(i, 5) : 0});
    return sections;
}

float_array array_of_sections(const std::vector<tube_section>& sections) {
    float_array rows({static_cast<py::ssize_t>(sections.size()), py::ssize_t{6}});
    float* to = rows.mutable_data();
    for (const tube_section& one : sections)
        for (const float number : {one.centre.x, one.centre.y, one.centre.z, one.radii.x, one.radii.y, one.turn})
            *to++ = number;
    return rows;
}

sectioned_line line_of(const given_line& given) {
    if (const sectioned_line* const line = std::get_if<sectioned_line>(&given)) return *line;
    std::vector<tube_section> sections = sections_of(std::get<float_array>(given), "centre_line: the sections");
    centre_line own{sections};
    return {std::move(sections), vec3{0, 0, 0}, std::move(own)};
}

void bind_tubes(py::module_& module) {
    py::class_<line_place>(module, "line_place", "A tube at one place of its line.")
        .def_readonly("centre", &line_place::centre, "on the line, metres")
        .def_readonly("along", &line_place::along, "of length 1, likewise the axes of the ellipse across")
        .def_readonly("first_axis", &line_place::first_axis)
        .def_readonly("second_axis", &line_place::second_axis)
        .def_readonly("radii", &line_place::radii, "of the ellipse, metres")
        .def("squared", &line_place::squared, py::arg("point"),
             "Square of the distance of a point from the line over that of the wall: 1 on the wall.")
        .def_property_readonly("area", &line_place::area, "of the ellipse, m^2");
    py::class_<sectioned_line> line{module, "centre_line", "The course of a tube that bends: sections along a line."};
    const auto made_of = [](const float_array& sections, vec3 across) {
        std::vector<tube_section> own = sections_of(sections, "centre_line: the sections");
        centre_line course{own, across};
        return sectioned_line{std::move(own), across, std::move(course)};
    };
    line.def(
            py::init(made_of), py::arg("sections"), py::arg("across") = vec3{0, 0, 0},
            "Sections, N x 4: centre and radius, metres; N x 5: both radii; N x 6: their turn, radians. `across`: the\n"
            "first axis of the first section; by default any.")
        .def_property_readonly(
            "sections", [](const sectioned_line& self) { return array_of_sections(self.sections); }, "N x 6: a copy")
        .def_property_readonly(
            "first",
            [](const sectioned_line& self) {
                require_line(self);
                return self.own.first();
            },
            "The first section, a line_place.")
        .def(
            "place",
            [](const sectioned_line& self, vec3 point) {
                require_line(self);
                return self.own.place(point);
            },
            py::arg("point"), "The place of a point, on the cross-section whose centre is nearest.")
        .def("__eq__", [](const sectioned_line& one, const sectioned_line& other) { return one.own == other.own; })
        .def("__repr__",
             [](const sectioned_line& self) {
                 return "<centre_line of " + std::to_string(self.sections.size()) + " sections>";
             })
        .def(py::pickle(
            [](const sectioned_line& self) { return py::make_tuple(array_of_sections(self.sections), self.across); },
            [made_of](const py::tuple& state) {
                const auto sections = py::cast<float_array>(state[0]);
                return sections.shape(0) == 0 ? sectioned_line{} : made_of(sections, py::cast<vec3>(state[1]));
            }));
    bind_copies(line);
    module.def("make_tube", &tube_of, py::arg("line"), py::kw_only(), py::arg("segments") = tube_settings{}.segments,
               py::arg("ends") = "round", py::arg("across") = vec3{0, 0, 0},
               "A closed tube along sections, as centre_line takes them: a vessel, a nerve. `ends`: round or flat.");
    module.def("make_sheet", &sheet_of, py::arg("points"), py::arg("thickness") = sheet_point{}.thickness,
               "A closed thin sheet around points, rows x columns x 3, metres: a fascia. Its thickness is one number,\n"
               "or one for each point.");
}

} // namespace insonify_python
