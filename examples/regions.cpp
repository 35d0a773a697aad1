// One standard view of each region that examples/anatomy makes by code: a neck, a thigh, an abdomen and a lumbar spine.
#define INSONIFY_IMPLEMENTATION
#include "anatomy/regions.hpp"
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cstdio>
#include <utility>
#include <variant>

using namespace insonify;

int main() {
    constexpr std::uint32_t height = 420;
    picture_strip strip{height};
    for (const auto& [region, seen] :
         {std::pair{"neck", "thyroid"}, std::pair{"leg", "femoral_block"}, std::pair{"right_upper_quadrant", "morison"},
          std::pair{"lumbar", "transverse_interlaminar"}}) {
        anatomy::body body = anatomy::find_region(region).make();
        body.anatomy.build(exec::par);
        anatomy::view view = body.find_view(seen);
        view.settings.size = {0, height};
        const pose at = anatomy::press_probe(body.anatomy, view);
        std::visit(
            [&](const auto& probe) { strip.add(b_mode(exec::par_unseq, body.anatomy, probe, at, view.settings)); },
            view.probe);
        std::printf("%s: %s\n", region, view.title.c_str());
    }
    write_png("regions.png", strip.picture());
}
