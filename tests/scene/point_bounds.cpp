#include <insonify/core/random.hpp>
#include <insonify/scene/point_bounds.hpp>
#include <doctest/doctest.h>
#include <limits>
#include <vector>

using namespace insonify;
using detail::bounds_of;

TEST_CASE("the box around points is that of their smallest and greatest coordinates, of any number of points") {
    std::vector<vec3> points;
    CHECK(bounds_of(points).empty());
    aabb expected;
    for (std::uint64_t i = 0; i < 100; ++i) {
        points.push_back({hash_uniform(3, 3 * i) - 0.5F, 10 * hash_uniform(3, 3 * i + 1), -hash_uniform(3, 3 * i + 2)});
        for (int axis = 0; axis < 3; ++axis) {
            expected.lower[axis] = std::min(expected.lower[axis], points.back()[axis]);
            expected.upper[axis] = std::max(expected.upper[axis], points.back()[axis]);
        }
        REQUIRE(bounds_of(points).lower == expected.lower);
        REQUIRE(bounds_of(points).upper == expected.upper);
    }
}

TEST_CASE("points that are not finite are left out of the box") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    for (std::size_t broken = 0; broken < 20; ++broken)
        for (const float value : {nan, infinity, -infinity}) {
            std::vector<vec3> points(20, vec3{1, 2, 3});
            points[(broken + 1) % 20] = {4, 5, 6};
            points[broken] = {value, value, value};
            CHECK(bounds_of(points).lower == vec3{1, 2, 3});
            CHECK(bounds_of(points).upper == vec3{4, 5, 6});
        }
    const std::vector<vec3> none(9, vec3{nan, nan, nan});
    CHECK(bounds_of(none).empty());
}
