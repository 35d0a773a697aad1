#include <insonify/acoustics/law2011.hpp>
#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/pixels.hpp>
#include <insonify/tracing/trace.hpp>
#include "../scene/line_memory.hpp"
#include "reference.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;
using detail::slice_finder;
using detail::touching_distance;
using detail::world_beam;

namespace slice_test {
namespace {

vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

// Balls, boxes and cylinders in random poses: they nest, overlap and hold the probe.
scene random_scene(std::uint64_t seed) {
    scene body{tissue::water};
    const auto objects = 2 + hash_bits(seed, 1) % 6;
    for (std::uint64_t i = 0; i < objects; ++i) {
        const std::uint64_t own = hash_bits(seed, 100 + i);
        const float size = 4_mm + 20_mm * hash_uniform(own, 0);
        mesh surface = own % 3 == 0 ? make_sphere({0, 0, 0}, size, 3)
                       : own % 3 == 1
                           ? make_box(-vec3{size, 0.7F * size, 0.5F * size}, {size, 0.7F * size, 0.5F * size}, 2)
                           : make_cylinder({0, 0, -size}, {0, 0, size}, 0.6F * size, 20);
        const vec3 centre = vec3{0, 0, 30_mm} + 25_mm * random_point(own, 3);
        body.add(std::move(surface), tissue::fat,
                 {.at = look_at(centre, centre + random_point(own, 4), random_point(own, 5))});
    }
    body.add(make_sphere({0, 0, 0}, 12_mm, 3), tissue::muscle); // the probe stands in it
    body.add(mesh{}, tissue::bone);                             // an empty one as well
    body.build(exec::par);
    return body;
}
// The same, its trees out of date.
scene treeless_scene(std::uint64_t seed) {
    scene body = random_scene(seed);
    for (const object& one : body.objects()) body.positions(one.id);
    body.update(exec::par);
    return body;
}

// Parallel lines that leave the face at an angle.
struct steered_array : linear_array {
    float angle = 20_deg;
    ray beam(float line) const {
        return {.origin = linear_array::beam(line).origin, .direction = {std::sin(angle), 0, std::cos(angle)}};
    }
};
// Lines from a flat face, as if they came from a point behind it; before it, they would run towards that point.
struct trapezoid : linear_array {
    float behind = 30_mm;
    ray beam(float line) const {
        const vec3 origin = linear_array::beam(line).origin;
        return {.origin = origin, .direction = (behind > 0 ? 1.0F : -1.0F) * normalize(origin + vec3{0, 0, behind})};
    }
};

// All crossings of all lines in all planes, by line and plane.
using line_lists = std::vector<std::vector<crossing>>;
template <class Probe>
line_lists by_slices(const scene& body, const Probe& probe, const pose& at, const std::vector<elevation_plane>& planes,
                     float depth) {
    slice_finder slices;
    REQUIRE(slices.assign(probe));
    const scene_view flat = body.view_for_slices(exec::par);
    slices.choose(flat, at, view<const elevation_plane>{planes}, true, 1);
    slices.cut(exec::par, flat, at, view<const elevation_plane>{planes}, depth, false);
    line_lists lists;
    slice_finder::block_crossings own;
    line_memory memory;
    for (std::uint32_t i = 0; i < probe.lines; ++i) {
        if (i % slice_finder::block == 0) slices.find_block(i, own);
        for (std::uint32_t plane = 0; plane < planes.size(); ++plane) {
            line_crossings found = memory.found();
            slices.view_of(own).find(i, plane, [&](const crossing& one) {
                if (one.distance <= depth) found.add(one);
            });
            found.sort();
            REQUIRE(found.complete());
            lists.emplace_back(found.sorted().begin(), found.sorted().end());
        }
    }
    return lists;
}
template <class Probe>
line_lists by_rays(const scene& body, const Probe& probe, const pose& at, const std::vector<elevation_plane>& planes,
                   float depth) {
    line_lists lists;
    line_memory memory;
    const scene_view flat = body.view_for_rays(exec::par);
    for (std::uint32_t i = 0; i < probe.lines; ++i)
        for (const elevation_plane& plane : planes) {
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

template <class Body>
void with_every_probe(const Body& body) {
    body(linear_array{.lines = 61, .width = 30_mm});
    body(steered_array{{.lines = 47, .width = 30_mm}});
    body(trapezoid{{.lines = 50, .width = 20_mm}});
    body(convex_array{.lines = 53, .radius = 20_mm, .field_of_view = 70_deg});
    body(convex_array{.lines = 64, .radius = 9_mm, .field_of_view = 300_deg});
    body(phased_array{.lines = 48, .width = 10_mm, .field_of_view = 90_deg});
    body(radial_array{.lines = 99, .radius = 2_mm});
    body(linear_array{.lines = 1, .width = 1_mm});
}

std::vector<elevation_plane> random_planes(std::uint64_t seed) {
    std::vector<elevation_plane> planes(1 + seed % 7);
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
        const std::vector<elevation_plane> planes = random_planes(seed);
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
    const auto check = [&](const auto& probe, const pose& at, const std::vector<elevation_plane>& planes) {
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

TEST_CASE("what lies in a slice, or is open, empty or not finite, does not disturb") {
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

    body.positions(box)[0].x = std::numeric_limits<float>::quiet_NaN();
    body.positions(box)[1].z = std::numeric_limits<float>::infinity();
    for (int frame = 0; frame < 5; ++frame) { // by a linear pass, then by a tree
        body.update(exec::par);
        for (const auto& list : by_slices(body, probe, pose{}, {{2_mm}}, 60_mm))
            for (const crossing& c : list) CHECK(is_finite(c.distance));
        CHECK(is_finite(body.box()));
    }
    const scene nothing = scene{tissue::water}.build(exec::seq);
    for (const auto& list : by_slices(nothing, probe, pose{}, {{}}, 60_mm)) CHECK(list.empty());
}

TEST_CASE("slices, beams and pixels make the same samples") {
    using namespace slice_test;
    const acquisition scan{.depth = 60_mm, .samples = 500};
    std::size_t samples = 0, different = 0; // beside an interface, or on a line through an edge
    for (std::uint64_t seed = 90; seed < 96; ++seed) {
        const scene body = random_scene(seed);
        const pose at = look_at(8_mm * random_point(seed, 7), {0, 0, 30_mm}, random_point(seed, 8));
        with_every_probe([&](const auto& probe) {
            const scan_lines slices = trace_slice(exec::par_unseq, body, probe, at, law2011{}, scan);
            const scan_lines beams = trace_beams(exec::par_unseq, body, probe, at, law2011{}, scan);
            const scan_lines pixels = trace_pixels(exec::par, body, probe, at, law2011{}, scan);
            for (std::size_t i = 0; i < slices.values.size(); ++i)
                for (const float other : {beams.values[i], pixels.values[i]})
                    different += std::fabs(slices.values[i] - other) > 1e-5F * std::fabs(other);
            samples += slices.values.size();
        });
    }
    MESSAGE(samples, " samples, ", different, " differ");
    CHECK(different * 5000 < samples);
}

TEST_CASE("slices are bit-equal on any number of threads, with trees and without, in any number of planes") {
    using namespace slice_test;
    const acquisition scan{.depth = 60_mm, .samples = 300, .planes = 5};
    const convex_array probe{.lines = 101, .radius = 40_mm, .field_of_view = 60_deg};
    for (const bool moved : {false, true}) {
        scene body = random_scene(5);
        body.add(make_sphere({0, 0, 35_mm}, 20_mm, 6), tissue::liver); // 81920 faces: work for several threads
        body.build(exec::par);
        if (moved) {
            for (const object& one : body.objects()) body.positions(one.id);
            body.update(exec::par);
        }
        const iq_lines reference = trace_slice(exec::seq, body, probe, pose{}, physical<>{}, scan);
        for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
            CHECK(trace_slice(exec::par.threads(threads), body, probe, pose{}, physical<>{}, scan) == reference);
    }
}

TEST_CASE("after vertices have moved, slices need no tree, and rays bring it up to date by themselves") {
    using namespace slice_test;
    scene body{tissue::water};
    const object_id ball = body.add(make_sphere({0, 0, 30_mm}, 10_mm, 5), tissue::bone, {.name = "ball"});
    body.build(exec::par);
    for (vec3& p : body.positions(ball)) p = vec3{0, 0, 5_mm} + 0.8F * p;
    scene fresh{tissue::water};
    fresh.add(body[ball].surface, tissue::bone);
    fresh.build(exec::par);
    body.update(exec::par);
    const linear_array probe{};
    const acquisition scan{.depth = 60_mm, .samples = 300};
    const scan_lines expected = trace_slice(exec::par, fresh, probe, pose{}, law2011{}, scan);
    CHECK(trace_slice(exec::par, body, probe, pose{}, law2011{}, scan) == expected);
    CHECK(trace(exec::par, body, probe, pose{}, law2011{}, scan) == expected);
    CHECK_FALSE(body.view_for_slices(exec::par).objects[0].tree_is_current);
    CHECK(body.box(ball).upper.z == doctest::Approx(37_mm).epsilon(1e-4).scale(1e-30));
    CHECK(trace_beams(exec::par, body, probe, pose{}, law2011{}, scan) ==
          trace_beams(exec::par, fresh, probe, pose{}, law2011{}, scan));
    CHECK(body.view_for_rays(exec::par).objects[0].tree_is_current);
}

TEST_CASE("lines that are no fan are traced as beams") {
    using namespace slice_test;
    const scene body = random_scene(3);
    const trapezoid focused{{.lines = 40, .width = 20_mm}, -25_mm};
    const acquisition scan{.depth = 50_mm, .samples = 300};
    CHECK_FALSE(slice_finder{}.assign(focused));
    CHECK(trace_slice(exec::par, body, focused, pose{}, law2011{}, scan) ==
          trace_beams(exec::par, body, focused, pose{}, law2011{}, scan));
    const scene treeless = treeless_scene(3);
    CHECK(trace_slice(exec::par, treeless, focused, pose{}, law2011{}, scan) ==
          trace_beams(exec::par, body, focused, pose{}, law2011{}, scan));
}

TEST_CASE(
    "slices are cut for many lines, and where a tree is out of date; rays are traced for a few lines on a fine mesh") {
    const elevation_plane middle{};
    const auto cuts = [&middle](std::uint32_t lines, const scene& body) {
        slice_finder slices;
        REQUIRE(slices.assign(linear_array{.lines = lines, .width = 30_mm}));
        return slices.choose(body.view_for_slices(exec::seq), pose{}, view<const elevation_plane>{&middle, 1}, false,
                             1);
    };
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 30_mm}, 20_mm, 5), tissue::bone);
    body.build(exec::seq);
    CHECK_FALSE(cuts(16, body));
    CHECK(cuts(512, body));
    body.positions(body.objects()[0].id)[0].z += 1_mm;
    body.update(exec::seq);
    CHECK(cuts(16, body));
}

TEST_CASE("where some objects are cut and rays are traced through others, lines find what rays alone find") {
    scene body{tissue::muscle};
    body.add(make_sphere({0.3_mm, 0.2_mm, 30.1_mm}, 20_mm, 6), tissue::bone);                        // fine: rays
    body.add(make_box({-9_mm, -8_mm, 5.2_mm}, {8_mm, 9_mm, 24.7_mm}), tissue::fat, {.priority = 1}); // coarse: cut
    body.build(exec::seq);
    const linear_array probe{.lines = 48, .width = 30_mm};
    slice_finder slices;
    const elevation_plane middle{};
    REQUIRE(slices.assign(probe));
    REQUIRE(slices.choose(body.view_for_slices(exec::seq), pose{}, view<const elevation_plane>{&middle, 1}, false, 1));
    REQUIRE(slices.leaves_rays());
    REQUIRE(slices.chosen()[0] == 1); // by rank: the box has priority
    REQUIRE(slices.chosen()[1] == 0);
    const acquisition settings{.depth = 60_mm, .samples = 600};
    const scan_lines mixed = trace(exec::seq, body, probe, pose{}, law2011{}, settings);
    const scan_lines rays = trace_beams(exec::seq, body, probe, pose{}, law2011{}, settings);
    std::size_t apart = 0;
    for (std::size_t i = 0; i < rays.values.size(); ++i)
        apart += std::fabs(mixed.values[i] - rays.values[i]) > 1e-5F * std::fabs(rays.values[i]);
    CHECK(apart * 1000 <= rays.values.size()); // samples within rounding of an interface
}

TEST_CASE("an object that comes into the frame changes no bit of the lines beside it") {
    const mesh organ = make_sphere({-8_mm, 0, 15_mm}, 4_mm, 5), visitor = make_sphere({9_mm, 0, 20_mm}, 5_mm, 4);
    for (const std::uint32_t lines : {16U, 48U, 64U, 100U, 128U, 192U, 300U}) {
        const linear_array probe{.lines = lines, .width = 38_mm};
        scene alone{tissue::muscle};
        alone.add(organ, tissue::blood);
        scene together = alone;
        together.add(visitor, tissue::bone);
        alone.build(exec::seq);
        together.build(exec::seq);
        const acquisition settings{.depth = 40_mm, .samples = 400};
        const scan_lines before = trace(exec::seq, alone, probe, pose{}, law2011{}, settings);
        const scan_lines after = trace(exec::seq, together, probe, pose{}, law2011{}, settings);
        CHECK(std::equal(before.values.begin(), before.values.begin() + std::ptrdiff_t{lines / 2} * 400,
                         after.values.begin()));
    }
}

TEST_CASE("a vertex at the end of what floats hold does not disturb the choice between slices and rays") {
    scene body{tissue::muscle};
    mesh far = make_box({-9_mm, -8_mm, 5_mm}, {8_mm, 9_mm, 25_mm});
    far.positions[0] = {3e38F, 3e38F, 3e38F};
    body.add(far, tissue::fat);
    body.build(exec::seq);
    const pose turned = look_at({0, 0, 0}, {1, 0, 1}, {1, 0, -1});
    for (const std::uint32_t lines : {1U, 5U, 200U}) {
        slice_finder slices;
        const elevation_plane middle{};
        REQUIRE(slices.assign(linear_array{.lines = lines, .width = 30_mm}));
        slices.choose(body.view_for_slices(exec::seq), turned, view<const elevation_plane>{&middle, 1}, false,
                      1); // under sanitizers
        REQUIRE(slices.assign(convex_array{.lines = lines + 1}));
        slices.choose(body.view_for_slices(exec::seq), turned, view<const elevation_plane>{&middle, 1}, false, 1);
    }
}
