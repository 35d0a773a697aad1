#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/error.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/tracing/trace.hpp>
#include "shaded_lines.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("shading is the same by rays and by slices, and on any number of threads") {
    using namespace aperture_shading_test;
    scene bones{body};
    bones.add(make_sphere({3_mm, 0, 20_mm}, 4_mm, 4), tissue::bone);
    bones.add(make_sphere({-6_mm, 1_mm, 12_mm}, 2_mm, 4), tissue::steel);
    bones.add(make_box({-30_mm, -30_mm, -5_mm}, {30_mm, 30_mm, 6_mm}), tissue::fat); // contains the face
    bones.build(exec::par);
    const auto check = [&](const auto& probe) {
        const acquisition how{.depth = 48_mm, .samples = 64, .planes = 3};
        using search = line_search;
        const iq_lines sliced =
            trace(exec::seq, bones, probe, pose{}, arrival_model{}, how, straight_lines{.search = search::slices});
        const iq_lines by_rays =
            trace(exec::seq, bones, probe, pose{}, arrival_model{}, how, straight_lines{.search = search::rays});
        std::size_t apart = 0;
        for (std::size_t i = 0; i < sliced.values.size(); ++i)
            apart += length(sliced.values[i] - by_rays.values[i]) > 1e-3F ? 1 : 0;
        CHECK(apart < sliced.values.size() / 200); // lines through vertices and edges
        for (const std::uint32_t threads : {2U, 5U})
            CHECK(trace(exec::par.threads(threads), bones, probe, pose{}, arrival_model{}, how,
                        straight_lines{.search = search::slices}) == sliced);
    };
    check(linear_array{.lines = 96, .width = 38_mm});
    check(convex_array{.lines = 96, .radius = 40_mm, .field_of_view = 60_deg});
    check(radial_array{.lines = 128, .radius = 5_mm});
}

TEST_CASE("single lines and one direction take no gains; directions out of range are refused") {
    using namespace aperture_shading_test;
    const scene half = sheet(-60_mm, 0.1_mm, 10_mm, absorber);
    const auto same = [&](const auto& probe) {
        return trace(exec::seq, half, probe, pose{}, arrival_model{}, scan) ==
               trace(exec::seq, half, probe, pose{}, arrival_model{}, scan, straight_lines{.directions = 1});
    };
    CHECK_FALSE(same(phased_array{.lines = 32}));
    CHECK(same(linear_array{.lines = 1}));
    CHECK_FALSE(same(linear_array{.lines = 32}));
    for (const std::uint32_t wrong : {0U, 65U})
        CHECK_THROWS_AS(
            trace(exec::seq, half, fine, pose{}, arrival_model{}, scan, straight_lines{.directions = wrong}),
            usage_error);
}

TEST_CASE("an object far away changes no bit of the shading") {
    using namespace aperture_shading_test;
    scene ball{body};
    ball.add(make_sphere({0, 0, 10_mm}, 0.5_mm, 4), absorber);
    scene far = ball;
    far.add(make_sphere({0, 0, 1}, 5_mm, 4), tissue::steel);
    ball.build(exec::par);
    far.build(exec::par);
    const auto seen = [](const scene& s) {
        return trace(exec::par_unseq, s, linear_array{.lines = 128}, pose{}, arrival_model{}, scan);
    };
    CHECK(seen(ball) == seen(far));
}

TEST_CASE("walls beside the axis of a round face, and few lines: rays and slices agree") {
    using namespace aperture_shading_test;
    using search = line_search;
    const auto apart = [](const scene& s, const auto& probe, float depth) {
        const acquisition how{.depth = depth, .samples = 64};
        const iq_lines sliced =
            trace(exec::par, s, probe, pose{}, arrival_model{}, how, straight_lines{.search = search::slices});
        const iq_lines by_rays =
            trace(exec::par, s, probe, pose{}, arrival_model{}, how, straight_lines{.search = search::rays});
        std::size_t count = 0;
        for (std::size_t i = 0; i < sliced.values.size(); ++i)
            count += length(sliced.values[i] - by_rays.values[i]) > 1e-2F ? 1 : 0;
        return static_cast<double>(count) / static_cast<double>(sliced.values.size());
    };
    for (const float wall : {0.1_mm, 0.3_mm}) {
        scene s{body};
        s.add(make_box({-30_mm, -30_mm, wall}, {30_mm, 30_mm, 30_mm}), tissue::fat);
        s.build(exec::par);
        CHECK(apart(s, radial_array{.lines = 256}, 20_mm) < 0.005);
    }
    scene wall{body};
    wall.add(make_box({-30_mm, -30_mm, -40_mm}, {-5_mm, 30_mm, 40_mm}), tissue::fat);
    wall.build(exec::par);
    CHECK(apart(wall, convex_array{.lines = 192, .radius = 10_mm, .field_of_view = 180_deg}, 30_mm) < 0.005);
    scene balls{body};
    balls.add(make_sphere({3_mm, 0, 20_mm}, 4_mm, 4), tissue::bone);
    balls.add(make_sphere({-12_mm, 1_mm, 12_mm}, 2_mm, 4), absorber);
    balls.build(exec::par);
    for (const std::uint32_t lines : {3U, 4U, 7U, 92U}) {
        CAPTURE(lines);
        CHECK(apart(balls, linear_array{.lines = lines}, 40_mm) < 0.01);
    }
}

TEST_CASE("an object that begins at the face of the probe shades as one that begins behind it") {
    using namespace aperture_shading_test;
    const auto seen = [](float top) {
        scene s{body};
        s.add(make_box({-60_mm, -30_mm, top}, {60_mm, 30_mm, 60_mm}), tissue::muscle);
        s.add(make_sphere({0, 0, 10_mm}, 2_mm, 4), absorber);
        s.build(exec::par);
        return trace(exec::par_unseq, s, linear_array{.lines = 128}, pose{}, arrival_model{}, scan,
                     straight_lines{.search = line_search::slices});
    };
    const iq_lines at_face = seen(0), before = seen(-1_mm);
    float worst = 0;
    for (std::size_t i = 0; i < at_face.values.size(); ++i)
        if (before.values[i].y > 1e-6F)
            worst = std::max(worst, std::fabs(at_face.values[i].y / before.values[i].y - 1));
    CHECK(worst < 1e-3F);
}

TEST_CASE("any number of lines can be turned") {
    for (std::uint32_t lines = 100; lines <= 4096; lines += 36) {
        const linear_array linear{.lines = lines};
        const convex_array convex{.lines = lines};
        const radial_array radial{.lines = lines};
        const auto turned = [](const auto& probe) {
            detail::line_fan fan;
            REQUIRE(fan.assign(probe));
            return detail::face_shape{}.assign(fan, is_full_circle(probe));
        };
        CAPTURE(lines);
        CHECK(turned(linear));
        CHECK(turned(convex));
        CHECK(turned(radial));
    }
}
