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

namespace {

/// What was done to the content of a file, as warnings, which Python shows and a program can catch.
/// @throws py::error_already_set  where warnings are errors
void warn(const std::vector<std::string>& notes) {
    for (const std::string& note : notes)
        if (PyErr_WarnEx(PyExc_UserWarning, note.c_str(), 1) != 0) throw py::error_already_set();
}

obj_settings settings_of(file_unit length, bool mends, float pennation, const medium& background) {
    obj_settings settings{.unit = length.metres, .background = background, .pennation = pennation};
    if (mends) settings.repair = repair_settings{};
    return settings;
}

} // namespace

void bind_obj(py::module_& module) {
    // None is not a default, but stands for a unit that was forgotten.
    const auto unit = [] { return py::arg_v("unit", py::none(), "required"); };
    module.def(
        "load_obj",
        [](const std::filesystem::path& path, file_unit length, bool mends) {
            std::vector<std::string> notes;
            mesh loaded = load_obj(path.string(), settings_of(length, mends, 0, tissue::water), notes);
            warn(notes);
            return loaded;
        },
        py::arg("path"), unit(), py::arg("repair") = false,
        "Loads all faces of an OBJ file as one mesh; `unit` is the length of 1 in the file, such as mm. What `repair` "
        "did is told by warnings.");
    module.def(
        "load_obj_scene",
        [](const std::filesystem::path& path, file_unit length, const medium& background, bool mends, float pennation) {
            std::vector<std::string> notes;
            scene loaded = load_obj_scene(path.string(), settings_of(length, mends, pennation, background), notes);
            warn(notes);
            return loaded;
        },
        py::arg("path"), unit(), py::arg_v("background", tissue::water, "tissue.water"), py::arg("repair") = false,
        py::arg("pennation") = 0.0F,
        "Loads an OBJ file; its materials are media. `unit` is the length of 1 in the file, such as mm; `pennation` "
        "the "
        "angle of the fibres of muscles to their long axis, radians. What the scene has otherwise than the file is "
        "told "
        "by warnings.");
}

} // namespace insonify_python
