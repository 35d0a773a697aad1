#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <doctest/doctest.h>

using namespace insonify;

namespace needle_levels_test {
namespace {

/// A needle at any angle up to 40 degrees, and sheets of fascia, fat and bone parallel to it, above and below.
scene needle_among_sheets(std::uint64_t seed) {
    std::uint64_t drawn = 0;
    const auto between = [&](float low, float high) { return low + (high - low) * hash_uniform(seed, drawn++); };
    const float steepness = between(0, 40) * 1_deg, aside = between(-6, 6) * 1_deg;
    const vec3 along{std::cos(steepness) * std::cos(aside), std::cos(steepness) * std::sin(aside), std::sin(steepness)};
    const vec3 down = normalize(vec3{-along.z, 0, along.x});
    const vec3 tip{between(0, 15_mm), between(-0.5_mm, 0.5_mm), between(10_mm, 30_mm)};
    scene made{tissue::muscle};
    for (const medium& of : {tissue::fascia, tissue::fat, tissue::bone}) {
        const float half = between(0.025_mm, 0.5_mm), below = between(-2_mm, 3_mm) + (of == tissue::bone ? 6_mm : 0);
        const vec3 middle = tip - 10_mm * along + below * down;
        made.add(make_box({-40_mm, -20_mm, -half}, {40_mm, 20_mm, half}), of,
                 {.at = look_at(middle, middle + down, {along.x, 0, along.z})});
    }
    const float gauges[] = {18, 19, 20, 22, 25};
    const float gauge = gauges[static_cast<std::size_t>(between(0, 4.99F))];
    made.add(make_needle(needle_diameter(static_cast<std::uint32_t>(gauge)), 60_mm), tissue::steel,
             {.priority = 1, .at = look_at(tip, tip - along, down)});
    return std::move(made).build(exec::par);
}

} // namespace

TEST_CASE("no echo is stronger than that of a mirror, whatever lies at a needle") {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const scene body = needle_among_sheets(seed);
        for (const std::uint32_t planes : {1U, 3U}) {
            const iq_lines echoes = trace(exec::par_unseq, body, linear_array{.lines = 128, .frequency = 7.5_MHz},
                                          pose{}, physical{}, {.depth = 40_mm, .planes = planes});
            float strongest = 0;
            for (const vec2 echo : echoes.values) strongest = std::max(strongest, length(echo));
            CAPTURE(seed);
            CAPTURE(planes);
            CHECK(strongest < 1);
        }
    }
}

} // namespace needle_levels_test
