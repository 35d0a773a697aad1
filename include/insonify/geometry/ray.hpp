#ifndef INSONIFY_GEOMETRY_RAY_HPP
#define INSONIFY_GEOMETRY_RAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cfloat>

namespace insonify::inline INSONIFY_ABI {

/// A ray, or a segment of one. Distances are in units of `direction`: metres where its length is 1.
struct ray {
    vec3 origin{0, 0, 0};         ///< metres
    vec3 direction{0, 0, 1};      ///< of any length except 0
    float min_distance = 0;       ///< closer hits are ignored
    float max_distance = FLT_MAX; ///< further hits are ignored

    /// The point at a distance, in units of `direction`.
    INSONIFY_FN vec3 at(float distance) const { return origin + distance * direction; }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
