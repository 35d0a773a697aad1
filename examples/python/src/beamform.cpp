// Lines of channel data, and the truth beside them.
#include "bindings.hpp"
#include <cstddef>
#include <cstring>

namespace insonify_python {

namespace {

template <class Data, class Probe>
void bind_sum(py::module_& module) {
    module.def(
        "beamform",
        [](const Data& received, const Probe& probe, const acquisition& grid, const beamform_settings& settings,
           const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return beamform(chosen, received, probe, grid, settings); });
        },
        py::arg("received"), py::arg("probe"), py::arg("grid"),
        py::arg_v("settings", beamform_settings{}, "beamform_settings()"), py::kw_only(),
        py::arg("policy") = "par_unseq", "Lines of a probe from channel data, by delay and sum.");
}

/// The pixels of a map: rows x columns, or more of them where a pixel has several numbers.
template <class Value, class Number>
py::array pixels_of(const py::object& self, std::vector<Value> tissue_maps::*values) {
    auto& own = py::cast<tissue_maps&>(self);
    std::vector<py::ssize_t> shape{own.grid.size.y, own.grid.size.x};
    if constexpr (sizeof(Value) > sizeof(Number)) shape.push_back(sizeof(Value) / sizeof(Number));
    return array_over(reinterpret_cast<Number*>((own.*values).data()), shape, self);
}

/// The members of `slice_strain` as the fields of a numpy array.
py::array strain_of(const py::object& self) {
    py::list names, formats, offsets;
    const auto add = [&](const char* name, std::size_t offset) {
        names.append(name);
        formats.append("f4");
        offsets.append(offset);
    };
    add("lateral", offsetof(slice_strain, lateral));
    add("axial", offsetof(slice_strain, axial));
    add("shear", offsetof(slice_strain, shear));
    auto& own = py::cast<tissue_maps&>(self);
    return py::array(py::dtype{names, formats, offsets, static_cast<py::ssize_t>(sizeof(slice_strain))},
                     std::vector<py::ssize_t>{own.grid.size.y, own.grid.size.x}, own.strain.data(), self);
}

/// Copies what `pixels_of` and `strain_of` made.
template <class Value>
void copy_pixels(const py::object& from, std::vector<Value>& to) {
    const auto pixels = py::cast<py::array>(from);
    to.resize(static_cast<std::size_t>(pixels.nbytes()) / sizeof(Value));
    if (!to.empty()) std::memcpy(static_cast<void*>(to.data()), pixels.data(), sizeof(Value) * to.size());
}

void bind_maps(py::module_& module) {
    settings_class<map_grid> grid{module, "map_grid", "Pixels in the slice plane of an array, at equal steps."};
    grid.member("from_", &map_grid::from, "x and z of the first pixel in the frame of the probe, metres")
        .member("spacing", &map_grid::spacing, "metres")
        .member("size", &map_grid::size, "columns, rows");
    grid.type().def("at", &map_grid::at, py::arg("column"), py::arg("row"),
                    "Where a pixel is, in the frame of the probe.");
    py::class_<tissue_maps> type{module, "tissue_maps", "The truth behind channel data, pixel by pixel."};
    bind_copies(type);
    const auto map = [&]<class Value>(const char* name, std::vector<Value> tissue_maps::*values, const char* doc) {
        using number = std::conditional_t<std::is_same_v<Value, vec2>, float, Value>;
        type.def_property_readonly(
            name, [values](const py::object& self) { return pixels_of<Value, number>(self, values); }, doc);
    };
    type.def_property_readonly(
        "grid", [](const tissue_maps& self) { return self.grid; }, "where the pixels are: a copy");
    map("sound_speed", &tissue_maps::sound_speed, "rows x columns, m/s; a view without a copy, as all maps");
    map("density", &tissue_maps::density, "kg/m^3");
    map("attenuation", &tissue_maps::attenuation, "dB/m at 1 MHz, one way");
    map("attenuation_power", &tissue_maps::attenuation_power, "exponent of the frequency");
    map("labels", &tissue_maps::labels, "the object, or background_label");
    map("displacement", &tissue_maps::displacement,
        "rows x columns x 2: of tissue from rest, x and z of the probe, metres");
    type.def_property_readonly("strain", &strain_of, "of tissue, with the fields lateral, axial and shear")
        .def(py::pickle(
            [](const py::object& self) {
                py::tuple state(8);
                std::size_t i = 0;
                for (const char* member : {"grid", "sound_speed", "density", "attenuation", "attenuation_power",
                                           "labels", "displacement", "strain"})
                    state[i++] = self.attr(member);
                return state;
            },
            [](const py::tuple& state) {
                tissue_maps made{.grid = py::cast<map_grid>(state[0])};
                copy_pixels(state[1], made.sound_speed);
                copy_pixels(state[2], made.density);
                copy_pixels(state[3], made.attenuation);
                copy_pixels(state[4], made.attenuation_power);
                copy_pixels(state[5], made.labels);
                copy_pixels(state[6], made.displacement);
                copy_pixels(state[7], made.strain);
                return made;
            }))
        .def("__repr__", [](const tissue_maps& self) {
            return "<tissue_maps of " + std::to_string(self.grid.size.x) + " x " + std::to_string(self.grid.size.y) +
                   " pixels>";
        });
    module.def(
        "map_tissue",
        [](const scene& body, const pose& at, const map_grid& pixels, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return map_tissue(chosen, body, at, pixels); });
        },
        py::arg("scene"), py::arg("pose"), py::arg("grid"), py::kw_only(), py::arg("policy") = "par_unseq",
        "What lies at each pixel of the slice plane of an array.");
}

} // namespace

void bind_beamform(py::module_& module) {
    settings_class<beamform_settings>(module, "beamform_settings", "How channel data become lines.")
        .member("fnumber", &beamform_settings::fnumber, "depth over the width of the aperture that receives")
        .choice("window", &beamform_settings::window,
                {{"rectangular", aperture_window::rectangular},
                 {"hann", aperture_window::hann},
                 {"hamming", aperture_window::hamming},
                 {"tukey", aperture_window::tukey}},
                "weights of elements across that aperture")
        .member("sound_speed", &beamform_settings::sound_speed, "m/s; 0: that of the channel data");
    const auto bind = [&]<class Probe>(const Probe*) {
        bind_sum<channel_data, Probe>(module);
        bind_sum<iq_channel_data, Probe>(module);
    };
    bind(static_cast<const linear_array*>(nullptr));
    bind(static_cast<const convex_array*>(nullptr));
    bind(static_cast<const phased_array*>(nullptr));
    bind(static_cast<const radial_array*>(nullptr));
    refuse_others(module, "beamform", 4,
                  {{"received", "channel_data or iq_channel_data", fits<channel_data, iq_channel_data>},
                   {"probe", "the probe of the lines, such as linear_array()",
                    fits<linear_array, convex_array, phased_array, radial_array>},
                   {"grid", "acquisition(...)", fits<acquisition>},
                   {"settings", "beamform_settings(...)", fits<beamform_settings>, true},
                   {"policy", "the name of a policy, such as \"par_unseq\"", fits<std::string>, true}});
    bind_maps(module);
}

} // namespace insonify_python
