// Settings of the picture and of its stages.
#include "bindings.hpp"

namespace insonify_python {

void bind_settings(py::module_& module) {
    using time_gain = b_mode_settings::time_gain_settings;
    using noise_level = b_mode_settings::noise_level;
    using grid = label_settings::depth_grid;
    settings_class<physical<>>(module, "physical", "The pulse-echo model.")
        .member("texture_db", &physical<>::texture_db, "level of the speckle of liver relative to a perfect mirror")
        .member("shadow_floor_db", &physical<>::shadow_floor_db,
                "lower bound on the level of speckle relative to soft tissue alone")
        .member("seed", &physical<>::seed, "of the diffuse echoes of rough surfaces")
        .member("min_ringing", &physical<>::min_ringing, "what rings on straight lines; 1: nothing");
    settings_class<acquisition>(module, "acquisition", "Depth and sampling of the scan lines.")
        .member("depth", &acquisition::depth, "metres")
        .member("samples", &acquisition::samples, "depth samples of each line; 0: chosen by the model")
        .member("planes", &acquisition::planes, "1, 3, 5 or 7 elevation planes")
        .member("frame", &acquisition::frame, "number of the frame");
    settings_class<tgc_point>(module, "tgc_point", "A point of a time-gain curve.")
        .member("depth", &tgc_point::depth, "metres")
        .member("gain_db", &tgc_point::gain_db, "gain at this depth")
        .frozen();
    settings_class<tgc_settings>(module, "tgc_settings", "Time-gain compensation.")
        .member("attenuation", &tgc_settings::attenuation, "assumed attenuation, dB/m at 1 MHz, one way")
        .member("max_db", &tgc_settings::max_db, "limit of the automatic gain")
        .member("sliders", &tgc_settings::sliders, "dB at eight depths from 0 to the end of the lines")
        .member("curve", &tgc_settings::curve, "points in order of depth")
        .member("bandwidth", &tgc_settings::bandwidth,
                "fractional, of the pulse whose losses are restored; 0: a single frequency");
    settings_class<log_compress_settings>(module, "log_compress_settings", "From amplitude to brightness.")
        .member("dynamic_range_db", &log_compress_settings::dynamic_range_db, "range of levels from black to white")
        .member("reference_db", &log_compress_settings::reference_db, "level of white")
        .member("gain_db", &log_compress_settings::gain_db, "added to every level")
        .member("reject_db", &log_compress_settings::reject_db, "levels below this are black");
    settings_class<scan_convert_settings>(module, "scan_convert_settings", "Size and background of the image.")
        .member("size", &scan_convert_settings::size, "columns, rows; a 0 is chosen")
        .member("background", &scan_convert_settings::background, "brightness outside the field of view");
    settings_class<electronic_noise_settings>(module, "electronic_noise_settings", "Noise of the receiver.")
        .member("level_db", &electronic_noise_settings::level_db, "rms of its envelope, relative to a perfect mirror")
        .member("seed", &electronic_noise_settings::seed, "selects a realization")
        .member("frame", &electronic_noise_settings::frame, "number of the frame");
    settings_class<label_settings>(module, "label_settings", "Depth and sampling of labels.")
        .member("depth", &label_settings::depth, "metres, of the grid")
        .member("samples", &label_settings::samples, "along each line; 0: as many as a picture has")
        .choice("grid", &label_settings::grid, {{"geometric", grid::geometric}, {"displayed", grid::displayed}},
                "what a depth means: metres along the line, or where a picture shows it");
    settings_class<grey_map>(module, "grey_map", "Tone curve for display.")
        .member("gamma", &grey_map::gamma, "exponent: below 1 brightens")
        .member("contrast", &grey_map::contrast, "strength of an S-curve, 0 to 1")
        .member("reject", &grey_map::reject, "brightness up to which the curve is nearly flat")
        .member("shoulder", &grey_map::shoulder, "brightness from which the slope is halved")
        .member("softness", &grey_map::softness, "half width of the bends");
    settings_class<time_gain>(module, "time_gain_settings", "Time-gain compensation beside `tgc`.")
        .choice("chosen", &time_gain::chosen,
                {{"first_frame", time_gain::choice::first_frame}, {"every_frame", time_gain::choice::every_frame}},
                "when the automatic gain is chosen")
        .member("max_db", &time_gain::max_db, "limit of the automatic gain")
        .member("sliders", &time_gain::sliders, "dB at eight depths from 0 to the end of the lines")
        .member("curve", &time_gain::curve, "replaces the automatic gain");
    settings_class<noise_level>(module, "noise_level", "Electronic noise of a picture.")
        .member("level_db", &noise_level::level_db, "rms of its envelope; no_level_db: none")
        .member("seed", &noise_level::seed, "selects a realization");
    settings_class<near_field_settings>(module, "near_field_settings", "Echoes of the probe itself.")
        .choice("shown", &near_field_settings::shown,
                {{"none", near_field_settings::lines::none},
                 {"in_gas", near_field_settings::lines::in_gas},
                 {"all", near_field_settings::lines::all}},
                "which lines have them")
        .member("lens_thickness", &near_field_settings::lens_thickness, "metres")
        .member("back_reflection", &near_field_settings::back_reflection,
                "amplitude that the back of the lens reflects")
        .member("ring_down_db", &near_field_settings::ring_down_db, "level of the ringing at the face")
        .member("ring_down", &near_field_settings::ring_down, "depth at which the ringing has lost 60 dB, metres");
    settings_class<reverberation_settings>(module, "reverberation_settings", "Echoes that appear behind gas and bone.")
        .member("mirror", &reverberation_settings::mirror, "part of the amplitude of the mirror image that is drawn")
        .member("face", &reverberation_settings::face, "the same of the reverberation with the face")
        .member("haze", &reverberation_settings::haze, "the same of the haze behind bone");
    settings_class<compound_settings>(module, "compound_settings", "Looks at several angles, averaged.")
        .member("angles", &compound_settings::angles, "number of looks; 1: no compounding")
        .member("spread", &compound_settings::spread, "angle between the outermost looks, radians")
        .choice("update", &compound_settings::update,
                {{"all", compound_settings::update_mode::all}, {"one", compound_settings::update_mode::one}},
                "which looks each frame of a clip traces");
    settings_class<b_mode_settings>(module, "b_mode_settings", "Settings of a B-mode image, as on a scanner.")
        .member("depth", &b_mode_settings::depth, "metres")
        .member("samples", &b_mode_settings::samples, "depth samples of each line; 0: chosen")
        .member("size", &b_mode_settings::size, "columns, rows; a 0 is chosen")
        .member("dynamic_range_db", &b_mode_settings::dynamic_range_db, "range of levels from black to white")
        .member("reference_db", &b_mode_settings::reference_db, "level of white; 0 dB is the echo of a perfect mirror")
        .member("gain_db", &b_mode_settings::gain_db, "added to every level")
        .member("tgc", &b_mode_settings::tgc, "attenuation to compensate for, dB/m at 1 MHz; 0: that of the tissue")
        .member("planes", &b_mode_settings::planes, "1, 3, 5 or 7 elevation planes")
        .member("background", &b_mode_settings::background, "brightness outside the field of view")
        .member("time_gain", &b_mode_settings::time_gain, "how gain depends on depth, beside `tgc`")
        .member("reject_db", &b_mode_settings::reject_db, "levels below this are black")
        .member("grey", &b_mode_settings::grey, "tone curve")
        .member("persistence", &b_mode_settings::persistence, "weight of the previous frames of a scanner")
        .member("noise", &b_mode_settings::noise, "electronic noise")
        .member("frame", &b_mode_settings::frame, "number of the frame")
        .member("near_field", &b_mode_settings::near_field, "echoes of the probe itself")
        .member("reverberation", &b_mode_settings::reverberation, "echoes that appear behind gas and bone")
        .member("compound", &b_mode_settings::compound, "looks at several angles")
        .member("max_motion", &b_mode_settings::max_motion,
                "metres from frame to frame above which persistence and rolling compounding start anew")
        .member("interpolates_lines", &b_mode_settings::interpolates_lines,
                "whether lines that the beam does not need are interpolated instead of traced")
        .choice("quality", &b_mode_settings::quality,
                {{"full", b_mode_settings::quality_level::full},
                 {"fast", b_mode_settings::quality_level::fast},
                 {"draft", b_mode_settings::quality_level::draft}},
                "lines, samples, planes and looks that are traced: see sampling_of")
        .member("ring_down_db", &b_mode_settings::ring_down_db, "of the transducer behind each echo");
    py::class_<b_mode_sampling>(module, "b_mode_sampling", "What is traced for a picture.")
        .def_readonly("lines", &b_mode_sampling::lines, "of each look")
        .def_readonly("samples", &b_mode_sampling::samples, "depth samples of each line")
        .def_readonly("planes", &b_mode_sampling::planes, "elevation planes of each line")
        .def_readonly("looks", &b_mode_sampling::looks, "that are averaged");
}

} // namespace insonify_python
