#ifndef INSONIFY_GEOMETRY_POSE_HPP
#define INSONIFY_GEOMETRY_POSE_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A rigid motion: first the rotation, then the translation (metres). Maps local coordinates to world coordinates.
struct pose {
    mat3 rotation{1};          ///< columns are the local x, y and z axis in the world
    vec3 translation{0, 0, 0}; ///< the local origin in the world, metres

    /// From local coordinates to the world.
    /// @{
    INSONIFY_FN vec3 point(vec3 p) const { return rotation * p + translation; }
    INSONIFY_FN vec3 direction(vec3 v) const { return rotation * v; }
    /// @}

    /// Back from world to local coordinates; precise also where both lie far from the origin.
    INSONIFY_FN vec3 local_point(vec3 p) const { return local_direction(p - translation); }
    /// Back for what has a direction and a length but no place.
    INSONIFY_FN vec3 local_direction(vec3 v) const {
        return {dot(rotation[0], v), dot(rotation[1], v), dot(rotation[2], v)};
    }

    friend bool operator==(const pose&, const pose&) = default;
};

/// The motion back.
INSONIFY_FN inline pose inverse(const pose& p) { return {transpose(p.rotation), -p.local_direction(p.translation)}; }

/// First `inner`, then `outer`.
INSONIFY_FN inline pose operator*(const pose& outer, const pose& inner) {
    return {outer.rotation * inner.rotation, outer.point(inner.translation)};
}

/// Poses stand no further from the origin along any axis, metres: beyond, floats are coarser than any probe.
inline constexpr float most_translation = 1e6F;

/// True where the rotation is one (orthonormal to 1e-4, no mirror), and the translation within `most_translation`.
INSONIFY_FN inline bool is_rigid(const pose& p) {
    const mat3& r = p.rotation;
    const auto near_to = [](float a, float b) { return std::fabs(a - b) < 1e-4F; };
    return is_finite(r[0]) && is_finite(r[1]) && is_finite(r[2]) && is_finite(p.translation) &&
           absolute(p.translation) == lesser(absolute(p.translation), vec3{most_translation}) &&
           near_to(dot(r[0], r[0]), 1) && near_to(dot(r[1], r[1]), 1) && near_to(dot(r[2], r[2]), 1) &&
           near_to(dot(r[0], r[1]), 0) && near_to(dot(r[1], r[2]), 0) && near_to(dot(r[2], r[0]), 0) &&
           determinant(r) > 0;
}

/// The pose of a probe (or tool) at `from` that looks `towards` a point, its array along `lateral`.
///
/// z = towards - from, x = lateral made orthogonal to z, y = z cross x, each of length 1; the inverse of glm::lookAt.
/// @throws geometry_error  where `lateral` is parallel to the line of sight, or the two points are one
INSONIFY_LAZY pose look_at(vec3 from, vec3 towards, vec3 lateral) {
    const vec3 sight = towards - from;
    const float distance = length(sight);
    const float width = length(lateral);
    if (!is_rigid({mat3{1}, from}) || !is_finite(distance) || !is_finite(width) || !(distance > 0) || !(width > 0))
        throw geometry_error{"look_at: `from` and `towards` must be two different points within 1000 km of the origin, "
                             "and `lateral` a direction"};
    const vec3 z = sight / distance;
    const vec3 across = lateral / width - dot(lateral / width, z) * z;
    if (!(length(across) > 1e-5F))
        throw geometry_error{
            "look_at: `lateral` is parallel to the line from `from` to `towards`; choose one across it"};
    const vec3 x = normalize(across);
    return {mat3{x, cross(z, x), z}, from};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
