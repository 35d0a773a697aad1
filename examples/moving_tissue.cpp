// Tissue that moves: an artery pulses in a limb that a probe is pressed into. Where its face leaves the skin, lines are dark.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cstdio>

using namespace insonify;

int main() {
    scene body{tissue::air};
    const auto along_y = [&](float depth, float radius, std::uint32_t sides, const medium& inside, const char* name) {
        return body.add(make_cylinder({0, -40_mm, depth}, {0, 40_mm, depth}, radius, sides, 32), inside,
                        {.name = name});
    };
    along_y(40_mm, 40_mm, 512, tissue::fat, "skin");
    along_y(40_mm, 36_mm, 384, tissue::muscle, "muscle");
    const object_id vessel = along_y(16_mm, 3_mm, 48, tissue::blood, "artery");
    along_y(34_mm, 7_mm, 64, tissue::bone, "bone");
    body.build(exec::par);

    const linear_array probe{.lines = 192, .width = 38_mm, .frequency = 7.5_MHz};
    scanner<linear_array> machine{probe, {.depth = 40_mm, .size = {380, 400}, .tgc = 80}};
    picture_strip strip{400};
    float worst = 0;
    struct moment {
        float depth, time;
    };
    for (const moment now : {moment{0.5_mm, 0}, moment{4_mm, 0}, moment{8_mm, 0}, moment{8_mm, 0.125F}}) {
        const pose at{.translation = {0, 0, now.depth}};
        const pulsation artery{
            .from = {0, 0, 16_mm}, .to = {0, 1, 16_mm}, .radius = 3_mm, .amplitude = 0.6_mm, .time = now.time};
        const contact touch = press(body, probe, at);
        const auto map = compose(artery, touch.deformation);
        body.deform(exec::par, map);
        strip.add(machine.scan(exec::par_unseq, body, at));
        const auto met = first_surface(body, {.origin = at.translation}, [&](object_id id) { return id == vessel; });
        const float top = met ? met->point.z : 0, expected = map({0, 0, 13_mm}).z;
        worst = max(worst, std::fabs(top - expected));
        std::printf(
            "%.1f mm deep at %.3f s: %3u of 192 lines touch, %.1f N; top of the artery %.2f mm below the face\n",
            touch.depth / 1_mm, now.time, touch.touching, touch.force, (top - at.translation.z) / 1_mm);
    }
    write_png("moving_tissue.png", strip.picture());
    return worst < 0.05_mm ? 0 : 1;
}
