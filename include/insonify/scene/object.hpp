#ifndef INSONIFY_SCENE_OBJECT_HPP
#define INSONIFY_SCENE_OBJECT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/tissue/fibre_directions.hpp>
#include <cstdint>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// Identifies an object of one scene. Ids are never reused.
enum class object_id : std::uint32_t {};

/// Optional arguments of `scene::add`.
struct object_settings {
    int priority = 0;   ///< where objects overlap, the medium of the highest priority applies
    pose at{};          ///< object to world
    std::string name{}; ///< for reports, files and error messages; need not be unique
    /// Their direction in coordinates of the object, as built: one for all, or a function of the point; 0: the axis of its mesh.
    fibre_directions fibres{};
    /// Edges where two faces meet at no more than this are smooth: echoes see a curved surface across them, not facets.
    /// Radians, 0 to pi; 0: every face is a flat mirror.
    float crease_angle = 30_deg;
};

/// A closed surface and the medium inside it, as the scene stores it.
struct object {
    object_id id{};              ///< in its scene
    std::string name{};          ///< may be empty
    mesh surface;                ///< in object coordinates, metres
    medium inside{};             ///< what fills it
    pose at{};                   ///< object to world
    int priority = 0;            ///< the highest applies where objects overlap
    fibre_directions fibres{};   ///< see `object_settings`
    float crease_angle = 30_deg; ///< edges up to this angle are smooth, radians: see `object_settings`
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
