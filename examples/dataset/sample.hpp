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

} // namespace dataset
#endif
