#ifndef INSONIFY_ACOUSTICS_NARROW_OBSTACLE_HPP
#define INSONIFY_ACOUSTICS_NARROW_OBSTACLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/layer.hpp>
#include <insonify/acoustics/propagation.hpp>
#include <insonify/core/decibels.hpp>
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

/// Adds the sound that passes beside a narrow obstacle in the strip of the beam that the line stands for to what passes through
/// it: by power, and at the mean time. What lets half of the amplitude through is no obstacle.
/// @param above  in front of the obstacle
/// @param below  behind it
/// @return       whether any was added
template <class Model>
INSONIFY_FN bool add_sound_beside(const Model& model, const traced_line& line, const layer& obstacle,
                                  const layer& behind, const echo_path& above, echo_path& below) {
    if (!(obstacle.own_surfaces.x > 0) || !(obstacle.own_surfaces.y > 0) || above.passed == 0) return false;
    layer tissue = obstacle; // beside it
    tissue.medium = behind.medium;
    echo_path around = above; // straight on
    around.refraction.enters_at = 0;
    pass(model, line, tissue, around);
    const float through = below.passed / above.passed *
                          amplitude_of_decibels(min(
                              pulse_loss(model, line, around.lost_db) - pulse_loss(model, line, below.lost_db), 300));
    if (!(through < 0.5F)) return false;
    const float beside = power_beside(obstacle, behind, line.aperture.strip(0.5F * (above.shown + around.shown)));
    if (beside == 0) return false;
    const float power = (1 - beside) * through * through + beside;
    below.shown += beside / power * (around.shown - below.shown);
    below.lost_db = around.lost_db;
    below.refraction.enters_at = 0; // what passes beside it arrives straight
    below.passed = above.passed * std::sqrt(power);
    return true;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
