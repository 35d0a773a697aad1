#ifndef INSONIFY_SCENE_OBJECT_HPP
#define INSONIFY_SCENE_OBJECT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/tissue/fibres.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Identifies an object of one scene. Ids are never reused.
enum class object_id : std::uint32_t {};

/// Optional arguments of `scene::add`.
struct object_settings {
    int priority = 0;   ///< where objects overlap, the medium of the highest priority applies
    pose at{};          ///< object to world
    std::string name{}; ///< for reports, files and error messages; need not be unique
    /// Their direction in coordinates of the object, as built: one, or a function of the point; 0: the mesh's axis.
    fibre_directions fibres{};
    /// Across their layers, likewise; 0: where the mesh is flattest.
    layer_normals layer_normal{};
    /// Edges where two faces meet at no more than this are smooth: echoes see a curved surface across them, not facets.
    /// Radians, 0 to pi; 0: every face is a flat mirror.
    float crease_angle = 30_deg;
};

/// A closed surface and the medium inside it, as the scene stores it.
struct object : object_settings {
    object_id id{};  ///< in its scene
    mesh surface;    ///< in object coordinates, metres
    medium inside{}; ///< what fills it
};

} // namespace insonify::inline INSONIFY_ABI

namespace insonify::inline INSONIFY_ABI::detail {

/// An object by its name, or by its id where it has none.
inline std::string named(const std::string& name, object_id id) {
    return name.empty() ? "object " + std::to_string(static_cast<std::uint32_t>(id)) : "object '" + name + "'";
}

/// @throws usage_error  for a point that is not finite
inline void check_point(vec3 point, const char* caller) {
    if (!is_finite(point)) throw usage_error{caller, ": the point is not finite; give three numbers of metres"};
}

/// @param what  begins the message, such as "scene: the background"
/// @throws usage_error  for a medium out of range
inline void check_medium(const medium& m, const std::string& what) {
    const auto check_length = [&](const char* name, float metres) {
        if (!(metres >= 0 && metres <= 1))
            throw usage_error{
                what, " has a `structure.sheath.", name, "` of ", metres, " m; it must be 0 to 1 m, such as 20_mm"};
    };
    check_length("thickness", m.structure.sheath.thickness);
    check_length("insertion", m.structure.sheath.insertion);
    if (!is_valid(m.structure))
        throw usage_error{what, " has a `structure` out of range: sizes must be above 0, fractions 0 to 1, "
                                "`lattices` 1 to 6, deviations 0 to 40 dB, bundles no wider than their spacing"};
    if (!is_valid(m))
        throw usage_error{what, " needs a density and a sound speed above 0, and every value finite and not below 0"};
}

/// The first vertex that is not finite; their number where there is none.
inline std::size_t find_not_finite(const std::vector<vec3>& positions) {
    const auto found = std::find_if(positions.begin(), positions.end(), [](const vec3& p) { return !is_finite(p); });
    return static_cast<std::size_t>(found - positions.begin());
}

/// @throws geometry_error  for a frame in which a vertex of an object is not finite
[[noreturn]] inline void refuse_frame(const object& one, std::size_t vertex) {
    throw geometry_error{
        named(one.name, one.id), ": vertex ", vertex,
        " was moved to a point that is not finite; all objects are back where they were before: check the "
        "simulation, or the formula, that moved it"};
}

/// Checks the arguments of `scene::add`, which documents what is thrown.
inline void check_object(const mesh& surface, const medium& inside, const object_settings& settings, object_id id) {
    const std::string who = named(settings.name, id) + ": ";
    check_medium(inside, who + "its medium");
    if (!is_rigid(settings.at)) throw geometry_error{who, "its pose is not a rigid transform; scale the mesh instead"};
    if (!settings.fibres.varies() && !is_finite(settings.fibres({0, 0, 0})))
        throw geometry_error{who, "the direction of its fibres is not finite; give three numbers, or leave it out"};
    if (!settings.layer_normal.varies() && !is_finite(settings.layer_normal({0, 0, 0})))
        throw geometry_error{who, "the normal of its layers is not finite; give three numbers, or leave it out"};
    if (!(settings.crease_angle >= 0) || !(settings.crease_angle <= pi))
        throw usage_error{who, "`crease_angle` is ", settings.crease_angle,
                          " radians; it must be from 0 (every face is flat) to pi; write it as in 30_deg"};
    check_faces(surface, who);
    if (const std::size_t vertex = find_not_finite(surface.positions); vertex < surface.positions.size())
        throw geometry_error{who, "vertex ", vertex, " is not finite; repair the mesh (`validate` reports more)"};
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
