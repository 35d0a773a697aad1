#ifndef INSONIFY_GEOMETRY_RAY_HPP
#define INSONIFY_GEOMETRY_RAY_HPP

#include <insonify/core/math.hpp>
#include <cfloat>

namespace insonify::inline INSONIFY_ABI {

/// A half line, or a piece of one. Distances along it are in units of `direction`: metres where that has length 1.
struct ray {
    vec3 origin{0, 0, 0};         ///< where it begins, metres
    vec3 direction{0, 0, 1};      ///< of any length but 0
    float min_distance = 0;       ///< hits nearer than this do not count
    float max_distance = FLT_MAX; ///< hits further than this do not count

    /// The point at a distance, in units of `direction`.
    INSONIFY_FN vec3 at(float distance) const { return origin + distance * direction; }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
