#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/queries.hpp>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("displayed and true depth of layers are those of their travel times, by hand") {
    medium fat = tissue::fat, bone = tissue::bone, metal{.density = 8000, .sound_speed = 6000};
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.add(make_box({-50_mm, -50_mm, 0}, {50_mm, 50_mm, 20_mm}), fat);      // 1455 m/s: 21.168 mm as displayed
    body.add(make_box({-50_mm, -50_mm, 30_mm}, {50_mm, 50_mm, 40_mm}), bone); // 3500 m/s: 4.4 mm
    body.build(exec::par);
    const ray down{.origin = {1_mm, 2_mm, 0}, .direction = {0, 0, 2}}; // of any length
    const struct {
        float depth, shown;
    } rows[] = {{10_mm, 10.58419_mm}, {20_mm, 21.16838_mm}, {30_mm, 31.16838_mm},
                {35_mm, 33.36838_mm}, {40_mm, 35.56838_mm}, {60_mm, 55.56838_mm}};
    for (const auto& row : rows) {
        CHECK(displayed_depth(body, down, row.depth) == doctest::Approx(row.shown).epsilon(2e-5).scale(1e-30));
        CHECK(true_depth(body, down, row.shown) == doctest::Approx(row.depth).epsilon(2e-5).scale(1e-30));
    }
    CHECK(displayed_depth(body, {.origin = {0, 0, 60_mm}, .direction = {0, 0, -1}}, 40_mm) ==
          doctest::Approx(34.4_mm).epsilon(1e-5).scale(1e-30)); // from below: 20 + 4.4 + 10
    scene many{medium{.density = 1000, .sound_speed = 1540}};
    for (int i = 0; i < 200; ++i) { // more surfaces than the first room holds
        const float z = 0.3_mm * static_cast<float>(i);
        many.add(make_box({-5_mm, -5_mm, z + 0.1_mm}, {5_mm, 5_mm, z + 0.2_mm}), metal);
    }
    many.build(exec::par);
    const double shown = 200 * (0.2e-3 + 0.1e-3 * 1540 / 6000);
    CHECK(displayed_depth(many, {.direction = {0, 0, 1}}, 60_mm) == doctest::Approx(shown).epsilon(1e-4).scale(1e-30));
    CHECK(true_depth(many, {.direction = {0, 0, 1}}, static_cast<float>(shown)) ==
          doctest::Approx(60e-3).epsilon(1e-4).scale(1e-30));
    CHECK_THROWS_AS(displayed_depth(body, {.direction = {0, 0, 0}}, 10_mm), usage_error);
    CHECK_THROWS_AS(true_depth(body, {.direction = {0, 0, 1}}, -1_mm), usage_error);
    CHECK_THROWS_AS(true_depth(body, {.direction = {0, 0, 1}}, 80), usage_error);
}
