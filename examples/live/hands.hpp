#ifndef INSONIFY_EXAMPLES_LIVE_HANDS_HPP
#define INSONIFY_EXAMPLES_LIVE_HANDS_HPP

#include <insonify/insonify.hpp>
#include <cmath>
#include <optional>

namespace live {

using namespace insonify;

/// The needle: where it enters the skin, and how far it has advanced.
struct needle_state {
    std::uint32_t gauge = 22;
    float bevel = 15_deg;
    vec3 entry{-24_mm, 0, 0.4_mm}; ///< in the world
    float steepness = 30_deg;      ///< angle to the skin
    float aside = 0;               ///< angle to the x axis, seen from above, towards -y
    float inserted = 0;            ///< metres from the skin to the tip
    float drag = 0;                ///< by which it has dragged the tissue along its shaft, metres
    std::optional<pose> held{};    ///< by a tracker, instead of what the hand does

    /// Its direction, into the body.
    vec3 advance() const {
        const float level = std::cos(steepness);
        return {level * std::cos(aside), -level * std::sin(aside), std::sin(steepness)};
    }
    /// Turns it from its entry towards a point.
    void aim(vec3 target) {
        const vec3 along = normalize(target - entry);
        steepness = std::asin(clamp(along.z, -1, 1));
        aside = std::atan2(-along.y, along.x);
    }
    /// Its bevel is towards the skin.
    pose at() const {
        if (held) return *held;
        const float rise = std::sin(steepness);
        return needle_pose(entry + inserted * advance(), advance(),
                           {rise * std::cos(aside), -rise * std::sin(aside), -std::cos(steepness)});
    }
    vec3 tip() const { return at().point({-0.5F * needle_diameter(gauge), 0, 0}); }
};

/// The hand on the probe.
struct hand_state {
    vec2 on_skin{0, 0};         ///< x, y in the world
    vec2 from{0, 0};            ///< where it began: the skin there is what `tilt` and `rock` are relative to
    float tilt = 0;             ///< about the array: the slice sweeps along y
    float rock = 0;             ///< in the slice plane
    float rotate = 0;           ///< about the axis of the probe
    float gel = 0.4_mm;         ///< between the middle of the face and the skin at rest; below 0: pressed into the skin
    std::optional<pose> held{}; ///< by a tracker, instead of all of these
};

} // namespace live

#endif
