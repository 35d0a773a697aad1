// A needle in muscle: at 5, 20 and 40 degrees to the face, and at 20 degrees with lines steered by 15 degrees.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cmath>
#include <cstdio>

using namespace insonify;

int main() {
    const linear_array array = presets::in_use(linear_array{.lines = 192, .width = 38_mm, .frequency = 9_MHz});
    const b_mode_settings settings{.depth = 36_mm, .size = {0, 210}};
    scene body{tissue::muscle};
    const object_id needle =
        body.add(make_needle(needle_diameter(22), 80_mm), tissue::steel, {.priority = 1, .crease_angle = 12_deg});
    body.build(exec::par);
    const auto along = [&](float tilt) { // its tip is 2 mm to the right of the middle, 18 mm deep
        const vec3 tip{2_mm, 0, 18_mm}, direction{std::cos(tilt), 0, std::sin(tilt)};
        body.place(needle,
                   look_at(tip, tip + direction, {std::sin(tilt), 0, -std::cos(tilt)})); // the bevel faces the probe
    };
    picture_strip strip{settings.size.y};
    for (const float tilt : {5_deg, 20_deg, 40_deg}) {
        along(tilt);
        strip.add(b_mode(exec::par_unseq, body, array, pose{}, settings));
    }
    along(20_deg);
    const image straight = b_mode(exec::par_unseq, body, array, pose{}, settings),
                facing = b_mode(exec::par_unseq, body, steered{array, -15_deg}, pose{}, settings);
    strip.add(facing);
    write_png("needle.png", strip.picture());

    const auto white = [](const image& of) {
        std::size_t count = 0;
        for (const float pixel : of.pixels) count += pixel > 0.95F;
        return count;
    };
    std::printf("bright pixels of a needle at 20 degrees: %zu, steered %zu\n", white(straight), white(facing));
    return white(facing) > 2 * white(straight) ? 0 : 1;
}
