// How the scene deforms: the maps of rest to now, and the probe that presses.
#include "scene_past.hpp"
#include "tube_lines.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <tuple>
#include <type_traits>

namespace insonify_python {

namespace {

/// Several maps of any types, one after the other; none: the identity.
struct composed_maps {
    struct map {
        std::function<vec3(vec3)> place;
        std::function<vec3(vec3)> rest; // empty: the map brings no inverse
        std::function<void()> check;
    };
    std::vector<map> maps{};
    std::optional<pressed_face> face{}; // the last one among them

    vec3 operator()(vec3 rest) const {
        for (const map& one : maps) rest = one.place(rest);
        return rest;
    }
    void check() const {
        for (const map& one : maps) one.check();
    }
};

/// The same of maps that all bring their inverse.
struct invertible_maps : composed_maps {
    vec3 rest_of(vec3 now) const {
        for (std::size_t i = maps.size(); i > 0; --i) now = maps[i - 1].rest(now);
        return now;
    }
};

/// Calls use(map) with a map of the type that knows its inverse, if there is one.
template <class Map, class Use>
void with_inverse(const Map& map, const Use& use) {
    if constexpr (std::is_same_v<Map, composed_maps>)
        if (std::all_of(map.maps.begin(), map.maps.end(), [](const auto& one) { return one.rest != nullptr; }))
            return use(invertible_maps{map});
    use(map);
}

/// All types of maps. Those that come later may be composed of the others.
using map_types = std::tuple<indentation, pressed_face, pulsation, collapse, line_map<pulsation>, line_map<collapse>,
                             breathing, needle_drag, displacement_grid, tetrahedra, composed_maps>;

template <class Map>
void check_settings(const Map& map) {
    if constexpr (requires { map.check(); }) map.check();
}

template <class Map>
bool is_identity(const Map& map) {
    if constexpr (std::is_same_v<Map, composed_maps>)
        return map.maps.empty();
    else
        return false;
}

/// Where points at rest are now, as an array of the same shape.
template <class Map>
py::array_t<float> mapped(const Map& map, const float_array& rest) {
    if (rest.ndim() < 1 || rest.shape(rest.ndim() - 1) != 3)
        throw usage_error{"a map takes points: an array whose last axis has 3 numbers"};
    check_settings(map);
    py::array_t<float> now(std::vector<py::ssize_t>(rest.shape(), rest.shape() + rest.ndim()));
    const float* from = rest.data();
    float* to = now.mutable_data();
    const py::ssize_t count = rest.size() / 3;
    const py::gil_scoped_release unlocked;
    for (py::ssize_t i = 0; i < count; ++i, from += 3, to += 3) {
        const vec3 place = map(vec3{from[0], from[1], from[2]});
        for (int axis = 0; axis < 3; ++axis) to[axis] = place[axis];
    }
    return now;
}

/// What all maps can do: place points, and deform a scene.
template <class Map>
void bind_map(py::class_<Map>& type, py::class_<scene>& scene_type) {
    type.def("__call__", &mapped<Map>, py::arg("rest"), "Where points at rest are now; an array of ... x 3.");
    scene_type.def(
        "deform",
        [](const py::object& self, const Map& map, const std::optional<std::vector<object_id>>& only,
           const std::string& policy) {
            auto& own = py::cast<scene&>(self);
            run(policy, [&](const auto& chosen) {
                with_inverse(map, [&](const auto& known) {
                    if (only)
                        own.deform(chosen, known, *only);
                    else
                        own.deform(chosen, known);
                });
            });
            note_deform(self, only, is_identity(map));
        },
        py::arg("map"), py::arg("only") = py::none(), py::kw_only(), py::arg("policy") = "par",
        "Deforms the body from rest. `only`: the ids of the objects that follow; the others, such as a needle, stay.");
}

/// A map of a straight vessel along a line.
template <class Map>
void bind_bent(py::module_& module, py::class_<scene>& scene_type, const char* name, const char* vessel) {
    settings_class<line_map<Map>> along{module, name, "A map of a straight vessel along one that bends: made by bent."};
    bind_line(along, "of the vessel at rest, in the world: a centre_line, or its sections");
    along.member("vessel", &bent<Map>::vessel, vessel);
    bind_map(along.type(), scene_type);
    module.def(
        "bent",
        [](const given_line& line, const Map& straight) {
            sectioned_line course = line_of(line);
            return line_map<Map>{{course.own, straight}, std::move(course)};
        },
        py::arg("line"), py::arg("vessel"),
        "A pulsation or a collapse along a vessel that bends, tapers and has elliptical sections: a map for deform.");
}

void bind_body_motion(py::module_& module, py::class_<scene>& scene_type) {
    settings_class<indentation> pressed{module, "indentation", "A flat face pressed into flat skin: a map for deform."};
    pressed.member("at", &indentation::at, "of the pressed face, to the world")
        .member("depth", &indentation::depth, "of the face below the skin at rest, metres; less than `decay`")
        .member("face", &indentation::face, "its size along x and y, metres")
        .member("decay", &indentation::decay, "depth at which the displacement is 1/e, metres")
        .member("recovery", &indentation::recovery, "distance beside the face at which it is, metres");
    bind_map(pressed.type(), scene_type);
    settings_class<pulsation> vessel{module, "pulsation", "A vessel that pulses, and the tissue around it: a map."};
    vessel.member("from_", &pulsation::from, "a point of the axis, metres")
        .member("to", &pulsation::to, "another one; the axis goes on beyond both")
        .member("radius", &pulsation::radius, "of the vessel at rest, metres")
        .member("amplitude", &pulsation::amplitude, "by which its wall moves outwards, metres")
        .member("rate", &pulsation::rate, "beats per second")
        .member("time", &pulsation::time, "seconds; whole beats are at rest");
    bind_map(vessel.type(), scene_type);
    settings_class<collapse> vein{module, "collapse", "A vessel that the pressure around it closes: a map for deform."};
    vein.member("from_", &collapse::from, "a point of the axis, metres")
        .member("to", &collapse::to, "another one; the axis goes on beyond both")
        .member("direction", &collapse::direction, "in which the vessel is flattened")
        .member("radius", &collapse::radius, "of the lumen at rest, metres")
        .member("outside", &collapse::outside, "pressure of the tissue around it, Pa, such as contact.pressure")
        .member("inside", &collapse::inside, "pressure of its blood, Pa")
        .member("stiffness", &collapse::stiffness, "of its wall against bending, Pa")
        .member("residual", &collapse::residual, "opening at which the walls touch, above 0 to 1")
        .member("beside", &collapse::beside, "distance beside the wall at which the displacement is 0.61, metres")
        .member("above", &collapse::above, "the same above and below its wall, metres");
    vein.type().def_property_readonly("opening", &collapse::opening, "height of the lumen over that at rest");
    bind_map(vein.type(), scene_type);
    bind_bent<pulsation>(module, scene_type, "bent_pulsation", "a pulsation; its `from_` and `to` do not count");
    bind_bent<collapse>(module, scene_type, "bent_collapse", "a collapse; its `from_` and `to` do not count");
    settings_class<breathing> breath{module, "breathing", "A region that moves back and forth: a map for deform."};
    breath.member("direction", &breathing::direction, "when breathing in")
        .member("amplitude", &breathing::amplitude, "metres")
        .member("centre", &breathing::centre, "where the motion is largest, metres")
        .member("extent", &breathing::extent, "distance from there at which it is 0.61, metres; more than `amplitude`")
        .member("rate", &breathing::rate, "breaths per second")
        .member("time", &breathing::time, "seconds; whole breaths are at rest");
    bind_map(breath.type(), scene_type);
    settings_class<needle_drag> drag{module, "needle_drag", "Tissue that moves with the shaft of a needle: a map."};
    drag.member("entry", &needle_drag::entry, "where the needle enters the tissue, metres")
        .member("tip", &needle_drag::tip, "metres")
        .member("drag", &needle_drag::drag, "displacement at the shaft towards the tip, metres")
        .member("extent", &needle_drag::extent, "distance at which it is 0.61, metres; more than `drag`");
    bind_map(drag.type(), scene_type);
}

/// @param displacements  size.z x size.y x size.x x 3
displacement_grid make_grid(float_array displacements, vec3 origin, vec3 spacing) {
    if (displacements.ndim() != 4 || displacements.shape(3) != 3)
        throw usage_error{"displacement_grid: `displacements` must be an array of nodes along z, y and x, of 3 metres "
                          "each"};
    const auto nodes = [&](int axis) { return static_cast<std::uint32_t>(displacements.shape(axis)); };
    displacement_grid made{.origin = origin, .spacing = spacing, .size = {nodes(2), nodes(1), nodes(0)}};
    made.displacements = rows_of(displacements.reshape({-1, 3}), "displacement_grid: the displacements");
    made.check();
    return made;
}

/// A map that a Python function gives, on a grid: one call with all nodes, so that no thread calls Python later.
displacement_grid sample_map(const py::function& map, vec3 lower, vec3 upper, float spacing) {
    displacement_grid made{.origin = lower, .spacing = vec3{spacing}};
    constexpr float largest = 1024; // nodes along an axis
    for (int axis = 0; axis < 3; ++axis) {
        const float steps = std::ceil((upper[axis] - lower[axis]) / spacing - 1e-3F);
        if (!(spacing > 0) || !(steps >= 1 && steps < largest))
            throw usage_error{"sample_map: `lower` must be below `upper`, with at most 1023 times `spacing` between "
                              "them along each axis"};
        made.size[axis] = static_cast<std::uint32_t>(steps) + 1;
    }
    const py::ssize_t count = py::ssize_t{made.size.x} * made.size.y * made.size.z;
    float_array rest(std::vector<py::ssize_t>{count, 3});
    float* to = rest.mutable_data();
    for (std::uint32_t z = 0; z < made.size.z; ++z)
        for (std::uint32_t y = 0; y < made.size.y; ++y)
            for (std::uint32_t x = 0; x < made.size.x; ++x, to += 3)
                for (int axis = 0; axis < 3; ++axis) to[axis] = lower[axis] + spacing * vec3{x, y, z}[axis];
    made.displacements = rows_of(rest, "sample_map: the points");
    const std::vector<vec3> now = rows_of(map(rest), "sample_map: what the function returns");
    if (now.size() != made.displacements.size())
        throw usage_error{"sample_map: the function was given " + std::to_string(count) + " x 3 points, and returned " +
                          std::to_string(now.size()) + " x 3; it must return where each of them is now"};
    for (std::size_t i = 0; i < now.size(); ++i) made.displacements[i] = now[i] - made.displacements[i];
    return made;
}

tetrahedra make_tetrahedra(const float_array& nodes, const index_array& cells) {
    if (cells.ndim() != 2 || cells.shape(1) != 4)
        throw usage_error{"tetrahedra: the cells must be an array of M x 4 indices of nodes"};
    std::vector<std::array<std::uint32_t, 4>> corners(static_cast<std::size_t>(cells.shape(0)));
    const std::int64_t* index = cells.data();
    for (auto& cell : corners)
        for (std::uint32_t& corner : cell) {
            if (*index < 0 || *index >= nodes.shape(0))
                throw geometry_error{"tetrahedra: a tetrahedron names node " + std::to_string(*index) +
                                     ", but there are " + std::to_string(nodes.shape(0)) + "; indices start at 0"};
            corner = static_cast<std::uint32_t>(*index++);
        }
    return {rows_of(nodes, "tetrahedra: the nodes"), std::move(corners)};
}

void bind_grids_of_nodes(py::module_& module, py::class_<scene>& scene_type) {
    py::class_<displacement_grid> grid{module, "displacement_grid", "Displacements on a regular grid: a map."};
    grid.def(py::init(&make_grid), py::arg("displacements"), py::arg("origin"), py::arg("spacing"),
             "Copies an array of nodes along z, y and x, of 3 metres each, from rest to now.")
        .def_readonly("origin", &displacement_grid::origin, "the first node, metres")
        .def_readonly("spacing", &displacement_grid::spacing, "of the nodes along x, y and z, metres")
        .def_readonly("size", &displacement_grid::size, "number of nodes along x, y and z")
        .def_property_readonly(
            "displacements",
            [](const py::object& self) {
                auto& own = py::cast<displacement_grid&>(self);
                return array_over(reinterpret_cast<float*>(own.displacements.data()),
                                  {own.size.z, own.size.y, own.size.x, 3}, self);
            },
            "size.z x size.y x size.x x 3, metres: a view to write into");
    bind_map(grid, scene_type);
    module.def(
        "sample_map", &sample_map, py::arg("map"), py::arg("lower"), py::arg("upper"), py::arg("spacing"),
        "A Python function as a displacement_grid between two corners: it is called once, with an array of N x 3 "
        "points at rest, and returns where they are now.");
    py::class_<tetrahedra> cells{module, "tetrahedra", "The tetrahedra of a finite-element engine: a map for deform."};
    cells
        .def(py::init(&make_tetrahedra), py::arg("nodes"), py::arg("cells"),
             "N x 3 positions at rest, metres, and M x 4 indices of nodes.")
        .def_property_readonly(
            "nodes",
            [](const py::object& self) {
                const std::span<vec3> nodes = py::cast<tetrahedra&>(self).nodes();
                return array_over(reinterpret_cast<float*>(nodes.data()), {static_cast<py::ssize_t>(nodes.size()), 3},
                                  self);
            },
            "Where the nodes are now, N x 3, metres: a view to write into each frame");
    bind_map(cells, scene_type);
}

/// Adds a map of one of the types, with its settings as they are now.
template <class... Maps>
composed_maps composed_of(const py::args& given, std::tuple<Maps...>*) {
    composed_maps made;
    for (const py::handle one : given) {
        const bool found = ((py::isinstance<Maps>(one) &&
                             [&] {
                                 const auto map = std::make_shared<const Maps>(py::cast<const Maps&>(one));
                                 std::function<vec3(vec3)> rest;
                                 if constexpr (invertible_map<Maps>)
                                     rest = [map](vec3 now) { return map->rest_of(now); };
                                 made.maps.push_back({[map](vec3 place) { return (*map)(place); }, rest,
                                                      [map] { check_settings(*map); }});
                                 if constexpr (std::is_same_v<Maps, composed_maps>) {
                                     if (map->face) made.face = map->face;
                                 } else if constexpr (!std::is_void_v<decltype(detail::face_of(*map))>) {
                                     made.face = detail::face_of(*map);
                                 }
                                 return true;
                             }()) ||
                            ...);
        if (!found)
            throw py::type_error("compose: not a map: " + py::cast<std::string>(py::repr(one)) +
                                 "; make one of a function by sample_map");
    }
    if (made.face && made.maps.size() > 1) {
        const kept_contact kept{made, *made.face};
        made.maps.push_back(
            {[kept](vec3 moved) { return kept(moved); }, [kept](vec3 now) { return kept.rest_of(now); }, [] {}});
    }
    return made;
}

void bind_contact(py::module_& module, py::class_<scene>& scene_type) {
    settings_class<press_settings>(module, "press_settings", "How a body yields to a probe.")
        .member("stiffness", &press_settings::stiffness, "of the body under the face, N/m")
        .member("gel", &press_settings::gel, "distance from the skin up to which a line touches, metres")
        .member("decay", &press_settings::decay, "depth at which the displacement is 1/e, metres")
        .member("recovery", &press_settings::recovery, "distance beside the face at which it is, metres")
        .member(
            "yields", &press_settings::yields,
            "where the face is so deep that tissue would fold over: whether it gives way as far as it can, or is an "
            "error");
    py::class_<pressed_face> face{module, "pressed_face", "A face pressed into any skin: a map, made by press."};
    face.def_property_readonly(
        "stop",
        [](const py::object& self) {
            auto& own = py::cast<pressed_face&>(self);
            return array_over(own.stop.front().data(), {pressed_face::rows, pressed_face::columns}, self);
        },
        "exp(-S / decay), where something stiff lies S metres below the skin; 0: nothing. Rows along y x columns along "
        "x, on the face and around it: a view without a copy");
    bind_map(face, scene_type);
    py::class_<contact>(module, "contact", "How a probe touches a body.")
        .def_readonly("depth", &contact::depth, "of the face in the body at rest, metres: the largest")
        .def_readonly("mean_depth", &contact::mean_depth, "the mean over the face, metres")
        .def_readonly("force", &contact::force, "stiffness times mean depth, N")
        .def_readonly("pressure", &contact::pressure, "force over the part of the face that is pressed, Pa")
        .def_readonly("touching", &contact::touching, "number of lines that touch the body")
        .def_property_readonly(
            "lines",
            [](const py::object& self) {
                auto& own = py::cast<contact&>(self);
                return array_over(reinterpret_cast<bool*>(own.lines.data()),
                                  {static_cast<py::ssize_t>(own.lines.size())}, self);
            },
            "whether each line touches: a view without a copy")
        .def_readonly("deformation", &contact::deformation, "a map for deform");
}

} // namespace

void bind_motion(py::module_& module) {
    auto scene_type = py::reinterpret_borrow<py::class_<scene>>(module.attr("scene"));
    bind_body_motion(module, scene_type);
    bind_contact(module, scene_type);
    bind_grids_of_nodes(module, scene_type);
    py::class_<composed_maps> composed{module, "composed", "Several maps, one after the other: made by compose."};
    bind_map(composed, scene_type);
    module.def(
        "compose", [](const py::args& maps) { return composed_of(maps, static_cast<map_types*>(nullptr)); },
        "One map of several, from the first to the last; of none, the identity, which puts a body to rest.");
    scene_type.def(
        "deform",
        [](const scene&, const py::function&, const py::args&, const py::kwargs&) {
            throw py::type_error("deform: a Python function is sampled first, as threads cannot call it: "
                                 "deform(sample_map(function, lower, upper, spacing))");
        },
        py::arg("map"), "Not for Python functions: see sample_map.");
    scene_type.def("rest_of", &scene::rest_of, py::arg("now"), py::arg("of") = py::none(),
                   "Where the tissue of an object, or of the background, that is now at a point was at rest.");
}

} // namespace insonify_python
