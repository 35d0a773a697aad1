// Values along lines and images, as views of numpy.
#include "bindings.hpp"
#include <cstring>
#include <filesystem>
#include <pybind11/stl/filesystem.h>

namespace insonify_python {

namespace {

/// The values of lines as an array of count x samples; complex numbers where they are pairs.
template <class Value>
struct array_number {
    using type = Value;
};
template <>
struct array_number<vec2> {
    using type = std::complex<float>;
};

template <class Value>
void bind_line_grid(py::module_& module, const char* name, const char* page) {
    using lines = line_grid<Value>;
    using number = typename array_number<Value>::type;
    static_assert(sizeof(number) == sizeof(Value));
    py::class_<lines> type{module, name, page};
    bind_copies(type);
    using input =
        std::conditional_t<std::is_same_v<Value, float>, float_array,
                           std::conditional_t<std::is_same_v<Value, label_id>, index_array,
                                              py::array_t<number, py::array::c_style | py::array::forcecast>>>;
    const auto make = [](const input& values, float depth) {
        if (values.ndim() != 2)
            throw usage_error{"lines are made of an array with a row for each line, not of " +
                              std::to_string(values.ndim()) + " dimensions"};
        lines made{static_cast<std::uint32_t>(values.shape(0)), static_cast<std::uint32_t>(values.shape(1)), depth};
        for (std::size_t i = 0; i < made.values.size(); ++i) {
            const auto& one = values.data()[i];
            if constexpr (std::is_same_v<Value, label_id>)
                if (one < 0 || one > std::int64_t{background_label})
                    throw usage_error{"a label is 0 to 2^32 - 1, not " + std::to_string(one)};
            if constexpr (std::is_same_v<Value, vec2>)
                made.values[i] = {one.real(), one.imag()};
            else
                made.values[i] = static_cast<Value>(one);
        }
        return made;
    };
    type.def(py::init(make), py::arg("values"), py::arg("depth"),
             "Copies an array with a row for each line; depth in metres.")
        .def(py::pickle(
            [](const py::object& self) { return py::make_tuple(self.attr("values"), self.attr("depth")); },
            [make](const py::tuple& state) { return make(py::cast<input>(state[0]), py::cast<float>(state[1])); }))
        .def_readonly("count", &lines::count, "number of lines")
        .def_readonly("samples", &lines::samples, "depth samples of each line")
        .def_readonly("depth", &lines::depth, "from the face to the end of the last sample, metres")
        .def_property_readonly(
            "values",
            [](const py::object& self) {
                auto& own = py::cast<lines&>(self);
                return array_over(reinterpret_cast<number*>(own.values.data()), {own.count, own.samples}, self);
            },
            "count x samples, a view without a copy")
        .def("__array__",
             [](const py::object& self, const py::args& how) { return self.attr("values").attr("__array__")(*how); })
        .def("__eq__", [](const lines& one, const lines& other) { return one == other; })
        .def("__repr__", [name = std::string{name}](const lines& self) {
            return "<" + name + " of " + std::to_string(self.count) + " lines of " + std::to_string(self.samples) +
                   " samples>";
        });
}

/// @throws usage_error  for a brightness beyond 0 to 1, or NaN
void check_brightness(const float* numbers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        if (!(numbers[i] >= 0 && numbers[i] <= 1))
            throw usage_error{
                "an image must be of finite numbers from 0 to 1; divide grey values by 255, or clip them"};
}
template <class Picture>
void write_checked(const std::filesystem::path& file, const Picture& picture) {
    check_brightness(reinterpret_cast<const float*>(picture.pixels.data()),
                     picture.pixels.size() * (sizeof(picture.pixels[0]) / sizeof(float)));
    write_png(file.string(), picture);
}

/// Brightness from 0 to 1 of an array: numbers of floating point as they are, bytes over 255.
/// @throws usage_error  for an array of another type or shape
float_array brightness_of(const py::array& pixels) {
    const char kind = pixels.dtype().kind();
    const bool bytes = kind == 'u' && pixels.itemsize() == 1;
    if (kind != 'f' && kind != 'b' && !bytes)
        throw usage_error{"an image is made of floating point from 0 to 1, of uint8 or of bool, not of " +
                          py::cast<std::string>(py::str(pixels.dtype())) +
                          "; for labels, array.astype(np.uint8) keeps the ids below 255"};
    const py::ssize_t axes = pixels.ndim();
    if (axes != 2 && (axes != 3 || pixels.shape(2) != 3))
        throw usage_error{"an image is made of an array of rows x columns, or rows x columns x 3 in colour"};
    for (py::ssize_t axis = 0; axis < 2; ++axis)
        if (pixels.shape(axis) > max_picture_side)
            throw usage_error{"an image has at most " + std::to_string(max_picture_side) + " pixels a side"};
    if (!bytes) {
        const float_array brightness(pixels);
        check_brightness(brightness.data(), static_cast<std::size_t>(brightness.size()));
        return brightness;
    }
    float_array made(py::module_::import("numpy").attr("divide")(pixels, 255.0F));
    return made;
}

template <class Picture>
Picture picture_of(const float_array& pixels) {
    Picture made{uvec2{pixels.shape(1), pixels.shape(0)}};
    if (!made.pixels.empty())
        std::memcpy(static_cast<void*>(made.pixels.data()), pixels.data(), sizeof(made.pixels[0]) * made.pixels.size());
    return made;
}

template <class Picture>
Picture picture_of(const py::array& pixels, py::ssize_t axes, const char* shape) {
    if (pixels.ndim() != axes)
        throw usage_error{std::string{shape} + ", not of " + std::to_string(pixels.ndim()) + " dimensions"};
    return picture_of<Picture>(brightness_of(pixels));
}

void write_array(const std::filesystem::path& path, const py::array& pixels) {
    const float_array brightness = brightness_of(pixels);
    const auto write = [&](const auto& picture) {
        const py::gil_scoped_release unlocked;
        write_png(path.string(), picture);
    };
    if (brightness.ndim() == 2)
        write(picture_of<image>(brightness));
    else
        write(picture_of<colour_image>(brightness));
}

/// The pixels as they are, as an array; labels keep their whole range.
template <class Picture>
void bind_pickle(py::class_<Picture>& type) {
    type.def(py::pickle([](const py::object& self) { return py::array(self.attr("pixels").attr("copy")()); },
                        [](const py::array& pixels) {
                            Picture made{uvec2{pixels.shape(1), pixels.shape(0)}};
                            if (static_cast<std::size_t>(pixels.nbytes()) !=
                                sizeof(made.pixels[0]) * made.pixels.size())
                                throw usage_error{"the pickled pixels are not those of such an image"};
                            if (!made.pixels.empty())
                                std::memcpy(static_cast<void*>(made.pixels.data()), pixels.data(),
                                            static_cast<std::size_t>(pixels.nbytes()));
                            return made;
                        }));
}

template <class Picture>
py::class_<Picture> bind_picture(py::module_& module, const char* name, const char* page) {
    py::class_<Picture> type{module, name, page};
    bind_copies(type);
    bind_pickle(type);
    type.def_property_readonly(
            "size", [](const Picture& self) { return self.size; }, "columns, rows")
        .def_property_readonly(
            "pixels",
            [](const py::object& self) {
                auto& own = py::cast<Picture&>(self);
                return array_over(own.pixels.data(), {own.size.y, own.size.x}, self);
            },
            "rows x columns, from the top; a view without a copy")
        .def("__array__",
             [](const py::object& self, const py::args& how) { return self.attr("pixels").attr("__array__")(*how); })
        .def("__eq__", [](const Picture& one, const Picture& other) { return one == other; })
        .def("__repr__", [name = std::string{name}](const Picture& self) {
            return "<" + name + " of " + std::to_string(self.size.x) + " x " + std::to_string(self.size.y) + " pixels>";
        });
    return type;
}

} // namespace

void bind_grids(py::module_& module) {
    bind_line_grid<float>(module, "scan_lines", "Real values along lines: envelope, brightness, angles.");
    bind_line_grid<vec2>(module, "iq_lines", "Complex baseband echoes along lines.");
    bind_line_grid<label_id>(module, "label_lines", "The object at each sample.");
    bind_picture<image>(module, "image", "A greyscale image: 0 black to 1 white.")
        .def(py::init([](const py::array& pixels) {
                 return picture_of<image>(pixels, 2, "an image is made of an array of rows x columns");
             }),
             py::arg("pixels"), "Copies an array of rows x columns, floats from 0 to 1 or uint8.");
    bind_picture<label_image>(module, "label_image", "The object at each pixel.");
    py::class_<colour_image> colours{module, "colour_image", "A colour image: red, green and blue from 0 to 1."};
    bind_copies(colours);
    bind_pickle(colours);
    colours
        .def(py::init([](const py::array& pixels) {
                 return picture_of<colour_image>(pixels, 3, "a colour_image is made of an array of rows x columns x 3");
             }),
             py::arg("pixels"), "Copies an array of rows x columns x 3, floats from 0 to 1 or uint8.")
        .def_property_readonly(
            "size", [](const colour_image& self) { return self.size; }, "columns, rows")
        .def_property_readonly(
            "pixels",
            [](const py::object& self) {
                auto& own = py::cast<colour_image&>(self);
                return array_over(reinterpret_cast<float*>(own.pixels.data()), {own.size.y, own.size.x, 3}, self);
            },
            "rows x columns x 3, from the top; a view without a copy")
        .def("__array__",
             [](const py::object& self, const py::args& how) { return self.attr("pixels").attr("__array__")(*how); })
        .def("__eq__", [](const colour_image& one, const colour_image& other) { return one == other; })
        .def("__repr__", [](const colour_image& self) {
            return "<colour_image of " + std::to_string(self.size.x) + " x " + std::to_string(self.size.y) + " pixels>";
        });
    py::class_<scan_map>(module, "scan_map", "Interpolation table of scan_convert, and pixel to millimetre.")
        .def_property_readonly(
            "size", [](const scan_map& self) { return self.size; }, "columns, rows")
        .def_property_readonly(
            "pitch", [](const scan_map& self) { return self.pitch; }, "width and height of a pixel, metres")
        .def(
            "point", [](const scan_map& self, vec2 pixel) { return self.point(pixel); }, py::arg("pixel"),
            "From pixel coordinates to (x, z) in the slice plane, metres.")
        .def("pixel", &scan_map::pixel, py::arg("point"),
             "From (x, z) in the slice plane, metres, to pixel coordinates.");
    using path = std::filesystem::path;
    module.def(
        "write_png", [](const path& file, const image& picture) { write_checked(file, picture); }, py::arg("path"),
        py::arg("picture"), py::call_guard<py::gil_scoped_release>(), "Writes an 8-bit greyscale PNG file.");
    module.def(
        "write_png", [](const path& file, const colour_image& picture) { write_checked(file, picture); },
        py::arg("path"), py::arg("picture"), py::call_guard<py::gil_scoped_release>(), "Likewise an 8-bit RGB file.");
    module.def("write_png", &write_array, py::arg("path"), py::arg("picture"),
               "Likewise an array of rows x columns, or x 3 in colour: floats from 0 to 1, or uint8.");
}

} // namespace insonify_python
