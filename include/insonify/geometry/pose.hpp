#ifndef INSONIFY_GEOMETRY_POSE_HPP
#define INSONIFY_GEOMETRY_POSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Rigid transform from local to world coordinates: the rotation, then the translation.
struct pose {
    mat3 rotation{1};          ///< its columns are the local x, y and z axes in the world
    vec3 translation{0, 0, 0}; ///< local origin in the world, metres

    /// From local to world coordinates.
    /// @{
    INSONIFY_FN vec3 point(vec3 p) const { return rotation * p + translation; }
    INSONIFY_FN vec3 direction(vec3 v) const { return rotation * v; }
    /// @}

    /// From world to local coordinates; precise far from the origin as well.
    INSONIFY_FN vec3 local_point(vec3 p) const { return local_direction(p - translation); }
    /// The same for a direction: the translation is ignored.
    INSONIFY_FN vec3 local_direction(vec3 v) const {
        return {dot(rotation[0], v), dot(rotation[1], v), dot(rotation[2], v)};
    }

    friend bool operator==(const pose&, const pose&) = default;
};

/// The inverse transform.
INSONIFY_FN inline pose inverse(const pose& p) { return {transpose(p.rotation), -p.local_direction(p.translation)}; }

/// Composition: `inner` first, then `outer`.
INSONIFY_FN inline pose operator*(const pose& outer, const pose& inner) {
    return {outer.rotation * inner.rotation, outer.point(inner.translation)};
}

/// Largest coordinate of a translation or shape, metres; further out the spacing of floats exceeds the size of a probe.
inline constexpr float max_translation = 1e6F;

/// True for an orthonormal rotation (within 1e-4, without reflection) and a translation within `max_translation`.
INSONIFY_FN inline bool is_rigid(const pose& p) {
    const mat3& r = p.rotation;
    const auto near_to = [](float a, float b) { return std::fabs(a - b) < 1e-4F; };
    return is_finite(r[0]) && is_finite(r[1]) && is_finite(r[2]) && is_finite(p.translation) &&
           abs(p.translation) == min(abs(p.translation), vec3{max_translation}) && near_to(dot(r[0], r[0]), 1) &&
           near_to(dot(r[1], r[1]), 1) && near_to(dot(r[2], r[2]), 1) && near_to(dot(r[0], r[1]), 0) &&
           near_to(dot(r[1], r[2]), 0) && near_to(dot(r[2], r[0]), 0) && determinant(r) > 0;
}

namespace detail {

/// @param caller, what  start of the sentence
/// @throws geometry_error  for a pose that is not rigid
inline void check_rigid(const pose& at, const char* caller, const char* what = "the pose") {
    if (!is_rigid(at))
        throw geometry_error{caller, ": ", what,
                             " is not a rigid transform; make it with look_at, or mend it with orthonormalised"};
}

} // namespace detail

/// The pose with an orthonormal rotation, the nearest to one that rounding has made inexact: of a pose that is
/// multiplied many times, such as that of a robot's arm.
///
///     at = orthonormalised(at * step); // each time
///
/// @throws geometry_error  for a rotation that is not nearly one: stretched, mirrored or not finite
inline pose orthonormalised(const pose& p) {
    mat3 r = p.rotation;
    // Newton's iteration for the polar decomposition: Higham 1986, SIAM J. Sci. Stat. Comput. 7, 1160.
    for (int i = 0; i < 4; ++i)
        if (determinant(r) > 0.1F) r = (r + transpose(inverse(r))) * 0.5F;
    const pose nearest{r, p.translation};
    const mat3 change = r - p.rotation;
    if (!is_rigid(nearest) ||
        !(dot(change[0], change[0]) + dot(change[1], change[1]) + dot(change[2], change[2]) < 0.1F))
        throw geometry_error{
            "orthonormalised: the pose is not nearly a rigid transform: its axes must be of length 1 and "
            "at right angles to within 0.1, not mirrored, its translation within 1000 km of the origin"};
    return nearest;
}

/// Pose of a probe (or tool, or camera) at `from` that faces `towards` a point, its array along `lateral`.
///
/// z = towards - from, x = lateral made orthogonal to z, y = z cross x, normalized; the inverse of glm::lookAt.
/// @throws geometry_error  where `lateral` is parallel to the line of sight, or the two points coincide
inline pose look_at(vec3 from, vec3 towards, vec3 lateral) {
    const vec3 sight = towards - from;
    const float distance = length(sight);
    const float width = length(lateral);
    if (!is_rigid({mat3{1}, from}) || !is_finite(distance) || !is_finite(width) || !(distance > 0) || !(width > 0))
        throw geometry_error{"look_at: `from` and `towards` must be different points within 1000 km of the origin, "
                             "and `lateral` a direction other than zero"};
    const vec3 z = sight / distance;
    const vec3 across = lateral / width - dot(lateral / width, z) * z;
    if (!(length(across) > 1e-5F))
        throw geometry_error{"look_at: `lateral` is parallel to the line of sight; choose a direction across it"};
    const vec3 x = normalize(across);
    return {mat3{x, cross(z, x), z}, from};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
