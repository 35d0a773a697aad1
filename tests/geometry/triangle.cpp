#include <insonify/core/random.hpp>
#include <insonify/geometry/triangle.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>

using namespace insonify;

namespace triangle_test {
namespace {

vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

// Moeller & Trumbore 1997, in double; `margin` is the smallest barycentric coordinate.
struct reference_hit {
    double distance, margin;
};
reference_hit reference(const ray& r, const triangle& t) {
    const glm::dvec3 a{t.a}, e1 = glm::dvec3{t.b} - a, e2 = glm::dvec3{t.c} - a, d{r.direction};
    const glm::dvec3 p = glm::cross(d, e2), s = glm::dvec3{r.origin} - a, q = glm::cross(s, e1);
    const double scale = 1 / glm::dot(e1, p), u = glm::dot(s, p) * scale, v = glm::dot(d, q) * scale;
    return {glm::dot(e2, q) * scale, std::min({u, v, 1 - u - v})};
}

} // namespace
} // namespace triangle_test

TEST_CASE("rays intersect random triangles as in double precision") {
    int met = 0;
    for (std::uint64_t i = 0; i < 200'000; ++i) {
        const triangle t{triangle_test::random_point(1, 3 * i), triangle_test::random_point(1, 3 * i + 1),
                         triangle_test::random_point(1, 3 * i + 2)};
        const ray r{.origin = triangle_test::random_point(2, 2 * i),
                    .direction = triangle_test::random_point(2, 2 * i + 1)};
        const triangle_test::reference_hit expected = triangle_test::reference(r, t);
        if (std::fabs(expected.margin) < 1e-5 || std::fabs(dot(area_vector(t), r.direction)) < 1e-3F) continue;
        const hit found = intersect(r, t);
        REQUIRE(static_cast<bool>(found) == (expected.margin > 0));
        if (found) REQUIRE(found.distance == doctest::Approx(expected.distance).scale(0.01).epsilon(1e-4));
        met += found ? 1 : 0;
    }
    CHECK(met > 10'000);
}

TEST_CASE("a ray through a shared edge or vertex belongs to exactly one triangle") {
    // A fan of six triangles around the origin of the plane z = 1; rays along z, tilted, and along other axes.
    const vec3 centre{0, 0, 1};
    const vec3 rim[6] = {{2, 0, 1}, {1, 2, 1}, {-1, 2, 1}, {-2, 0, 1}, {-1, -2, 1}, {1, -2, 1}};
    const vec3 targets[] = {{0, 0, 1},  {1, 0, 1},        {0.5F, 1, 1},   {-0.5F, 1, 1},
                            {-1, 0, 1}, {0.25F, 0.5F, 1}, {-0.5F, -1, 1}, {0.3F, 0.1F, 1}};
    for (const vec3 target : targets)
        for (const vec3 origin : {vec3{target.x, target.y, 0}, vec3{0, 0, 0}, vec3{1, 1, 0}, vec3{-3, 0.5F, 0.5F}})
            for (int turn = 0; turn < 3; ++turn) { // the shear picks another axis each time
                const auto turned = [turn](vec3 p) { return vec3{p[turn], p[(turn + 1) % 3], p[(turn + 2) % 3]}; };
                int crossings = 0;
                for (int i = 0; i < 6; ++i) {
                    const triangle t{turned(centre), turned(rim[i]), turned(rim[(i + 1) % 6])};
                    const triangle flipped{t.c, t.b, t.a};
                    const ray r{.origin = turned(origin), .direction = turned(target - origin)};
                    crossings += intersect(r, t) ? 1 : 0;
                    CHECK(static_cast<bool>(intersect(r, t)) == static_cast<bool>(intersect(r, flipped)));
                }
                CHECK(crossings == 1);
            }
}

TEST_CASE("a triangle without area is never hit") {
    const ray up{.origin = {0, 0, 0}, .direction = {0, 0, 1}};
    CHECK_FALSE(intersect(up, triangle{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}));
    CHECK_FALSE(intersect(up, triangle{{-1, 0, 1}, {0, 0, 1}, {1, 0, 1}}));
    CHECK_FALSE(intersect(up, triangle{{0, 0, 1}, {0, 0, 2}, {1, 0, 1}})); // the ray lies in its plane
}

TEST_CASE("distances are in units of the direction, negative behind the origin") {
    const triangle t{{-1, -1, 4}, {1, -1, 4}, {0, 1, 4}};
    CHECK(intersect(ray{.direction = {0, 0, 1}}, t).distance == 4);
    CHECK(intersect(ray{.direction = {0, 0, 2}}, t).distance == 2);
    CHECK(intersect(ray{.origin = {0, 0, 5}}, t).distance == -1);
}

TEST_CASE("bounds contain the corners, the area vector points outwards") {
    const triangle t{{0, 0, 0}, {2, 0, 0}, {0, 3, 1}};
    CHECK(bounds(t).lower == vec3{0, 0, 0});
    CHECK(bounds(t).upper == vec3{2, 3, 1});
    CHECK(area_vector(triangle{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}}) == vec3{0, 0, 6});
}

TEST_CASE("a ray with a tiny direction hits a triangle whose distance overflows a float") {
    // A quarter of the way from the edge y = -1 to the corner; the distance to that corner, 6e38, overflows.
    const triangle t{{-1, -1, -1}, {1, -1, -1}, {0, 3, -3e38F}};
    CHECK(intersect(ray{.direction = {0, 0, -0.5F}}, t).distance == doctest::Approx(1.5e38).scale(1e-30).epsilon(1e-6));
}
