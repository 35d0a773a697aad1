#ifndef INSONIFY_SCENE_CHECK_OBJECT_HPP
#define INSONIFY_SCENE_CHECK_OBJECT_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/text.hpp>
#include <insonify/scene/object.hpp>
#include <cstddef>
#include <string>

namespace insonify::inline INSONIFY_ABI::detail {

/// @param what  begins the message, such as "scene: the background"
/// @throws usage_error  for a medium out of range
inline void check_medium(const medium& m, const std::string& what) {
    if (!is_valid(m.structure))
        throw usage_error{what + " has a `structure` out of range: sizes must be above 0, fractions 0 to 1, "
                                 "`lattices` 1 to 6, deviations 0 to 40 dB, bundles no wider than their spacing"};
    if (!is_valid(m))
        throw usage_error{what + " needs a density and a sound speed above 0, and every value finite and not below 0"};
}

/// Checks the arguments of `scene::add`, which documents what is thrown.
inline void check_object(const mesh& surface, const medium& inside, const object_settings& settings) {
    const std::string named = "object '" + settings.name + "': ";
    check_medium(inside, named + "its medium");
    if (!is_rigid(settings.at))
        throw geometry_error{named + "its pose is not a rigid transform; scale the mesh instead"};
    if (!settings.fibres.varies() && !is_finite(settings.fibres({0, 0, 0})))
        throw geometry_error{named + "the direction of its fibres is not finite; give three numbers, or leave it out"};
    if (!(settings.crease_angle >= 0) || !(settings.crease_angle <= pi))
        throw usage_error{named + "`crease_angle` is " + std::to_string(settings.crease_angle) +
                          " radians; it must be from 0 (every face is flat) to pi; write it as in 30_deg"};
    check_faces(surface, named);
    for (std::size_t i = 0; i < surface.positions.size(); ++i)
        if (!is_finite(surface.positions[i]))
            throw geometry_error{joined(
                {named, "vertex ", std::to_string(i), " is not finite; repair the mesh (`validate` reports more)"})};
}

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
