#ifndef INSONIFY_EXAMPLES_LIVE_WEB_CONTROLS_HPP
#define INSONIFY_EXAMPLES_LIVE_WEB_CONTROLS_HPP

#include "../session.hpp"

namespace live {

/// A slider of the page: an event with one number.
struct control {
    std::string event{}, group{}, title{}, unit{}, tooltip{};
    float low = 0, high = 1, step = 1;
    float (*value)(const session&) = nullptr; ///< at present
    bool is_relative = false;                 ///< the event takes the difference from the present value
};

/// The sliders, in groups as on a scanner.
inline const std::vector<control>& controls() {
    static const std::vector<control> all{
        {"gain", "Image", "Gain", "dB", "Brightness of the whole picture", -30, 30, 1,
         [](const session& s) { return s.machine.settings.gain_db; }},
        {"dynamic_range", "Image", "Dynamic range", "dB", "Levels from black to white: less gives more contrast", 30,
         90, 1, [](const session& s) { return s.machine.settings.dynamic_range_db; }},
        {"depth", "Image", "Depth", "mm", "Depth of the lower edge of the picture", 20, 80, 1,
         [](const session& s) { return 1e3F * s.machine.settings.depth; }},
        {"focus", "Image", "Focus", "mm", "Depth at which the beam is narrowest: the mark beside the picture", 5, 70, 1,
         [](const session& s) { return 1e3F * s.machine.probe.focus; }},
        {"frequency", "Image", "Frequency", "MHz", "Higher shows finer detail, but less deep", 4, 12, 0.5F,
         [](const session& s) { return 1e-6F * s.machine.probe.frequency; }},
        {"compound", "Smoothing", "Compounding", "looks", "Averages looks from several angles: less speckle", 1, 9, 1,
         [](const session& s) { return static_cast<float>(std::max(s.machine.settings.compound.angles, 1U)); }},
        {"persistence", "Smoothing", "Persistence", "", "Weight of earlier pictures: less noise, but slower to follow",
         0, 0.9F, 0.05F, [](const session& s) { return s.machine.settings.persistence; }},
        {"advance", "Needle", "Inserted", "mm", "Length of the needle below the skin; also keys N and M", -20, 60, 0.5F,
         [](const session& s) { return 1e3F * s.needle.inserted; }, true},
        {"steepness", "Needle", "Steepness", "°", "Angle between the needle and the skin", 5, 85, 1,
         [](const session& s) { return s.needle.steepness / 1_deg; }},
        {"aside", "Needle", "Out of plane", "°", "Angle between the needle and the scan plane", -45, 45, 1,
         [](const session& s) { return s.needle.aside / 1_deg; }},
        {"gauge", "Needle", "Gauge", "G", "Thickness of the needle: a higher number is thinner", 18, 25, 1,
         [](const session& s) { return static_cast<float>(s.needle.gauge); }},
        {"bevel", "Needle", "Bevel", "°", "Angle of the tip: smaller is sharper", 10, 60, 1,
         [](const session& s) { return s.needle.bevel / 1_deg; }},
        {"lines", "Quality", "Lines", "", "Scan lines of a picture: more is finer, but slower", 64, 256, 32,
         [](const session& s) { return static_cast<float>(s.machine.probe.lines); }},
        {"planes", "Quality", "Planes", "", "Planes that sample the thickness of the slice: more is truer, but slower",
         1, 7, 2, [](const session& s) { return static_cast<float>(s.machine.settings.planes); }}};
    return all;
}

} // namespace live

#endif
