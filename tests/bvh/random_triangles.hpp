#ifndef INSONIFY_TESTS_BVH_RANDOM_TRIANGLES_HPP
#define INSONIFY_TESTS_BVH_RANDOM_TRIANGLES_HPP

#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <vector>

/// Random triangles and rays, and hits by brute force.
namespace bvh_test {

using namespace insonify;
using namespace insonify::detail;

inline vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

inline ray random_ray(std::uint64_t seed, std::uint64_t i) {
    ray r{.origin = 1.5F * random_point(seed, 2 * i), .direction = random_point(seed, 2 * i + 1)};
    if (i % 3 == 1) r.direction[static_cast<int>(i / 3 % 3)] = 0; // along a coordinate plane
    if (i % 7 == 2) r.max_distance = 0.7F;
    if (i % 7 == 3) r.min_distance = 0.4F;
    return r;
}

inline mesh random_triangles(std::uint64_t seed, std::uint32_t count, float size) {
    mesh m;
    for (std::uint32_t i = 0; i < count; ++i) {
        const vec3 centre = random_point(seed, 4 * std::uint64_t{i});
        for (std::uint64_t corner = 1; corner <= 3; ++corner)
            m.positions.push_back(centre + size * random_point(seed, 4 * std::uint64_t{i} + corner));
        m.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return m;
}

// Tests every triangle by the scalar test that is checked against double precision elsewhere.
inline std::vector<hit> by_brute_force(const mesh& m, const ray& r) {
    std::vector<hit> hits;
    const sheared_ray sheared{r};
    for (std::uint32_t i = 0; i < m.faces.size(); ++i) {
        hit found = intersect(sheared, mesh_view{m}[i]);
        found.primitive = i;
        if (found && found.distance >= r.min_distance && found.distance <= r.max_distance) hits.push_back(found);
    }
    std::sort(hits.begin(), hits.end(), nearer);
    return hits;
}

inline bool same_distance(float a, float b) {
    return std::fabs(a - b) <= 1e-5F * (std::fabs(a) + std::fabs(b)) + 1e-6F;
}

// The same primitives; those within rounding of one another in any order.
inline bool same(std::vector<hit> a, std::vector<hit> b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!same_distance(a[i].distance, b[i].distance)) return false;
    const auto by_primitive = [](const hit& x, const hit& y) { return x.primitive < y.primitive; };
    std::sort(a.begin(), a.end(), by_primitive);
    std::sort(b.begin(), b.end(), by_primitive);
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i].primitive != b[i].primitive) return false;
    return true;
}

// A limit of the ray that falls on a hit to within rounding may let it through or not.
inline bool limit_in_doubt(const ray& r, const mesh& m) {
    ray open = r;
    open.min_distance = -FLT_MAX;
    open.max_distance = FLT_MAX;
    for (const hit& h : by_brute_force(m, open))
        if (same_distance(h.distance, r.min_distance) || same_distance(h.distance, r.max_distance)) return true;
    return false;
}

inline int disagreements(const mesh& m, std::uint64_t seed, std::uint64_t rays) {
    const bvh tree{exec::par, m};
    std::vector<hit> hits;
    int wrong = 0;
    for (std::uint64_t i = 0; i < rays; ++i) {
        const ray r = random_ray(seed, i);
        const std::vector<hit> expected = by_brute_force(m, r);
        tree.all(r, hits);
        const hit closest = tree.closest(r);
        const bool right = same(hits, expected) && tree.any(r) == !expected.empty() &&
                           static_cast<bool>(closest) == !expected.empty() &&
                           (hits.empty() || closest == hits.front()) &&
                           std::is_sorted(hits.begin(), hits.end(), nearer);
        if (!right && !limit_in_doubt(r, m)) ++wrong;
    }
    return wrong;
}

} // namespace bvh_test

#endif
