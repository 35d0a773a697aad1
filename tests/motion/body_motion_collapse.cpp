#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/scene/inverse_map.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace collapse_test {
namespace {

constexpr collapse vein{.from = {2_mm, 0, 17_mm}, .to = {2_mm, 1, 17_mm}, .radius = 4.5_mm, .inside = 8_mmHg};

collapse pressed(float outside) {
    collapse map = vein;
    map.outside = outside;
    return map;
}

/// Area of the outline that a map makes of a circle, and its width and height: polygon of many corners, in doubles.
struct outline {
    double area = 0, width = 0, height = 0;
};
template <class Map>
outline outline_of(const Map& map, vec3 centre, float radius) {
    constexpr int corners = 720;
    std::vector<dvec3> now;
    for (int i = 0; i < corners; ++i) {
        const float angle = 2 * pi * static_cast<float>(i) / corners;
        now.push_back(dvec3{map(centre + radius * vec3{std::cos(angle), 0, std::sin(angle)})});
    }
    outline found;
    dvec3 lower = now[0], upper = now[0];
    for (std::size_t i = 0; i < now.size(); ++i) {
        const dvec3 &a = now[i], &b = now[(i + 1) % now.size()];
        found.area += 0.5 * (a.x * b.z - b.x * a.z);
        lower = min(lower, a);
        upper = max(upper, a);
    }
    found.width = upper.x - lower.x;
    found.height = upper.z - lower.z;
    return found;
}

} // namespace
} // namespace collapse_test

TEST_CASE("collapse: the lumen has the area and the height of the law of tubes that are nearly closed") {
    using namespace collapse_test;
    const outline open = outline_of(vein, vein.from, vein.radius);
    for (const float excess : {-5_mmHg, 0_mmHg, 0.3_mmHg, 1_mmHg, 2_mmHg, 4_mmHg, 8_mmHg, 60_mmHg}) {
        const outline now = outline_of(pressed(8_mmHg + excess), vein.from, vein.radius);
        const double law = std::pow(1 + std::fmax(static_cast<double>(excess) / 40.0, 0.0), -2.0 / 3.0);
        const double expected = std::fmax(law, 0.06);
        MESSAGE("pressure ", excess / 1_mmHg, " mmHg above venous pressure: area ", now.area / open.area, ", height ",
                now.height / open.height, ", width ", now.width / open.width, " of those at rest; expected ", expected,
                ", ", expected, ", 1");
        CHECK(std::fabs(now.area / open.area - expected) < 1e-4);
        CHECK(std::fabs(now.height / open.height - expected) < 1e-4);
        CHECK(std::fabs(now.width / open.width - 1) < 1e-5);
    }
}

TEST_CASE("collapse: tissue stays in one piece, and does not fold over for any pressure and setting") {
    using namespace collapse_test;
    bool ahead = true;
    double lowest = 1, jump = 0, lost = 0;
    for (std::uint64_t trial = 0; trial < 400; ++trial) {
        const auto number = [&](std::uint64_t i) { return hash_uniform(7, 10 * trial + i); };
        collapse map = pressed(8_mmHg + 20_mmHg * number(0));
        map.to = map.from + vec3{0.3F * (number(1) - 0.5F), 1, number(2) - 0.5F};
        map.beside = 0.5_mm + 4_mm * number(3);
        map.above = 0.5_mm + 8_mm * number(4);
        map.residual = 0.03F + 0.3F * number(5);
        for (std::uint64_t i = 0; i < 200; ++i) {
            const auto fraction = [&](std::uint64_t k) { return hash_uniform(trial, 3 * i + k) - 0.5F; };
            const vec3 rest = map.from + 30_mm * vec3{fraction(0), fraction(1), fraction(2)};
            const vec3 now = map(rest);
            const vec3 axis = normalize(map.to - map.from), step = 30_um * normalize(vec3{0, 0, 1} - axis.z * axis);
            // Points move along `step` alone, so the determinant is the derivative along it.
            const dvec3 apart = dvec3{map(rest + step)} - dvec3{map(rest - step)};
            lowest = std::fmin(lowest, length(apart) / length(2.0 * dvec3{step}) / static_cast<double>(map.opening()));
            ahead = ahead && dot(apart, dvec3{step}) > 0;
            vec3 found = now;
            CHECK(detail::find_rest(map, now, found));
            lost = std::fmax(lost, static_cast<double>(length(found - rest)));
        }
        // Across the wall: points that are 0.2 um apart stay together.
        for (int i = 0; i < 64; ++i) {
            const vec3 axis = normalize(map.to - map.from), side = normalize(cross(axis, vec3{0, 0, 1}));
            const float angle = 2 * pi * static_cast<float>(i) / 64;
            const vec3 outwards = std::cos(angle) * side + std::sin(angle) * cross(side, axis);
            jump = std::fmax(jump, static_cast<double>(length(map(map.from + (map.radius + 0.1_um) * outwards) -
                                                              map(map.from + (map.radius - 0.1_um) * outwards))));
        }
    }
    MESSAGE("lowest determinant ", lowest, " of the opening, expected at least 1; across the wall ", jump * 1e6,
            " um from points 0.2 um apart; the inverse is off by at most ", lost * 1e6, " um");
    CHECK(ahead);
    CHECK(lowest > 0.99);
    CHECK(jump < 0.3e-6);
    CHECK(lost < 20e-6);
}

TEST_CASE("collapse: an artery beside the vein stays open") {
    using namespace collapse_test;
    const vec3 beside = vein.from - vec3{9.25_mm, 0, 0}; // walls of 0.5 and 0.5 mm, 0.5 mm between them
    const outline at_rest = outline_of(vein, beside, 3.25_mm);
    for (const float pressure : {10_mmHg, 15_mmHg, 40_mmHg}) {
        const outline now = outline_of(pressed(pressure), beside, 3.25_mm);
        MESSAGE("pressure ", pressure / 1_mmHg, " mmHg: the artery is ", now.width / at_rest.width, " wide and ",
                now.height / at_rest.height, " high, expected 0.95 to 1.05; area ", now.area / at_rest.area);
        CHECK(std::fabs(now.width / at_rest.width - 1) < 0.05);
        CHECK(std::fabs(now.height / at_rest.height - 1) < 0.05);
    }
    // Its own pressure is that of an artery: it does not collapse until that is exceeded.
    CHECK(collapse{.outside = 80_mmHg, .inside = 90_mmHg}.opening() == 1);
    CHECK(collapse{.outside = 80_mmHg, .inside = 90_mmHg}({1_mm, 2_mm, 3_mm}) == vec3{1_mm, 2_mm, 3_mm});
}

TEST_CASE("deform: a scene follows a vein that collapses") {
    using namespace collapse_test;
    scene body{tissue::muscle};
    const object_id lumen =
        body.add(make_cylinder({2_mm, -20_mm, 17_mm}, {2_mm, 20_mm, 17_mm}, 4.5_mm, 64, 8), tissue::blood);
    body.build(exec::par);
    for (const float pressure : {0_mmHg, 9_mmHg, 30_mmHg, 0_mmHg}) {
        const collapse map = pressed(pressure);
        body.deform(exec::par, map);
        const float height = body.box(lumen).size().z / 9_mm;
        CHECK(std::fabs(height - map.opening()) < 1e-4F);
        const vec3 wall{2_mm, 0, 17_mm - 4.5_mm * map.opening()};
        CHECK(length(body.rest_of(wall) - vec3{2_mm, 0, 12.5_mm}) < 0.01_mm);
    }
    CHECK_THROWS_AS(body.deform(exec::par, collapse{.direction = {0, 1, 0}}), usage_error);
    CHECK_THROWS_AS(body.deform(exec::par, collapse{.residual = 0}), usage_error);
    CHECK_THROWS_AS(body.deform(exec::par, collapse{.above = 0}), usage_error);
}
