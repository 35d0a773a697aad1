#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include "random_triangles.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <type_traits>
#include <vector>

using namespace insonify;

namespace bvh_test {

using namespace insonify::detail;

TEST_CASE("closest, any and all agree with brute force on 50 random scenes of 10^4 rays each") {
    constexpr std::uint64_t first_seed = 20261121;
    MESSAGE("first seed ", first_seed);
    int wrong = 0;
    for (std::uint64_t scene = 0; scene < 50; ++scene) {
        const auto count = static_cast<std::uint32_t>(1 + hash_bits(first_seed, scene) % 300);
        const float size = 0.02F + 0.8F * hash_uniform(first_seed + 1, scene);
        wrong += bvh_test::disagreements(bvh_test::random_triangles(first_seed + scene, count, size), scene, 10'000);
    }
    CHECK(wrong == 0);
}

TEST_CASE("trees of few primitives agree with brute force") {
    for (const std::uint32_t count : {0U, 1U, 2U, 3U, 4U, 5U, 7U, 8U, 9U, 31U, 32U, 33U, 63U, 64U, 65U}) {
        const mesh m = bvh_test::random_triangles(count, count, 0.7F);
        CHECK(bvh_test::disagreements(m, 5, 500) == 0);
        CHECK(bvh{exec::seq, m}.statistics().primitives == count);
    }
}

TEST_CASE_TEMPLATE("trees of any width find the same, whatever the registers hold", Width,
                   std::integral_constant<int, 4>, std::integral_constant<int, 8>) {
    const mesh m = bvh_test::random_triangles(3, 500, 0.2F);
    const bvh usual{exec::seq, m};
    const bvh<mesh_view, Width::value> tree{exec::seq, m};
    std::vector<ray> rays;
    for (std::uint64_t i = 0; i < 1000; ++i)
        rays.push_back({vec3{hash_uniform(1, i), hash_uniform(2, i), -3}, vec3{0.01F * hash_normal(3, i), 1}});
    std::vector<hit> hits(rays.size());
    tree.closest(exec::unseq, rays, hits);
    std::size_t wrong = 0, met = 0, of_all = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const hit expected = usual.closest(rays[i]);
        met += expected ? 1 : 0;
        wrong += tree.closest(rays[i]).distance != expected.distance || hits[i].distance != expected.distance;
        wrong += tree.any(rays[i]) != usual.any(rays[i]);
        std::vector<hit> of_tree, of_usual;
        tree.all(rays[i], of_tree);
        usual.all(rays[i], of_usual);
        wrong += of_tree != of_usual;
        of_all += of_tree.size();
    }
    CHECK(of_all > met);
    CHECK(wrong == 0);
    CHECK(met > 100);
}

TEST_CASE("an empty tree is valid and never hit") {
    const mesh nothing;
    bvh tree{exec::par, nothing};
    CHECK_FALSE(tree.closest({}));
    CHECK_FALSE(tree.any({}));
    CHECK(tree.box().empty());
    tree.refit(exec::par);
    tree.rebuild(exec::par);
    CHECK(tree.degradation() == 1);
    std::vector<std::uint32_t> met{1, 2};
    tree.overlapping(aabb{{-1, -1, -1}, {1, 1, 1}}, met);
    CHECK(met.empty());
}

TEST_CASE("the tree does not depend on the policy") {
    const mesh m = make_sphere({0, 0, 0}, 1, 6);
    const bvh one{exec::seq, m}, many{exec::par.threads(3), m};
    const auto leaves = one.view_of().leaves, same = many.view_of().leaves;
    REQUIRE(leaves.size() == same.size());
    CHECK(std::equal(leaves.begin(), leaves.end(), same.begin(), [](const auto& a, const auto& b) {
        return std::equal(std::begin(a.primitive), std::end(a.primitive), std::begin(b.primitive));
    }));
    CHECK(one.statistics().cost == many.statistics().cost);
}

TEST_CASE("refitting equals rebuilding over 200 random deformations") {
    mesh moving = make_sphere({0, 0, 0}, 0.7F, 3);
    const mesh rest = moving;
    bvh followed{exec::par, moving};
    int wrong = 0;
    for (std::uint64_t frame = 0; frame < 200; ++frame) {
        for (std::size_t i = 0; i < rest.positions.size(); ++i)
            moving.positions[i] =
                rest.positions[i] + (frame % 2 == 0 ? 0.02F : 0.4F) * bvh_test::random_point(frame, i);
        followed.refit(exec::par);
        const bvh anew{exec::par, moving};
        for (std::uint64_t i = 0; i < 200; ++i) {
            const ray r = bvh_test::random_ray(frame, i);
            std::vector<hit> a, b;
            followed.all(r, a);
            anew.all(r, b);
            if (!bvh_test::same(a, b) || followed.any(r) != anew.any(r) ||
                followed.closest(r).primitive != anew.closest(r).primitive)
                ++wrong;
        }
    }
    CHECK(wrong == 0);
    CHECK(followed.degradation() > 1);
    followed.rebuild(exec::par);
    CHECK(followed.degradation() == 1);
}

TEST_CASE("refit throws for another number of primitives") {
    std::vector<vec3> positions{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    mesh m{.positions = positions, .faces = {{0, 1, 2}}};
    bvh_storage<mesh_view> storage;
    storage.build(exec::seq, mesh_view{m});
    m.faces.push_back({0, 1, 2});
    CHECK_THROWS_AS(storage.refit(exec::seq, mesh_view{m}), geometry_error);
}

TEST_CASE("batches return the hits of single queries, with any policy") {
    const mesh m = bvh_test::random_triangles(1, 400, 0.3F);
    const bvh tree{exec::par, m};
    std::vector<ray> rays;
    for (std::uint64_t i = 0; i < 3000; ++i) rays.push_back(bvh_test::random_ray(2, i));
    std::vector<hit> hits(rays.size());
    std::vector<std::uint8_t> met(rays.size());
    tree.closest(exec::par_unseq, rays, hits);
    tree.any(exec::par.threads(3), rays, met);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        REQUIRE(hits[i] == tree.closest(rays[i]));
        REQUIRE((met[i] == 1) == tree.any(rays[i]));
    }
    hits.pop_back();
    CHECK_THROWS_AS(tree.closest(exec::seq, rays, hits), usage_error);
}

TEST_CASE("overlapping finds the primitives whose bounds overlap a box") {
    const mesh m = bvh_test::random_triangles(3, 500, 0.2F);
    const bvh tree{exec::par, m};
    std::vector<std::uint32_t> found;
    for (std::uint64_t i = 0; i < 200; ++i) {
        const vec3 corner = bvh_test::random_point(4, i);
        const aabb box{corner, corner + abs(bvh_test::random_point(5, i))};
        std::vector<std::uint32_t> in_box;
        for (std::uint32_t p = 0; p < m.faces.size(); ++p)
            if (overlaps(box, bounds(mesh_view{m}[p]))) in_box.push_back(p);
        tree.overlapping(box, found);
        REQUIRE(found == in_box);
    }
}

TEST_CASE("a mesh whose faces refer to no vertex is rejected") {
    mesh m = make_sphere({0, 0, 0}, 1, 1);
    bvh tree{exec::par, m};
    m.faces[3].y = 1000;
    CHECK_THROWS_AS((bvh{exec::par, m}), geometry_error);
    CHECK_THROWS_AS(tree.rebuild(exec::par), geometry_error);
}

} // namespace bvh_test
