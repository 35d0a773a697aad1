#ifndef INSONIFY_ACOUSTICS_NARROW_OBSTACLE_HPP
#define INSONIFY_ACOUSTICS_NARROW_OBSTACLE_HPP

#include <insonify/acoustics/layer.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// The fraction of the power of a strip of the beam that passes beside a layer which is narrow out of the slice plane, such as
/// a needle, a wire or a small ball; 0 where it is wide, as bone and plates are.
///
/// The layer's section out of the slice plane is the ellipse that has, at the line, its thickness T and the first and second
/// derivatives T' and T'' of that by the height y, which follow from slope and curvature of the two surfaces. T(y)^2 is then a
/// polynomial of degree two, and its zeros are the sides of the section:
///
///     y = T (T' +- sqrt(-T T'')) / -(T'^2 + T T'')
///
/// Of a strip with the power exp(-y^2 / s^2), what lies outside them passes. Facets do not curve: an obstacle whose normals are
/// not smooth lets nothing pass.
/// @param obstacle  a layer between two surfaces that are the object's own
/// @param behind    the next one
/// @param strip     s, metres
INSONIFY_FN inline float power_beside(const layer& obstacle, const layer& behind, float strip) {
    const float thickness = obstacle.end - obstacle.begin;
    const float first = obstacle.slope.y - behind.slope.y; // a slope is the negative derivative of the depth
    const float bend = thickness * (obstacle.curvature.y - behind.curvature.y), open = bend - first * first;
    if (!(strip > 0) || !(open > 0)) return 0;
    const float root = std::sqrt(bend), per_strip = thickness / (open * strip);
    return 0.5F * (std::erfc((root + first) * per_strip) + std::erfc((root - first) * per_strip));
}

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
