#ifndef INSONIFY_EXAMPLES_LIVE_CONTROLS_HANDS_HPP
#define INSONIFY_EXAMPLES_LIVE_CONTROLS_HANDS_HPP

#include "presets.hpp"

namespace live::detail {

/// Events of the groups Probe and Needle. Angles are degrees, lengths millimetres.
inline std::span<const control> hand_controls() {
    static constexpr literal switched[] = {"Off", "On"};
    static constexpr control all[] = {
        {"slide",
         "Probe",
         "Slide",
         "mm",
         "Moves the probe on the skin, along x and y",
         -100,
         100,
         1,
         2,
         nullptr,
         true,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.hand.on_skin = s.slid(1e-3F * vec2{v[0], v[1]});
         }},
        {"tilt",
         "Probe",
         "Tilt",
         "°",
         "Fans the probe out of the slice",
         -45,
         45,
         1,
         1,
         [](const session& s) { return s.hand.tilt / 1_deg; },
         true,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.hand.tilt = std::clamp(s.hand.tilt + 1_deg * v[0], -45_deg, 45_deg);
         }},
        {"rock",
         "Probe",
         "Rock",
         "°",
         "Rocks the probe within the slice, heel to toe",
         -30,
         30,
         1,
         1,
         [](const session& s) { return s.hand.rock / 1_deg; },
         true,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.hand.rock = std::clamp(s.hand.rock + 1_deg * v[0], -30_deg, 30_deg);
         }},
        {"rotate",
         "Probe",
         "Rotate",
         "°",
         "Turns the probe about its axis: 90° shows the other section",
         -180,
         180,
         1,
         1,
         [](const session& s) { return s.hand.rotate / 1_deg; },
         true,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.hand.rotate = std::remainder(s.hand.rotate + 1_deg * v[0], 2 * pi);
         }},
        {"press",
         "Probe",
         "Press",
         "mm",
         "Presses the probe into the skin; below 0 it is lifted, and gel fills the gap",
         -8,
         10,
         0.1F,
         1,
         [](const session& s) { return -1e3F * s.hand.gel; },
         true,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.hand.gel = std::clamp(s.hand.gel - 1e-3F * v[0], -10_mm, 8_mm);
         }},
        {"heart_rate",
         "Probe",
         "Heart rate",
         "beats/min",
         "Of the arteries and their flow",
         30,
         180,
         1,
         1,
         [](const session& s) { return 60 * s.beat.rate; },
         false,
         {},
         [](session& s, const float* v, std::uint32_t) { s.beat.rate = v[0] / 60; }},
        {"pulse",
         "Probe",
         "Pulse",
         "mm",
         "By how much the wall of an artery of 3 mm radius moves with each beat",
         0,
         1,
         0.05F,
         1,
         [](const session& s) { return 1e3F * s.beat.amplitude; },
         false,
         {},
         [](session& s, const float* v, std::uint32_t) { s.beat.amplitude = 1e-3F * v[0]; }},
        {"labels", "Image", "Labels", "", "Tints the tissues and outlines them, by name", 0, 1, 1, 1,
         [](const session& s) { return s.shows_labels ? 1.0F : 0.0F; }, false, switched,
         [](session& s, const float* v, std::uint32_t) { s.shows_labels = v[0] != 0; }},
        {"advance",
         "Needle",
         "Inserted",
         "mm",
         "Length of the needle below the skin",
         -20,
         75,
         0.1F,
         1,
         [](const session& s) { return 1e3F * s.needle.inserted; },
         true,
         {},
         [](session& s, const float* v, std::uint32_t) {
             constexpr float slips = 0.8_mm; // tissue follows the shaft by no more
             const float before = s.needle.inserted;
             s.needle.inserted = std::clamp(before + 1e-3F * v[0], -20_mm, 75_mm);
             s.needle.drag = std::clamp(s.needle.drag + s.needle.inserted - before, -slips, slips);
             s.place_needle();
         }},
        {"steepness",
         "Needle",
         "Steepness",
         "°",
         "Angle between the needle and the skin",
         5,
         85,
         1,
         1,
         [](const session& s) { return s.needle.steepness / 1_deg; },
         false,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.needle.steepness = 1_deg * v[0];
             s.place_needle();
         }},
        {"aside",
         "Needle",
         "Out of plane",
         "°",
         "Angle between the needle and the x axis, seen from above",
         -180,
         180,
         1,
         1,
         [](const session& s) { return s.needle.aside / 1_deg; },
         false,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.needle.aside = 1_deg * v[0];
             s.place_needle();
         }},
        {"entry",
         "Needle",
         "Entry",
         "mm",
         "Where the needle enters the skin, x and y",
         -500,
         500,
         1,
         2,
         nullptr,
         false,
         {},
         [](session& s, const float* v, std::uint32_t) {
             const vec2 place = 1e-3F * vec2{v[0], v[1]};
             s.needle.entry = {place, s.skin_at(place)};
             s.needle.drag = 0;
             s.place_needle();
         }},
        {"gauge",
         "Needle",
         "Gauge",
         "G",
         "A higher number is a thinner needle",
         18,
         25,
         1,
         1,
         [](const session& s) { return static_cast<float>(s.needle.gauge); },
         false,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.needle.gauge = whole(v[0]);
             s.renew_needle();
         },
         0,
         nullptr,
         1},
        {"bevel",
         "Needle",
         "Bevel",
         "°",
         "Angle of the tip: smaller is sharper",
         10,
         60,
         1,
         1,
         [](const session& s) { return s.needle.bevel / 1_deg; },
         false,
         {},
         [](session& s, const float* v, std::uint32_t) {
             s.needle.bevel = 1_deg * v[0];
             s.renew_needle();
         }}};
    return all;
}

} // namespace live::detail

#endif
