#ifndef INSONIFY_EXAMPLES_LIVE_CONTROLS_TRACKER_HPP
#define INSONIFY_EXAMPLES_LIVE_CONTROLS_TRACKER_HPP

#include "session.hpp"

namespace live::detail {

// The columns of the rotation, then the translation in mm.
inline pose tracked_pose(const float* v) {
    const pose at{{vec3{v[0], v[1], v[2]}, vec3{v[3], v[4], v[5]}, vec3{v[6], v[7], v[8]}},
                  1e-3F * vec3{v[9], v[10], v[11]}};
    if (!is_rigid(at))
        throw std::invalid_argument{"the twelve numbers do not form a rigid transform: the columns of a rotation, then "
                                    "x, y and z in mm"};
    return at;
}

/// Events of a tracker, which holds the probe and the needle instead of the hand.
inline std::span<const control> tracker_controls() {
    static constexpr control all[] = {
        {.event = "hold_probe",
         .group = "Probe",
         .title = "Tracked probe",
         .unit = "mm",
         .tooltip = "Pose of the probe in the world: the columns of the rotation, then the position",
         .low = -1e5F,
         .high = 1e5F,
         .values = 12,
         .run = [](session& s, const float* v, std::uint32_t) { s.hand.held = tracked_pose(v); }},
        {.event = "hold_needle",
         .group = "Needle",
         .title = "Tracked needle",
         .unit = "mm",
         .tooltip = "Pose of the needle in the world: the columns of the rotation, z along the needle, then the tip",
         .low = -1e5F,
         .high = 1e5F,
         .values = 12,
         .run =
             [](session& s, const float* v, std::uint32_t) {
                 s.needle.held = tracked_pose(v);
                 s.needle.drag = 0;
                 s.place_needle();
             }},
        {.event = "release",
         .group = "Probe",
         .title = "Release",
         .tooltip = "Returns the probe and the needle from a tracker to the hand",
         .values = 0,
         .run = [](session& s, const float*, std::uint32_t) {
             s.hand.held.reset();
             s.needle.held.reset();
             s.place_needle();
         }}};
    return all;
}

} // namespace live::detail

#endif
