#ifndef INSONIFY_DATASET_SAMPLE_HPP
#define INSONIFY_DATASET_SAMPLE_HPP

#include "description.hpp"
#include <cmath>
#include <utility>

namespace dataset {

/// The numbers of one sample.
struct sample {
    std::uint32_t number = 0;
    std::uint64_t seed = 0;    ///< of everything random in this sample
    std::uint32_t anatomy = 0; ///< index into `description::anatomy`
    float scale = 1, bend = 0, spread = 0, azimuth = 0, along = 0, across = 0, tilt = 0, rock = 0, turn = 0,
          standoff = 0, pressure = 0;
    float frequency = 0, depth = 0, focus = 0, gain = 0, dynamic_range = 0, noise = 0;
    bool needle = false;
    std::uint32_t gauge = 22;
    float needle_angle = 0, needle_depth = 0;
};

/// Sample `number`: it depends on the seed and the number alone.
inline sample draw_sample(const description& d, std::uint32_t number) {
    sample s{.number = number, .seed = hash_bits(d.seed, number)};
    std::uint64_t next = 0;
    const auto uniform = [&] { return hash_uniform(s.seed, next++); };
    const auto within = [&](const range& of) { return of.from + (of.to - of.from) * uniform(); };
    s.anatomy = static_cast<std::uint32_t>(uniform() * static_cast<float>(std::max<std::size_t>(d.anatomy.size(), 1)));
    s.scale = within(d.scale);
    s.bend = within(d.bend);
    s.spread = within(d.spread);
    s.azimuth = 360 * uniform();
    s.along = within(d.along);
    s.across = within(d.across);
    s.tilt = within(d.tilt);
    s.rock = within(d.rock);
    s.turn = within(d.turn);
    s.standoff = within(d.standoff);
    s.frequency = within(d.frequency);
    s.depth = within(d.depth);
    s.focus = within(d.focus);
    s.gain = within(d.gain);
    s.dynamic_range = within(d.dynamic_range);
    s.noise = within(d.noise);
    s.needle = uniform() < d.needle;
    s.gauge = static_cast<std::uint32_t>(std::lround(within(d.gauge)));
    s.needle_angle = within(d.needle_angle);
    s.needle_depth = within(d.needle_depth);
    s.pressure = within(d.pressure);
    if (s.pressure > 0) s.standoff = 0;
    return s;
}

/// A number of a sample, as it is stored.
struct named_number {
    const char* name;
    const char* unit;
    const char* description;
    float (*of)(const sample&);
};

/// All numbers of a sample that vary.
inline const std::vector<named_number>& numbers() {
    static const std::vector<named_number> all{
        {"anatomy", "-", "index into the attribute `anatomies` of the file",
         [](const sample& s) { return static_cast<float>(s.anatomy); }},
        {"scale", "-", "factor of all lengths of the anatomy", [](const sample& s) { return s.scale; }},
        {"bend", "mm", "rms of the displacement of the anatomy", [](const sample& s) { return s.bend; }},
        {"spread", "degrees", "angle between the direction of the probe and `from`",
         [](const sample& s) { return s.spread; }},
        {"azimuth", "degrees", "of that direction about `from`", [](const sample& s) { return s.azimuth; }},
        {"along", "mm", "shift of the probe along its array", [](const sample& s) { return s.along; }},
        {"across", "mm", "shift of the probe across its array", [](const sample& s) { return s.across; }},
        {"tilt", "degrees", "turn of the probe about its array", [](const sample& s) { return s.tilt; }},
        {"rock", "degrees", "turn of the probe within its slice", [](const sample& s) { return s.rock; }},
        {"turn", "degrees", "turn of the probe about its axis", [](const sample& s) { return s.turn; }},
        {"standoff", "mm", "distance of the face from the surface", [](const sample& s) { return s.standoff; }},
        {"pressure", "mm", "how deep the face is pressed into the surface at rest",
         [](const sample& s) { return s.pressure; }},
        {"frequency", "MHz", "carrier frequency", [](const sample& s) { return s.frequency; }},
        {"image_depth", "mm", "depth of the image", [](const sample& s) { return s.depth; }},
        {"focus", "mm", "depth of the transmit focus", [](const sample& s) { return s.focus; }},
        {"gain", "dB", "added to every level", [](const sample& s) { return s.gain; }},
        {"dynamic_range", "dB", "from black to white", [](const sample& s) { return s.dynamic_range; }},
        {"noise", "dB", "electronic noise, relative to the echo of a perfect mirror",
         [](const sample& s) { return s.noise; }},
        {"needle", "-", "1 where there is a needle", [](const sample& s) { return s.needle ? 1.0F : 0.0F; }},
        {"gauge", "-", "of the needle", [](const sample& s) { return static_cast<float>(s.gauge); }},
        {"needle_angle", "degrees", "of the needle to the face", [](const sample& s) { return s.needle_angle; }},
        {"needle_depth", "mm", "depth of the needle's tip", [](const sample& s) { return s.needle_depth; }},
    };
    return all;
}

} // namespace dataset
#endif
