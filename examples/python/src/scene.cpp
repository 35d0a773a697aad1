// Poses, meshes and the scene.
#include "scene_past.hpp"
#include <cstring>

namespace insonify_python {

std::vector<vec3> rows_of(const float_array& numbers, const char* what) {
    if (numbers.ndim() != 2 || numbers.shape(1) != 3)
        throw usage_error{std::string{what} + " must be an array of N x 3 numbers"};
    std::vector<vec3> rows(static_cast<std::size_t>(numbers.shape(0)));
    if (!rows.empty()) std::memcpy(static_cast<void*>(rows.data()), numbers.data(), sizeof(vec3) * rows.size());
    return rows;
}

float_array array_of_rows(const std::vector<vec3>& rows) {
    float_array made(std::vector<py::ssize_t>{static_cast<py::ssize_t>(rows.size()), 3});
    if (!rows.empty()) std::memcpy(made.mutable_data(), rows.data(), sizeof(vec3) * rows.size());
    made.attr("setflags")(py::arg("write") = false);
    return made;
}

py::object read_only(const py::dict& values) { return py::module_::import("types").attr("MappingProxyType")(values); }

namespace {

mesh make_mesh(const float_array& positions, const index_array& faces) {
    if (positions.ndim() != 2 || positions.shape(1) != 3 || faces.ndim() != 2 || faces.shape(1) != 3)
        throw usage_error{"a mesh needs an array of N x 3 positions in metres and one of M x 3 vertex indices"};
    mesh made;
    made.positions = rows_of(positions, "mesh: the positions");
    made.faces.resize(static_cast<std::size_t>(faces.shape(0)));
    const std::int64_t* index = faces.data();
    for (uvec3& face : made.faces)
        for (int corner = 0; corner < 3; ++corner, ++index) {
            if (*index < 0 || *index >= positions.shape(0))
                throw geometry_error{"a face names vertex " + std::to_string(*index) + ", but the mesh has " +
                                     std::to_string(positions.shape(0)) + "; indices start at 0"};
            face[corner] = static_cast<std::uint32_t>(*index);
        }
    return made;
}

float_array matrix_of(const pose& at) {
    float_array made({4, 4});
    auto m = made.mutable_unchecked<2>();
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            m(row, column) = row == 3      ? (column == 3 ? 1.0F : 0.0F)
                             : column == 3 ? at.translation[row]
                                           : at.rotation[column][row];
    return made;
}

float_array rotation_of(const pose& at) {
    float_array made({3, 3});
    auto m = made.mutable_unchecked<2>();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) m(row, column) = at.rotation[column][row];
    return made;
}

/// The pose of a matrix, which need not be rigid.
pose parts_of(const float_array& matrix) {
    if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4)
        throw usage_error{"a pose is made of a 4 x 4 matrix"};
    const auto m = matrix.unchecked<2>();
    pose made;
    for (int row = 0; row < 3; ++row) {
        made.translation[row] = m(row, 3);
        for (int column = 0; column < 3; ++column) made.rotation[column][row] = m(row, column);
    }
    return made;
}

pose pose_of(const float_array& matrix) {
    const pose made = parts_of(matrix);
    if (!is_rigid(made))
        throw geometry_error{"the matrix of a pose must be a rotation and a translation, in metres; orthonormalised "
                             "mends one that is inexact"};
    return made;
}

pose pose_of_parts(const std::optional<float_array>& rotation, vec3 translation) {
    pose made{.translation = translation};
    if (rotation) {
        if (rotation->ndim() != 2 || rotation->shape(0) != 3 || rotation->shape(1) != 3)
            throw usage_error{"the rotation of a pose is a 3 x 3 matrix"};
        const auto m = rotation->unchecked<2>();
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) made.rotation[column][row] = m(row, column);
    }
    if (!is_rigid(made))
        throw geometry_error{"the rotation of a pose must be orthonormal, without reflection, and its translation at "
                             "most 1000 km, in metres"};
    return made;
}

void bind_meshes(py::module_& module) {
    py::class_<pose> poses{module, "pose", "Rigid transform from local to world coordinates."};
    bind_copies(poses);
    poses.def(py::init<>())
        .def(py::init(&pose_of), py::arg("matrix"), "4 x 4 matrix, from local to world, metres")
        .def(py::init(&pose_of_parts), py::arg("rotation") = py::none(), py::arg("translation") = vec3{0, 0, 0},
             "3 x 3 rotation, by default the identity, and translation, metres")
        .def(py::pickle(&matrix_of, &parts_of)) // one that has drifted, too
        .def_property_readonly("matrix", &matrix_of, "4 x 4, from local to world: a copy")
        .def_property_readonly("rotation", &rotation_of, "3 x 3, from local to world: a copy")
        .def_property_readonly(
            "translation", [](const pose& self) { return self.translation; }, "metres")
        .def("point", &pose::point, py::arg("p"), "From local to world coordinates.")
        .def("local_point", &pose::local_point, py::arg("p"), "From world to local coordinates.")
        .def("__matmul__", [](const pose& outer, const pose& inner) { return outer * inner; })
        .def("__eq__", [](const pose& one, const pose& other) { return one == other; })
        .def("__repr__", [](const pose& self) {
            return "pose(" + py::cast<std::string>(py::repr(matrix_of(self).attr("tolist")())) + ")";
        });
    module.def(
        "inverse", [](const pose& self) { return inverse(self); }, py::arg("pose"), "The inverse transform.");
    const char* mended =
        "The pose with the nearest rotation, of one that rounding has made inexact, or of a 4 x 4 matrix.";
    module.def("orthonormalised", &orthonormalised, py::arg("pose"), mended);
    module.def(
        "orthonormalised", [](const float_array& matrix) { return orthonormalised(parts_of(matrix)); },
        py::arg("matrix"));
    module.def("needle_pose", &needle_pose, py::arg("tip"), py::arg("direction"), py::arg("bevel"),
               "Where a needle of make_needle is: its tip, where it points, and to which side its bevel faces.");
    module.def("look_at", &look_at, py::arg("from_"), py::arg("towards"), py::arg("lateral"),
               "Pose of a probe at `from_` that faces `towards` a point, its array along `lateral`.");

    py::class_<mesh> meshes{module, "mesh", "Indexed triangle mesh; faces are counter-clockwise seen from outside."};
    bind_copies(meshes);
    meshes.def(py::init(&make_mesh), py::arg("positions"), py::arg("faces"), "Copies N x 3 metres and M x 3 indices.")
        .def_property_readonly(
            "positions",
            [](const py::object& self) {
                auto& own = py::cast<mesh&>(self);
                return array_over(reinterpret_cast<float*>(own.positions.data()),
                                  {static_cast<py::ssize_t>(own.positions.size()), 3}, self);
            },
            "N x 3, metres: a view without a copy")
        .def_property_readonly(
            "faces",
            [](const py::object& self) {
                auto& own = py::cast<mesh&>(self);
                return array_over(reinterpret_cast<std::uint32_t*>(own.faces.data()),
                                  {static_cast<py::ssize_t>(own.faces.size()), 3}, self);
            },
            "M x 3, vertex indices: a view without a copy")
        .def(py::pickle(
            [](const py::object& self) { return py::make_tuple(self.attr("positions"), self.attr("faces")); },
            [](const py::tuple& state) {
                return make_mesh(py::cast<float_array>(state[0]), py::cast<index_array>(state[1]));
            }));
    module.def("make_box", &make_box, py::arg("lower"), py::arg("upper"), py::arg("subdivisions") = 0, "A box.");
    module.def("make_sphere", &make_sphere, py::arg("centre"), py::arg("radius"), py::arg("subdivisions") = 4,
               "A sphere.");
    module.def("make_cylinder", &make_cylinder, py::arg("from_"), py::arg("to"), py::arg("radius"),
               py::arg("segments") = 64, py::arg("segments_along") = 1, "A closed cylinder.");
    module.def(
        "make_needle",
        [](float diameter, float length, float bevel) { return make_needle(diameter, length, {.bevel = bevel}); },
        py::arg("diameter"), py::arg("length"), py::arg("bevel") = needle_settings{}.bevel,
        "A solid needle along z with its tip at (-diameter / 2, 0, 0); the bevel faces +x.");
    module.def("needle_diameter", &needle_diameter, py::arg("gauge"),
               "Outer diameter of a needle of 14 to 30 gauge, metres.");
    module.def(
        "validate", [](const mesh& surface) { return explain(validate(surface)); }, py::arg("mesh"),
        "What is wrong with a mesh, in a sentence.");
    module.def(
        "repair",
        [](const mesh& surface, float weld_distance) {
            repaired_mesh done = repair(surface, {.weld_distance = weld_distance});
            return std::pair{std::move(done.surface), std::move(done.notes)};
        },
        py::arg("mesh"), py::arg("weld_distance") = repair_settings{}.weld_distance,
        "A mesh that encloses a volume, as far as it is clear how, and a list of sentences about what was done.");
}

/// The arrays of vertices that were handed out and still exist: id, weak reference, and whether it can be written.
py::list held_views(const py::object& self) {
    py::list held;
    if (py::hasattr(self, "_views"))
        for (const py::handle entry : self.attr("_views"))
            if (!entry[py::int_(1)]().is_none()) held.append(entry);
    self.attr("_views") = held;
    return held;
}

py::array held_view(const py::object& self, object_id id, vec3* places, std::size_t count, bool writable) {
    py::array made = array_over(reinterpret_cast<float*>(places), {static_cast<py::ssize_t>(count), 3}, self);
    if (!writable) made.attr("setflags")(py::arg("write") = false);
    held_views(self).append(py::make_tuple(id, py::weakref(made), writable));
    return made;
}
py::array positions_of(const py::object& self, object_id id) {
    note_positions(self, id);
    const std::span<vec3> places = py::cast<scene&>(self).positions(id);
    return held_view(self, id, places.data(), places.size(), true);
}
py::array rest_positions_of(const py::object& self, object_id id) {
    const std::span<const vec3> places = py::cast<scene&>(self).rest_positions(id);
    return held_view(self, id, const_cast<vec3*>(places.data()), places.size(), false);
}

/// Arrays of `positions` that are held count as written.
/// @throws usage_error  for one that is no longer that of its object
void count_as_written(const py::object& self) {
    auto& own = py::cast<scene&>(self);
    for (const py::handle entry : held_views(self)) {
        if (!py::cast<bool>(entry[py::int_(2)])) continue;
        const auto id = py::cast<object_id>(entry[py::int_(0)]);
        const py::array held = entry[py::int_(1)]();
        if (held.data() != own.positions(id).data())
            throw usage_error{"scene::update: an array of positions(" + std::to_string(static_cast<std::uint32_t>(id)) +
                              ") is out of date; ask for it again after add, remove or build"};
    }
}

void remove_from(const py::object& self, object_id id) {
    check_not_held(self, id, "scene::remove");
    py::cast<scene&>(self).remove(id);
    note_remove(self, id);
}

} // namespace

void check_not_held(const py::object& self, object_id id, const char* caller) {
    for (const py::handle entry : held_views(self))
        if (py::cast<object_id>(entry[py::int_(0)]) == id)
            throw usage_error{std::string{caller} + ": an array of positions(" +
                              std::to_string(static_cast<std::uint32_t>(id)) + ") is still in use; delete it first"};
}

void bind_scene(py::module_& module) {
    bind_meshes(module);
    py::class_<scene> scenes{module, "scene", py::dynamic_attr(),
                             "Closed surfaces, each filled with a medium, in a background."};
    bind_pickling(scenes, module);
    scenes.def(py::init<const medium&>(), py::arg_v("background", medium{}, "medium()"))
        .def(
            "add",
            [](scene& self, const mesh& surface, const medium& inside, int priority, const pose& at, std::string name,
               vec3 fibres, const layer_direction& layer_normal, float crease_angle) {
                return self.add(surface, inside,
                                {.priority = priority,
                                 .at = at,
                                 .name = std::move(name),
                                 .fibres = fibres,
                                 .layer_normal = layers_of(layer_normal),
                                 .crease_angle = crease_angle});
            },
            py::arg("mesh"), py::arg("medium"), py::kw_only(), py::arg("priority") = 0,
            py::arg_v("at", pose{}, "pose()"), py::arg("name") = "", py::arg("fibres") = vec3{0, 0, 0},
            py::arg("layer_normal") = layer_direction{vec3{0, 0, 0}},
            py::arg("crease_angle") = object_settings{}.crease_angle,
            "Adds a closed surface and returns its id, which is also its label. Layers of its structure lie across\n"
            "layer_normal, or are parallel to the surface where it is \"own_surface\".")
        .def("remove", &remove_from, py::arg("id"), "Call build afterwards.")
        .def("place", &scene::place, py::arg("id"), py::arg("at"), "Sets the pose of an object; takes effect at once.")
        .def(
            "set_medium",
            [](const py::object& self, object_id id, const medium& inside) {
                py::cast<scene&>(self).set_medium(id, inside);
                note_medium(self, id);
            },
            py::arg("id"), py::arg("medium"), "Sets what fills an object; takes effect at once.")
        .def(
            "set_background_fibres",
            [](const py::object& self, vec3 along, vec3 flat) {
                py::cast<scene&>(self).set_background_fibres(along, flat);
                past_of(self).background_fibres = {along, flat};
            },
            py::arg("along"), py::arg("flat") = vec3{0, 0, 1},
            "Sets the axes of the structure of the background: along its fibres, and where it is flattest.")
        .def("positions", &positions_of, py::arg("id"),
             "Vertices of an object, N x 3, in its own coordinates: a view to write into, then call update; it may be "
             "held "
             "from frame to frame. Ask again after add or remove.")
        .def("rest_positions", &rest_positions_of, py::arg("id"),
             "The same at rest, before `deform`: a view to be read. Ask again after the first deform, add or remove.")
        .def(
            "build",
            [](py::object self, const std::string& policy) {
                auto& own = py::cast<scene&>(self);
                run(policy, [&](const auto& chosen) { own.build(chosen); });
                note_build(self);
                return self;
            },
            py::arg("policy") = "par", "Needed after add and remove; returns the scene.")
        .def(
            "update",
            [](const py::object& self, const std::string& policy) {
                count_as_written(self);
                auto& own = py::cast<scene&>(self);
                run(policy, [&](const auto& chosen) { own.update(chosen); });
            },
            py::arg("policy") = "par",
            "Needed after moving objects or vertices. An array of positions that is held counts as written.")
        .def(
            "find", [](const scene& self, const std::string& name) { return self.find(name); }, py::arg("name"),
            "The id of the object of a name, or None.")
        .def(
            "box",
            [](const scene& self, std::optional<object_id> of) {
                const aabb box = of ? self.box(*of) : self.box();
                return std::pair{box.lower, box.upper};
            },
            py::arg("id") = py::none(), "Lower and upper corner of all objects, or of one.")
        .def_property_readonly(
            "names",
            [](const scene& self) {
                py::dict names;
                for (const object& one : self.objects()) names[py::cast(one.id)] = one.name;
                return read_only(names);
            },
            "Name of each object, by its id: to be read.")
        .def_property_readonly(
            "media",
            [](const scene& self) {
                py::dict media;
                for (const object& one : self.objects()) media[py::cast(one.id)] = one.inside;
                return read_only(media);
            },
            "Medium of each object, by its id: copies, to be read; set_medium changes one.")
        .def("is_inside_out", &scene::is_inside_out, py::arg("id"),
             "Whether an object was turned inside out since it was added, as by a simulation that diverges.")
        .def_property_readonly(
            "background", [](const scene& self) { return self.background(); }, "a copy of its medium")
        .def_property_readonly("is_built", &scene::is_built);
}

} // namespace insonify_python
