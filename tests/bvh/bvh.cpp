#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <algorithm>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;
using namespace insonify::detail;

namespace bvh_test {
namespace {

vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

ray random_ray(std::uint64_t seed, std::uint64_t i) {
    ray r{.origin = 1.5F * random_point(seed, 2 * i), .direction = random_point(seed, 2 * i + 1)};
    if (i % 3 == 1) r.direction[static_cast<int>(i / 3 % 3)] = 0; // along a coordinate plane
    if (i % 7 == 2) r.max_distance = 0.7F;
    if (i % 7 == 3) r.min_distance = 0.4F;
    return r;
}

mesh random_triangles(std::uint64_t seed, std::uint32_t count, float size) {
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
std::vector<hit> by_brute_force(const mesh& m, const ray& r) {
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

bool same_distance(float a, float b) { return std::fabs(a - b) <= 1e-5F * (std::fabs(a) + std::fabs(b)) + 1e-6F; }

// The same primitives; those within rounding of one another in any order.
bool same(std::vector<hit> a, std::vector<hit> b) {
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
bool limit_in_doubt(const ray& r, const mesh& m) {
    ray open = r;
    open.min_distance = -FLT_MAX;
    open.max_distance = FLT_MAX;
    for (const hit& h : by_brute_force(m, open))
        if (same_distance(h.distance, r.min_distance) || same_distance(h.distance, r.max_distance)) return true;
    return false;
}

int disagreements(const mesh& m, std::uint64_t seed, std::uint64_t rays) {
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

} // namespace
} // namespace bvh_test

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

TEST_CASE("identical, flat and point-like primitives make trees within the traversal stack") {
    constexpr std::uint32_t count = 100'000;
    mesh identical{.positions = {{-1, -1, 1}, {1, -1, 1}, {0, 1, 1}}, .faces = {}};
    identical.faces.assign(count, {0, 1, 2});
    mesh points{.positions = {{0, 0, 0}}, .faces = {}};
    points.faces.assign(count, {0, 0, 0});
    mesh line; // boxes that double in size: every split of least cost peels off one
    for (int i = 0; i < 120; ++i) {
        const float x = std::ldexp(1.0F, i - 60);
        for (const vec3 corner : {vec3{x, 0, 0}, vec3{1.5F * x, 0, x}, vec3{x, x, 0}}) line.positions.push_back(corner);
        const auto first = static_cast<std::uint32_t>(3 * i);
        line.faces.push_back({first, first + 1, first + 2});
    }
    for (const mesh* m : {&identical, &points, &line}) {
        const bvh tree{exec::par, *m};
        const bvh_statistics told = tree.statistics();
        CHECK(told.primitives == m->faces.size());
        CHECK(told.levels <= max_levels<simd_width>);
        CHECK(told.leaves >= (m->faces.size() + simd_width - 1) / simd_width);
    }
    const bvh tree{exec::par, identical};
    std::vector<hit> hits;
    tree.all({}, hits);
    CHECK(hits.size() == count);
    CHECK(tree.closest({}).primitive == 0); // ties go to the lowest
    CHECK(bvh_test::disagreements(line, 3, 300) == 0);
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

TEST_CASE("overlapping finds the primitives whose bounds overlap a box or a plane") {
    const mesh m = bvh_test::random_triangles(3, 500, 0.2F);
    const bvh tree{exec::par, m};
    std::vector<std::uint32_t> found;
    for (std::uint64_t i = 0; i < 200; ++i) {
        const vec3 corner = bvh_test::random_point(4, i);
        const aabb box{corner, corner + abs(bvh_test::random_point(5, i))};
        const plane cut{normalize(bvh_test::random_point(6, i)), 0.5F * hash_uniform(7, i)};
        std::vector<std::uint32_t> in_box, on_plane;
        for (std::uint32_t p = 0; p < m.faces.size(); ++p) {
            if (overlaps(box, bounds(mesh_view{m}[p]))) in_box.push_back(p);
            if (overlaps(cut, bounds(mesh_view{m}[p]))) on_plane.push_back(p);
        }
        tree.overlapping(box, found);
        REQUIRE(found == in_box);
        tree.overlapping(cut, found);
        REQUIRE(found == on_plane);
    }
}

TEST_CASE("primitives that are not finite are left out, and change no other hit") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const mesh clean = bvh_test::random_triangles(8, 300, 0.4F);
    mesh dirty = clean;
    for (const float wild : {nan, infinity, -infinity})
        for (int axis = 0; axis < 3; ++axis) {
            const auto first = static_cast<std::uint32_t>(dirty.positions.size());
            for (int corner = 0; corner < 3; ++corner)
                dirty.positions.push_back({0.1F * static_cast<float>(corner), 0, 0});
            dirty.positions[first + static_cast<std::uint32_t>(axis)][axis] = wild;
            dirty.faces.push_back({first, first + 1, first + 2});
        }
    const bvh a{exec::par, clean}, b{exec::par, dirty};
    CHECK(b.statistics().primitives == 300);
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const ray r = bvh_test::random_ray(9, i);
        REQUIRE(a.closest(r) == b.closest(r));
    }
    mesh spoilt = clean; // by an update, after the tree was built
    bvh followed{exec::par, spoilt};
    spoilt.positions[3].y = nan;
    followed.refit(exec::par);
    for (std::uint64_t i = 0; i < 2000; ++i) REQUIRE(followed.closest(bvh_test::random_ray(9, i)).primitive != 1);
}

TEST_CASE("a mesh whose faces refer to no vertex is rejected") {
    mesh m = make_sphere({0, 0, 0}, 1, 1);
    bvh tree{exec::par, m};
    m.faces[3].y = 1000;
    CHECK_THROWS_AS((bvh{exec::par, m}), geometry_error);
    CHECK_THROWS_AS(tree.rebuild(exec::par), geometry_error);
}

TEST_CASE("meshes with the largest finite coordinates make trees") {
    mesh m = bvh_test::random_triangles(10, 100, 0.4F);
    const auto clean = static_cast<std::uint32_t>(m.faces.size());
    for (const float reach : {1e15F, 1e25F, FLT_MAX})
        for (std::uint64_t i = 0; i < 100; ++i) {
            const auto first = static_cast<std::uint32_t>(m.positions.size());
            for (std::uint64_t corner = 0; corner < 3; ++corner)
                m.positions.push_back(reach * bvh_test::random_point(11, 3 * i + corner));
            m.faces.push_back({first, first + 1, first + 2});
        }
    const bvh tree{exec::par, m};
    CHECK(tree.statistics().primitives == 400);
    CHECK(tree.statistics().levels <= max_levels<simd_width>);
    mesh alone = m;
    alone.faces.resize(clean);
    const bvh expected{exec::par, alone};
    std::vector<hit> hits;
    for (std::uint64_t i = 0; i < 500; ++i) {
        const ray r = bvh_test::random_ray(12, i);
        tree.all(r, hits);
        hits.erase(std::remove_if(hits.begin(), hits.end(), [&](const hit& h) { return h.primitive >= clean; }),
                   hits.end());
        std::vector<hit> all_expected;
        expected.all(r, all_expected);
        REQUIRE(bvh_test::same(hits, all_expected));
    }
}

TEST_CASE("a ray that is not finite or has no direction misses") {
    const mesh box = make_box({-1, -1, -1}, {1, 1, 1});
    const bvh tree{exec::seq, box};
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    for (const ray& r : {ray{.origin = {nan, 0, 0}}, ray{.direction = {0, nan, 1}}, ray{.direction = {0, 0, infinity}},
                         ray{.direction = {0, 0, 0}}, ray{.min_distance = nan}, ray{.max_distance = nan}}) {
        CHECK_FALSE(tree.closest(r));
        CHECK_FALSE(tree.any(r));
    }
}

TEST_CASE("786,432 triangles of a box make a tree of many leaves") { // a known fault elsewhere: one leaf
    const mesh box = make_box({-1, -1, -1}, {1, 1, 1}, 8);
    const bvh tree{exec::par, box};
    CHECK(tree.statistics().primitives == 786'432);
    CHECK(tree.statistics().levels < 16);
    CHECK(tree.statistics().leaves < 786'432U / 3);
    CHECK(tree.closest({.origin = {0.1F, 0.2F, -3}}).distance == doctest::Approx(2));
}
