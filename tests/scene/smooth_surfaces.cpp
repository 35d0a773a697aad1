#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/trace.hpp>
#include "../slab.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <type_traits>

using namespace insonify;

namespace smooth_surfaces_test {
namespace {

static_assert(std::is_trivially_copyable_v<detail::smooth_normals_view>);

constexpr acquisition scan{.depth = 40_mm, .samples = 1600, .planes = 3};
const linear_array probe{.lines = 64};

iq_lines traced(const scene& body, straight_lines how = {}) {
    return trace(exec::par, body, probe, pose{}, physical<>{}, scan, how);
}
/// The largest difference relative to the largest sample.
float difference(const iq_lines& a, const iq_lines& b) {
    float largest = 0, worst = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        largest = std::max(largest, length(a.values[i]));
        worst = std::max(worst, length(a.values[i] - b.values[i]));
    }
    return worst / largest;
}
void flatten(std::span<vec3> positions) {
    for (vec3& p : positions) p = {1.3F * p.x, p.y, 20_mm + 0.6F * (p.z - 20_mm)};
}
medium quiet() { return {.density = 1000, .sound_speed = 1540}; }

} // namespace
} // namespace smooth_surfaces_test

TEST_CASE("boxes and plates are the same to the bit whether edges are smooth or not") {
    using namespace smooth_surfaces_test;
    const auto body = [](float crease_angle) {
        scene all{tissue::muscle};
        all.add(make_box({-10_mm, -10_mm, 12_mm}, {3_mm, 10_mm, 20_mm}, 3), tissue::bone,
                {.crease_angle = crease_angle});
        all.add(slab({0, 0, 25_mm}, {0.3F, 0.1F, -1}, 30_mm, 2_mm), tissue::fat, {.crease_angle = crease_angle});
        return std::move(all).build(exec::par);
    };
    CHECK(traced(body(30_deg)).values == traced(body(0)).values);
}

TEST_CASE("smooth normals follow vertices that move, and objects that are placed") {
    using namespace smooth_surfaces_test;
    const auto ball = [] { return make_sphere({0, 0, 20_mm}, 8_mm, 4); };
    const medium inside{.density = 1400, .sound_speed = 1540};
    scene moving{quiet()}, made{quiet()};
    const object_id id = moving.add(ball(), inside);
    moving.build(exec::par);
    const iq_lines before = traced(moving);
    flatten(moving.positions(id));
    moving.update(exec::par);
    mesh deformed = ball();
    flatten(deformed.positions);
    made.add(std::move(deformed), inside);
    made.build(exec::par);
    // The first frames after an update need no tree: normals are computed as they are needed, later they are stored.
    const straight_lines slices{.search = line_search::slices};
    const iq_lines expected = traced(made, slices), first = traced(moving, slices);
    MESSAGE("after a deformation, of the largest echo: ", difference(expected, first));
    CHECK(difference(expected, first) < 1e-4F);
    moving.update(exec::par);
    moving.update(exec::par);
    CHECK(traced(moving, slices).values == first.values);
    CHECK(difference(expected, before) > 0.1F);

    scene placed{quiet()}, shifted{quiet()};
    const object_id at_origin = placed.add(make_sphere({0, 0, 0}, 8_mm, 4), inside);
    placed.build(exec::par).place(at_origin, look_at({2_mm, 1_mm, 19_mm}, {2_mm, 1_mm, 30_mm}, {1, 0, 0}));
    shifted.add(make_sphere({2_mm, 1_mm, 19_mm}, 8_mm, 4), inside);
    shifted.build(exec::par);
    MESSAGE("placed, of the largest echo: ", difference(traced(placed), traced(shifted)));
    CHECK(difference(traced(placed), traced(shifted)) < 2e-3F); // of its phase, by rounding of 20 mm
}

TEST_CASE("roughness is that of the object of higher priority, on both of its sides") {
    using namespace smooth_surfaces_test;
    const auto layers_of = [](int priority) {
        medium rough{.density = 1100, .sound_speed = 1540, .roughness = 20_um}, smooth = rough;
        smooth.roughness = 2_um;
        smooth.density = 3000;
        scene body{quiet()};
        body.add(make_box({-20_mm, -20_mm, 10_mm}, {20_mm, 20_mm, 30_mm}), rough);
        body.add(make_box({-10_mm, -10_mm, 15_mm}, {10_mm, 10_mm, 40_mm}), smooth, {.priority = priority});
        body.build(exec::par);
        const scene_view flat = body.view_for_rays(exec::par);
        crossing crossings[16];
        std::uint32_t inside[4];
        layer room[16];
        line_crossings found{.room = {crossings, 16}, .inside = {.ranks = {inside, 4}}};
        const line_frame line{.origin = {1_mm, 2_mm, 0}};
        find_crossings(flat, {.origin = line.origin, .direction = line.along}, 60_mm, found);
        std::vector<float> roughness;
        for (const layer& one : stack_layers(flat, line, 60_mm, found, {room, 16})) roughness.push_back(one.roughness);
        return roughness;
    };
    CHECK(layers_of(1) == std::vector<float>{-1, 20_um, 2_um, 2_um});   // the smooth one is a mirror throughout
    CHECK(layers_of(-1) == std::vector<float>{-1, 20_um, 20_um, 2_um}); // its end within the other is hidden
}

TEST_CASE("a crease angle out of range is refused") {
    scene body;
    CHECK_THROWS_AS(body.add(make_sphere({0, 0, 0}, 1_mm, 1), medium{}, {.crease_angle = -0.1F}), usage_error);
    CHECK_THROWS_AS(body.add(make_sphere({0, 0, 0}, 1_mm, 1), medium{}, {.crease_angle = 30}), usage_error);
    CHECK(body[body.add(make_sphere({0, 0, 0}, 1_mm, 1), medium{}, {.crease_angle = 0})].crease_angle == 0);
}
