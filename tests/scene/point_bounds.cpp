#include <insonify/core/random.hpp>
#include <insonify/scene/scene_state.hpp>
#include <doctest/doctest.h>
#include <limits>
#include <vector>

using namespace insonify;
using detail::bounds_of;
using detail::point_bounds;

TEST_CASE("the box around points is that of their smallest and greatest coordinates, of any number of points") {
    std::vector<vec3> points;
    CHECK(bounds_of(points, nullptr).box.empty());
    aabb expected;
    for (std::uint64_t i = 0; i < 100; ++i) {
        points.push_back({hash_uniform(3, 3 * i) - 0.5F, 10 * hash_uniform(3, 3 * i + 1), -hash_uniform(3, 3 * i + 2)});
        for (int axis = 0; axis < 3; ++axis) {
            expected.lower[axis] = std::min(expected.lower[axis], points.back()[axis]);
            expected.upper[axis] = std::max(expected.upper[axis], points.back()[axis]);
        }
        std::vector<vec3> copy(points.size() + 1, vec3{7, 8, 9});
        for (vec3* const to : {static_cast<vec3*>(nullptr), copy.data()}) {
            const point_bounds found = bounds_of(points, to);
            REQUIRE(found.box.lower == expected.lower);
            REQUIRE(found.box.upper == expected.upper);
            REQUIRE(found.finite);
        }
        REQUIRE(copy.back() == vec3{7, 8, 9}); // nothing is written beyond the end
        copy.pop_back();
        REQUIRE(copy == points);
    }
}

TEST_CASE("a single coordinate that is not finite is found, wherever it is") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    for (std::size_t broken = 0; broken < 27; ++broken)
        for (int axis = 0; axis < 3; ++axis)
            for (const float value : {nan, -nan, infinity, -infinity}) {
                std::vector<vec3> points(27, vec3{-FLT_MAX, 0, FLT_MAX});
                CHECK(bounds_of(points, nullptr).finite);
                points[broken][axis] = value;
                CHECK_FALSE(bounds_of(points, nullptr).finite);
            }
}
