// One phantom, scaled to the depth of four kinds of probe: a cyst, a vessel, and bone below.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cstdio>

using namespace insonify;

constexpr vec2 cyst{-0.15F, 0.35F}, vessel{0.16F, 0.4F}, bone{0.03F, 0.72F}; ///< x, z as fractions of the depth

scene phantom(float depth) {
    scene body{tissue::liver};
    const auto add = [&](vec2 centre, float radius, const medium& inside) {
        const vec3 middle = depth * vec3{centre.x, 0, centre.y}, half{0, depth, 0};
        body.add(make_cylinder(middle - half, middle + half, radius * depth, 96), inside);
    };
    add(cyst, 0.08F, tissue::bile);
    add(vessel, 0.07F, tissue::vessel_wall);
    add(vessel, 0.055F, tissue::blood);
    add(bone, 0.1F, tissue::bone);
    return body;
}

/// Draws the phantom. Returns whether cyst and shadow are dark and the liver is not.
template <transducer Probe>
bool draw(const char* name, const Probe& probe, const b_mode_settings& settings, picture_strip& strip) {
    const scene body = phantom(settings.depth).build(exec::par);
    const image picture = b_mode(exec::par_unseq, body, probe, pose{}, settings);
    strip.add(picture);

    const scan_map map =
        make_scan_map(exec::par, probe, {.depth = settings.depth, .samples = 1}, {.size = settings.size});
    const auto grey_at = [&](vec2 fraction) { // mean of 5 x 5 pixels
        const vec2 pixel = map.pixel(settings.depth * fraction);
        const auto column = static_cast<std::uint32_t>(pixel.x), row = static_cast<std::uint32_t>(pixel.y);
        float sum = 0;
        for (std::uint32_t i = 0; i < 25; ++i) sum += picture(column - 2 + i % 5, row - 2 + i / 5) / 25;
        return sum;
    };
    const float liver = grey_at({0, 0.4F}), dark = grey_at(cyst), shadow = grey_at({bone.x, 0.9F});
    std::printf("%s: liver %.2f, cyst %.2f, shadow of the bone %.2f\n", name, liver, dark, shadow);
    return liver > 0.3F && dark < 0.1F && shadow < 0.1F;
}

int main() {
    const uvec2 size{0, 150};
    picture_strip strip{size.y};
    const bool seen[] = {
        draw("linear", linear_array{}, {.depth = 40_mm, .size = size}, strip),
        draw("convex", convex_array{}, {.depth = 120_mm, .size = size}, strip),
        draw("phased", phased_array{}, {.depth = 120_mm, .size = size}, strip),
        draw("radial", radial_array{}, {.depth = 6_mm, .size = size}, strip),
    };
    write_png("probes.png", strip.picture());
    return seen[0] && seen[1] && seen[2] && seen[3] ? 0 : 1;
}
