#ifndef INSONIFY_GEOMETRY_RAY_HPP
#define INSONIFY_GEOMETRY_RAY_HPP

#include <insonify/core/math.hpp>
#include <cfloat>

namespace insonify::inline INSONIFY_ABI {

/// A half line, or a piece of one. Distances along it are in units of `direction`: metres where that has length 1.
struct ray {
    vec3 origin{0, 0, 0};
    vec3 direction{0, 0, 1};
    float min_distance = 0;
    float max_distance = FLT_MAX;

    INSONIFY_FN vec3 at(float distance) const { return origin + distance * direction; }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
