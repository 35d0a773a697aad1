#ifndef INSONIFY_MOTION_REST_ALONG_HPP
#define INSONIFY_MOTION_REST_ALONG_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// Inverse of a map that displaces all points along one direction and does not fold over: along a line in that direction the
/// displacement then falls by less than one to one, so that there is one solution, which is bracketed. Unlike Newton's method in
/// space it needs no derivative, and edges of the map, where its slope jumps, do no harm.
/// @param map        vec3(vec3)
/// @param direction  of length 1
/// @param max        upper bound of the displacement, metres
/// @return           the point that the map takes to `now`, to within 0.1 um (and rounding)
template <class Map>
vec3 rest_along(const Map& map, vec3 now, vec3 direction, float max) {
    const float tolerance = 1e-7F + 2.5e-7F * length(now);
    const auto displacement = [&](vec3 rest) { return dot(map(rest) - rest, direction); };
    float low = -max, high = max, last = 0, error_before = displacement(now), moved = error_before;
    for (int i = 0; i < 40 && error_before != 0; ++i) {
        const float error = displacement(now - moved * direction) - moved;
        if (!(std::fabs(error) > tolerance)) break;
        (error > 0 ? low : high) = moved;
        const float change = error - error_before;
        float next =
            change != 0 ? moved - error * (moved - last) / change : high; // secant; where that is slow, bisection
        if (i >= 8 || !(next > low && next < high)) next = 0.5F * (low + high);
        last = moved;
        error_before = error;
        moved = next;
    }
    return now - moved * direction;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
