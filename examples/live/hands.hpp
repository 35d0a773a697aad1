#ifndef INSONIFY_EXAMPLES_LIVE_HANDS_HPP
#define INSONIFY_EXAMPLES_LIVE_HANDS_HPP

#include <insonify/insonify.hpp>
#include "../nerve_block_phantom.hpp"

namespace live {

using namespace insonify;

/// The needle: where it enters the skin, and how far it has advanced.
struct needle_state {
    std::uint32_t gauge = 22;
    float bevel = 15_deg;
    vec3 entry{-24_mm, 0, 0.4_mm}; ///< in the world
    float steepness = 30_deg;      ///< angle to the skin
    float aside = 0;               ///< angle to the x axis
    float inserted = 0;            ///< metres from the skin to the tip
    float drag = 0;                ///< by which it has dragged the tissue along its shaft, metres

    pose at() const {
        const pose from_entry = nerve_block::needle_at(entry, steepness, aside);
        return {from_entry.rotation, entry + inserted * from_entry.direction({0, 0, 1})};
    }
    vec3 tip() const { return at().point({-0.5F * needle_diameter(gauge), 0, 0}); }
};

/// The hand on the probe.
struct hand_state {
    vec2 on_skin{0, 0}; ///< x, y in the world
    float tilt = 0;     ///< about the array: the slice sweeps along y
    float rock = 0;     ///< in the slice plane
    float rotate = 0;   ///< about the axis of the probe
    float gel = 0.4_mm; ///< between the middle of the face and the skin at rest; below 0: pressed into the skin
};

} // namespace live

#endif
