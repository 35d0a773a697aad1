// A muscle below fat, with straight fibres, with fibres on arcs, and with fibres that fan out.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cmath>
#include <cstdio>

using namespace insonify;

int main() {
    constexpr std::uint32_t height = 220;
    const linear_array probe = presets::in_use(linear_array{.lines = 192, .width = 50_mm, .frequency = 9_MHz});
    const auto picture_of = [&](const fibre_directions& fibres) {
        scene body{tissue::fat};
        body.add(make_box({-40_mm, -15_mm, 6_mm}, {40_mm, 15_mm, 42_mm}), tissue::muscle, {.fibres = fibres});
        body.build(exec::par);
        b_mode_settings settings = presets::settings_for(probe);
        settings.size = {0, height};
        return b_mode(exec::par_unseq, body, probe, pose{}, settings);
    };
    const image straight = picture_of({1, 0, 0}), curved = picture_of([](vec3 p) {
                                                      return vec3{p.z + 40_mm, 0, -p.x};
                                                  }),
                fan = picture_of([](vec3 p) {
                    return p - vec3{-60_mm, p.y, 25_mm};
                });
    picture_strip strip{height};
    for (const image& each : {straight, curved, fan}) strip.add(each);
    write_png("fibres.png", strip.picture());

    // How alike brightness is 3 mm to the right, as many pixels higher as the arcs rise there, in the left half of the picture.
    const auto similar = [&](const image& of, bool rising) {
        const float pitch = 40_mm / height;
        const auto aside = static_cast<std::uint32_t>(3_mm / pitch);
        double ab = 0, aa = 0;
        for (std::uint32_t y = height / 3; y < height - 40; ++y)
            for (std::uint32_t x = 0; x < of.size.x / 4; ++x) {
                const float at = static_cast<float>(x) * pitch - 25_mm,
                            slope = at / (static_cast<float>(y) * pitch + 40_mm);
                const auto down = static_cast<std::uint32_t>(rising ? std::lround(-slope * 3_mm / pitch) : 0);
                const float a = of(x, y) - 0.4F, b = of(x + aside, y + down) - 0.4F;
                ab += static_cast<double>(a * b), aa += static_cast<double>(a * a);
            }
        return ab / aa;
    };
    std::printf("along arcs: %.2f with straight fibres, %.2f with fibres on arcs\n", similar(straight, true),
                similar(curved, true));
    return similar(curved, true) > similar(curved, false) ? 0 : 1;
}
