#include <insonify/acoustics/tissue.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/read/label.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace numbers_test {
namespace {

float uniform(std::uint64_t seed, std::uint64_t index) { return 2 * hash_uniform(seed, index) - 1; }

vec3 point_in_cube(std::uint64_t seed, std::uint64_t index) {
    return {uniform(seed, 3 * index), uniform(seed, 3 * index + 1), uniform(seed, 3 * index + 2)};
}

/// From a sphere of radius 3 through one of radius 1, around `centre`.
ray random_ray(std::uint64_t index, float scale, vec3 centre) {
    const vec3 from = 3.0F * normalize(point_in_cube(1, index)), towards = point_in_cube(2, index);
    return {.origin = centre + scale * from, .direction = normalize(towards - from)};
}

/// Whether crossings of a closed surface go in and out by turns, for a ray from outside.
bool alternates(const mesh& m, const ray& r, const std::vector<hit>& hits) {
    bool inside = false;
    for (const hit& found : hits) {
        const bool goes_in = dot(area_vector(mesh_view{m}[found.primitive]), r.direction) < 0;
        if (goes_in == inside) return false;
        inside = goes_in;
    }
    return !inside;
}

} // namespace

TEST_CASE("coordinates scaled by a power of two give the same primitives") {
    const mesh unit = make_sphere({0.2F, -0.1F, 0.3F}, 1, 4);
    const bvh tree{exec::seq, unit};
    std::vector<hit> expected, hits;
    std::size_t different = 0, found = 0;
    for (int k = -20; k <= 20; ++k) {
        const float scale = std::ldexp(1.0F, k);
        mesh scaled = unit;
        for (vec3& p : scaled.positions) p *= scale;
        const bvh other{exec::seq, scaled};
        for (std::uint64_t i = 0; i < 200; ++i) {
            ray one = random_ray(i, 1, {0, 0, 0});
            tree.all(one, expected);
            one.origin *= scale; // not drawn anew, lest it be rounded otherwise there
            other.all(one, hits);
            found += hits.size();
            different += hits.size() != expected.size();
            for (std::size_t h = 0; h < std::min(hits.size(), expected.size()); ++h)
                different +=
                    hits[h].primitive != expected[h].primitive || hits[h].distance != scale * expected[h].distance;
        }
    }
    CHECK(different == 0);
    CHECK(found > 41 * 100);
}

TEST_CASE("far from the origin, 30 m and 1 km, surfaces stay closed to rays and to slices") {
    for (const float offset : {30.0F, 1000.0F}) {
        const vec3 centre{offset, -offset, 0.5F * offset};
        const mesh ball = make_sphere(centre, 20_mm, 4);
        const bvh tree{exec::seq, ball};
        std::vector<hit> hits;
        std::size_t leaks = 0, met = 0;
        for (std::uint64_t i = 0; i < 20'000; ++i) {
            ray r = random_ray(i, 20_mm, centre);
            if (i % 4 == 0) r.direction = normalize(ball.positions[i % ball.positions.size()] - r.origin); // a vertex
            tree.all(r, hits);
            met += hits.empty() ? 0 : 1;
            leaks += hits.size() % 2;
        }
        CHECK(leaks == 0);
        CHECK(met > 10'000);

        scene body{tissue::muscle};
        body.add(ball, tissue::bone);
        body.build(exec::seq); // cut into slices
        const pose at{.translation = centre - vec3{0, 0, 30_mm}};
        const label_lines seen =
            label(exec::seq, body, linear_array{.lines = 64, .width = 30_mm}, at, {.depth = 60_mm, .samples = 600});
        for (std::uint32_t line = 0; line < seen.count; ++line) {
            INFO(offset << " " << line);
            CHECK(seen(line, 0) == background_label);
            CHECK(seen(line, 300) == 0); // its middle
            CHECK(seen(line, 599) == background_label);
        }
    }
}

TEST_CASE("crossings alternate between in and out") {
    const mesh ball = make_sphere({0, 0, 0}, 1, 4);
    const bvh tree{exec::seq, ball};
    std::vector<hit> hits;
    std::size_t wrong = 0;
    for (std::uint64_t i = 0; i < 20'000; ++i) {
        const ray r = random_ray(i, 1, {0, 0, 0});
        tree.all(r, hits);
        wrong += alternates(ball, r, hits) ? 0 : 1;
    }
    CHECK(wrong == 0);
}

TEST_CASE("a NaN vertex among 100,000 changes no other hit") {
    mesh ball = make_sphere({0, 0, 0}, 1, 7); // 163,842 vertices
    const bvh whole{exec::seq, ball};
    std::vector<std::vector<hit>> before(4000);
    for (std::size_t i = 0; i < before.size(); ++i) whole.all(random_ray(i, 1, {0, 0, 0}), before[i]);
    const std::uint32_t victim = ball.faces[before[0].at(0).primitive].x;
    ball.positions[victim].y = std::nanf("");
    const auto is_lost = [&](const hit& found) {
        const uvec3 face = ball.faces[found.primitive];
        return face.x == victim || face.y == victim || face.z == victim;
    };
    bvh torn{exec::seq, ball}, moved = whole; // built with it, and refitted to it
    moved.refit(exec::seq);
    std::vector<hit> hits;
    std::size_t different = 0, lost = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        std::vector<hit> expected = before[i];
        lost += std::erase_if(expected, is_lost);
        for (const bvh<mesh_view>* tree : {&torn, &moved}) {
            tree->all(random_ray(i, 1, {0, 0, 0}), hits);
            different += hits == expected ? 0 : 1;
        }
    }
    CHECK(different == 0);
    CHECK(lost >= 1);
}

TEST_CASE("a NaN ray is a miss, and costs no more than 2.5 normal ones") {
    const mesh ball = make_sphere({0, 0, 0}, 1, 6);
    const bvh tree{exec::seq, ball};
    std::vector<ray> normal(20'000), bad;
    for (std::size_t i = 0; i < normal.size(); ++i) normal[i] = random_ray(i, 1, {0, 0, 0});
    bad = normal;
    for (std::size_t i = 0; i < bad.size(); ++i)
        (i % 2 == 0 ? bad[i].origin : bad[i].direction)[static_cast<int>(i % 3)] = std::nanf("");
    std::vector<hit> hits(normal.size());
    const auto seconds = [&](const std::vector<ray>& rays) {
        double best = 1e9;
        for (int round = 0; round < 5; ++round) {
            const auto begin = std::chrono::steady_clock::now();
            for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = tree.closest(rays[i]);
            best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        }
        return best;
    };
    const double usual = seconds(normal), with_nan = seconds(bad);
    CHECK(std::none_of(hits.begin(), hits.end(), [](const hit& found) { return static_cast<bool>(found); }));
    MESSAGE("a NaN ray takes " << with_nan / usual << " times as long as a normal one");
    tree.closest(exec::seq, bad, hits);
    CHECK(std::none_of(hits.begin(), hits.end(), [](const hit& found) { return static_cast<bool>(found); }));
}

TEST_CASE("what is not finite is told by its bits, whatever the compiler assumes") {
    const auto number = [](std::uint32_t bits) { return __builtin_bit_cast(float, bits); };
    for (const std::uint32_t bits : {0x7F800000U, 0xFF800000U, 0x7FC00000U, 0xFFC00000U, 0x7F800001U, 0xFFFFFFFFU})
        CHECK_FALSE(is_finite(number(bits)));
    for (const std::uint32_t bits : {0U, 0x80000000U, 1U, 0x7F7FFFFFU, 0xFF7FFFFFU}) CHECK(is_finite(number(bits)));
    scene body{tissue::water};
    mesh ball = make_sphere({0, 0, 0}, 1, 1);
    ball.positions[3].z = number(0x7FC00000U);
    CHECK_THROWS_AS(body.add(ball, tissue::bone), geometry_error);
    CHECK_THROWS_AS(body.add(make_sphere({0, 0, 0}, 1, 1), {.density = number(0x7F800000U)}), usage_error);
    CHECK_THROWS_AS(look_at({number(0x7FC00000U), 0, 0}, {0, 0, 1}, {1, 0, 0}), geometry_error);
    CHECK_THROWS_AS(linear_array{.width = number(0x7FC00000U)}.check(), usage_error);
}

} // namespace numbers_test
