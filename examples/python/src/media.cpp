// Errors, media and tissues.
#include "bindings.hpp"

namespace insonify_python {

void bind_errors(py::module_& module) {
    py::register_exception<usage_error>(module, "usage_error", PyExc_ValueError).doc() =
        "A setting that is out of range, or a call out of order.";
    py::register_exception<geometry_error>(module, "geometry_error", PyExc_ValueError).doc() =
        "An invalid mesh or pose.";
    py::register_exception<io_error>(module, "io_error", PyExc_OSError).doc() =
        "A file that could not be read or written, or whose content is invalid.";
}

void bind_media(py::module_& module) {
    using variation = structure::variation;
    using sheet_layer = structure::sheet_layer;
    using bundle_layer = structure::bundle_layer;
    using sheath_layer = structure::sheath_layer;
    settings_class<variation>(module, "variation", "Slow random variation of the level.")
        .member("deviation_db", &variation::deviation_db, "standard deviation of the level, dB; 0: none")
        .member("size", &variation::size, "distance between independent values, metres");
    settings_class<sheet_layer>(module, "sheet_layer", "Thin bright sheets of finite size, such as the perimysium.")
        .member("fill", &sheet_layer::fill, "fraction of the cells that contain a sheet; 0: none")
        .member("lattices", &sheet_layer::lattices, "number of lattices, 1 to 6")
        .member("cell", &sheet_layer::cell, "size of the cells of the first lattice, metres")
        .member("thickness", &sheet_layer::thickness, "standard deviation of a sheet's profile, metres")
        .member("level_db", &sheet_layer::level_db, "amplitude at normal incidence, relative to the speckle around it")
        .member("spread_db", &sheet_layer::spread_db, "standard deviation of that level from sheet to sheet")
        .member("turn", &sheet_layer::turn, "normals are turned about the fibres by at most this, radians")
        .member("bend", &sheet_layer::bend,
                "largest slope of the edge of a sheet against its middle, across the fibres")
        .member("tilt", &sheet_layer::tilt, "lattices are tilted against the fibres by up to this, radians")
        .member("waviness", &sheet_layer::waviness, "standard deviation of the angle of the facets, radians")
        .member("diffuse_db", &sheet_layer::diffuse_db,
                "amplitude that remains at any angle, relative to normal incidence");
    settings_class<bundle_layer>(module, "bundle_layer", "Round bundles along the fibres, such as those of a nerve.")
        .member("spacing", &bundle_layer::spacing, "of their centres across the fibres, metres; 0: none")
        .member("diameter", &bundle_layer::diameter, "of the largest, metres")
        .member("level_db", &bundle_layer::level_db, "amplitude inside, relative to the net");
    settings_class<sheath_layer>(module, "sheath_layer", "The sheath of an object, such as the epimysium of a muscle.")
        .member("thickness", &sheath_layer::thickness, "mean, metres; 0: none")
        .member("level_db", &sheath_layer::level_db, "amplitude at normal incidence, relative to the speckle")
        .member("spread_db", &sheath_layer::spread_db, "standard deviation of that level along the surface")
        .member("waviness", &sheath_layer::waviness, "standard deviation of the angle of its facets, radians")
        .member("diffuse_db", &sheath_layer::diffuse_db, "amplitude that remains at any angle")
        .member("insertion", &sheath_layer::insertion,
                "length over which fibres curve into the surface that they end on, metres; 0: none");
    settings_class<structure>(module, "structure", "What a tissue is made of above the scale of speckle.")
        .member("mottling", &structure::mottling, "of everything")
        .member("grain", &structure::grain, "of the speckle between the sheets")
        .member("wave", &structure::wave, "deviation of sheets and bundles from straight, metres")
        .member("wave_length", &structure::wave_length, "of these waves along the fibres, metres")
        .member("sheets", &structure::sheets, "short sheets")
        .member("septa", &structure::septa, "long ones")
        .member("bundles", &structure::bundles, "along the fibres")
        .member("sheath", &structure::sheath, "below the surface of the object");
    settings_class<medium>(module, "medium",
                           "Acoustic properties of an object; by default lossless water without echoes.")
        .member("density", &medium::density, "kg/m^3")
        .member("sound_speed", &medium::sound_speed, "m/s")
        .member("attenuation", &medium::attenuation, "dB/m at 1 MHz, one way")
        .member("attenuation_power", &medium::attenuation_power, "exponent of the frequency")
        .member("backscatter", &medium::backscatter, "echo amplitude of its speckle relative to liver; 0: anechoic")
        .member("roughness", &medium::roughness, "rms height of its surface, metres; 0: specular")
        .member("scatterer_density", &medium::scatterer_density, "scatterers per m^3; 0: the field's default")
        .member("structure", &medium::structure, "above the scale of speckle")
        .member("flowing", &medium::flowing, "whether its speckle is independent from frame to frame")
        .type()
        .def_property_readonly("impedance", &medium::impedance, "density times sound speed, rayl");

    struct tissue_table {};
    py::class_<tissue_table> tissues{
        module, "tissue",
        "Media of the body, of instruments and of phantoms: constants; copy.copy makes one that can be changed."};
    for (const tissue::named_medium& one : tissue::all)
        tissues.def_property_readonly_static(std::string{one.name}.c_str(),
                                             [&one](const py::object&) { return constant(one.value); });
    tissues
        .def_static(
            "find", [](const std::string& name) { return tissue::find(name); }, py::arg("name"),
            "The medium of a name, or None.")
        .def_property_readonly_static(
            "names",
            [](const py::object&) {
                std::vector<std::string> names;
                for (const tissue::named_medium& one : tissue::all) names.emplace_back(one.name);
                return py::tuple(py::cast(names));
            },
            "All names.");
}

} // namespace insonify_python
