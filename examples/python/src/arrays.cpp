// Arrays, element by element, and what they transmit.
#include "bindings.hpp"
#include "custom_array.hpp"

namespace insonify_python {

namespace {

// What all arrays have.
template <class Array>
void bind_elements(settings_class<Array>& bound, const char* name) {
    bound.member("element_width", &Array::element_width, "of an element along the array, metres")
        .member("frequency", &Array::frequency, "of the carrier, hertz")
        .member("height", &Array::height, "of the elements, out of the slice plane, metres")
        .member("elevation_focus", &Array::elevation_focus, "of the lens, metres")
        .member("bandwidth", &Array::bandwidth, "fractional, of echoes at -6 dB")
        .member("sound_speed", &Array::sound_speed, "that delays assume, m/s")
        .member("fnumber", &Array::fnumber, "of the pictures whose levels `backscatter` states");
    bound.type().def(
        "element",
        [name = std::string{name}](const Array& self, std::uint32_t i) {
            if (i >= self.elements)
                throw py::index_error(name + ": element " + std::to_string(i) + " is not one of the " +
                                      std::to_string(self.elements) + ", counted from 0");
            const ray one = self.element(i);
            return std::pair{one.origin, one.direction};
        },
        py::arg("i"), "Centre and normal of an element, in the frame of the probe.");
}

// At equal steps.
template <class Array>
settings_class<Array> bind_array(py::module_& module, const char* name, const char* page) {
    settings_class<Array> bound{module, name, page};
    bound.member("elements", &Array::elements, "from left to right")
        .member("pitch", &Array::pitch, "from centre to centre, metres");
    bind_elements(bound, name);
    return bound;
}

void bind_custom_array(py::module_& module) {
    constexpr const char* name = "custom_element_array";
    settings_class<custom_element_array> bound{module, name, "Array of elements of one size, wherever they are."};
    bound
        .property(
            "positions", [](const custom_element_array& self) { return array_of_rows(self.positions); },
            [](custom_element_array& self, const float_array& given) {
                self.positions = rows_of(given, "custom_element_array: `positions`");
                self.elements = static_cast<std::uint32_t>(self.positions.size());
            },
            "N x 3: centres of the elements in the frame of the probe, from left to right, metres")
        .property(
            "directions", [](const custom_element_array& self) { return array_of_rows(self.directions); },
            [](custom_element_array& self, const float_array& given) {
                self.directions = rows_of(given, "custom_element_array: `directions`");
            },
            "N x 3: normals of their faces, of length 1, in the plane y = 0; none: all along z");
    bind_elements(bound, name);
    bound.type().def_property_readonly(
        "elements", [](const custom_element_array& self) { return self.elements; }, "number of elements");
}

template <class Array>
void bind_transmits(py::module_& module) {
    module.def("plane_waves", &plane_waves<Array>, py::arg("array"), py::arg("count"), py::arg("spread"),
               "Plane waves at equal steps of angle; `spread` is that from the first to the last, radians.");
    module.def(
        "diverging_waves",
        [](const Array& array, const float_array& sources) {
            return diverging_waves(array, rows_of(sources, "diverging_waves: the sources"));
        },
        py::arg("array"), py::arg("sources"),
        "Waves that diverge from virtual sources behind the face, an array of N x 3, metres.");
    module.def(
        "focused",
        [](const Array& array, const float_array& points, float fnumber) {
            return focused(array, rows_of(points, "focused: the points"), fnumber);
        },
        py::arg("array"), py::arg("points"), py::arg("fnumber") = 0.0F,
        "Focused beams, one for each focus of an array of N x 3, metres. `fnumber`: depth of the focus over the width "
        "of\nthe elements that fire; 0: all fire.");
    module.def("full_synthetic_aperture", &full_synthetic_aperture<Array>, py::arg("array"),
               "Every element fires once, alone.");
}

void refuse_other_transmits(py::module_& module) {
    const argument array = array_argument();
    refuse_others(
        module, "plane_waves", 3,
        {array, {"count", "a whole number", fits<std::uint32_t>}, {"spread", "a number, radians", fits<float>}});
    refuse_others(module, "diverging_waves", 2, {array, {"sources", "an array of N x 3, metres", fits<float_array>}});
    refuse_others(module, "focused", 3,
                  {array,
                   {"points", "an array of N x 3, metres", fits<float_array>},
                   {"fnumber", "a number", fits<float>, true}});
    refuse_others(module, "full_synthetic_aperture", 1, {array});
}

} // namespace

void bind_arrays(py::module_& module) {
    bind_array<element_array>(module, "element_array", "Flat array, element by element: linear and phased arrays.");
    bind_array<convex_element_array>(module, "convex_element_array", "Array on an arc, element by element.")
        .member("radius", &convex_element_array::radius, "of the arc, metres");
    bind_custom_array(module);
    settings_class<transmit>(module, "transmit", "When each element fires, and how strongly.")
        .member("delays", &transmit::delays, "of each element, seconds; the first one fires at 0")
        .member("weights", &transmit::weights, "of each element, -1 to 1; 0: silent. Empty: all 1")
        .choice("front", &transmit::front,
                {{"any", transmit::wave::any},
                 {"plane", transmit::wave::plane},
                 {"diverging", transmit::wave::diverging},
                 {"focused", transmit::wave::focused}},
                "shape of the wave front; any: it arrives with the first of the elements' waves")
        .member("angle", &transmit::angle, "of a plane wave, from z towards x, radians")
        .member("source", &transmit::source, "virtual source or focus, metres")
        .member("origin", &transmit::origin, "middle of the elements that fire, metres");
    bind_transmits<element_array>(module);
    bind_transmits<convex_element_array>(module);
    bind_transmits<custom_element_array>(module);
    refuse_other_transmits(module);
}

} // namespace insonify_python
