#ifndef INSONIFY_PYTHON_SCENE_PAST_HPP
#define INSONIFY_PYTHON_SCENE_PAST_HPP

#include "bindings.hpp"
#include <map>
#include <optional>
#include <string>
#include <variant>

namespace insonify_python {

/// `layer_normal` in Python: a direction, or `own_surface_name`.
using layer_direction = std::variant<vec3, std::string>;
inline constexpr const char* own_surface_name = "own_surface";

/// @throws usage_error  for another word
inline layer_normals layers_of(const layer_direction& given) {
    if (const vec3* const direction = std::get_if<vec3>(&given)) return *direction;
    if (std::get<std::string>(given) != own_surface_name)
        throw usage_error{"scene.add: `layer_normal` must be a direction or \"own_surface\""};
    return own_surface{};
}

/// A dictionary that refuses changes, which would be lost.
py::object read_only(const py::dict& values);

/// What a scene depends on beside its present objects, so that a pickled one can be made to draw the same picture.
struct scene_past {
    std::map<object_id, std::vector<vec3>> built{};  ///< vertices as built, of objects that may have moved since
    std::map<object_id, std::vector<vec3>> filled{}; ///< vertices of moved objects when `set_medium` laid out structure
    std::map<object_id, pose> following{};           ///< objects that the last map deformed, and where they were
    std::optional<std::pair<vec3, vec3>> background_fibres{};
    std::uint32_t next_id = 0;  ///< at least, as ids of removed objects are not used again
    bool deformed = false;      ///< by a map other than the identity
    bool needs_rebuild = false; ///< built or filled away from rest, which cannot be done again
};

/// The past of a scene, an attribute of it.
scene_past& past_of(const py::object& self);

/// The vertices of an object as built.
std::span<const vec3> built_positions(const scene& own, const scene_past& past, object_id id);

// To be called before `positions(id)` is handed out, and after `build`, `remove`, `set_medium` and `deform`.
void note_positions(const py::object& self, object_id id);
void note_build(const py::object& self);
void note_remove(const py::object& self, object_id id);
void note_medium(const py::object& self, object_id id);
void note_deform(const py::object& self, const std::optional<std::vector<object_id>>& only, bool is_identity);

/// Vertices that an array still refers to must not be freed.
/// @throws usage_error  with the name of the caller
void check_not_held(const py::object& self, object_id id, const char* caller);

/// A copy with all attributes, but for arrays of vertices that were handed out.
/// @param memo  that of `copy.deepcopy`; none: attributes are not copied
py::object copied_scene(const py::object& self, const std::optional<py::dict>& memo);

void bind_pickling(py::class_<scene>& type, py::module_& module);

} // namespace insonify_python
#endif
