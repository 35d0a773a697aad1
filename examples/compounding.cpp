// A needle, a vessel and bone in muscle: by one look, and as the mean of five looks over 20 degrees.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cmath>
#include <cstdio>

using namespace insonify;

scene phantom() {
    scene body{tissue::muscle};
    body.add(make_sphere({7_mm, 0, 22_mm}, 4_mm, 5), tissue::blood);
    body.add(make_sphere({-8_mm, 0, 27_mm}, 3_mm, 5), tissue::bone);
    const vec3 tip{3_mm, 0, 15_mm}, along{std::cos(20_deg), 0, std::sin(20_deg)};
    body.add(make_cylinder(tip - 60_mm * along, tip, 0.4_mm, 96), tissue::steel, {.priority = 1});
    return body;
}

/// Standard deviation of brightness over its mean, in the middle.
float contrast(const image& picture, const scan_map& map) {
    const vec2 from = map.pixel({-1_mm, 20_mm}), to = map.pixel({2_mm, 30_mm});
    float sum = 0, squares = 0, count = 0;
    for (auto y = static_cast<std::uint32_t>(from.y); y < static_cast<std::uint32_t>(to.y); ++y)
        for (auto x = static_cast<std::uint32_t>(from.x); x < static_cast<std::uint32_t>(to.x); ++x) {
            sum += picture(x, y);
            squares += picture(x, y) * picture(x, y);
            ++count;
        }
    const float mean = sum / count;
    return std::sqrt(squares / count - mean * mean) / mean;
}

int main() {
    const linear_array probe{.lines = 256, .width = 38_mm, .frequency = 9_MHz};
    b_mode_settings settings{.depth = 36_mm, .size = {0, 320}};
    const scene body = phantom().build(exec::par);
    const image one = b_mode(exec::par_unseq, body, probe, pose{}, settings);
    settings.compound = {.angles = 5, .spread = 20_deg};
    const image five = b_mode(exec::par_unseq, body, probe, pose{}, settings);

    picture_strip strip{settings.size.y};
    strip.add(one);
    strip.add(five);
    write_png("compounding.png", strip.picture());

    // Without structure, so that speckle alone makes the contrast.
    medium plain = tissue::muscle;
    plain.structure = structure{};
    const scene even = scene{plain}.build(exec::par);
    const image many = b_mode(exec::par_unseq, even, probe, pose{}, settings);
    settings.compound = {};
    const image single = b_mode(exec::par_unseq, even, probe, pose{}, settings);
    const scan_map map =
        make_scan_map(exec::par, probe, {.depth = settings.depth, .samples = 1}, {.size = settings.size});
    const float before = contrast(single, map), after = contrast(many, map);
    std::printf("contrast of speckle: %.2f, compounded %.2f\n", before, after);
    return after < 0.75F * before ? 0 : 1;
}
