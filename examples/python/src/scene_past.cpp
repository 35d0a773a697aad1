// Copies of scenes, and scenes that are pickled: what must be done again for the same picture.
#include "scene_past.hpp"
#include <algorithm>

namespace insonify_python {

namespace {

bool are_equal(std::span<const vec3> one, std::span<const vec3> other) {
    return std::equal(one.begin(), one.end(), other.begin(), other.end());
}
std::vector<vec3> vector_of(std::span<const vec3> points) { return {points.begin(), points.end()}; }

std::span<const vec3> positions_now(const scene& own, object_id id) { return own.positions(id); }
/// Whether an object was ever deformed, so that it has vertices at rest.
bool has_rest(const scene& own, object_id id) { return own.rest_positions(id).data() != positions_now(own, id).data(); }

py::object array_of(std::span<const vec3> points) {
    return float_array({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}},
                       reinterpret_cast<const float*>(points.data()));
}
std::vector<vec3> points_of(const py::handle& array) { return rows_of(py::cast<float_array>(array), "a scene"); }

/// The attributes of a scene but for arrays that were handed out, with a past of their own.
py::dict attributes_of(const py::object& self) {
    const py::dict own = py::module_::import("builtins").attr("dict")(self.attr("__dict__"));
    if (own.contains("_views")) PyDict_DelItemString(own.ptr(), "_views");
    own["_past"] = py::cast(scene_past{past_of(self)});
    return own;
}

py::dict state_of(const object& one, const scene& own, const scene_past& past) {
    const object_id id = one.id;
    if (one.fibres.varies() || (one.layer_normal.varies() && !one.layer_normal.follows_surface()))
        throw usage_error{"a scene cannot be pickled with '" + one.name +
                          "', whose fibres or layers follow a function"};
    const std::span<const vec3> built = built_positions(own, past, id), now = positions_now(own, id);
    const mesh surface{vector_of(own.is_built() ? built : now), one.surface.faces};
    py::dict state;
    state["id"] = id;
    state["mesh"] = surface;
    state["medium"] = one.inside;
    state["priority"] = one.priority;
    state["at"] = one.at;
    state["name"] = one.name;
    state["fibres"] = one.fibres(vec3{0, 0, 0});
    state["layer_normal"] = one.layer_normal.follows_surface() ? layer_direction{std::string{own_surface_name}}
                                                               : layer_direction{one.layer_normal(vec3{0, 0, 0})};
    state["crease_angle"] = one.crease_angle;
    if (!own.is_built()) return state;
    if (const auto found = past.filled.find(id); found != past.filled.end()) state["filled"] = array_of(found->second);
    if (has_rest(own, id)) state["rest"] = array_of(own.rest_positions(id));
    if (const auto found = past.following.find(id); found != past.following.end()) state["rest_at"] = found->second;
    if (past.built.contains(id) || has_rest(own, id)) state["positions"] = array_of(now);
    return state;
}

py::tuple pickled(const py::object& self) {
    const auto& own = py::cast<const scene&>(self);
    const scene_past& past = past_of(self);
    if (past.deformed)
        throw usage_error{"a scene that is deformed cannot be pickled: call deform(compose()) first, and deform the "
                          "scene that is unpickled"};
    const auto deformed = [&](const object& one) { return has_rest(own, one.id); };
    if (past.needs_rebuild || (!own.is_built() && std::any_of(own.objects().begin(), own.objects().end(), deformed)))
        throw usage_error{"a scene that was built or changed while it was moved or deformed cannot be pickled: call "
                          "deform(compose()) and build() first"};
    py::list objects;
    for (const object& one : own.objects()) objects.append(state_of(one, own, past));
    py::dict state;
    state["background"] = own.background();
    state["background_fibres"] = past.background_fibres;
    state["objects"] = objects;
    state["next_id"] = past.next_id;
    state["built"] = own.is_built();
    py::dict attributes = attributes_of(self);
    PyDict_DelItemString(attributes.ptr(), "_past");
    return py::make_tuple(state, attributes);
}

/// Makes a scene again, step by step.
class scene_maker {
  public:
    explicit scene_maker(const py::dict& state)
        : made_{py::cast<const medium&>(state["background"])}, objects_{state["objects"]} {
        past_.background_fibres = py::cast<decltype(past_.background_fibres)>(state["background_fibres"]);
        if (past_.background_fibres)
            made_.set_background_fibres(past_.background_fibres->first, past_.background_fibres->second);
        for (const py::handle one : objects_) add(one);
        past_.next_id = py::cast<std::uint32_t>(state["next_id"]);
        use_up(past_.next_id);
        if (!py::cast<bool>(state["built"])) return;
        made_.build(exec::seq); // not by threads, which a forked process lacks
        fill();
        deform();
        move("positions");
        for (const py::handle one : objects_) made_.place(id_of(one), py::cast<const pose&>(one["at"]));
    }

    scene take() { return std::move(made_); }
    const scene_past& past() const { return past_; }

  private:
    static object_id id_of(py::handle one) { return py::cast<object_id>(one["id"]); }

    /// Ids below one are those of objects that were removed.
    void use_up(std::uint32_t id) {
        const mesh removed = make_box(vec3{0}, vec3{1_mm});
        for (; next_ < id; ++next_) made_.remove(made_.add(removed, {}));
    }
    void add(py::handle one) {
        use_up(py::cast<std::uint32_t>(one["id"]));
        made_.add(py::cast<const mesh&>(one["mesh"]), py::cast<const medium&>(one["medium"]),
                  {.priority = py::cast<int>(one["priority"]),
                   .at = py::cast<const pose&>(one[one.contains("rest_at") ? "rest_at" : "at"]),
                   .name = py::cast<std::string>(one["name"]),
                   .fibres = py::cast<vec3>(one["fibres"]),
                   .layer_normal = layers_of(py::cast<layer_direction>(one["layer_normal"])),
                   .crease_angle = py::cast<float>(one["crease_angle"])});
        ++next_;
    }
    /// Moves vertices to where they were, if they are elsewhere.
    void move(const char* to_where) {
        for (const py::handle one : objects_) {
            if (!one.contains(to_where)) continue;
            const object_id id = id_of(one);
            const std::vector<vec3> to = points_of(one[to_where]);
            const std::span<const vec3> from = positions_now(made_, id);
            if (are_equal(from, to)) continue;
            past_.built.try_emplace(id, vector_of(from));
            std::copy(to.begin(), to.end(), made_.positions(id).begin());
        }
        made_.update(exec::seq);
    }
    void fill() {
        move("filled");
        for (const py::handle one : objects_) {
            if (!one.contains("filled")) continue;
            made_.set_medium(id_of(one), py::cast<const medium&>(one["medium"]));
            past_.filled[id_of(one)] = points_of(one["filled"]);
        }
    }
    void deform() {
        const auto identity = [](vec3 rest) { return rest; };
        std::vector<object_id> deformed, following;
        move("rest");
        for (const py::handle one : objects_) {
            if (one.contains("rest")) deformed.push_back(id_of(one));
            if (!one.contains("rest_at")) continue;
            following.push_back(id_of(one));
            past_.following[id_of(one)] = py::cast<pose>(one["rest_at"]);
        }
        if (deformed.empty()) return;
        made_.deform(exec::seq, identity, deformed);
        made_.deform(exec::seq, identity, following);
    }

    scene made_;
    py::list objects_;
    std::uint32_t next_ = 0;
    scene_past past_{};
};

} // namespace

scene_past& past_of(const py::object& self) {
    if (!py::hasattr(self, "_past")) self.attr("_past") = scene_past{};
    return py::cast<scene_past&>(self.attr("_past"));
}

std::span<const vec3> built_positions(const scene& own, const scene_past& past, object_id id) {
    const auto found = past.built.find(id);
    return found != past.built.end() ? std::span<const vec3>{found->second} : own.rest_positions(id);
}

void note_positions(const py::object& self, object_id id) {
    const auto& own = py::cast<const scene&>(self);
    scene_past& past = past_of(self);
    if (!past.built.contains(id)) past.built.emplace(id, vector_of(own.rest_positions(id)));
}

void note_build(const py::object& self) {
    const auto& own = py::cast<const scene&>(self);
    scene_past& past = past_of(self);
    for (auto& [id, positions] : past.built)
        positions = vector_of(positions_now(own, id)); // an array may still be held
    past.filled.clear();
    past.needs_rebuild = std::any_of(own.objects().begin(), own.objects().end(), [&](const object& one) {
        return !are_equal(positions_now(own, one.id), own.rest_positions(one.id));
    });
}

void note_remove(const py::object& self, object_id id) {
    scene_past& past = past_of(self);
    past.built.erase(id);
    past.filled.erase(id);
    past.following.erase(id);
    past.next_id = std::max(past.next_id, static_cast<std::uint32_t>(id) + 1);
}

void note_medium(const py::object& self, object_id id) {
    const auto& own = py::cast<const scene&>(self);
    scene_past& past = past_of(self);
    if (!own.is_built() || own[id].inside.structure.empty()) return;
    const std::span<const vec3> now = positions_now(own, id), rest = own.rest_positions(id);
    if (are_equal(now, built_positions(own, past, id)) && !past.filled.contains(id) && are_equal(now, rest)) return;
    if (past.deformed || own.awaits_update(id) || !are_equal(now, rest))
        past.needs_rebuild = true;
    else
        past.filled[id] = vector_of(now);
}

void note_deform(const py::object& self, const std::optional<std::vector<object_id>>& only, bool is_identity) {
    scene_past& past = past_of(self);
    past.deformed = !is_identity;
    past.following.clear();
    for (const object& one : py::cast<const scene&>(self).objects())
        if (!only || std::find(only->begin(), only->end(), one.id) != only->end())
            past.following.emplace(one.id, one.at);
}

py::object copied_scene(const py::object& self, const std::optional<py::dict>& memo) {
    py::object made = py::cast(scene{py::cast<const scene&>(self)});
    py::object attributes = attributes_of(self);
    if (memo) attributes = py::module_::import("copy").attr("deepcopy")(attributes, *memo);
    made.attr("__dict__").attr("update")(attributes);
    return made;
}

void bind_pickling(py::class_<scene>& type, py::module_& module) {
    py::class_<scene_past> past{module, "_scene_past"};
    bind_copies(past);
    type.def("__copy__", [](const py::object& self) { return copied_scene(self, std::nullopt); });
    type.def(
        "__deepcopy__", [](const py::object& self, const py::dict& memo) { return copied_scene(self, memo); },
        py::arg("memo"));
    type.def(py::pickle(&pickled, [](const py::tuple& given) {
        scene_maker maker{given[0]};
        py::dict attributes = given[1];
        attributes["_past"] = scene_past{maker.past()};
        return std::pair{maker.take(), attributes};
    }));
}

} // namespace insonify_python
