#include <insonify/geometry/needle.hpp>
#include <insonify/geometry/validate.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("a needle is closed, has its tip where it says, and the volume of a cylinder cut by a plane") {
    for (const float bevel : {12_deg, 30_deg, 90_deg})
        for (const std::uint32_t along : {1U, 20U}) {
            const float diameter = needle_diameter(22), shaft = 60_mm;
            const mesh needle =
                make_needle(diameter, shaft, {.bevel = bevel, .segments = 192, .segments_along = along});
            CHECK(validate(needle).closed());
            // A plane through the axis's point halfway along the bevel halves what it cuts off.
            const double radius = static_cast<double>(diameter) / 2,
                         cut = radius / std::tan(static_cast<double>(bevel));
            const double expected = 3.14159265358979 * radius * radius * (static_cast<double>(shaft) - cut);
            MESSAGE("volume ", enclosed_volume(needle) * 1e9, " mm^3 (expected ", expected * 1e9, ")");
            CHECK(enclosed_volume(needle) == doctest::Approx(expected).scale(1e-30).epsilon(1e-3));
            float furthest = -FLT_MAX, nearest = FLT_MAX;
            vec3 tip{0, 0, 0};
            for (const vec3& p : needle.positions) {
                nearest = std::fmin(nearest, p.z);
                if (p.z > furthest) {
                    furthest = p.z;
                    tip = p;
                }
            }
            CHECK(nearest == -shaft);
            CHECK(std::fabs(furthest) < 1e-9F);
            if (bevel < 89_deg) CHECK(length(tip - vec3{-diameter / 2, 0, 0}) < 1e-9F);
        }
}

TEST_CASE("gauges have their nominal diameters") {
    CHECK(needle_diameter(14) == 2.108_mm);
    CHECK(needle_diameter(18) == 1.270_mm);
    CHECK(needle_diameter(22) == 0.718_mm);
    CHECK(needle_diameter(25) == 0.514_mm);
    CHECK(needle_diameter(30) == 0.312_mm);
    for (std::uint32_t gauge = 14; gauge < 30; ++gauge) CHECK(needle_diameter(gauge) > needle_diameter(gauge + 1));
    CHECK_THROWS_AS(needle_diameter(13), geometry_error);
    CHECK_THROWS_AS(needle_diameter(31), geometry_error);
}

TEST_CASE("a needle out of range is refused") {
    CHECK_THROWS_AS(make_needle(0, 60_mm), geometry_error);
    CHECK_THROWS_AS(make_needle(1_mm, -1_mm), geometry_error);
    CHECK_THROWS_AS(make_needle(1_mm, 3_mm), geometry_error); // its bevel is 3.7 mm long
    CHECK_THROWS_AS(make_needle(1_mm, 60_mm, {.bevel = 1_deg}), geometry_error);
    CHECK_THROWS_AS(make_needle(1_mm, 60_mm, {.segments = 2}), geometry_error);
    CHECK_THROWS_AS(make_needle(1_mm, 60_mm, {.segments_along = 0}), geometry_error);
}
