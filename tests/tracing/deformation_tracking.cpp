#include "deformed_frames.hpp"
#include <doctest/doctest.h>

using namespace insonify;

namespace deformed_test {
namespace {

/// Correlation of the speckle of muscle with that at rest, where the map says that it was.
double correlation_at(float depth, const frame& rest) {
    scene body = calf();
    body.deform(exec::par, pressed{depth});
    const frame now = frame_of(body);
    double sum = 0;
    int count = 0;
    for (int line = 10; line < 182; line += 9)
        for (float z = 6_mm; z < 28_mm; z += 1.5_mm, ++count) {
            const pressed map{depth};
            correlation window;
            for (int i = line - 4; i <= line + 4; ++i)
                for (float d = -0.75_mm; d <= 0.75_mm; d += 0.02_mm)
                    window.add(rest.at(i, z + d), now.at(i, map({x_of(i), 0, z + d}).z));
            sum += window.value();
        }
    return sum / count;
}

} // namespace
} // namespace deformed_test

TEST_CASE("speckle correlates with that at rest while tissue is pressed") {
    using namespace deformed_test;
    const frame rest = frame_of(calf());
    const double at_1mm = correlation_at(1_mm, rest), at_4mm = correlation_at(4_mm, rest);
    MESSAGE("correlation in windows of 1.5 mm: pressed by 1 mm ", at_1mm, ", expected above 0.85; by 4 mm ", at_4mm,
            ", expected above 0.7");
    CHECK(at_1mm > 0.85);
    CHECK(at_4mm > 0.7);
}

TEST_CASE("block matching finds the displacement that was put in") {
    using namespace deformed_test;
    const frame rest = frame_of(calf());
    for (const float depth : {1_mm, 3_mm, 5_mm}) {
        scene body = calf();
        const pressed map{depth};
        body.deform(exec::par, map);
        const frame now = frame_of(body);
        float worst = 0, sum = 0;
        int sure = 0, all = 0;
        for (int line = 12; line < 180; line += 14)
            for (float z = 6_mm; z < 28_mm; z += 2_mm, ++all) {
                const float x = x_of(line), expected = map({x, 0, z}).z - z;
                const float stretch = (map({x, 0, z + 0.1_mm}).z - map({x, 0, z - 0.1_mm}).z) / 0.2_mm;
                const match found = find_window(rest, now, line, z, stretch, expected - 0.6_mm, expected + 0.6_mm);
                if (found.correlation < 0.9) continue;
                ++sure;
                worst = max(worst, std::fabs(found.moved - expected));
                sum += std::fabs(found.moved - expected);
            }
        MESSAGE("pressed by ", depth * 1e3F, " mm: ", sure, " of ", all, " windows correlate above 0.9; error at most ",
                worst * 1e3F, " mm, mean ", sum / static_cast<float>(sure) * 1e3F, " mm, expected below 0.1");
        CHECK(sure > all / 10);
        CHECK(worst < 0.1_mm);
    }
}

TEST_CASE("strain by block matching is the strain that was put in") {
    using namespace deformed_test;
    const frame rest = frame_of(calf());
    scene body = calf();
    const float strain = 0.02F;
    body.deform(exec::par, [strain](vec3 p) { return vec3{p.x, p.y, (1 - strain) * p.z}; });
    const frame now = frame_of(body);
    // Least squares of displacement by depth, over all lines.
    double n = 0, z1 = 0, d1 = 0, zz = 0, zd = 0;
    for (int line = 12; line < 180; line += 14)
        for (float z = 6_mm; z < 28_mm; z += 1_mm) {
            const match found = find_window(rest, now, line, z, 1, -1.2_mm, 0.3_mm);
            if (found.correlation < 0.8) continue;
            const double depth = static_cast<double>(z), moved = static_cast<double>(found.moved);
            n += 1, z1 += depth, d1 += moved, zz += depth * depth, zd += depth * moved;
        }
    const double found = -(zd - z1 * d1 / n) / (zz - z1 * z1 / n);
    MESSAGE("strain of ", found, " found in ", n, " windows, ", strain, " was put in");
    CHECK(std::fabs(found - static_cast<double>(strain)) < 0.001);
}
