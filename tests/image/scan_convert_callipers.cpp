#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace callipers_test {
namespace {

const scan_map linear = make_scan_map(exec::seq, linear_array{.lines = 50, .width = 40_mm},
                                      {.depth = 50_mm, .samples = 100}, {.size = {400, 0}});
const scan_map uneven = make_scan_map(exec::seq, linear_array{.lines = 50, .width = 40_mm},
                                      {.depth = 50_mm, .samples = 100}, {.size = {100, 700}}); // pixels 0.4 x 0.071 mm
const scan_map convex = make_scan_map(exec::seq, convex_array{}, {.depth = 120_mm, .samples = 100}, {.size = {333, 0}});

double ratio(float measured, double expected) { return static_cast<double>(measured) / expected; }

} // namespace

TEST_CASE("callipers: distances are those of the points, in metres") {
    CHECK(ratio(distance(linear, {0, 200}, {400, 200}), 40e-3) ==
          doctest::Approx(1).scale(1e-30).epsilon(1e-5)); // the whole width
    CHECK(ratio(distance(linear, {200, 0}, {200, 500}), 50e-3) ==
          doctest::Approx(1).scale(1e-30).epsilon(1e-5)); // the whole depth
    for (const scan_map& map : {linear, uneven, convex}) {
        const vec2 a = map.pixel({-3_mm, 20_mm}), b = map.pixel({9_mm, 25_mm}); // 5, 12, 13
        MESSAGE("13 mm is measured as ", 1e3F * distance(map, a, b), " mm");
        CHECK(ratio(distance(map, a, b), 13e-3) == doctest::Approx(1).scale(1e-30).epsilon(1e-5));
        CHECK(distance(map, a, a) == 0);
    }
}

TEST_CASE("callipers: area, circumference and centroid of rectangles, triangles and circles") {
    for (const scan_map& map : {linear, uneven, convex}) {
        const auto outline = [&](std::vector<vec2> points) {
            for (vec2& p : points) p = map.pixel(p);
            return points;
        };
        const std::vector<vec2> box = outline({{-5_mm, 10_mm}, {3_mm, 10_mm}, {3_mm, 22_mm}, {-5_mm, 22_mm}});
        const std::vector<vec2> back{box.rbegin(), box.rend()};
        for (const std::vector<vec2>& each : {box, back}) {
            const outline_measure found = measure_outline(map, {each.data(), each.size()});
            CHECK(ratio(found.area, 8e-3 * 12e-3) == doctest::Approx(1).scale(1e-30).epsilon(1e-5));
            CHECK(ratio(found.circumference, 2 * (8e-3 + 12e-3)) == doctest::Approx(1).scale(1e-30).epsilon(1e-5));
            CHECK(length(map.point(found.centroid) - vec2{-1_mm, 16_mm}) < 1e-6F);
        }
        const std::vector<vec2> triangle = outline({{0, 10_mm}, {6_mm, 10_mm}, {0, 19_mm}});
        const outline_measure third = measure_outline(map, {triangle.data(), triangle.size()});
        CHECK(ratio(third.area, 0.5 * 6e-3 * 9e-3) == doctest::Approx(1).scale(1e-30).epsilon(1e-5));
        CHECK(length(map.point(third.centroid) - vec2{2_mm, 13_mm}) < 1e-6F);

        // A regular polygon of n sides in a circle of radius r: area n r^2 sin(2 pi / n) / 2, circumference 2 n r sin(pi / n).
        const double pi_ = 3.14159265358979, r = 4e-3;
        for (const int n : {6, 100}) {
            std::vector<vec2> circle;
            for (int i = 0; i < n; ++i)
                circle.push_back({static_cast<float>(1e-3 + r * std::cos(2 * pi_ * i / n)),
                                  static_cast<float>(20e-3 + r * std::sin(2 * pi_ * i / n))});
            circle = outline(circle);
            const outline_measure found = measure_outline(map, {circle.data(), circle.size()});
            const double area = 0.5 * n * r * r * std::sin(2 * pi_ / n), around = 2 * n * r * std::sin(pi_ / n);
            MESSAGE(n, " sides: ", 1e6F * found.area, " mm^2, expected ", 1e6 * area, "; around ",
                    1e3F * found.circumference, " mm, expected ", 1e3 * around);
            CHECK(ratio(found.area, area) == doctest::Approx(1).scale(1e-30).epsilon(1e-4));
            CHECK(ratio(found.circumference, around) == doctest::Approx(1).scale(1e-30).epsilon(1e-4));
        }
    }
}

TEST_CASE("callipers: fewer than three points enclose nothing") {
    CHECK(measure_outline(linear, {}).area == 0);
    const vec2 line[] = {{10, 10}, {10, 20}};
    const outline_measure found = measure_outline(linear, {line, 2});
    CHECK(found.area == 0);
    CHECK(ratio(found.circumference, 2 * 10 * 0.1e-3) ==
          doctest::Approx(1).scale(1e-30).epsilon(1e-5)); // there and back
    CHECK(found.centroid == vec2{10, 15});
}

} // namespace callipers_test
