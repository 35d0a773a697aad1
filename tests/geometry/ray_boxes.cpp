#include <insonify/geometry/ray.hpp>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

TEST_CASE("an empty box contains nothing, overlaps nothing and leaves a merged box unchanged") {
    const aabb empty, unit{{0, 0, 0}, {1, 1, 1}};
    CHECK(empty.empty());
    CHECK(empty.half_area() == 0);
    CHECK_FALSE(empty.contains({0, 0, 0}));
    CHECK_FALSE(overlaps(empty, unit));
    CHECK_FALSE(is_finite(empty));
    CHECK(merged(empty, unit).lower == unit.lower);
    CHECK(merged(empty, unit).upper == unit.upper);
}

TEST_CASE("boxes include their sides") {
    const aabb unit{{0, 0, 0}, {1, 1, 1}};
    CHECK(unit.contains({1, 0, 0.5F}));
    CHECK_FALSE(unit.contains({1.001F, 0, 0}));
    CHECK(overlaps(unit, aabb{{1, 1, 1}, {2, 2, 2}}));
    CHECK_FALSE(overlaps(unit, aabb{{1.001F, 0, 0}, {2, 1, 1}}));
    CHECK(unit.half_area() == 3);
    CHECK(unit.centre() == vec3{0.5F, 0.5F, 0.5F});
    CHECK(merged(unit, vec3{2, -1, 0}).size() == vec3{2, 2, 1});
}

TEST_CASE("a box with NaN or infinity is not finite") {
    const float wild[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
    for (const float w : wild) {
        CHECK_FALSE(is_finite(aabb{{0, w, 0}, {1, 1, 1}}));
        CHECK_FALSE(is_finite(aabb{{0, 0, 0}, {1, 1, w}}));
    }
}
