#ifndef INSONIFY_MOTION_INDENTATION_HPP
#define INSONIFY_MOTION_INDENTATION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/motion/body_motion.hpp>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Displacement below pressed skin: exponential with depth. @param depth  below the skin at rest, metres
inline float sunk(float at_skin, float depth, float decay) { return at_skin * std::exp(-max(depth, 0) / decay); }

/// How much of the displacement at the edge of a face is left beside it. @param away  from the edge, metres
inline float beside_face(float away, float recovery) { return std::exp(-away / recovery); }

} // namespace detail

/// A flat face pressed into flat skin, parallel to it: a map for `scene::deform`.
///
/// Skin below the face comes to lie on it. Beside the face it recovers exponentially, and the tissue below sinks exponentially
/// less with depth. No model of elasticity: volume is not preserved. `press` finds the deformation for any skin.
struct indentation {
    pose at{};                ///< of the pressed face, to the world: x lateral, y elevation, z into the body
    float depth = 0;          ///< of the face below the skin at rest, metres; less than `decay`, or tissue folds over
    vec2 face{40e-3F, 8e-3F}; ///< its size along x and y, metres
    float decay = 20e-3F;     ///< depth at which the displacement is 1/e, metres
    float recovery = 8e-3F;   ///< distance beside the face at which it is, metres

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 local = at.local_point(rest);
        const vec2 beside{max(std::fabs(local.x) - 0.5F * face.x, 0), max(std::fabs(local.y) - 0.5F * face.y, 0)};
        const float at_skin = depth * detail::beside_face(length(beside), recovery);
        return rest + at.direction({0, 0, detail::sunk(at_skin, local.z + depth, decay)});
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const { return detail::rest_along(*this, now, at.direction({0, 0, 1}), decay); }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_rigid(at) || !(depth >= 0) || !(face.x > 0) || !(face.y > 0) || !(decay > depth) || !(recovery > 0))
            throw usage_error{
                "indentation: `depth` must be at least 0 and less than `decay`, the sizes of the face and "
                "`recovery` above 0, and `at` a rigid pose"};
    }

    friend bool operator==(const indentation&, const indentation&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
