#include <insonify/bvh/bvh.hpp>
#include <array>
#include <doctest/doctest.h>
#include <list>

using namespace insonify;

namespace node_concepts_test {

using namespace insonify::detail;

namespace fake {

struct smallest {}; // meets the concept and no more
aabb bounds(const smallest&) { return {{-1, -1, 1}, {1, 1, 1}}; }
hit intersect(const ray& r, const smallest&) { return {.distance = (1 - r.origin.z) / r.direction.z}; }

struct no_bounds {};
hit intersect(const ray&, const no_bounds&) { return {}; }

struct no_intersect {};
aabb bounds(const no_intersect&) { return {}; }

} // namespace fake

static_assert(primitive<fake::smallest> && primitive<triangle>);
static_assert(!primitive<fake::no_bounds> && !primitive<fake::no_intersect> && !primitive<int>);
static_assert(primitive_range<mesh_view> && primitive_range<view<const fake::smallest>>);
static_assert(!primitive_range<std::list<fake::smallest>> && !primitive_range<view<const int>>);
static_assert(std::is_trivially_copyable_v<bvh_view<mesh_view>>, "a device takes it by value");
static_assert(!std::constructible_from<bvh<mesh_view>, exec::parallel_policy, mesh>, "the mesh must outlive the tree");
static_assert(!std::constructible_from<bvh<view<const triangle>>, exec::parallel_policy, std::vector<triangle>>);

TEST_CASE("a tree accepts any primitive, in a vector, an array, a span or a view") {
    const std::vector<fake::smallest> several(20);
    const std::array<fake::smallest, 3> few{};
    std::vector<fake::smallest> writable(5);
    const bvh from_vector{exec::par, several};
    const bvh from_array{exec::seq, few};
    const bvh from_span{exec::unseq, std::span{writable}};
    const bvh from_view{exec::par_unseq, view<const fake::smallest>{several}};
    CHECK(from_vector.closest({}).distance == 1);
    CHECK(from_array.closest({}).primitive == 0);
    std::vector<hit> hits;
    from_span.all({}, hits);
    CHECK(hits.size() == 5);
    from_view.all({}, hits);
    CHECK(hits.size() == 20);
}

TEST_CASE("hits of a primitive outside the ray's limits are discarded") {
    const std::vector<fake::smallest> one(1);
    const bvh tree{exec::seq, one};
    CHECK_FALSE(tree.closest({.min_distance = 1.5F}));
    CHECK_FALSE(tree.closest({.max_distance = 0.5F}));
    CHECK(tree.closest({.min_distance = 1, .max_distance = 1}));
    CHECK_FALSE(tree.any({.origin = {0, 0, 2}}));
}

} // namespace node_concepts_test
