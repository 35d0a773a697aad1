#include <insonify/bvh/traverse.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace traversal_stack_test {

using namespace insonify::detail;

namespace {

constexpr int width = simd_width;

tree_node<width> node_of(std::uint32_t first_child) {
    tree_node<width> node;
    for (std::uint32_t i = 0; i < width; ++i) node.child[i] = first_child + i;
    return node;
}

// Children that are missed are at FLT_MAX.
lanes<width> lanes_of(const float (&distances)[width], std::uint32_t met) {
    return each_lane<width>(
        [&](int i) { return (met >> static_cast<unsigned>(i) & 1U) != 0 ? distances[i] : FLT_MAX; });
}

// A node at the root, and one below the child that is visited first. @return all references in the order of visits
std::vector<std::uint32_t> visits(const float (&distances)[width], std::uint32_t met, std::uint32_t met_below,
                                  float limit) {
    nearest_first<width> stack;
    stack.start();
    std::vector<std::uint32_t> seen;
    stack.descend(node_of(100), lanes_of(distances, met), met);
    seen.push_back(stack.next);
    if (met_below != 0) {
        stack.descend(node_of(200), lanes_of(distances, met_below), met_below);
        seen.push_back(stack.next);
    }
    while (stack.pop(limit)) seen.push_back(stack.next);
    return seen;
}

} // namespace

TEST_CASE("traversal visits every child that is hit, and the nearest one first") {
    using namespace traversal_stack_test;
    float distances[width];
    for (int i = 0; i < width; ++i) distances[i] = 1 + std::fmod(0.618F * static_cast<float>(i), 1.0F);
    distances[2] = -1; // behind the origin
    const std::uint32_t all = (1U << static_cast<unsigned>(width)) - 1;
    for (std::uint32_t met = 1; met <= all; ++met)
        for (const std::uint32_t met_below : {0U, 1U, all, met}) {
            std::vector<std::uint32_t> expected;
            std::uint32_t nearest = 0;
            for (std::uint32_t i = 0; i < width; ++i) {
                if ((met >> i & 1U) != 0) {
                    expected.push_back(100 + i);
                    if (nearest == 0 || distances[i] < distances[nearest - 100]) nearest = 100 + i;
                }
                if ((met_below >> i & 1U) != 0) expected.push_back(200 + i);
            }
            std::vector<std::uint32_t> by_distance = visits(distances, met, met_below, 10);
            REQUIRE(by_distance[0] == nearest);
            REQUIRE(std::is_permutation(by_distance.begin(), by_distance.end(), expected.begin(), expected.end()));
        }
}

TEST_CASE("pop skips references that begin beyond the limit") {
    using namespace traversal_stack_test;
    float distances[width];
    for (int i = 0; i < width; ++i) distances[i] = static_cast<float>(i);
    const std::uint32_t all = (1U << static_cast<unsigned>(width)) - 1;
    std::vector<std::uint32_t> seen = visits(distances, all, 0, 2);
    std::sort(seen.begin(), seen.end());
    CHECK(seen == std::vector<std::uint32_t>{100, 101, 102}); // a reference at the limit is not beyond it
}

TEST_CASE("the stack has room for the deepest tree with full nodes") {
    using namespace traversal_stack_test;
    const std::uint32_t all = (1U << static_cast<unsigned>(width)) - 1;
    nearest_first<width> stack;
    stack.start();
    for (std::uint32_t level = 1; level <= max_levels<width>; ++level) {
        CHECK(stack.size + width <= max_stack<width>); // detail::pack_lanes writes a whole register
        stack.descend(node_of(100 * level), lanes<width>(0.0F), all);
    }
    std::uint32_t back = 0;
    while (stack.pop(1)) ++back;
    CHECK(back == (width - 1) * max_levels<width>);
}

} // namespace traversal_stack_test
