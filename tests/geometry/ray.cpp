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
