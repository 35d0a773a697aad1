#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/centre_line.hpp>
#include <insonify/geometry/shapes.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace centre_line_test {
namespace {

// A quarter of a circle of a radius of 30 mm in the plane of x and z, from {30, 0, 0} to {0, 0, 30} mm.
std::vector<tube_section> quarter(std::uint32_t count, vec2 radii = {3_mm, 2_mm}) {
    std::vector<tube_section> line;
    for (std::uint32_t i = 0; i <= count; ++i) {
        const float angle = 0.5F * pi * static_cast<float>(i) / static_cast<float>(count);
        line.push_back({.centre = 30_mm * vec3{std::cos(angle), 0, std::sin(angle)}, .radii = radii});
    }
    return line;
}

} // namespace
} // namespace centre_line_test

TEST_CASE("centre_line: a point's place is that of the section across which it lies") {
    using namespace centre_line_test;
    const centre_line line{quarter(24), {0, 1, 0}};
    for (std::uint64_t i = 0; i < 500; ++i) {
        const float angle = 0.1F + 1.37F * hash_uniform(1, i), out = 6_mm * (hash_uniform(2, i) - 0.5F),
                    up = 6_mm * (hash_uniform(3, i) - 0.5F);
        const vec3 outwards{std::cos(angle), 0, std::sin(angle)};
        const vec3 point = (30_mm + out) * outwards + vec3{0, up, 0};
        const line_place here = line.place(point);
        // Chords of an arc of 3.75 degrees: 30 mm (1 - cos(1.875 degrees)) = 16 um inside.
        CHECK(length(here.centre - 30_mm * outwards) < 20_um);
        CHECK(dot(here.along, vec3{-std::sin(angle), 0, std::cos(angle)}) > 1 - 1e-4F);
        CHECK(std::fabs(dot(point - here.centre, here.along)) < 1_um);
        // The first axis, y, is that of 3 mm.
        CHECK(here.squared(point) == doctest::Approx(up * up / 9e-6F + out * out / 4e-6F).epsilon(0.03).scale(0.1));
        CHECK(here.area() == doctest::Approx(pi * 6e-6F).scale(1e-30));
    }
}

TEST_CASE("centre_line: a point that moves across the line keeps its place") {
    using namespace centre_line_test;
    const centre_line line{quarter(7)};
    for (std::uint64_t i = 0; i < 500; ++i) {
        const vec3 point = 30_mm * normalize(vec3{hash_uniform(4, i), 0, hash_uniform(5, i)} + 0.01F) +
                           5_mm * (vec3{hash_uniform(6, i), hash_uniform(7, i), hash_uniform(8, i)} - 0.5F);
        const line_place before = line.place(point);
        const vec3 moved = before.centre + 2.0F * (point - before.centre) + 1_mm * before.second_axis;
        const line_place after = line.place(moved);
        CHECK(length(after.centre - before.centre) < 1_um);
        CHECK(length(after.along - before.along) < 1e-4F);
    }
}

TEST_CASE("centre_line: places are continuous, go on straight beyond the ends, and fit the surface of the tube") {
    using namespace centre_line_test;
    std::vector<tube_section> sections = quarter(12);
    for (std::size_t i = 0; i < sections.size(); ++i) {
        sections[i].radii *= 1 + 0.05F * static_cast<float>(i);
        sections[i].turn = 0.1F * static_cast<float>(i);
    }
    const centre_line line{sections};
    // Along the first chord, which is half a step from z.
    CHECK(length(line.place({32_mm, 0, -10_mm}).centre - vec3{30_mm, 0, -10_mm}) < 1_mm);
    const auto place = [&](int i) {
        const float angle = -0.4F + 2.4F * static_cast<float>(i) / 2000;
        return line.place({32_mm * std::cos(angle), 0, 32_mm * std::sin(angle)});
    };
    line_place last = place(0);
    for (int i = 1; i <= 2000; ++i) {
        const line_place here = place(i);
        CHECK(length(here.centre - last.centre) < 0.1_mm);
        CHECK(length(here.first_axis - last.first_axis) < 0.02F);
        last = here;
    }
    for (const vec3& p : make_tube(sections, {.ends = tube_settings::end_shape::flat}).positions)
        if (const float r = line.place(p).squared(p); r > 1e-6F) // not the middles of the ends
            CHECK(r == doctest::Approx(1).scale(1e-30).epsilon(1e-3));
}

TEST_CASE("centre_line: too few points, and a line that turns back, are refused") {
    const tube_section at{}, next{{0, 0, 1_mm}};
    CHECK(centre_line{}.empty());
    CHECK_THROWS_WITH_AS((centre_line{{at}}), "centre_line: `line` has 1 points; give from 2 to 1048576",
                         geometry_error);
    CHECK_THROWS_AS((centre_line{{at, at}}), geometry_error);
    CHECK_THROWS_AS((centre_line{{at, next, at}}), geometry_error);
    CHECK(centre_line{{at, next}} == centre_line{{at, next}});
    CHECK_FALSE(centre_line{{at, next}} == centre_line{});
}
