#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/motion/press.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace body_motion_test {
namespace {

/// Determinant of a map's derivative, by central differences in double precision of the positions.
template <class Map>
double volume_factor(const Map& map, vec3 at) {
    constexpr float h = 0.2_mm;
    dvec3 columns[3];
    for (int k = 0; k < 3; ++k) {
        vec3 plus = at, minus = at;
        plus[k] += h;
        minus[k] -= h;
        columns[k] = (dvec3{map(plus)} - dvec3{map(minus)}) / static_cast<double>(plus[k] - minus[k]);
    }
    return dot(columns[0], cross(columns[1], columns[2]));
}

} // namespace
} // namespace body_motion_test

TEST_CASE("indentation: skin below the face lies on it, and only there") {
    const pose at = look_at({10_mm, 5_mm, 3_mm}, {10_mm, 5_mm, 30_mm}, {0.6F, 0.8F, 0});
    const indentation pressed{.at = at, .depth = 3_mm};
    float worst = 0, nearest = 1;
    for (float x = -30_mm; x <= 30_mm; x += 0.7_mm)
        for (float y = -15_mm; y <= 15_mm; y += 0.7_mm) {
            const vec3 now = at.local_point(pressed(at.point({x, y, -3_mm}))); // flat skin, 3 mm above the face
            const bool below = std::fabs(x) <= 20_mm && std::fabs(y) <= 4_mm;
            if (below)
                worst = max(worst, std::fabs(now.z));
            else
                nearest = min(nearest, -now.z / max(max(std::fabs(x) - 20_mm, std::fabs(y) - 4_mm), 0.1_mm));
            CHECK(now.z < 1e-7F);
        }
    MESSAGE("skin is within ", worst * 1e6F, " um of the face below it; beside it, above the face by at least ",
            nearest, " of the distance from its edge");
    CHECK(worst < 0.01_um);
    CHECK(nearest > 0.05F);
    // Below the middle: exponential with depth.
    const vec3 deep = at.local_point(pressed(at.point({0, 0, 17_mm})));
    CHECK(std::fabs(deep.z - 17_mm - 3_mm * std::exp(-1.0F)) < 0.01_um);
    CHECK_THROWS_AS((indentation{.depth = 30_mm}.check()), usage_error);
}

TEST_CASE("pulsation: the wall moves by the amplitude, and tissue around it keeps its volume") {
    pulsation artery{.from = {0, 0, 20_mm}, .to = {0, 1, 20_mm}, .radius = 3_mm, .amplitude = 0.4_mm, .rate = 1};
    CHECK(artery({1_mm, 2_mm, 21_mm}) == vec3{1_mm, 2_mm, 21_mm});
    artery.time = 0.13F;
    const float wave = artery.wave();
    const vec3 wall = artery({3_mm, 7_mm, 20_mm});
    MESSAGE("at 0.13 of a beat the wall has moved by ", (wall.x - 3_mm) * 1e3F, " mm, expected ", 0.4F * wave);
    CHECK(std::fabs(wall.x - 3_mm - 0.4_mm * wave) < 1e-8F);
    CHECK(wave > 0.95F);
    CHECK(wave <= 1);
    for (const float away : {4_mm, 8_mm, 20_mm})
        CHECK(std::fabs(body_motion_test::volume_factor(artery, {0.6F * away, 1_mm, 20_mm + 0.8F * away}) - 1) < 1e-3);
    artery.time = 5; // whole beats
    CHECK(artery({2_mm, 0, 21_mm}) == vec3{2_mm, 0, 21_mm});
    float highest = 0;
    for (int i = 0; i < 1000; ++i) {
        artery.time = static_cast<float>(i) / 1000;
        CHECK(artery.wave() >= 0);
        highest = max(highest, artery.wave());
    }
    CHECK(std::fabs(highest - 1) < 0.02F);
}

TEST_CASE("breathing: rests when breathed out, and reaches its amplitude in the middle") {
    breathing chest{.direction = {0, 0, 2}, .amplitude = 12_mm, .rate = 0.25F};
    CHECK(chest({1_mm, 0, 0}) == vec3{1_mm, 0, 0});
    chest.time = 2; // half a period of 4 s
    CHECK(std::fabs(chest({0, 0, 0}).z - 12_mm) < 1e-7F);
    chest.time = 1; // 1 - cos^6(pi / 4) = 7 / 8
    CHECK(std::fabs(chest({0, 0, 0}).z - 12_mm * 0.875F) < 1e-6F);
}

TEST_CASE("needle_drag: tissue at the shaft moves by the drag, and less away from it") {
    const needle_drag drag{.entry = {0, 0, 0}, .tip = {0, 0, 30_mm}, .drag = 1_mm, .extent = 3_mm};
    CHECK(std::fabs(drag({0, 0, 15_mm}).z - 16_mm) < 1e-8F);
    CHECK(std::fabs(drag({3_mm, 0, 15_mm}).z - 15_mm - 1_mm * std::exp(-0.5F)) < 1e-8F);
    CHECK(std::fabs(drag({0, 0, 36_mm}).z - 36_mm - 1_mm * std::exp(-2.0F)) < 1e-8F); // 6 mm beyond the tip
}

TEST_CASE("compose applies maps from the first to the last") {
    const auto doubled = [](vec3 p) { return 2.0F * p; };
    const auto aside = [](vec3 p) { return p + vec3{1, 0, 0}; };
    CHECK(compose(doubled, aside)({1, 2, 3}) == vec3{3, 4, 6});
    CHECK(compose(aside, doubled)({1, 2, 3}) == vec3{4, 4, 6});
    CHECK(compose(aside, doubled, aside)({1, 2, 3}) == vec3{5, 4, 6});
    CHECK_THROWS_AS(compose(aside, breathing{.extent = 0}).check(), usage_error);
}

TEST_CASE("deform checks the settings of ready-made maps") {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 20_mm}, 5_mm, 2), tissue::blood);
    body.build(exec::par);
    CHECK_THROWS_AS(body.deform(exec::par, pulsation{.radius = 0}), usage_error);
    CHECK_THROWS_AS(body.deform(exec::par, needle_drag{.extent = 0}), usage_error);
    const centre_line along_y{{{{0, -5_mm, 20_mm}, vec2{3_mm}}, {{0, 5_mm, 20_mm}, vec2{3_mm}}}};
    for (const vec3 direction : {vec3{0, 1, 0}, vec3{0, 0, 1}}) // the vessel's own axis does not count
        CHECK_NOTHROW(body.deform(exec::par, bent{along_y, collapse{.direction = direction}}));
    CHECK_THROWS_AS(body.deform(exec::par, bent{along_y, collapse{.direction = {0, 0, 0}}}), usage_error);
    CHECK_NOTHROW(body.deform(exec::par, compose(breathing{.time = 1.3F},
                                                 pulsation{.from = {0, 0, 20_mm}, .to = {0, 1, 20_mm}, .time = 1.3F},
                                                 needle_drag{})));
}

TEST_CASE("bent: along a straight line it is the map of the straight vessel, and scales with the section") {
    const vec3 from{0, 0, 20_mm}, to{30_mm, 0, 30_mm};
    pulsation beat{.from = from, .to = to, .radius = 3_mm, .amplitude = 0.3_mm, .time = 0.1F};
    collapse vein{.from = from, .to = to, .direction = {0, 0, 1}, .radius = 3_mm, .outside = 1200};
    const centre_line same{{{from, vec2{3_mm}}, {to, vec2{3_mm}}}}, twice{{{from, vec2{6_mm}}, {to, vec2{6_mm}}}};
    for (std::uint64_t i = 0; i < 300; ++i) {
        const vec3 point =
            vec3{30_mm, 20_mm, 40_mm} * vec3{hash_uniform(1, i), hash_uniform(2, i) - 0.5F, hash_uniform(3, i)};
        CHECK(length(bent{same, beat}(point)-beat(point)) < 0.1_um);
        CHECK(length(bent{same, vein}(point)-vein(point)) < 0.1_um);
        const vec3 axis = normalize(to - from), foot = from + dot(point - from, axis) * axis;
        const vec3 near = foot + 0.5F * (point - foot);
        CHECK(length(bent{twice, beat}(point)-point - 2.0F * (beat(near) - near)) < 0.2_um);
    }
}

TEST_CASE("bent: around a curved, elliptical vessel the maps have their inverse, and the lumen the law's area") {
    std::vector<tube_section> sections;
    for (int i = 0; i <= 12; ++i) {
        const float angle = 0.1F * static_cast<float>(i);
        sections.push_back({.centre = 40_mm * vec3{std::cos(angle), 0, std::sin(angle)}, .radii = {4_mm, 2.5_mm}});
    }
    const centre_line line{sections, {0, 1, 0}};
    const bent beat{line, pulsation{.radius = 3_mm, .amplitude = 0.3_mm, .rate = 1, .time = 0.15F}};
    const bent vein{line, collapse{.direction = {1, 0, 1}, .outside = 1150, .residual = 0.1F}};
    for (std::uint64_t i = 0; i < 300; ++i) {
        const float angle = 1.2F * hash_uniform(1, i);
        const vec3 point = (32_mm + 16_mm * hash_uniform(2, i)) * vec3{std::cos(angle), 0, std::sin(angle)} +
                           vec3{0, 16_mm * (hash_uniform(3, i) - 0.5F), 0};
        CHECK(length(beat.rest_of(beat(point)) - point) < 1_um);
        CHECK(length(vein.rest_of(vein(point)) - point) < 1_um);
    }
    // The outline of the section at 0.6 radians; shoelace formula in doubles.
    const auto area = [&](const auto& map) {
        const vec3 outwards{std::cos(0.6F), 0, std::sin(0.6F)};
        double sum = 0;
        glm::dvec2 last{0, 0};
        for (int i = 0; i <= 720; ++i) {
            const float turn = 2 * pi * static_cast<float>(i) / 720;
            const vec3 p =
                map(40_mm * outwards + 2.499_mm * std::sin(turn) * outwards + vec3{0, 3.999_mm * std::cos(turn), 0});
            const glm::dvec2 now{dot(p, outwards) - 40_mm, p.y};
            if (i > 0) sum += 0.5 * (last.x * now.y - last.y * now.x);
            last = now;
        }
        return std::fabs(sum);
    };
    const double rest = 3.14159265 * 4e-3 * 2.5e-3;
    CHECK(area(beat) == doctest::Approx(rest * 1.21).scale(1e-30).epsilon(0.005)); // (3.3 / 3)^2
    CHECK(area(vein) == doctest::Approx(rest * vein.vessel.opening()).scale(1e-30).epsilon(0.02));
    CHECK_THROWS_AS((bent<pulsation>{}).check(), usage_error);
    CHECK_THROWS_AS((bent{line, pulsation{.radius = -1}}).check(), usage_error);
}
