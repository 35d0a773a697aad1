// The structure of tissues: muscle without it, along its fibres and across them; fat; tendon, flat and tilted by 10 degrees;
// nerve.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cmath>
#include <cstdio>

using namespace insonify;

int main() {
    constexpr std::uint32_t height = 220;
    const linear_array probe =
        presets::in_use(linear_array{.lines = 128, .width = 20_mm, .frequency = 9_MHz, .focus = 12_mm});
    const auto picture_of = [&](const medium& tissue, vec3 fibres) {
        const b_mode_settings settings{.depth = 22_mm, .size = {0, height}, .tgc = tissue.attenuation};
        scene body{tissue};
        body.set_background_fibres(fibres, std::fabs(fibres.z) < 0.9F ? vec3{0, 0, 1} : vec3{1, 0, 0});
        body.build(exec::par);
        return b_mode(exec::par_unseq, body, probe, pose{}, settings);
    };
    medium plain = tissue::muscle;
    plain.structure = structure{};
    const image flat = picture_of(tissue::tendon, {1, 0, 0}),
                tilted = picture_of(tissue::tendon, {std::cos(10_deg), 0, std::sin(10_deg)});
    picture_strip strip{height};
    for (const image& each :
         {picture_of(plain, {1, 0, 0}), picture_of(tissue::muscle, {1, 0, 0}), picture_of(tissue::muscle, {0, 1, 0}),
          picture_of(tissue::fat, {1, 0, 0}), flat, tilted, picture_of(tissue::nerve, {0, 1, 0})})
        strip.add(each);
    write_png("structure.png", strip.picture());

    const auto mean = [](const image& of) { // down to 8 mm
        const std::size_t count = std::size_t{of.size.x} * of.size.y * 8 / 22;
        float sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += of.pixels[i];
        return sum / static_cast<float>(count);
    };
    const float lost = 60 * (mean(flat) - mean(tilted));
    std::printf("tendon loses %.1f dB of brightness where it is tilted by 10 degrees\n", lost);
    return lost > 4 && lost < 20 ? 0 : 1;
}
