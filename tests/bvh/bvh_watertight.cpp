#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include "random_triangles.hpp"
#include <algorithm>
#include <doctest/doctest.h>

using namespace insonify;

namespace bvh_watertight_test {

using namespace insonify::detail;

TEST_CASE("no ray leaks out of a closed surface, through faces, vertices or edges, near the origin or far from it") {
    const mesh round = make_sphere({0, 0, 0}, 25_mm, 5); // 20,480 triangles
    for (const float offset : {0.0F, 0.3F, 30.0F}) {
        mesh bumpy = round;
        for (std::size_t i = 0; i < bumpy.positions.size(); ++i)
            bumpy.positions[i] = bumpy.positions[i] * (1 + 0.05F * hash_uniform(9, i)) + vec3{offset, -offset, offset};
        const bvh tree{exec::par, bumpy};
        const vec3 centre{offset, -offset, offset};
        const auto leaks = [&](std::size_t count, const auto& target) {
            std::atomic<int> even = 0, missed = 0;
            exec::for_each_block(exec::par, count, 1000, 1e6F, [&](std::size_t begin, std::size_t end) {
                std::vector<hit> hits;
                for (std::size_t i = begin; i < end; ++i) {
                    ray r{.origin = centre + 10_mm * bvh_test::random_point(11, i)};
                    r.direction = target(i, r.origin);
                    tree.all(r, hits);
                    if (hits.size() % 2 == 0) ++even;
                    if (!tree.any(r) || !tree.closest(r)) ++missed;
                }
            });
            return even + missed;
        };
        const auto vertex = [&](std::uint64_t i) { return bumpy.positions[hash_bits(12, i) % bumpy.positions.size()]; };
        CHECK(leaks(1'000'000, [&](std::uint64_t i, vec3) { return bvh_test::random_point(13, i); }) == 0);
        CHECK(leaks(100'000, [&](std::uint64_t i, vec3 from) { return vertex(i) - from; }) == 0);
        CHECK(leaks(100'000, [&](std::uint64_t i, vec3 from) {
                  const uvec3 face = bumpy.faces[hash_bits(14, i) % bumpy.faces.size()];
                  const vec3 a = bumpy.positions[face.x], b = bumpy.positions[face.y];
                  return a + hash_uniform(15, i) * (b - a) - from;
              }) == 0);
    }
}

TEST_CASE("rays in the planes and along the lines of a grid of triangles cross it once") {
    const mesh box = make_box({-1, -1, 2}, {1, 1, 4}, 3); // vertices on multiples of a quarter
    const bvh tree{exec::par, box};
    std::vector<hit> hits;
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (const float from : {0.0F, 3.0F, 6.0F})
                for (const float sign : {1.0F, -1.0F}) {
                    const ray r{.origin = {static_cast<float>(x) / 4, static_cast<float>(y) / 4, from},
                                .direction = {sign * 0.0F, -sign * 0.0F, sign}}; // both zeros
                    tree.all(r, hits);
                    const std::size_t expected = from == 3.0F ? 1 : (from < 3.0F) == (sign > 0) ? 2 : 0;
                    CHECK(hits.size() == expected);
                }
}

TEST_CASE("slivers are hit as by brute force, at the same distances, by single rays and by packets") {
    mesh slivers;
    for (std::uint32_t i = 0; i < 300; ++i) { // 10^3 to 10^6 times as long as wide
        const vec3 a = bvh_test::random_point(16, 3 * i), b = bvh_test::random_point(16, 3 * i + 1);
        const vec3 between = a + hash_uniform(17, i) * (b - a);
        slivers.positions.insert(
            slivers.positions.end(),
            {a, b,
             between + std::pow(10.0F, -3.0F - static_cast<float>(i % 4)) * bvh_test::random_point(16, 3 * i + 2)});
        slivers.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const bvh tree{exec::par, slivers};
    std::vector<ray> rays;
    for (std::size_t i = 0; i < 3000; ++i) {
        const triangle t = mesh_view{slivers}[i / 10];
        const vec3 from = 3.0F * bvh_test::random_point(18, i / 10); // ten rays side by side go together
        const float b = hash_uniform(19, 2 * i), c = (1 - b) * hash_uniform(19, 2 * i + 1);
        rays.push_back({.origin = from, .direction = t.a + b * (t.b - t.a) + c * (t.c - t.a) - from});
    }
    std::vector<std::vector<hit>> hits(rays.size());
    tree.all(exec::par_unseq, rays, hits);
    std::size_t met = 0;
    std::vector<hit> alone;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        tree.all(rays[i], alone);
        REQUIRE(alone == hits[i]);
        const sheared_ray sheared{rays[i]};
        std::size_t expected = 0;
        for (std::uint32_t k = 0; k < slivers.faces.size(); ++k) {
            const triangle t = mesh_view{slivers}[k];
            const hit exact = intersect(sheared, t);
            if (!(exact.distance >= 0) || !exact) continue;
            ++expected;
            const auto found = std::find_if(alone.begin(), alone.end(), [k](const hit& h) { return h.primitive == k; });
            REQUIRE(found != alone.end());
            const float reach =
                max(std::fabs(sheared(t.a).z), max(std::fabs(sheared(t.b).z), std::fabs(sheared(t.c).z)));
            CHECK(std::fabs(found->distance - exact.distance) <= 4e-6F * reach * std::fabs(sheared.shear.z));
        }
        REQUIRE(alone.size() == expected);
        met += expected;
    }
    CHECK(met > 1000);
}

} // namespace bvh_watertight_test
