#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include "random_scenes.hpp"
#include "reference.hpp"
#include <algorithm>
#include <doctest/doctest.h>

using namespace insonify;
using detail::slice_finder;
using detail::touching_distance;
using detail::world_beam;

TEST_CASE("slices, beams and pixels make the same samples") {
    using namespace slice_test;
    const acquisition scan{.depth = 60_mm, .samples = 500};
    std::size_t samples = 0, different = 0; // beside an interface, or on a line through an edge
    for (std::uint64_t seed = 90; seed < 96; ++seed) {
        const scene body = random_scene(seed);
        const pose at = look_at(8_mm * random_point(seed, 7), {0, 0, 30_mm}, random_point(seed, 8));
        with_every_probe([&](const auto& probe) {
            const scan_lines slices =
                trace(exec::par_unseq, body, probe, at, law2011{}, scan, straight_lines{line_search::slices});
            const scan_lines beams =
                trace(exec::par_unseq, body, probe, at, law2011{}, scan, straight_lines{line_search::rays});
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
        const iq_lines reference =
            trace(exec::seq, body, probe, pose{}, physical<>{}, scan, straight_lines{line_search::slices});
        for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
            CHECK(trace(exec::par.threads(threads), body, probe, pose{}, physical<>{}, scan,
                        straight_lines{line_search::slices}) == reference);
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
    const scan_lines expected =
        trace(exec::par, fresh, probe, pose{}, law2011{}, scan, straight_lines{line_search::slices});
    CHECK(trace(exec::par, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::slices}) == expected);
    CHECK(trace(exec::par, body, probe, pose{}, law2011{}, scan) == expected);
    CHECK_FALSE(body.view_for_slices(exec::par).objects[0].tree_is_current);
    CHECK(body.box(ball).upper.z == doctest::Approx(37_mm).epsilon(1e-4).scale(1e-30));
    CHECK(trace(exec::par, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::rays}) ==
          trace(exec::par, fresh, probe, pose{}, law2011{}, scan, straight_lines{line_search::rays}));
    CHECK(body.view_for_rays(exec::par).objects[0].tree_is_current);
}

TEST_CASE("lines that are no fan are traced as beams") {
    using namespace slice_test;
    const scene body = random_scene(3);
    const trapezoid focused{{.lines = 40, .width = 20_mm}, -25_mm};
    const acquisition scan{.depth = 50_mm, .samples = 300};
    CHECK_FALSE(slice_finder{}.assign(focused));
    CHECK(trace(exec::par, body, focused, pose{}, law2011{}, scan, straight_lines{line_search::slices}) ==
          trace(exec::par, body, focused, pose{}, law2011{}, scan, straight_lines{line_search::rays}));
    const scene treeless = treeless_scene(3);
    CHECK(trace(exec::par, treeless, focused, pose{}, law2011{}, scan, straight_lines{line_search::slices}) ==
          trace(exec::par, body, focused, pose{}, law2011{}, scan, straight_lines{line_search::rays}));
}

TEST_CASE(
    "slices are cut for many lines, and where a tree is out of date; rays are traced for a few lines on a fine mesh") {
    const detail::elevation_plane middle{};
    const auto cuts = [&middle](std::uint32_t lines, const scene& body) {
        slice_finder slices;
        REQUIRE(slices.assign(linear_array{.lines = lines, .width = 30_mm}));
        return slices.choose(body.view_for_slices(exec::seq), pose{}, view<const detail::elevation_plane>{&middle, 1},
                             false, 1);
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
    const detail::elevation_plane middle{};
    REQUIRE(slices.assign(probe));
    REQUIRE(slices.choose(body.view_for_slices(exec::seq), pose{}, view<const detail::elevation_plane>{&middle, 1},
                          false, 1));
    REQUIRE(slices.leaves_rays());
    REQUIRE(slices.source({}).cut[0] == 1); // by rank: the box has priority
    REQUIRE(slices.source({}).cut[1] == 0);
    const acquisition settings{.depth = 60_mm, .samples = 600};
    const scan_lines mixed = trace(exec::seq, body, probe, pose{}, law2011{}, settings);
    const scan_lines rays =
        trace(exec::seq, body, probe, pose{}, law2011{}, settings, straight_lines{line_search::rays});
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
        const detail::elevation_plane middle{};
        REQUIRE(slices.assign(linear_array{.lines = lines, .width = 30_mm}));
        slices.choose(body.view_for_slices(exec::seq), turned, view<const detail::elevation_plane>{&middle, 1}, false,
                      1); // under sanitizers
        REQUIRE(slices.assign(convex_array{.lines = lines + 1}));
        slices.choose(body.view_for_slices(exec::seq), turned, view<const detail::elevation_plane>{&middle, 1}, false,
                      1);
    }
}
