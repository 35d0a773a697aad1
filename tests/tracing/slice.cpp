// Covers tracing/find/slice_finder.hpp.
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include "../scene/crossing_memory.hpp"
#include "random_scenes.hpp"
#include "reference.hpp"
#include <algorithm>
#include <doctest/doctest.h>

using namespace insonify;
using detail::slice_finder;
using detail::touching_distance;
using detail::world_beam;

namespace slice_test {
namespace {

// All crossings of all lines in all planes, by line and plane.
using line_lists = std::vector<std::vector<crossing>>;

template <class Probe>
line_lists by_slices(const scene& body, const Probe& probe, const pose& at,
                     const std::vector<detail::elevation_plane>& planes, float depth) {
    slice_finder slices;
    REQUIRE(slices.assign(probe));
    const scene_view flat = body.view_for_slices(exec::par);
    slices.choose(flat, at, view<const detail::elevation_plane>{planes}, true, 1);
    slices.cut(exec::par, flat, at, view<const detail::elevation_plane>{planes}, depth);
    line_lists lists;
    detail::crossing_lists found_of_block;
    crossing_memory memory;
    for (std::uint32_t i = 0; i < probe.lines; ++i) {
        if (i % slice_finder::block == 0) slices.find_block(i, found_of_block);
        for (std::uint32_t plane = 0; plane < planes.size(); ++plane) {
            line_crossings found = memory.found();
            const detail::crossing_lists& of_block = found_of_block;
            for (const crossing& one : of_block[slice_finder::list_of(i, plane)])
                if (one.distance >= 0 && one.distance <= depth) found.add(one);
            found.sort();
            REQUIRE(found.complete());
            lists.emplace_back(found.sorted().begin(), found.sorted().end());
        }
    }
    return lists;
}

template <class Probe>
line_lists by_rays(const scene& body, const Probe& probe, const pose& at,
                   const std::vector<detail::elevation_plane>& planes, float depth) {
    line_lists lists;
    crossing_memory memory;
    const scene_view flat = body.view_for_rays(exec::par);
    for (std::uint32_t i = 0; i < probe.lines; ++i)
        for (const detail::elevation_plane& plane : planes) {
            ray beam = probe.beam(static_cast<float>(i));
            beam.origin.y += plane.height(beam.origin.z);
            beam.direction.y += plane.slope * beam.direction.z;
            beam.origin = at.point(beam.origin);
            beam.direction = at.direction(beam.direction);
            line_crossings found = memory.found();
            REQUIRE(find_crossings(flat, beam, depth, found));
            lists.emplace_back(found.sorted().begin(), found.sorted().end());
        }
    return lists;
}

// Both are the same: objects and faces equal, distances within rounding.
struct comparison {
    std::size_t lines = 0, doubtful = 0;
    float worst = 0;
};

void compare(const line_lists& a, const line_lists& b, comparison& seen) {
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        ++seen.lines;
        bool same = a[i].size() == b[i].size();
        float apart = 0;
        for (std::size_t k = 0; same && k < a[i].size(); ++k) {
            same = a[i][k].rank == b[i][k].rank;
            apart = std::max(apart, std::fabs(a[i][k].distance - b[i][k].distance));
        }
        if (!same || apart > 1e-6F)
            ++seen.doubtful; // a grazing line, or one through an edge: looked at elsewhere
        else
            seen.worst = std::max(seen.worst, apart);
    }
}

std::vector<detail::elevation_plane> random_planes(std::uint64_t seed) {
    std::vector<detail::elevation_plane> planes(1 + seed % 7);
    for (std::size_t i = 0; i < planes.size(); ++i)
        planes[i] = {4_mm * hash_uniform(seed, 50 + i) - 2_mm, 0.3F * hash_uniform(seed, 60 + i) - 0.15F};
    return planes;
}

} // namespace
} // namespace slice_test

TEST_CASE(
    "slices find the crossings that rays find, on random scenes and poses, with every probe, in 1 to 7 tilted planes") {
    using namespace slice_test;
    constexpr std::uint64_t first_seed = 40;
    MESSAGE("first seed ", first_seed);
    comparison seen;
    std::size_t crossings = 0;
    for (std::uint64_t seed = first_seed; seed < first_seed + 30; ++seed) {
        const scene body = random_scene(seed), treeless = treeless_scene(seed);
        const vec3 face = 8_mm * random_point(seed, 7);
        const pose at = look_at(face, {0, 0, 30_mm}, random_point(seed, 8));
        const std::vector<detail::elevation_plane> planes = random_planes(seed);
        with_every_probe([&](const auto& probe) {
            const line_lists slices = by_slices(body, probe, at, planes, 60_mm);
            CHECK(by_slices(treeless, probe, at, planes, 60_mm) == slices); // tree or none: the very same
            compare(slices, by_rays(body, probe, at, planes, 60_mm), seen);
            for (const auto& list : slices) crossings += list.size();
        });
    }
    MESSAGE(seen.lines, " lines, ", crossings, " crossings, ", seen.doubtful, " in doubt, worst ", seen.worst, " m");
    CHECK(crossings > seen.lines);
    CHECK(seen.doubtful * 2000 < seen.lines);
}

TEST_CASE("slices find the crossings of brute force in double precision") {
    using namespace slice_test;
    std::size_t lines = 0, doubtful = 0;
    for (std::uint64_t seed = 7; seed < 11; ++seed) {
        const scene body = random_scene(seed);
        const pose at = look_at(8_mm * random_point(seed, 7), {0, 0, 30_mm}, random_point(seed, 8));
        with_every_probe([&](const auto& probe) {
            const line_lists slices = by_slices(body, probe, at, {{0.7_mm}}, 60_mm);
            for (std::uint32_t i = 0; i < probe.lines; i += 3) {
                const ray beam = world_beam(probe, at, static_cast<float>(i));
                const vec3 origin = beam.origin + 0.7_mm * at.direction({0, 1, 0});
                std::vector<std::pair<double, std::uint32_t>> expected;
                const scene_view flat = body.view_for_rays(exec::par);
                for (std::uint32_t rank = 0; rank < flat.objects.size(); ++rank)
                    for (const double distance : reference::crossings(body[object_id{flat.objects[rank].id}],
                                                                      glm::dvec3{origin}, glm::dvec3{beam.direction}))
                        if (distance <= 0.06) expected.push_back({distance, rank});
                std::sort(expected.begin(), expected.end());
                bool same = expected.size() == slices[i].size();
                for (std::size_t k = 0; same && k < expected.size(); ++k)
                    same = slices[i][k].rank == expected[k].second &&
                           std::fabs(static_cast<double>(slices[i][k].distance) - expected[k].first) < 2e-6;
                ++lines;
                doubtful += !same;
            }
        });
    }
    MESSAGE(lines, " lines, ", doubtful, " differ");
    CHECK(doubtful * 500 < lines); // through an edge, or grazing
}

TEST_CASE("every line crosses a closed surface in and out by turns, also through its vertices and edges") {
    using namespace slice_test;
    // A box whose vertices lie on a grid of lines and slices, and a ball with vertices in the slices, from all sides.
    scene body{tissue::water};
    body.add(make_box({-8_mm, -8_mm, 12_mm}, {8_mm, 8_mm, 28_mm}, 4), tissue::bone);
    body.add(make_sphere({0, 0, 20_mm}, 16_mm, 4), tissue::fat);
    body.build(exec::par);
    const scene_view flat = body.view_for_rays(exec::par);
    const linear_array grid{.lines = 81, .width = 40.5_mm}; // a line each half millimetre, on the vertices
    std::size_t lines = 0, crossings = 0;
    const auto check = [&](const auto& probe, const pose& at, const std::vector<detail::elevation_plane>& planes) {
        const line_lists lists = by_slices(body, probe, at, planes, 1.0F);
        for (std::size_t i = 0; i < lists.size(); ++i) {
            const ray beam = world_beam(probe, at, static_cast<float>(i / planes.size()));
            const vec3 tilted =
                beam.direction + planes[i % planes.size()].slope * dot(beam.direction, at.rotation[2]) * at.rotation[1];
            for (std::uint32_t rank = 0; rank < 2; ++rank) {
                const object_view& one = flat.objects[rank];
                float level = 0; // 1 inside, 0 outside
                float before = 0;
                for (const crossing& c : lists[i]) {
                    if (c.rank != rank) continue;
                    // Two places within rounding of each other may have changed their order.
                    if (level < 0 || level > 1) REQUIRE(c.distance - before < touching_distance);
                    const vec3 normal = one.at.direction(area_vector(one.surface[c.primitive]));
                    if (std::fabs(dot(normalize(normal), tilted)) < 1e-3F)
                        level = 1 - level; // along a face: either way
                    else
                        level += dot(normal, tilted) < 0 ? 1.0F : -1.0F;
                    before = c.distance;
                    ++crossings;
                }
                REQUIRE(level == 0);
            }
            ++lines;
        }
    };
    for (const float turn : {0.0F, 90_deg, 180_deg, 270_deg, 45_deg}) {
        const vec3 z{std::sin(turn), 0, std::cos(turn)};
        const pose at{mat3{{z.z, 0, -z.x}, {0, 1, 0}, z}, vec3{0, 0, 20_mm} - 40_mm * z};
        check(grid, at, {{0}, {1_mm}, {-1_mm}, {8_mm}, {-8_mm}, {0.5_mm}, {7.999_mm}});
        check(grid, at, {{0}, {-4_mm, 0.1F}, {4_mm, -0.1F}, {0, 0.2F}});
        check(phased_array{.lines = 401, .width = 1_mm, .field_of_view = 60_deg}, at, {{0}, {8_mm}});
    }
    for (std::uint64_t seed = 1; seed < 400; ++seed) {
        const vec3 from = vec3{0, 0, 20_mm} + 40_mm * normalize(random_point(seed, 1));
        const pose at = look_at(from, {0, 0, 20_mm}, random_point(seed, 2));
        check(convex_array{.lines = 200, .radius = 10_mm, .field_of_view = 80_deg}, at, random_planes(seed));
    }
    MESSAGE(lines, " lines, ", crossings, " crossings");
    CHECK(crossings > lines);
}

TEST_CASE("what lies in a slice, or is open, empty or huge, does not disturb") {
    using namespace slice_test;
    const linear_array probe{.lines = 101, .width = 30_mm};
    scene body{tissue::water};
    const object_id box = body.add(make_box({-5_mm, 0, 10_mm}, {5_mm, 5_mm, 20_mm}), tissue::bone);
    body.build(exec::par);
    const auto met = [&](float offset) {
        std::size_t lines = 0;
        for (const auto& list : by_slices(body, probe, pose{}, {{offset}}, 60_mm)) {
            REQUIRE((list.empty() || list.size() == 2));
            lines += !list.empty();
        }
        return lines;
    };
    CHECK(met(0) == 33); // a face lies in the slice, which counts as a little higher
    CHECK(met(2_mm) == 33);
    CHECK(met(5_mm) == 0);
    CHECK(met(-1e-6F) == 0);

    body.positions(box)[0].x = 1e15F;
    body.positions(box)[1].z = -1e15F;
    for (int frame = 0; frame < 5; ++frame) { // by a linear pass, then by a tree
        body.update(exec::par);
        for (const auto& list : by_slices(body, probe, pose{}, {{2_mm}}, 60_mm))
            for (const crossing& c : list) CHECK(is_finite(c.distance));
        CHECK(is_finite(body.box()));
    }
    const scene nothing = scene{tissue::water}.build(exec::seq);
    for (const auto& list : by_slices(nothing, probe, pose{}, {{}}, 60_mm)) CHECK(list.empty());
}
