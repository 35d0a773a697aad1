#ifndef INSONIFY_SCENE_DISPLAYED_DEPTH_HPP
#define INSONIFY_SCENE_DISPLAYED_DEPTH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Follows a straight line through the media of a scene: in_layer(length, stretch) is called for each layer, metres and displayed
/// metres per metre, until it returns false.
template <class InLayer>
void follow_displayed(const scene& body, const ray& line, float depth, const char* caller, const InLayer& in_layer) {
    const float size = length(line.direction);
    if (!is_finite(line.origin) || !is_finite(line.direction) || !(size > 0))
        throw usage_error{
            std::string{caller} +
            ": the line must have a finite origin and a direction that is not 0, such as that of `probe.beam(i)`"};
    check_depth(depth, caller);
    const scene_view flat = body.view_for_rays(exec::par);
    const line_frame along{.origin = line.origin, .along = line.direction / size};
    std::vector<crossing> crossings(64);
    std::vector<std::uint32_t> inside(64);
    std::vector<layer> room(64);
    for (view<const layer> layers{}; layers.empty();) {
        line_crossings found{.room = crossings, .inside = {.ranks = inside}};
        if (find_crossings(flat, {along.origin, along.along}, depth, found))
            layers = stack_layers(flat, along, depth, found, view<layer>{room}, false);
        for (const layer& one : layers)
            if (!in_layer(one.end - one.begin, displayed_stretch(flat.media[one.medium]))) return;
        crossings.resize(2 * crossings.size());
        inside.resize(2 * inside.size());
        room.resize(2 * room.size());
    }
}

} // namespace detail

/// Depth at which an echo is displayed, metres: c0 t / 2 with c0 = 1540 m/s, as `physical` does, from the true depth along a
/// straight line.
///
///     shown = sum over the media along the line of d c0 / c
///
///     const float shown = displayed_depth(body, {at.point(beam.origin), at.direction(beam.direction)}, 20_mm);
///
/// Refraction and the shadows of obstacles are left out: see `physical`.
/// @param line   from the face of the probe, in the world; its limits are not used
/// @param depth  true one, metres along the line
/// @throws usage_error  for a scene that was not built, a line or a depth out of range
inline float displayed_depth(const scene& body, const ray& line, float depth) {
    double shown = 0;
    detail::follow_displayed(body, line, depth, "displayed_depth", [&](float part, float stretch) {
        shown += static_cast<double>(part) * static_cast<double>(stretch);
        return true;
    });
    return static_cast<float>(shown);
}

/// The inverse of `displayed_depth`: the true depth along a line of what a scanner displays at a depth, such as that of
/// `scan_map::point`, metres.
/// @throws usage_error  as `displayed_depth`
inline float true_depth(const scene& body, const ray& line, float shown) {
    check_depth(shown, "true_depth");
    float fastest = display_speed;
    for (const medium& m : body.media()) fastest = max(fastest, m.sound_speed);
    double depth = 0, left = static_cast<double>(shown);
    const float farthest = min(shown * fastest / display_speed * 1.001F, max_scan_depth);
    detail::follow_displayed(body, line, farthest, "true_depth", [&](float part, float stretch) {
        const double here = std::fmin(static_cast<double>(part), left / static_cast<double>(stretch));
        depth += here;
        left -= here * static_cast<double>(stretch);
        return left > 0;
    });
    return static_cast<float>(depth);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
