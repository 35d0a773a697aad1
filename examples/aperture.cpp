// Shadows of a wire, of a ball and of half a plate: sharp, by one line to each point, and as the whole aperture sees them.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cstdio>

using namespace insonify;

int main() {
    medium plain = tissue::muscle;
    plain.structure = structure{};
    scene body{plain};
    body.add(make_cylinder({-11_mm, -20_mm, 10_mm}, {-11_mm, 20_mm, 10_mm}, 0.4_mm, 96), tissue::bone);
    body.add(make_sphere({-2_mm, 0, 12_mm}, 2_mm, 5), tissue::bone);
    body.add(make_box({8_mm, -20_mm, 10_mm}, {40_mm, 20_mm, 11_mm}), tissue::bone);
    body.build(exec::par);
    const linear_array probe{.lines = 192, .width = 38_mm, .frequency = 7.5_MHz};
    const b_mode_settings settings{.depth = 36_mm, .size = {0, 220}};
    const auto seen = [&](straight_lines tracer) {
        return b_mode(exec::par_unseq, body, probe, pose{}, physical{}, settings, tracer);
    };
    const image sharp = seen({.directions = 1}), soft = seen({});
    picture_strip strip{settings.size.y};
    strip.add(sharp);
    strip.add(soft);
    write_png("aperture.png", strip.picture());

    // Mean brightness in the shadow of the wire, 8 to 22 mm behind it.
    const scan_map map =
        make_scan_map(exec::par, probe, {.depth = settings.depth, .samples = 1}, {.size = settings.size});
    const auto shadow = [&](const image& of) {
        const vec2 from = map.pixel({-11.2_mm, 18_mm}), to = map.pixel({-10.8_mm, 32_mm});
        float sum = 0, count = 0;
        for (auto y = static_cast<std::uint32_t>(from.y); y <= static_cast<std::uint32_t>(to.y); ++y)
            for (auto x = static_cast<std::uint32_t>(from.x); x <= static_cast<std::uint32_t>(to.x); ++x, ++count)
                sum += of(x, y);
        return sum / count;
    };
    std::printf("brightness in the shadow of a wire: %.2f by one line, %.2f by the aperture\n", shadow(sharp),
                shadow(soft));
    return shadow(soft) > shadow(sharp) + 0.1F ? 0 : 1;
}
