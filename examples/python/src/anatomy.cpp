// Regions of the body by code: the submodule `anatomy`.
#include "../../anatomy/regions.hpp"
#include "scene_past.hpp"
#include "tube_lines.hpp"
#include <algorithm>

namespace insonify_python {

/// A Python object, and its type in signatures.
template <class Type>
struct typed : py::object {
    using py::object::object;
    explicit typed(const py::object& one) : py::object{one} {}
};
struct scene_type {
    static constexpr auto name = py::detail::const_name("insonify.scene");
};
struct views_by_name {
    static constexpr auto name = py::detail::const_name("Mapping[str, insonify.anatomy.view]");
};
struct vessel_tuple {
    static constexpr auto name = py::detail::const_name("tuple[insonify.anatomy.vessel, ...]");
};
struct flow_list {
    static constexpr auto name = py::detail::const_name("list[insonify.tube_flow]");
};
struct composed_type {
    static constexpr auto name = py::detail::const_name("insonify.composed");
};
struct names_by_id {
    static constexpr auto name = py::detail::const_name("Mapping[int, str]");
};
struct numbers_by_name {
    static constexpr auto name = py::detail::const_name("Mapping[str, float]");
};
struct titles_by_name {
    static constexpr auto name = py::detail::const_name("dict[str, str]");
};

} // namespace insonify_python

namespace pybind11::detail {
template <class Type>
struct handle_type_name<insonify_python::typed<Type>> {
    static constexpr auto name = Type::name;
};
} // namespace pybind11::detail

namespace insonify_python {

namespace {

/// `anatomy::body` in Python.
struct region_body {
    py::object body_scene;
    py::dict views{};
    py::tuple vessels{};
    std::string region{};
    anatomy::values values{};
};

const char* word_of(anatomy::vessel::kind kind) { return kind == anatomy::vessel::kind::artery ? "artery" : "vein"; }

std::string repr_of(const py::object& one) { return py::cast<std::string>(py::repr(one)); }

/// @throws py::type_error  for a value that is not a number
anatomy::values values_of(const anatomy::region& region, std::optional<std::uint64_t> seed, const py::kwargs& given) {
    anatomy::values values = seed ? region.drawn(*seed) : anatomy::values{};
    for (const auto& [key, value] : given) {
        const auto name = py::cast<std::string>(key);
        py::detail::make_caster<float> number;
        if (!number.load(value, true))
            throw py::type_error("anatomy.make: `" + name + "` cannot be " +
                                 repr_of(py::reinterpret_borrow<py::object>(value)) + "; it is a number");
        values[name] = py::detail::cast_op<float>(number);
    }
    return region.completed(values);
}

region_body make_body(const std::string& name, std::optional<std::uint64_t> seed, const py::kwargs& given) {
    const anatomy::region& region = anatomy::find_region(name);
    const anatomy::values values = values_of(region, seed, given);
    anatomy::body made = [&] {
        const py::gil_scoped_release unlocked;
        return region.make(values);
    }();
    const object_id next = made.anatomy.add(make_box(vec3{0}, vec3{1_mm}), {}); // C++ may have removed others
    made.anatomy.remove(next);
    region_body body{.body_scene = py::cast(std::move(made.anatomy)), .region = name, .values = values};
    note_remove(body.body_scene, next);
    for (anatomy::view& one : made.views) {
        const std::string view = one.name;
        body.views[py::str(view)] = py::cast(std::move(one));
    }
    body.vessels = py::tuple(py::cast(std::move(made.vessels)));
    return body;
}

std::vector<anatomy::vessel> vessels_of(const region_body& body) {
    return py::cast<std::vector<anatomy::vessel>>(body.vessels);
}

anatomy::contact_pressure pressure_of(const std::vector<vec3>& face, float pressure) { return {face, pressure}; }

typed<flow_list> flow_of(const region_body& body, float heart_rate, float pressure, const std::vector<vec3>& face) {
    const auto& own = py::cast<const scene&>(body.body_scene);
    const std::vector<anatomy::vessel> vessels = vessels_of(body);
    anatomy::blood_flow flow = anatomy::flow_of(own, vessels, heart_rate, pressure_of(face, pressure));
    py::list all;
    for (std::size_t i = 0; i < vessels.size(); ++i) {
        const pose to_object = inverse(own[flow.tubes[i].object].at);
        const centre_line line = flow.tubes[i].line;
        all.append(line_flow{std::move(flow.tubes[i]), {anatomy::moved(vessels[i].line, to_object), {}, line}});
    }
    return typed<flow_list>{all};
}

typed<composed_type> motion_of(const region_body& body, const pulsation& beat, float pressure,
                               const std::vector<vec3>& face) {
    const std::vector<anatomy::vessel> vessels = vessels_of(body);
    const anatomy::vessel_motion motion = anatomy::motion_of(vessels, beat, pressure_of(face, pressure));
    py::list maps;
    const auto add = [&]<class Map>(const bent<Map>& one) {
        const auto its = std::find_if(vessels.begin(), vessels.end(),
                                      [&](const anatomy::vessel& of) { return centre_line{of.line} == one.line; });
        maps.append(line_map<Map>{one, {its->line, {}, one.line}});
    };
    for (const auto& one : motion.arteries) add(one);
    for (const auto& one : motion.veins) add(one);
    return typed<composed_type>{py::module_::import("insonify").attr("compose")(*maps)};
}

pose press_view(const region_body& body, const anatomy::view& seen) {
    auto& own = py::cast<scene&>(body.body_scene);
    const pose at = [&] {
        const py::gil_scoped_release unlocked;
        return anatomy::press_probe(own, seen);
    }();
    note_deform(body.body_scene, std::nullopt, false);
    return at;
}

/// Names and titles.
template <class Named>
typed<titles_by_name> titles_of(const std::vector<Named>& all) {
    py::dict titles;
    for (const Named& one : all) titles[py::str(one.name)] = one.title;
    return typed<titles_by_name>{titles};
}

void bind_parts(py::module_& module) {
    using anatomy::parameter, anatomy::vessel, anatomy::view;
    py::class_<parameter>(module, "parameter", "What varies from body to body: a size, or a choice.")
        .def_property_readonly("name", [](const parameter& self) { return self.name; })
        .def_property_readonly(
            "unit", [](const parameter& self) { return self.unit; }, "m or rad; empty for a ratio or a choice")
        .def_property_readonly(
            "description", [](const parameter& self) { return self.description; },
            "in words; those of a choice list the numbers")
        .def_readonly("min", &parameter::smallest)
        .def_readonly("max", &parameter::largest)
        .def_readonly("default", &parameter::usual)
        .def_readonly("is_choice", &parameter::is_choice, "a whole number")
        .def("__repr__", [](const parameter& self) {
            const auto text = [&](float number) { return insonify::detail::number_text(number); };
            return "<" + std::string{self.name} + ": " + text(self.smallest) + " to " + text(self.largest) +
                   (*self.unit ? " " : "") + self.unit + " (" + text(self.usual) + "): " + self.description + ">";
        });
    py::class_<vessel> vessels{module, "vessel", "A vessel with flowing blood."};
    vessels.def_readonly("name", &vessel::name, "of the object that is its blood")
        .def_property_readonly(
            "kind", [](const vessel& self) { return word_of(self.type); }, "artery or vein")
        .def_property_readonly(
            "line", [](const vessel& self) { return array_of_sections(self.line); },
            "of its lumen at rest, in the direction of flow: sections as centre_line takes them, N x 6; a copy")
        .def_readonly("peak_velocity", &vessel::peak_velocity,
                      "on the axis at the first section, of an artery in systole, m/s; below 0: towards it")
        .def_readonly("resistive_index", &vessel::resistive_index,
                      "of an artery: see pulsatile; the flow of veins is steady")
        .def_readonly("pressure", &vessel::pressure, "of the blood of a vein, Pa: see collapse")
        .def("__repr__",
             [](const vessel& self) { return "<" + std::string{word_of(self.type)} + " '" + self.name + "'>"; })
        .def(py::pickle(
            [](const vessel& self) {
                return py::make_tuple(self.name, self.type == vessel::kind::artery, array_of_sections(self.line),
                                      self.peak_velocity, self.resistive_index, self.pressure);
            },
            [](const py::tuple& state) {
                return vessel{.name = py::cast<std::string>(state[0]),
                              .type = py::cast<bool>(state[1]) ? vessel::kind::artery : vessel::kind::vein,
                              .line = sections_of(py::cast<float_array>(state[2]), "vessel: the line"),
                              .peak_velocity = py::cast<float>(state[3]),
                              .resistive_index = py::cast<float>(state[4]),
                              .pressure = py::cast<float>(state[5])};
            }));
    py::class_<view> views{module, "view", "A standard view of a region."};
    const auto needle_of = [](const view& self) -> std::optional<std::pair<vec3, vec3>> {
        if (!self.needle) return std::nullopt;
        return std::pair{self.needle->entry, self.needle->target};
    };
    views.def_readonly("name", &view::name)
        .def_readonly("title", &view::title, "in words")
        .def_readwrite("at", &view::at, "where the middle of the probe's face touches the skin; z points into the body")
        .def_property_readonly(
            "probe", [](const view& self) -> const auto& { return self.probe; },
            "what such a view is taken with; its settings can be changed")
        .def_readonly("settings", &view::settings, "likewise")
        .def_property_readonly("needle", needle_of, "where it enters the skin, and the target of its tip; or None")
        .def_readwrite("pressed", &view::pressed, "by which an operator presses the probe in, metres: see body.press")
        .def("__repr__", [](const view& self) { return "<view '" + self.name + "': " + self.title + ">"; })
        .def(py::pickle(
            [needle_of](const view& self) {
                return py::make_tuple(self.name, self.title, self.at, self.probe, self.settings, needle_of(self),
                                      self.pressed);
            },
            [](const py::tuple& state) {
                view made{.name = py::cast<std::string>(state[0]),
                          .title = py::cast<std::string>(state[1]),
                          .at = py::cast<pose>(state[2]),
                          .probe = py::cast<decltype(view::probe)>(state[3]),
                          .settings = py::cast<b_mode_settings>(state[4]),
                          .pressed = py::cast<float>(state[6])};
                if (const auto needle = py::cast<std::optional<std::pair<vec3, vec3>>>(state[5]))
                    made.needle = anatomy::needle_path{needle->first, needle->second};
                return made;
            }));
}

void bind_body(py::module_& module) {
    py::class_<region_body> bodies{module, "body", "A region of the body: made by make."};
    bodies
        .def_property_readonly(
            "scene", [](const region_body& self) { return typed<scene_type>{self.body_scene}; },
            "Not built: add tools, then call build. An object 'gel', of the lowest priority, lies on the skin.")
        .def_property_readonly(
            "views", [](const region_body& self) { return typed<views_by_name>{read_only(self.views)}; },
            "By name; the first is the one to begin with.")
        .def_property_readonly(
            "vessels", [](const region_body& self) { return typed<vessel_tuple>{self.vessels}; },
            "in which blood flows")
        .def_property_readonly(
            "labels",
            [](const region_body& self) {
                py::dict labels = py::dict(self.body_scene.attr("names"));
                labels[py::int_(background_label)] = "background";
                return typed<names_by_id>{read_only(labels)};
            },
            "What a label means: the names of the objects by their ids, with us.background_label. All differ.")
        .def_readonly("region", &region_body::region, "its name")
        .def_property_readonly(
            "values", [](const region_body& self) { return typed<numbers_by_name>{read_only(py::cast(self.values))}; },
            "of all parameters, given, drawn or by default")
        .def("flow", &flow_of, py::arg("heart_rate") = 1.2F, py::arg("pressure") = 0.0F,
             py::arg("face") = std::vector<vec3>{},
             "The velocity of the blood, for Doppler: a tube_flow for each vessel. Heart beats per second; 0: as in "
             "systole.\n"
             "`pressure`, Pa, at `face`: points of a face that presses on veins, see motion.")
        .def("motion", &motion_of, py::arg("beat"), py::arg("pressure") = 0.0F, py::arg("face") = std::vector<vec3>{},
             "How arteries pulse and veins collapse, for deform. `beat`: a pulsation, of an artery of its radius; that "
             "of\n"
             "others is in proportion to theirs. `pressure`, Pa: of the tissue at `face`, points along the face that\n"
             "presses; more than 24 mm below them it falls off.")
        .def("press", &press_view, py::arg("view"),
             "Presses the probe of a view into the skin as an operator does, and returns its pose: bone and cartilage\n"
             "stay, the tissue above them gives way. deform(compose()) puts the scene to rest.")
        .def(
            "press",
            [](const region_body& self, const std::string& name) {
                anatomy::body known;
                for (const auto& [_, one] : self.views) known.views.push_back(py::cast<const anatomy::view&>(one));
                return press_view(self, known.find_view(name));
            },
            py::arg("view"))
        .def("__repr__",
             [](const region_body& self) {
                 return "<" + self.region + " of " + std::to_string(py::len(self.body_scene.attr("names"))) +
                        " objects, views: " + py::cast<std::string>(py::str(", ").attr("join")(self.views)) + ">";
             })
        .def(py::pickle(
            [](const region_body& self) {
                return py::make_tuple(self.body_scene, self.views, self.vessels, self.region, self.values);
            },
            [](const py::tuple& state) {
                return region_body{state[0], state[1], state[2], py::cast<std::string>(state[3]),
                                   py::cast<anatomy::values>(state[4])};
            }));
}

} // namespace

void bind_anatomy(py::module_& module) {
    py::module_ own =
        module.def_submodule("anatomy", "Regions of the body by code: closed, labelled meshes and views.");
    bind_parts(own);
    bind_body(own);
    own.def(
        "regions", [] { return titles_of(anatomy::regions()); }, "The titles of all regions, by name.");
    own.def(
        "parameters", [](const std::string& region) { return anatomy::find_region(region).parameters; },
        py::arg("region"), "What varies in a region.");
    own.def(
        "views",
        [](const std::string& region) {
            const anatomy::region& found = anatomy::find_region(region);
            anatomy::values coarse; // the views are the same
            for (const anatomy::parameter& one : found.parameters)
                if (one.name == std::string{"resolution"}) coarse[one.name] = one.smallest;
            return titles_of(found.make(coarse).views);
        },
        py::arg("region"), "The titles of the views of a region, by name.");
    own.def("make", &make_body, py::arg("region"), py::kw_only(), py::arg("seed") = py::none(),
            "A region, by values of some of its parameters. `seed` draws the others but `resolution`; without it they "
            "have their defaults.");
}

} // namespace insonify_python
