#include <insonify/core/units.hpp>
#include <insonify/signal/kernel/compensated_echoes.hpp>
#include <doctest/doctest.h>
#include <initializer_list>

using namespace insonify;
using detail::surface_strip;

TEST_CASE("the strip of a plane surface falls evenly") {
    const surface_strip strip{0.5F, 0, {-0.2_mm, 0.6_mm}};
    CHECK(strip.deeper(0) == doctest::Approx(0.1_mm).scale(1e-30));
    CHECK(strip.deeper(0.25F) == doctest::Approx(0).scale(1e-3));
    CHECK(strip.deeper(1) == doctest::Approx(-0.3_mm).scale(1e-30));
    CHECK(strip.range() == doctest::Approx(0.4_mm).scale(1e-30));
}

TEST_CASE("the strip of a round surface is an arc, and ends with it") {
    // A cylinder along the line's lateral axis, of which the line meets a point at a height: depths of a circle. Cavities
    // (radius below 0) are met from inside.
    for (const float radius : {1_mm, -1_mm, 4_mm})
        for (const float height : {-0.6_mm, 0.0F, 0.3_mm}) {
            const auto depth = [&](float above) {
                return -std::copysign(1.0F, radius) * std::sqrt(radius * radius - above * above);
            };
            const float slope = -height / -depth(height), cosine = 1 / std::sqrt(1 + slope * slope),
                        curvature = 1 / (radius * cosine * cosine * cosine);
            const vec2 ends{-0.5_mm, 0.8_mm};
            const surface_strip strip{slope, curvature, ends};
            const float lower = max(ends.x, -0.95F * std::fabs(radius) - height),
                        upper = min(ends.y, 0.95F * std::fabs(radius) - height);
            for (const float part : {0.0F, 0.3F, 0.7F, 1.0F}) {
                const float above = height + lower + part * (upper - lower);
                CHECK(strip.deeper(part) == doctest::Approx(depth(above) - depth(height)).scale(1e-30).epsilon(1e-3));
            }
            CHECK(strip.range() < 2.1F * std::fabs(radius));
        }
}

TEST_CASE("a strip of no height is the point of the line, however the surface bends") {
    for (const float curvature : {0.0F, 1e3F, -1e6F, 1e12F, INFINITY, -INFINITY, NAN})
        for (const float slope : {0.0F, 5.0F, -0.1F}) {
            const surface_strip strip{slope, curvature, {0, 0}};
            CHECK(std::fabs(strip.deeper(0.5F)) < 1e-8F);
            CHECK(strip.range() < 1e-8F);
        }
}

TEST_CASE("a strip beside the line, of a surface that ends before it, stays within the surface") {
    const float radius = 0.05_mm;
    const surface_strip strip{0, 1 / radius, {0.3_mm, 0.5_mm}};
    for (const float part : {0.0F, 0.5F, 1.0F}) CHECK(std::fabs(strip.deeper(part)) <= 1.001F * radius);
    CHECK(strip.range() <= 2.001F * radius);
}
