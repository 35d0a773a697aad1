#include <insonify/bvh/ray_packet.hpp>
#include <insonify/core/random.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <vector>

using namespace insonify;

namespace ray_lanes_test {

using namespace insonify::detail;

namespace {

constexpr int width = simd_width;

float uniform(std::uint64_t seed, std::uint64_t i) { return 2 * hash_uniform(seed, i) - 1; }

// By how much a ray misses a box between its limits, in distance; 0 or less where it enters. Slab test in double.
double miss_of(const ray& r, const aabb& box) {
    double in = r.min_distance, out = r.max_distance;
    for (int axis = 0; axis < 3; ++axis) {
        const double origin = r.origin[axis], direction = r.direction[axis];
        const double lower = box.lower[axis] - origin, upper = box.upper[axis] - origin;
        if (direction == 0) {
            if (lower > 0 || upper < 0) return std::numeric_limits<double>::infinity();
            continue;
        }
        in = std::max(in, std::min(lower / direction, upper / direction));
        out = std::min(out, std::max(lower / direction, upper / direction));
    }
    return in - out;
}

std::uint32_t entering(const std::vector<ray>& rays, const aabb& box) {
    return may_enter(box, 4.0F, ray_lanes<width>{rays.data()});
}

float lane(const lanes<width>& value, std::size_t i) {
    float each[width];
    store(value, each);
    return each[i];
}

} // namespace

TEST_CASE("rays in lanes keep their components") {
    using namespace ray_lanes_test;
    std::vector<ray> rays(width);
    for (std::size_t i = 0; i < width; ++i)
        rays[i] = {.origin = {uniform(1, i), uniform(2, i), uniform(3, i)},
                   .direction = {uniform(4, i), uniform(5, i), uniform(6, i)},
                   .min_distance = uniform(7, i),
                   .max_distance = uniform(8, i)};
    const ray_lanes<width> lanes{rays.data()};
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const ray& one = rays[i];
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(lane(lanes.origin[axis], i) == one.origin[axis]);
            CHECK(lane(lanes.direction[axis], i) == one.direction[axis]);
        }
        CHECK(lane(lanes.min_distance, i) == one.min_distance);
        CHECK(lane(lanes.max_distance, i) == one.max_distance);
    }
}

TEST_CASE("may_enter loses no ray that enters a box, and culls those that clearly miss it") {
    using namespace ray_lanes_test;
    const aabb box{{-1, 2, -0.5F}, {1, 4, 0.5F}};
    int lost = 0, kept = 0, missing = 0, entered = 0;
    for (std::uint64_t group = 0; group < 20'000; ++group) {
        std::vector<ray> rays(width);
        for (std::size_t i = 0; i < width; ++i) {
            const std::uint64_t k = 8 * (group * width + i);
            ray& r = rays[i];
            r.origin = 4.0F * vec3{uniform(9, k), uniform(9, k + 1), uniform(9, k + 2)};
            r.direction = {uniform(9, k + 3), uniform(9, k + 4), uniform(9, k + 5)};
            if (i % 3 == 1) r.direction[static_cast<int>(group % 3)] = 0; // in a coordinate plane, also of a side
            if (group % 5 == 0) r.origin[static_cast<int>(group % 3)] = box.lower[static_cast<int>(group % 3)];
            if (group % 7 == 0) r.max_distance = 2;
            if (group % 11 == 0) r.min_distance = 2;
        }
        const std::uint32_t found = entering(rays, box);
        for (std::size_t i = 0; i < width; ++i) {
            const double miss = miss_of(rays[i], box);
            const bool enters = (found >> i & 1U) != 0;
            entered += miss <= 0;
            missing += miss > 1e-2;
            lost += miss <= 0 && !enters;
            kept += miss > 1e-2 && enters;
        }
    }
    CHECK(lost == 0);
    CHECK(kept * 1000 < missing);
    CHECK(entered > 2000);
    CHECK(missing > 10'000);
}

TEST_CASE("may_enter keeps rays whose slab test would overflow") {
    using namespace ray_lanes_test;
    const aabb box{{-1, -1, 1}, {1, 1, 2}};
    for (const ray& odd : {ray{.origin = {1e30F, 0, 0}}, ray{.direction = {0, 0, 1e-30F}}, ray{.direction = {0, 0, 0}}})
        CHECK(entering(std::vector<ray>(width, odd), box) == (1U << static_cast<unsigned>(width)) - 1);
}

} // namespace ray_lanes_test
