#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

namespace prepared_ray_test {

using namespace insonify::detail;

namespace {

mesh scaled(const mesh& m, int exponent) {
    mesh result = m;
    for (vec3& p : result.positions)
        for (int axis = 0; axis < 3; ++axis) p[axis] = std::ldexp(p[axis], exponent);
    return result;
}

ray scaled(const ray& r, int exponent) {
    ray result = r;
    for (int axis = 0; axis < 3; ++axis) result.origin[axis] = std::ldexp(r.origin[axis], exponent);
    return result;
}

// Coherent rows of rays that diverge in front of the mesh.
std::vector<ray> rows(std::size_t count) {
    std::vector<ray> rays;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t row = i / simd_width;
        rays.push_back({.origin = {0.2F * hash_uniform(1, row), 0.2F * hash_uniform(2, row), -1},
                        .direction = {hash_uniform(3, row) - 0.5F + 0.002F * static_cast<float>(i % simd_width),
                                      hash_uniform(4, row) - 0.5F, 1}});
    }
    return rays;
}

std::vector<std::uint32_t> sorted_primitives(const std::vector<hit>& hits) {
    std::vector<std::uint32_t> primitives;
    for (const hit& h : hits) primitives.push_back(h.primitive);
    std::sort(primitives.begin(), primitives.end());
    return primitives;
}

} // namespace

TEST_CASE("a mesh scaled by 2^-60 to 2^60 is hit in the same triangles, by single rays and by packets") {
    mesh ball = make_sphere({0, 0, 0}, 0.1F, 3);
    for (std::size_t i = 0; i < ball.positions.size(); ++i) ball.positions[i] *= 1 + 0.05F * hash_uniform(9, i);
    const std::vector<ray> rays = prepared_ray_test::rows(4000);
    std::vector<std::vector<std::uint32_t>> expected;
    std::size_t met = 0;
    for (const ray& r : rays) { // brute force in double precision
        std::vector<hit> hits;
        for (std::uint32_t p = 0; p < ball.faces.size(); ++p)
            if (hit found = intersect(r, mesh_view{ball}[p])) {
                found.primitive = p;
                hits.push_back(found);
            }
        expected.push_back(prepared_ray_test::sorted_primitives(hits));
        met += hits.size();
    }
    REQUIRE(met > 100);
    for (int exponent = -60; exponent <= 60; exponent += 20) {
        CAPTURE(exponent);
        const mesh other = prepared_ray_test::scaled(ball, exponent);
        const bvh tree{exec::par, other};
        std::vector<ray> moved;
        for (const ray& r : rays) moved.push_back(prepared_ray_test::scaled(r, exponent));
        std::vector<std::vector<hit>> together(rays.size());
        tree.all(exec::par, moved, together);
        std::vector<hit> hits;
        int wrong = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            tree.all(moved[i], hits);
            wrong += prepared_ray_test::sorted_primitives(hits) != expected[i] ||
                     prepared_ray_test::sorted_primitives(together[i]) != expected[i];
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("a ray is valid if it can hit anything, and enters a box through the nearer side") {
    const float inf = std::numeric_limits<float>::infinity();
    const float numbers[] = {NAN, -inf, inf, 0.0F, -0.0F, 1e-40F, -1e-40F, 1e-29F, -1e-29F, 1, -1, FLT_MAX, -FLT_MAX};
    using node = tree_node<simd_width>;
    std::size_t wrong = 0;
    for (const float x : numbers)
        for (const float y : numbers)
            for (const float z : numbers)
                for (const float place : {0.0F, NAN, inf})
                    for (const float limit : {inf, NAN}) {
                        const vec3 along{x, y, z};
                        prepared_ray<simd_width> prepared;
                        prepared.prepare({.origin = {1, place, 1}, .direction = along, .max_distance = limit}, 1);
                        const bool valid = is_finite(along) && is_finite(vec3{place}) && is_number(limit);
                        const vec3 size = abs(along);
                        wrong += prepared.valid != (valid && (size.x > 1e-30F || size.y > 1e-30F || size.z > 1e-30F));
                        if (!prepared.valid) continue;
                        for (std::uint32_t axis = 0; axis < 3; ++axis) {
                            const std::uint32_t backwards = along[static_cast<int>(axis)] < -1e-30F;
                            wrong += prepared.entry_row[axis] != node::row(backwards, axis) ||
                                     prepared.exit_row[axis] != node::row(1 - backwards, axis);
                        }
                    }
    CHECK(wrong == 0);
}

TEST_CASE("a ray enters the boxes within its limits, and misses the others at FLT_MAX") {
    tree_node<simd_width> node{};
    for (int i = 0; i < simd_width; ++i) { // one behind the other, every second one to the side
        const vec3 place{i % 2 == 0 ? 0.0F : 10.0F, 0, static_cast<float>(i)};
        node.set_box(i, {place - vec3{1, 1, 0}, place + vec3{1, 1, 0.5F}});
    }
    prepared_ray<simd_width> r;
    r.prepare({.origin = {0.2F, 0.1F, -1}, .min_distance = 1.2F, .max_distance = 3.5F}, 20);
    lanes<simd_width> entry(0.0F);
    CHECK(enter(node, r, r.source.max_distance, entry) == 0b101U);
    float distance[simd_width];
    store(entry, distance);
    for (int i = 0; i < simd_width; ++i)
        CHECK(distance[i] == (i == 0   ? 1.2F
                              : i == 2 ? doctest::Approx(3).scale(1e-30).epsilon(1e-5)
                                       : doctest::Approx(FLT_MAX).scale(1e-30)));
}

TEST_CASE("hits at distances that overflow are misses, with any limit") {
    mesh sphere = make_sphere({0, 0, 0}, 1, 2);
    for (vec3& p : sphere.positions) p *= 1e11F; // 1e40 steps away
    const bvh tree{exec::seq, sphere};
    std::vector<ray> rays;
    for (std::uint64_t i = 0; i < 512; ++i) {
        const vec3 along{hash_uniform(13, 2 * i) - 0.5F, hash_uniform(13, 2 * i + 1) - 0.5F, 1};
        rays.push_back({.direction = 1e-29F * along, .max_distance = std::numeric_limits<float>::infinity()});
    }
    std::vector<hit> hits(rays.size());
    std::vector<std::uint8_t> met(rays.size());
    tree.closest(exec::seq, rays, hits);
    tree.any(exec::seq, rays, met);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        REQUIRE_FALSE((hits[i] || met[i] != 0));
        REQUIRE_FALSE((tree.closest(rays[i]) || tree.any(rays[i])));
    }
}

TEST_CASE("a ray that contains a NaN misses and does not change hits of its neighbours") {
    const mesh ball = make_sphere({0, 0, 0}, 0.4F, 4);
    const bvh tree{exec::par, ball};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<ray> rays = prepared_ray_test::rows(800);
    std::vector<hit> expected(rays.size()), hits(rays.size());
    tree.closest(exec::seq, rays, expected);
    for (int place = 0; place < 8; ++place) {
        std::vector<ray> some = rays;
        for (std::size_t i = 3; i < some.size(); i += 5) {
            ray& r = some[i];
            (place < 3   ? r.origin[place]
             : place < 6 ? r.direction[place - 3]
             : place < 7 ? r.min_distance
                         : r.max_distance) = nan;
        }
        tree.closest(exec::seq, some, hits);
        int wrong = 0;
        for (std::size_t i = 0; i < some.size(); ++i)
            wrong += i % 5 == 3 ? static_cast<bool>(hits[i]) || tree.any(some[i]) : hits[i] != expected[i];
        CHECK(wrong == 0);
    }
}

} // namespace prepared_ray_test
