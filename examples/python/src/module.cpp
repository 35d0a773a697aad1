// The Python module `insonify`: the library's names and settings, with numpy arrays where C++ has vectors.
#define INSONIFY_IMPLEMENTATION
#include "bindings.hpp"

PYBIND11_MODULE(insonify, module) {
    using namespace insonify_python;
    module.doc() = "Ultrasound images of triangle meshes by ray tracing.\n\n"
                   "Everything is in SI units; multiply by `mm`, `MHz`, `deg` or `dB_per_cm`: depth=40 * mm.";
    module.attr("__version__") = std::to_string(INSONIFY_VERSION / 10000) + "." +
                                 std::to_string(INSONIFY_VERSION / 100 % 100) + "." +
                                 std::to_string(INSONIFY_VERSION % 100);
    module.attr("m") = 1.0;
    module.attr("cm") = 1e-2;
    module.attr("mm") = 1e-3;
    module.attr("um") = 1e-6;
    module.attr("Hz") = 1.0;
    module.attr("kHz") = 1e3;
    module.attr("MHz") = 1e6;
    module.attr("s") = 1.0;
    module.attr("ms") = 1e-3;
    module.attr("us") = 1e-6;
    module.attr("rad") = 1.0;
    module.attr("m_per_s") = 1.0;
    module.attr("kg_per_m3") = 1.0;
    module.attr("mmHg") = 133.322387415;
    module.attr("Rayl") = 1.0;
    module.attr("MRayl") = 1e6;
    module.attr("dB_per_m") = 1.0;
    module.attr("deg") = 3.14159265358979323846 / 180;
    module.attr("dB_per_cm") = 100.0;
    module.attr("background_label") = background_label;
    module.attr("background_object") = static_cast<std::uint32_t>(background_object);
    module.attr("no_level_db") = no_level_db;
    bind_errors(module);
    bind_media(module);
    bind_grids(module);
    bind_scene(module);
    bind_tubes(module);
    bind_queries(module);
    bind_obj(module);
    bind_motion(module);
    bind_flow(module);
    bind_settings(module);
    bind_tracers(module);
    bind_layers(module);
    bind_probes(module);
    bind_stages(module);
    bind_scanner(module);
    bind_linear_array(module);
    bind_convex_array(module);
    bind_phased_array(module);
    bind_radial_array(module);
    bind_doppler_linear_array(module);
    bind_doppler_convex_array(module);
    bind_doppler_phased_array(module);
    bind_doppler_radial_array(module);
    bind_arrays(module);
    bind_channels(module);
    bind_beamform(module);
    bind_anatomy(module);
}
