#include <insonify/acoustics/tissue.hpp>
#include <insonify/diagnose.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/read/automatic_tgc.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace automatic_tgc_test {
namespace {

const linear_array probe{.lines = 128, .width = 40_mm, .frequency = 5_MHz};

scene layered(float muscle_from, float bone_from) {
    scene body{tissue::fat};
    body.add(make_box({-90_mm, -30_mm, muscle_from}, {90_mm, 30_mm, 200_mm}), tissue::muscle);
    body.add(make_box({-90_mm, -30_mm, bone_from}, {90_mm, 30_mm, 200_mm}), tissue::bone, {.priority = 1});
    body.build(exec::par);
    return body;
}

} // namespace

TEST_CASE("automatic_tgc: the mean attenuation along the middle lines, down to what blocks sound") {
    struct {
        const char* scene;
        float measured;
        double expected;
    } const rows[] = {
        {"fat, 60 dB/m", automatic_tgc(exec::par, layered(150_mm, 160_mm), probe, pose{}, 40_mm), 60},
        {"10 mm fat, 30 mm muscle", automatic_tgc(exec::par, layered(10_mm, 160_mm), probe, pose{}, 40_mm), 90},
        {"10 mm fat, 10 mm muscle, bone", automatic_tgc(exec::par, layered(10_mm, 20_mm), probe, pose{}, 40_mm), 80},
        {"the same, convex", automatic_tgc(exec::par, layered(160_mm, 180_mm), convex_array{}, pose{}, 80_mm), 60},
        {"water, at least 50", automatic_tgc(exec::par, scene{tissue::water}.build(exec::par), probe, pose{}, 40_mm),
         50},
        {"tendon, at most 100", automatic_tgc(exec::par, scene{tissue::tendon}.build(exec::par), probe, pose{}, 40_mm),
         100},
        {"air: the background's, at most 100",
         automatic_tgc(exec::par, scene{tissue::air}.build(exec::par), probe, pose{}, 40_mm), 100}};
    for (const auto& row : rows) {
        INFO(row.scene, ": ", row.measured, ", expected ", row.expected);
        CHECK(row.measured == doctest::Approx(row.expected).scale(1e-30).epsilon(1e-4));
    }
}

TEST_CASE("automatic_tgc: a vessel below a few of the middle lines changes nothing") {
    scene body = layered(10_mm, 160_mm);
    body.add(make_cylinder({2_mm, -20_mm, 20_mm}, {2_mm, 20_mm, 20_mm}, 4_mm, 64), tissue::blood);
    body.build(exec::par);
    CHECK(automatic_tgc(exec::par, body, probe, pose{}, 40_mm) == doctest::Approx(90).scale(1e-30).epsilon(1e-4));
}

TEST_CASE("automatic_tgc: wrong use is refused") {
    scene body{tissue::fat};
    body.add(make_sphere({0, 0, 20_mm}, 5_mm, 3), tissue::bone);
    CHECK_THROWS_AS(automatic_tgc(exec::par, body, probe, pose{}, 40_mm), usage_error);
    body.build(exec::par);
    CHECK_THROWS_AS(automatic_tgc(exec::par, body, probe, pose{}, 0), usage_error);
}

TEST_CASE("diagnose: a depth from which attenuation lets nothing return is reported") {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 25_mm}, 5_mm, 4), tissue::liver);
    body.build(exec::par);
    const linear_array high{.lines = 64, .width = 40_mm, .frequency = 10_MHz};
    CHECK(diagnose(body, high, pose{}, {.depth = 60_mm}).problems.empty()); // 60 dB at 30 mm, restored
    const diagnosis found = diagnose(body, high, pose{}, {.depth = 120_mm});
    REQUIRE(found.problems == std::vector{diagnosis::problem::attenuation});
    // 50 mm of muscle and 10 mm of liver (0.52 f^1.05): 2 (50 + 5.83) dB in the middle, 120 dB beside the sphere for the
    // carrier. The pulse of B = 0.644 loses 120 - 20 log10(e) (2.3548 / B)^2 / 8 = 105 dB, see `attenuated`.
    CHECK(found.sentence ==
          "Echoes from half the depth lose 105 dB, and automatic gain restores 60 dB: the picture is dark "
          "below; lower the frequency or `depth`.");
}

} // namespace automatic_tgc_test
