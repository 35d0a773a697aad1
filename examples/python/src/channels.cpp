// Channel data: what each element of an array receives.
#include "bindings.hpp"
#include "custom_array.hpp"
#include <algorithm>
#include <complex>
#include <cstddef>
#include <cstring>
#include <tuple>

namespace insonify_python {

/// Its type in signatures.
struct transmit_tuple : py::tuple {
    using py::tuple::tuple;
};

} // namespace insonify_python

template <>
struct pybind11::detail::handle_type_name<insonify_python::transmit_tuple> {
    static constexpr auto name = const_name("tuple[insonify.transmit, ...]");
};

namespace insonify_python {

namespace {

/// `channel_settings` that own their points.
struct settings_with_points : channel_settings {
    std::vector<point_scatterer> own{};

    /// Valid as long as these are.
    channel_settings viewed() const {
        channel_settings made = *this;
        made.points = own;
        return made;
    }

    friend bool operator==(const settings_with_points& a, const settings_with_points& b) {
        const auto numbers = [](const settings_with_points& s) {
            return std::tie(s.depth, s.sampling_frequency, s.opening, s.speckle, s.surfaces, s.wave_fronts,
                            s.noise_level_db, s.noise_seed, s.frame, s.max_memory);
        };
        return numbers(a) == numbers(b) && std::equal(a.own.begin(), a.own.end(), b.own.begin(), b.own.end(),
                                                      [](const point_scatterer& one, const point_scatterer& other) {
                                                          return one.position == other.position &&
                                                                 one.scattering_length == other.scattering_length;
                                                      });
    }
};

using point_arrays = std::pair<float_array, float_array>;

/// Copies, which refuse changes.
point_arrays points_of(const settings_with_points& self) {
    std::vector<vec3> positions;
    float_array lengths(static_cast<py::ssize_t>(self.own.size()));
    for (const point_scatterer& one : self.own) {
        lengths.mutable_at(static_cast<py::ssize_t>(positions.size())) = one.scattering_length;
        positions.push_back(one.position);
    }
    lengths.attr("setflags")(py::arg("write") = false);
    return {array_of_rows(positions), lengths};
}

void set_points(settings_with_points& self, const point_arrays& given) {
    const std::vector<vec3> positions = rows_of(given.first, "channel_settings: the positions of `points`");
    const float_array& lengths = given.second;
    if (lengths.ndim() != 1 || static_cast<std::size_t>(lengths.size()) != positions.size())
        throw usage_error{"channel_settings: `points` are " + std::to_string(positions.size()) +
                          " positions; state as many scattering lengths, an array of one dimension"};
    self.own.clear();
    for (std::size_t i = 0; i < positions.size(); ++i) self.own.push_back({positions[i], lengths.data()[i]});
}

template <class Sample>
using number_of = std::conditional_t<std::is_same_v<Sample, vec2>, std::complex<float>, float>;
template <class Sample>
using samples_given = std::conditional_t<std::is_same_v<Sample, float>, float_array,
                                         py::array_t<std::complex<float>, py::array::c_style | py::array::forcecast>>;

/// Channel data of arrays, without the numbers beside them.
/// @throws usage_error  for arrays of another shape
template <class Sample>
channel_grid<Sample> channels_of(const samples_given<Sample>& values, const std::vector<transmit>& sent,
                                 const float_array& places, const std::string& name) {
    if (values.ndim() != 3)
        throw usage_error{name + ": `values` must be an array of transmits x elements x samples, not of " +
                          std::to_string(values.ndim()) + " dimensions"};
    if (places.ndim() != 3 || places.shape(0) != values.shape(1) || places.shape(1) != 2 || places.shape(2) != 3)
        throw usage_error{name + ": `places` must be an array of elements x 2 x 3, the centre and the normal of each "
                                 "of the elements of `values`"};
    if (static_cast<py::ssize_t>(sent.size()) != values.shape(0))
        throw usage_error{name + ": `sent` are " + std::to_string(sent.size()) + " transmits, but `values` are of " +
                          std::to_string(values.shape(0))};
    channel_grid<Sample> made;
    made.transmits = static_cast<std::uint32_t>(values.shape(0));
    made.elements = static_cast<std::uint32_t>(values.shape(1));
    made.samples = static_cast<std::uint32_t>(values.shape(2));
    made.values.resize(static_cast<std::size_t>(values.size()));
    if (!made.values.empty())
        std::memcpy(static_cast<void*>(made.values.data()), values.data(), sizeof(Sample) * made.values.size());
    made.sent = sent;
    const auto place = places.unchecked<3>();
    for (py::ssize_t i = 0; i < places.shape(0); ++i)
        made.places.push_back({.origin = {place(i, 0, 0), place(i, 0, 1), place(i, 0, 2)},
                               .direction = {place(i, 1, 0), place(i, 1, 1), place(i, 1, 2)}});
    return made;
}

/// References: what is changed in a transmit is changed in the data.
template <class Sample>
transmit_tuple sent_of(const py::object& self) {
    py::list all;
    for (transmit& each : py::cast<channel_grid<Sample>&>(self).sent)
        all.append(py::cast(&each, py::return_value_policy::reference_internal, self));
    return transmit_tuple{all};
}

template <class Sample>
py::array places_of(const py::object& self) {
    auto& own = py::cast<channel_grid<Sample>&>(self);
    static_assert(offsetof(ray, origin) == 0 && offsetof(ray, direction) == sizeof(vec3));
    return py::array(py::dtype::of<float>(), std::vector<py::ssize_t>{own.elements, 2, 3},
                     std::vector<py::ssize_t>{sizeof(ray), sizeof(vec3), sizeof(float)},
                     reinterpret_cast<float*>(own.places.data()), self);
}

template <class Sample>
void bind_channel_grid(py::module_& module, const char* name, const char* page) {
    using data = channel_grid<Sample>;
    static_assert(sizeof(number_of<Sample>) == sizeof(Sample));
    py::class_<data> type{module, name, page};
    bind_copies(type);
    const auto make = [name = std::string{name}](const samples_given<Sample>& values, const std::vector<transmit>& sent,
                                                 const float_array& places, float sampling_frequency, float frequency,
                                                 float start, float bandwidth, float sound_speed, float pitch,
                                                 float element_width, float height, float elevation_focus) {
        data made = channels_of<Sample>(values, sent, places, name);
        made.sampling_frequency = sampling_frequency;
        made.frequency = frequency;
        made.start = start;
        made.bandwidth = bandwidth;
        made.sound_speed = sound_speed;
        made.pitch = pitch;
        made.element_width = element_width;
        made.height = height;
        made.elevation_focus = elevation_focus;
        return made;
    };
    type.def(py::init(make), py::arg("values"), py::arg("sent"), py::arg("places"), py::kw_only(),
             py::arg("sampling_frequency"), py::arg("frequency"), py::arg("start") = 0.0F, py::arg("bandwidth") = 0.0F,
             py::arg("sound_speed") = display_speed, py::arg("pitch") = 0.0F, py::arg("element_width") = 0.0F,
             py::arg("height") = 0.0F, py::arg("elevation_focus") = 0.0F,
             "Copies an array of transmits x elements x samples, and one of elements x 2 x 3: centre and normal of "
             "each.")
        .def(py::pickle(
            [](const py::object& self) {
                py::tuple state(12);
                std::size_t i = 0;
                for (const char* member :
                     {"values", "sent", "places", "sampling_frequency", "frequency", "start", "bandwidth",
                      "sound_speed", "pitch", "element_width", "height", "elevation_focus"})
                    state[i++] = self.attr(member);
                return state;
            },
            [make](const py::tuple& state) {
                const auto number = [&](std::size_t i) { return py::cast<float>(state[i]); };
                return make(py::cast<samples_given<Sample>>(state[0]), py::cast<std::vector<transmit>>(state[1]),
                            py::cast<float_array>(state[2]), number(3), number(4), number(5), number(6), number(7),
                            number(8), number(9), number(10), number(11));
            }))
        .def_readonly("transmits", &data::transmits, "number of transmits")
        .def_readonly("elements", &data::elements, "that receive")
        .def_readonly("samples", &data::samples, "of each element")
        .def_readwrite("sampling_frequency", &data::sampling_frequency, "hertz")
        .def_readwrite("start", &data::start, "time of the first sample after the first element fires, seconds")
        .def_readwrite("frequency", &data::frequency, "of the carrier, hertz")
        .def_readwrite("bandwidth", &data::bandwidth, "fractional, of the pulse there and back, at -6 dB")
        .def_readwrite("sound_speed", &data::sound_speed, "that delays assume, m/s")
        .def_readwrite("pitch", &data::pitch, "mean distance of neighbouring elements, metres")
        .def_readwrite("element_width", &data::element_width, "metres")
        .def_readwrite("height", &data::height, "of the elements, metres")
        .def_readwrite("elevation_focus", &data::elevation_focus, "of the lens, metres")
        .def_property_readonly("places", &places_of<Sample>,
                               "elements x 2 x 3: centre and normal, in the frame of the probe; a view without a copy")
        .def_property_readonly("sent", &sent_of<Sample>, "the transmits, without a copy")
        .def_property_readonly(
            "values",
            [](const py::object& self) {
                auto& own = py::cast<data&>(self);
                return array_over(reinterpret_cast<number_of<Sample>*>(own.values.data()),
                                  {own.transmits, own.elements, own.samples}, self);
            },
            "transmits x elements x samples, a view without a copy")
        .def("__array__",
             [](const py::object& self, const py::args& how) { return self.attr("values").attr("__array__")(*how); })
        .def("__eq__", [](const data& one, const data& other) { return one == other; })
        .def("__repr__", [name = std::string{name}](const data& self) {
            return "<" + name + " of " + std::to_string(self.transmits) + " transmits, " +
                   std::to_string(self.elements) + " elements and " + std::to_string(self.samples) + " samples>";
        });
}

template <class Array>
void bind_trace(py::module_& module) {
    module.def(
        "trace_channels",
        [](const scene& body, const Array& array, const pose& at, const physical<>& model,
           const std::vector<transmit>& sent, const settings_with_points& settings, const std::string& policy) {
            return run(policy, [&](const auto& chosen) {
                return trace_channels(chosen, body, array, at, model, sent, settings.viewed());
            });
        },
        py::arg("scene"), py::arg("array"), py::arg("pose"), py::arg("model"), py::arg("sent"),
        py::arg_v("settings", settings_with_points{}, "channel_settings()"), py::kw_only(),
        py::arg("policy") = "par_unseq", "What each element receives of each transmit.");
}

} // namespace

void bind_channels(py::module_& module) {
    settings_class<settings_with_points>(module, "channel_settings", "How channel data are made.")
        .member("depth", &channel_settings::depth, "to be recorded, metres")
        .member("sampling_frequency", &channel_settings::sampling_frequency, "hertz; 0: four times the carrier")
        .member("opening", &channel_settings::opening,
                "beyond the ends of the array: the slice that is covered, radians")
        .member("speckle", &channel_settings::speckle, "scatterers of tissue")
        .member("surfaces", &channel_settings::surfaces, "echoes of surfaces")
        .member("wave_fronts", &channel_settings::wave_fronts,
                "each transmit is one wave front: faster, without the waves from the ends of the aperture")
        .member("noise_level_db", &channel_settings::noise_level_db, "of electronic noise, rms; no_level_db: none")
        .member("noise_seed", &channel_settings::noise_seed, "selects a realization of the noise")
        .member("frame", &channel_settings::frame, "number of the frame")
        .member("max_memory", &channel_settings::max_memory, "bytes, of what is returned and of what it takes")
        .property("points", &points_of, &set_points,
                  "scatterers of one's own: their positions in the world, N x 3, metres, and N scattering lengths, "
                  "metres");
    bind_channel_grid<float>(module, "channel_data",
                             "RF of each element and transmit; 1 is the echo of a perfect mirror.");
    bind_channel_grid<vec2>(module, "iq_channel_data", "Complex baseband of each element and transmit.");
    bind_trace<element_array>(module);
    bind_trace<convex_element_array>(module);
    bind_trace<custom_element_array>(module);
    refuse_others(module, "trace_channels", 6,
                  {{"scene", "a scene", fits<scene>},
                   array_argument(),
                   {"pose", "a pose", fits<pose>},
                   {"model", "physical(...)", fits<physical<>>},
                   {"sent", "a list of transmits", fits<std::vector<transmit>>},
                   {"settings", "channel_settings(...)", fits<settings_with_points>, true},
                   {"policy", "the name of a policy, such as \"par_unseq\"", fits<std::string>, true}});
    module.def(
        "demodulate",
        [](const channel_data& received, const std::string& policy) {
            return run(policy, [&](const auto& chosen) { return demodulate(chosen, received); });
        },
        py::arg("received"), py::kw_only(), py::arg("policy") = "par_unseq",
        "Complex baseband of RF; its magnitude is the envelope.");
}

} // namespace insonify_python
