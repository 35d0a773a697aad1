// Blood that flows: velocity fields, settings of Doppler, and what Doppler measures.
#include "tube_lines.hpp"
#include <cstddef>

namespace insonify_python {

namespace {

/// @param velocities  steps x size.z x size.y x size.x x 3, or without steps
velocity_samples make_samples(float_array velocities, object_id object, vec3 lower, vec3 spacing, float interval) {
    const py::ssize_t axes = velocities.ndim();
    if ((axes != 4 && axes != 5) || velocities.shape(axes - 1) != 3)
        throw usage_error{"velocity_samples: `velocities` must be an array of samples along z, y and x, of 3 m/s each; "
                          "or of steps of time and these"};
    const auto along = [&](py::ssize_t axis) { return static_cast<std::uint32_t>(velocities.shape(axis)); };
    velocity_samples made{.object = object,
                          .lower = lower,
                          .spacing = spacing,
                          .size = {along(axes - 2), along(axes - 3), along(axes - 4)}};
    made.velocities = rows_of(velocities.reshape({-1, 3}), "velocity_samples: the velocities");
    made.steps = axes == 5 ? along(0) : 1;
    made.interval = interval;
    made.check();
    return made;
}

void bind_fields(py::module_& module) {
    settings_class<pulsatile> wave{module, "pulsatile", "Velocity over the heart beat, relative to its peak."};
    wave.member("heart_rate", &pulsatile::heart_rate, "beats per second; 0: steady flow")
        .member("resistive_index", &pulsatile::resistive_index, "(systolic - diastolic) / systolic; 0: steady flow")
        .member("systole", &pulsatile::systole, "phase of the peak, 0.05 to 0.2")
        .member("delay", &pulsatile::delay, "the first beat begins at this time, seconds");
    wave.type()
        .def("__call__", &pulsatile::operator(), py::arg("time"),
             "Velocity at a time in seconds over that of the peak.")
        .def("mean", &pulsatile::mean, "The mean over a beat.");
    settings_class<poiseuille> tube{module, "poiseuille", "Laminar flow in a straight tube: a velocity field."};
    tube.member("object", &poiseuille::object, "id of the object whose blood flows")
        .member("from_", &poiseuille::from, "on the axis, in coordinates of the object, metres")
        .member("to", &poiseuille::to, "on the axis; blood flows from `from_` to `to`")
        .member("radius", &poiseuille::radius, "of the tube, metres")
        .member("peak_velocity", &poiseuille::peak_velocity, "on the axis in systole, m/s")
        .member("waveform", &poiseuille::waveform, "a pulsatile; steady by default");
    tube.type().def("volume_flow", &poiseuille::volume_flow, py::arg("time"), "Volume per second at a time, m^3/s.");
    settings_class<line_flow> bending{module, "tube_flow",
                                      "Laminar flow in a tube that bends and tapers: a velocity field."};
    bending.member("object", &tube_flow::object, "id of the object whose blood flows");
    bind_line(bending,
              "of the tube, in coordinates of the object: a centre_line or its sections; blood flows to the last");
    bending.member("peak_velocity", &tube_flow::peak_velocity, "on the axis of the first section in systole, m/s")
        .member("waveform", &tube_flow::waveform, "a pulsatile; steady by default")
        .member("side_branches", &tube_flow::side_branches,
                "what branches take where the tube tapers: 0 nothing, to 1, so much that the velocity stays");
    bending.type().def(
        "volume_flow",
        [](const line_flow& self, float time) {
            self.check();
            return self.volume_flow(time);
        },
        py::arg("time"), "Volume per second at a time, m^3/s.");
    py::class_<velocity_samples>(module, "velocity_samples", "Velocities on a regular grid: a velocity field.")
        .def(py::init(&make_samples), py::arg("velocities"), py::kw_only(), py::arg("object"), py::arg("lower"),
             py::arg("spacing"), py::arg("interval") = 0.0F,
             "Copies an array of samples along z, y and x, of 3 m/s each, or of steps of time and these.")
        .def_readwrite("object", &velocity_samples::object, "id of the object whose tissue or blood moves")
        .def_readonly("lower", &velocity_samples::lower, "of the first sample, in coordinates of the object, metres")
        .def_readonly("spacing", &velocity_samples::spacing, "of the samples along x, y and z, metres")
        .def_readonly("size", &velocity_samples::size, "samples along x, y and z")
        .def_readonly("steps", &velocity_samples::steps, "of time")
        .def_readonly("interval", &velocity_samples::interval, "from step to step, seconds")
        .def_property_readonly(
            "velocities",
            [](const py::object& self) {
                auto& own = py::cast<velocity_samples&>(self);
                return array_over(reinterpret_cast<float*>(own.velocities.data()),
                                  {own.steps, own.size.z, own.size.y, own.size.x, 3}, self);
            },
            "steps x size.z x size.y x size.x x 3, m/s: a view to write into");
}

void bind_doppler_settings(py::module_& module) {
    using kind = wall_filter::kind;
    settings_class<colour_box>(module, "colour_box", "Where velocities are measured: by default everywhere.")
        .member("from_", &colour_box::from, "depth, metres")
        .member("to", &colour_box::to, "depth, metres; 0: the end of the lines")
        .member("first_line", &colour_box::first_line, "of the probe")
        .member("lines", &colour_box::lines, "their number; 0: to the last one");
    settings_class<wall_filter>(module, "wall_filter", "Removes the echoes of tissue from an ensemble.")
        .choice("type", &wall_filter::type,
                {{"none", kind::none}, {"polynomial", kind::polynomial}, {"fir", kind::fir}}, "its kind")
        .member("order", &wall_filter::order, "of the polynomial; of the FIR filter, even")
        .member("cutoff", &wall_filter::cutoff, "of the FIR filter, as a fraction of the prf");
    settings_class<doppler_settings>(module, "doppler_settings", "Settings of colour and power Doppler.")
        .member("depth", &doppler_settings::depth, "metres")
        .member("prf", &doppler_settings::prf, "pulse repetition frequency, hertz")
        .member("ensemble", &doppler_settings::ensemble, "pulses along each line")
        .member("box", &doppler_settings::box, "where velocities are measured")
        .member("wall", &doppler_settings::wall, "the wall filter")
        .member("average_length", &doppler_settings::average_length, "of the autocorrelation along lines, metres")
        .member("average_lines", &doppler_settings::average_lines, "and across them, in lines of the probe")
        .member("burst", &doppler_settings::burst, "length of the excitation, in cycles")
        .member("planes", &doppler_settings::planes, "1, 3, 5 or 7 elevation planes")
        .member("time", &doppler_settings::time, "of the first pulse, seconds")
        .member("noise_db", &doppler_settings::noise_db, "electronic noise")
        .member("seed", &doppler_settings::seed, "of the noise");
    settings_class<ensemble_settings>(module, "ensemble_settings", "How doppler_ensemble acquires a pulse train.")
        .member("depth", &ensemble_settings::depth, "metres")
        .member("samples", &ensemble_settings::samples, "depth samples of each line; 0: chosen")
        .member("prf", &ensemble_settings::prf, "pulse repetition frequency, hertz")
        .member("pulses", &ensemble_settings::pulses, "number of pulses along each line")
        .member("first", &ensemble_settings::first, "the first of them, where a train is acquired in parts")
        .member("from_", &ensemble_settings::from, "depth from which moving scatterers are needed, metres")
        .member("burst", &ensemble_settings::burst, "length of the excitation, in cycles")
        .member("planes", &ensemble_settings::planes, "1, 3, 5 or 7 elevation planes")
        .member("time", &ensemble_settings::time, "of pulse 0, seconds")
        .member("noise_db", &ensemble_settings::noise_db, "electronic noise")
        .member("seed", &ensemble_settings::seed, "of the noise");
    settings_class<spectrum_settings>(module, "spectrum_settings", "From a series of echoes to a spectrum.")
        .member("window", &spectrum_settings::window, "pulses of each spectrum, a power of two")
        .member("overlap", &spectrum_settings::overlap, "of successive windows, 0 to below 1")
        .member("baseline", &spectrum_settings::baseline, "shift of the range of velocities, -0.5 to 0.5 of its whole")
        .member("angle", &spectrum_settings::angle, "between line and flow, radians")
        .member("wall_order", &spectrum_settings::wall_order, "degree of the polynomial wall filter");
    settings_class<pulsed_doppler_settings>(module, "pulsed_doppler_settings", "Settings of pulsed Doppler.")
        .member("line", &pulsed_doppler_settings::line, "of the probe")
        .member("gate", &pulsed_doppler_settings::gate, "depth of the middle of the gate, metres")
        .member("gate_length", &pulsed_doppler_settings::gate_length, "metres")
        .member("prf", &pulsed_doppler_settings::prf, "pulse repetition frequency, hertz")
        .member("duration", &pulsed_doppler_settings::duration, "of the acquisition, seconds")
        .member("spectrum", &pulsed_doppler_settings::spectrum, "windows, baseline and angle")
        .member("burst", &pulsed_doppler_settings::burst, "length of the excitation, in cycles")
        .member("depth", &pulsed_doppler_settings::depth, "of the image, metres; 0: twice the depth of the gate")
        .member("planes", &pulsed_doppler_settings::planes, "1, 3, 5 or 7 elevation planes")
        .member("time", &pulsed_doppler_settings::time, "of the first pulse, seconds")
        .member("noise_db", &pulsed_doppler_settings::noise_db, "electronic noise")
        .member("seed", &pulsed_doppler_settings::seed, "of the noise");
    settings_class<doppler_picture_settings>(module, "doppler_picture_settings", "What counts as flow.")
        .member("size", &doppler_picture_settings::size, "columns, rows; a 0 is chosen")
        .member("min_power_db", &doppler_picture_settings::min_power_db, "weaker echoes show no flow")
        .member("min_velocity", &doppler_picture_settings::min_velocity, "slower flow is not shown, m/s");
    settings_class<colour_overlay_settings>(module, "colour_overlay_settings",
                                            "Colours of flow, and where they are shown.")
        .choice("map", &colour_overlay_settings::map,
                {{"velocity", doppler_map::velocity}, {"power", doppler_map::power}}, "what is shown")
        .member("max_velocity", &colour_overlay_settings::max_velocity, "of the brightest colour, m/s; 0: chosen")
        .member("power_range_db", &colour_overlay_settings::power_range_db, "from the darkest to the brightest colour")
        .member("min_power_db", &colour_overlay_settings::min_power_db, "weaker echoes show no flow")
        .member("min_velocity", &colour_overlay_settings::min_velocity, "slower flow is not shown, m/s")
        .member("max_grey", &colour_overlay_settings::max_grey, "brighter tissue is shown in grey");
}

/// A number of all samples, as an array of lines x samples.
py::array numbers_of(const py::object& self, float flow_sample::*number) {
    auto& own = py::cast<flow_lines&>(self);
    float* first = own.values.empty() ? nullptr : &(own.values[0].*number);
    constexpr auto step = static_cast<py::ssize_t>(sizeof(flow_sample));
    return py::array(py::dtype::of<float>(), {own.count, own.samples}, {step * own.samples, step}, first, self);
}

void bind_results(py::module_& module) {
    py::class_<flow_lines>(module, "flow_lines", "Velocity, power and variance along the lines of a probe.")
        .def_readonly("count", &flow_lines::count, "number of lines")
        .def_readonly("samples", &flow_lines::samples, "of each line")
        .def_readonly("depth", &flow_lines::depth, "to the end of the last sample, metres")
        .def_readonly("max_velocity", &flow_lines::max_velocity, "the largest that does not alias, m/s")
        .def_property_readonly(
            "velocity", [](const py::object& self) { return numbers_of(self, &flow_sample::velocity); },
            "count x samples, m/s, towards the probe positive: a view without a copy")
        .def_property_readonly(
            "power", [](const py::object& self) { return numbers_of(self, &flow_sample::power); },
            "likewise; 1 is that of a perfect mirror")
        .def_property_readonly(
            "variance", [](const py::object& self) { return numbers_of(self, &flow_sample::variance); },
            "of the velocity, (m/s)^2");
    py::class_<iq_ensemble>(module, "iq_ensemble", "Echoes of successive pulses along the same lines.")
        .def_readonly("prf", &iq_ensemble::prf, "pulse repetition frequency, hertz")
        .def_property_readonly(
            "pulses",
            [](const py::object& self) -> py::object {
                py::list pulses;
                for (iq_lines& each : py::cast<iq_ensemble&>(self).pulses)
                    pulses.append(py::cast(&each, py::return_value_policy::reference_internal, self));
                return py::tuple(pulses);
            },
            "iq_lines of each pulse, without a copy");
    py::class_<doppler_spectrum>(module, "doppler_spectrum", "Power by velocity, window after window.")
        .def_readonly("windows", &doppler_spectrum::windows, "number of windows")
        .def_readonly("bins", &doppler_spectrum::bins, "velocities of each")
        .def_readonly("first_time", &doppler_spectrum::first_time, "of the middle of the first window, seconds")
        .def_readonly("interval", &doppler_spectrum::interval, "from window to window, seconds")
        .def_readonly("lowest_velocity", &doppler_spectrum::lowest_velocity, "of bin 0, m/s")
        .def_readonly("step", &doppler_spectrum::step, "from bin to bin, m/s")
        .def_property_readonly(
            "power",
            [](const py::object& self) {
                auto& own = py::cast<doppler_spectrum&>(self);
                return array_over(own.power.data(), {own.windows, own.bins}, self);
            },
            "windows x bins: a view without a copy")
        .def("velocity", &doppler_spectrum::velocity, py::arg("bin"), "Velocity of a bin, m/s.")
        .def(
            "mean_velocity",
            [](const doppler_spectrum& self, std::uint32_t window) {
                if (window >= self.windows)
                    throw py::index_error("mean_velocity: the window is " + std::to_string(window) + " of " +
                                          std::to_string(self.windows) + ", counted from 0");
                return self.mean_velocity(window);
            },
            py::arg("window"), "The mean velocity of a window, m/s.");
}

} // namespace

void bind_flow(py::module_& module) {
    bind_fields(module);
    bind_doppler_settings(module);
    bind_results(module);
    module.def(
        "filter_walls",
        [](const iq_ensemble& echoes, const wall_filter& filter, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return filter_walls(chosen, echoes, filter); });
        },
        py::arg("echoes"), py::arg_v("filter", wall_filter{}, "wall_filter()"), py::kw_only(),
        py::arg("policy") = "par_unseq", "Removes the echoes of tissue from an ensemble.");
}

} // namespace insonify_python
