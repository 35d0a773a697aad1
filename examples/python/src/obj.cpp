// OBJ files.
#include "bindings.hpp"
#include <filesystem>
#include <pybind11/stl/filesystem.h>

namespace insonify_python {

namespace {

/// The length of 1 in a file, metres. A missing or wrong one gives a sentence instead of Python's list of signatures.
struct file_unit {
    float metres = 0;
};

} // namespace

} // namespace insonify_python

namespace pybind11::detail {

template <>
struct type_caster<insonify_python::file_unit> {
    PYBIND11_TYPE_CASTER(insonify_python::file_unit, const_name("float"));

    /// @throws usage_error  for anything but a number above 0
    bool load(handle from, bool) {
        make_caster<float> number;
        if (number.load(from, true)) value.metres = cast_op<float>(number);
        if (!(value.metres > 0) || !insonify::is_finite(value.metres))
            throw insonify::usage_error{"unit: give the length of 1 in the file in metres, such as mm" +
                                        (from.is_none() ? "" : ", not " + pybind11::cast<std::string>(repr(from)))};
        return true;
    }
};

} // namespace pybind11::detail

namespace insonify_python {

void bind_obj(py::module_& module) {
    // None is not a default, but stands for a unit that was forgotten.
    const auto unit = [] { return py::arg_v("unit", py::none(), "required"); };
    module.def(
        "load_obj",
        [](const std::filesystem::path& path, file_unit length) {
            return load_obj(path.string(), {.unit = length.metres});
        },
        py::arg("path"), unit(),
        "Loads all faces of an OBJ file as one mesh; `unit` is the length of 1 in the file, such as mm.");
    module.def(
        "load_obj_scene",
        [](const std::filesystem::path& path, file_unit length, const medium& background) {
            return load_obj_scene(path.string(), {.unit = length.metres, .background = background});
        },
        py::arg("path"), unit(), py::arg_v("background", tissue::water, "tissue.water"),
        "Loads an OBJ file; its materials are media. `unit` is the length of 1 in the file, such as mm.");
}

} // namespace insonify_python
