#include <insonify/bvh/storage.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/shapes.hpp>
#include <algorithm>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

namespace storage_test {

using namespace insonify::detail;

namespace {

void shake(mesh& m, const mesh& rest, float by, std::uint64_t seed) {
    for (std::size_t i = 0; i < rest.positions.size(); ++i)
        m.positions[i] = rest.positions[i] + by * (vec3{hash_uniform(seed, 3 * i), hash_uniform(seed, 3 * i + 1),
                                                        hash_uniform(seed, 3 * i + 2)} -
                                                   vec3{0.5F});
}

bool all_inside_are_hit(const bvh_view<mesh_view>& tree) {
    for (std::uint64_t i = 0; i < 300; ++i)
        if (!tree.any(
                {.direction = vec3{hash_uniform(1, 3 * i), hash_uniform(1, 3 * i + 1), hash_uniform(1, 3 * i + 2)} -
                              vec3{0.5F}}))
            return false;
    return true;
}

} // namespace

TEST_CASE("update refits small motion, and rebuilds a degraded tree") {
    const mesh rest = make_sphere({0, 0, 0}, 1, 4);
    mesh moving = rest;
    bvh_storage<mesh_view> tree;
    tree.build(exec::par, mesh_view{moving});
    for (std::uint64_t frame = 0; frame < 20; ++frame) { // small motion: always refits
        storage_test::shake(moving, rest, 0.005F, frame);
        CHECK(tree.update(exec::par, mesh_view{moving}) == bvh_update::refit);
        CHECK(storage_test::all_inside_are_hit(tree.view_of(mesh_view{moving})));
    }
    std::reverse(moving.faces.begin(), moving.faces.end()); // every leaf now holds faces of somewhere else
    std::rotate(moving.faces.begin(), moving.faces.begin() + 1234, moving.faces.end());
    for (std::size_t i = 1; i < moving.faces.size(); i += 2) // from all over the sphere
        std::swap(moving.faces[i], moving.faces[hash_bits(3, i) % moving.faces.size()]);
    CHECK(tree.update(exec::par, mesh_view{moving}) == bvh_update::rebuild); // it lasted 20 frames
    CHECK(tree.degradation() == 1);
    for (std::size_t i = 1; i < moving.faces.size(); i += 2)
        std::swap(moving.faces[i], moving.faces[hash_bits(4, i) % moving.faces.size()]);
    CHECK(tree.update(exec::par, mesh_view{moving}) == bvh_update::quick_rebuild); // and this one
    CHECK(tree.degradation() == 1);
    CHECK(storage_test::all_inside_are_hit(tree.view_of(mesh_view{moving})));
}

TEST_CASE("a tree that was built when no primitive was finite is rebuilt once they are") {
    const mesh rest = make_sphere({0, 0, 0}, 1, 4);
    mesh m = rest;
    for (vec3& p : m.positions) p.x = std::numeric_limits<float>::quiet_NaN();
    bvh_storage<mesh_view, simd_width, build_sah> tree;
    tree.build(exec::seq, mesh_view{m});
    CHECK(tree.degradation() == 1);
    m = rest;
    CHECK(tree.update(exec::seq, mesh_view{m}) == bvh_update::quick_rebuild);
    CHECK(storage_test::all_inside_are_hit(tree.view_of(mesh_view{m})));
    CHECK(tree.update(exec::seq, mesh_view{m}) == bvh_update::refit);
}

TEST_CASE("update throws for another number of primitives") {
    mesh m = make_sphere({0, 0, 0}, 1, 1);
    bvh_storage<mesh_view> tree;
    tree.build(exec::seq, mesh_view{m});
    m.faces.pop_back();
    CHECK_THROWS_AS(tree.update(exec::seq, mesh_view{m}), geometry_error);
}

TEST_CASE("a tree takes less than 80 bytes per triangle") {
    const mesh m = make_sphere({0, 0, 0}, 1, 6);
    bvh_storage<mesh_view> tree;
    tree.build(exec::par, mesh_view{m});
    CHECK(tree.statistics().bytes < 80 * m.faces.size());
}

TEST_CASE("trees and costs are bit-equal for any number of threads, after builds, rebuilds and refits") {
    const mesh rest = make_sphere({0, 0, 0}, 1, 7); // 327,680: large groups are cut in blocks
    mesh moving = rest;
    bvh_storage<mesh_view> one, three;
    one.build(exec::seq, mesh_view{moving});
    three.build(exec::par.threads(3), mesh_view{moving});
    const auto same = [&] {
        const auto a = one.view_of(mesh_view{moving}), b = three.view_of(mesh_view{moving});
        if (a.nodes.size() != b.nodes.size() || a.leaves.size() != b.leaves.size()) return false;
        for (std::size_t i = 0; i < a.nodes.size(); ++i)
            if (!std::equal(a.nodes[i].child, a.nodes[i].child + simd_width, b.nodes[i].child) ||
                !std::equal(a.nodes[i].sides, a.nodes[i].sides + 6 * simd_width, b.nodes[i].sides))
                return false;
        return std::equal(a.leaves.begin(), a.leaves.end(), b.leaves.begin(),
                          [](const auto& x, const auto& y) {
                              return std::equal(std::begin(x.primitive), std::end(x.primitive),
                                                std::begin(y.primitive));
                          }) &&
               one.statistics().cost == three.statistics().cost;
    };
    CHECK(same());
    storage_test::shake(moving, rest, 0.01F, 1);
    one.refit(exec::seq, mesh_view{moving});
    three.refit(exec::par.threads(3), mesh_view{moving});
    CHECK(same());
    std::reverse(moving.faces.begin(), moving.faces.end());
    for (std::size_t i = 1; i < moving.faces.size(); i += 2)
        std::swap(moving.faces[i], moving.faces[hash_bits(3, i) % moving.faces.size()]);
    CHECK(one.update(exec::seq, mesh_view{moving}) == three.update(exec::par.threads(3), mesh_view{moving}));
    CHECK(same());
}

} // namespace storage_test
