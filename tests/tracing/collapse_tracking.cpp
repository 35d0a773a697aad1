#include <insonify/motion/body_motion.hpp>
#include "deformed_frames.hpp"
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("speckle around a vein that collapses is found where the map puts it") {
    using namespace deformed_test;
    scene body{tissue::muscle};
    body.add(make_cylinder({0, -20_mm, 18_mm}, {0, 20_mm, 18_mm}, 4.5_mm, 96, 8), tissue::blood);
    body.build(exec::par);
    const frame rest = frame_of(body);
    for (const float pressure : {8.1_mmHg, 8.2_mmHg}) {
        const collapse map{.from = {0, 0, 18_mm}, .to = {0, 1, 18_mm}, .outside = pressure, .inside = 8_mmHg};
        body.deform(exec::par, map);
        const frame now = frame_of(body);
        float worst = 0, farthest = 0;
        int sure = 0, all = 0;
        for (int line = 12; line < 180; line += 6)
            for (float z = 5_mm; z < 31_mm; z += 1_mm) {
                if (std::hypot(x_of(line), z - 18_mm) < 6_mm) continue; // the lumen, its wall and their echoes
                ++all;
                match best;
                for (float off = -0.4_mm; off <= 0.4_mm; off += 0.02_mm) { // from where the map puts the window
                    correlation window;
                    for (int i = line - 4; i <= line + 4; ++i)
                        for (float d = -0.75_mm; d <= 0.75_mm; d += 0.02_mm)
                            window.add(rest.at(i, z + d), now.at(i, map({x_of(i), 0, z + d}).z + off));
                    if (window.value() > best.correlation) best = {off, window.value()};
                }
                if (best.correlation < 0.9) continue;
                ++sure;
                farthest = max(farthest, std::fabs(map({x_of(line), 0, z}).z - z));
                worst = max(worst, std::fabs(best.moved));
            }
        MESSAGE("opening ", map.opening(), ": ", sure, " of ", all, " windows correlate above 0.9, moved by up to ",
                farthest * 1e3F, " mm; error at most ", worst * 1e3F, " mm, expected below 0.1");
        CHECK(sure > all / 3);
        CHECK(farthest > 0.5F * (1 - map.opening()) * 4.5_mm);
        CHECK(worst < 0.1_mm);
    }
}
