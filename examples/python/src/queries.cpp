// Queries of the scene: what is at a point, and where surfaces are.
#include "bindings.hpp"
#include <algorithm>
#include <optional>

namespace insonify_python {

namespace {

std::optional<surface_point> first_surface_of(const scene& self, vec3 origin, vec3 direction,
                                              const std::optional<std::vector<object_id>>& only) {
    if (!is_finite(origin) || !is_finite(direction) || direction == vec3{0, 0, 0})
        throw usage_error{"first_surface: `origin` and `direction` must be finite, and `direction` not zero"};
    return first_surface(self, {.origin = origin, .direction = direction}, [&](object_id id) {
        return !only || std::find(only->begin(), only->end(), id) != only->end();
    });
}

} // namespace

void bind_queries(py::module_& module) {
    py::class_<surface_point>(module, "surface_point", "A point on the surface of an object.")
        .def_readonly("object", &surface_point::object, "id of the object")
        .def_readonly("face", &surface_point::face, "index into the faces of its mesh")
        .def_readonly("distance", &surface_point::distance,
                      "from the origin, in lengths of `direction`; for nearest_surface, metres")
        .def_readonly("point", &surface_point::point, "in the world, metres")
        .def_readonly("normal", &surface_point::normal, "of the face, outwards, length 1");
    py::reinterpret_borrow<py::class_<scene>>(module.attr("scene"))
        .def("object_at", &object_at, py::arg("point"), "The object that gives the medium at a point, or None.")
        .def("medium_at", &medium_at, py::arg("point"), "The medium at a point: a copy.")
        .def("first_surface", &first_surface_of, py::arg("origin"), py::arg("direction"), py::arg("only") = py::none(),
             "The first surface along a ray, from either side, or None. `only`: the ids of the objects that count.")
        .def(
            "displayed_depth",
            [](const scene& self, vec3 origin, vec3 direction, float depth) {
                return displayed_depth(self, {.origin = origin, .direction = direction}, depth);
            },
            py::arg("origin"), py::arg("direction"), py::arg("depth"), py::call_guard<py::gil_scoped_release>(),
            "Depth at which a scanner displays an echo from a true depth along a line in the world, metres.")
        .def(
            "true_depth",
            [](const scene& self, vec3 origin, vec3 direction, float shown) {
                return true_depth(self, {.origin = origin, .direction = direction}, shown);
            },
            py::arg("origin"), py::arg("direction"), py::arg("shown"), py::call_guard<py::gil_scoped_release>(),
            "The inverse: the true depth of what is displayed at a depth.")
        .def("nearest_surface", &nearest_surface, py::arg("id"), py::arg("point"),
             "The point of an object's surface that is nearest to a point.");
}

} // namespace insonify_python
