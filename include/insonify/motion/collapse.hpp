#ifndef INSONIFY_MOTION_COLLAPSE_HPP
#define INSONIFY_MOTION_COLLAPSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/motion/body_motion.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A vessel that collapses where the pressure around it exceeds that of its blood: a map for `scene::deform`. Veins close at
/// a few mmHg; arteries, whose pressure is ten times that, do not.
///
/// The lumen, a circle of a radius R at rest, becomes an ellipse of the same width. Its height and its area are those at rest
/// times
///
///     opening = max((1 + (outside - inside) / stiffness)^(-2/3), residual),
///
/// and 1 where `outside` is below `inside`. Tissue above and below follows the point of the wall that lies between it and the
/// axis, by exp(-z^2 / (2 above^2)), where z is its distance from there along `direction`; tissue beside the lumen, at a distance
/// x from where its width ends, by exp(-x^2 / (2 beside^2)) of that. All move along `direction`, by at most (1 - opening) R. No
/// setting makes the map fold over: the determinant of its derivative is at least `opening`.
/// Source: Shapiro 1977, J. Biomech. Eng. 99, 126: area of thin-walled tubes that are nearly closed.
struct collapse {
    vec3 from{0, 0, 0}; ///< a point of the vessel's axis, in the world, metres
    vec3 to{0, 1, 0};   ///< another one; the axis goes on beyond both
    vec3 direction{0, 0,
                   1}; ///< in which the vessel is flattened, of any length above 0; its part across the axis counts
    float radius = 4.5e-3F; ///< of the lumen at rest, metres
    float outside = 0;      ///< pressure of the tissue around the vessel, Pa: see `_mmHg`
    float inside = 1070;    ///< pressure of its blood, Pa: 8 mmHg, a vein of the leg in a patient who lies
    float stiffness = 40;   ///< of its wall against bending, Pa: E h^3 / (12 (1 - nu^2) R^3) of its thickness h
    float residual = 0.06F; ///< opening at which the walls touch, above 0 to 1
    float beside = 1.5e-3F; ///< distance beside the wall at which the displacement is 0.61, metres
    float above = 4e-3F;    ///< the same above and below its wall, metres

    /// Height of the lumen over that at rest.
    float opening() const {
        const float excess = max(outside - inside, 0) / stiffness, root = std::cbrt(1 + excess);
        return max(1 / (root * root), residual);
    }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const float closed = 1 - opening();
        if (closed == 0) return rest;
        const vec3 axis = normalize(to - from), up = normalize(direction - dot(direction, axis) * axis);
        const vec3 away = rest - from - dot(rest - from, axis) * axis;
        const float height = dot(away, up), distance = length(away);
        if (distance <= radius) return rest - closed * height * up;
        const float to_wall = radius / distance, z = (1 - to_wall) * height / above;
        const float x = max(std::fabs(dot(away, cross(axis, up))) - radius, 0) / beside;
        return rest - closed * to_wall * height * std::exp(-0.5F * (x * x + z * z)) * up;
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        const vec3 axis = normalize(to - from), up = normalize(direction - dot(direction, axis) * axis);
        return detail::rest_along(*this, now, up, radius);
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(from) || !is_finite(to) || !is_finite(direction) ||
            !(length(cross(to - from, direction)) > 1e-3F * length(to - from) * length(direction)))
            throw usage_error{"collapse: `from` and `to` must be different points, and `direction` not along the axis"};
        if (!(radius > 0) || !(beside > 0) || !(above > 0) || !(stiffness > 0) || !is_finite(outside) ||
            !is_finite(inside) || !(residual > 0 && residual <= 1))
            throw usage_error{"collapse: `radius`, `beside`, `above` and `stiffness` must be above 0, the pressures "
                              "finite, and `residual` above 0 to 1"};
    }

    friend bool operator==(const collapse&, const collapse&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
