#include <insonify/geometry/ray.hpp>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("a default ray runs along z without limit, and a default hit is a miss") {
    const ray r;
    CHECK(r.direction == vec3{0, 0, 1});
    CHECK(r.min_distance == 0);
    CHECK(r.max_distance == FLT_MAX);
    CHECK(ray{.origin = {1, 2, 3}, .direction = {0, 2, 0}}.at(0.5F) == vec3{1, 3, 3});
    CHECK_FALSE(hit{});
    CHECK(hit{.distance = 3});
}

TEST_CASE("hits at equal distance are ordered by index") {
    CHECK(nearer({1, 5}, {2, 3}));
    CHECK(nearer({1, 3}, {1, 5}));
    CHECK_FALSE(nearer({1, 5}, {1, 5}));
}

TEST_CASE("a ray enters a box where its nearest side is, or at once if it begins inside; through an edge as well") {
    const aabb box{{-1, -1, 2}, {1, 1, 3}};
    CHECK(intersect({.origin = {0, 0, 0}, .direction = {0, 0, 2}}, box).distance == 1);
    CHECK(intersect({.origin = {0, 0, 2.5F}}, box).distance == 0);
    CHECK(intersect({.origin = {1, -1, 0}}, box).distance == 2);
    CHECK(intersect({.origin = {-3, 0, 0}, .direction = {1, 0, 1}}, box).distance == doctest::Approx(2).scale(1e-30));
    CHECK_FALSE(intersect({.origin = {2, 0, 0}}, box));
    CHECK_FALSE(intersect({.origin = {0, 0, 4}}, box));
    CHECK_FALSE(intersect({.max_distance = 1.5F}, box));
    CHECK(bounds(box).lower == box.lower);
}
