#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace sheath_test {
namespace {

// The layers of a line along z from the origin.
std::vector<layer> layers_of(const scene& body, float depth) {
    std::vector<crossing> crossings(64);
    std::vector<std::uint32_t> inside(16);
    std::vector<layer> room(32);
    line_crossings found{.room = crossings, .inside = {.ranks = inside}};
    const scene_view flat = body.view_for_rays(exec::seq);
    REQUIRE(find_crossings(flat, {.direction = {0, 0, 1}}, depth, found));
    const view<const layer> layers = stack_layers(flat, line_frame{}, depth, found, room);
    return {layers.begin(), layers.end()};
}

mesh slab(float from, float to) { return make_box({-20_mm, -20_mm, from}, {20_mm, 20_mm, to}); }

} // namespace
} // namespace sheath_test

TEST_CASE("layers: a surface belongs to the object that has precedence") {
    using namespace sheath_test;
    scene body{tissue::fat};
    body.add(slab(10_mm, 40_mm), tissue::muscle);
    body.add(make_box({-5_mm, -5_mm, 20_mm}, {5_mm, 5_mm, 25_mm}), tissue::blood);
    body.build(exec::seq);
    const std::vector<layer> layers = layers_of(body, 60_mm); // fat, muscle, blood, muscle, fat
    REQUIRE(layers.size() == 5);
    CHECK(layers[0].own_surfaces == vec2{0, 0});
    CHECK(layers[1].own_surfaces == vec2{1, 0}); // its upper surface is the muscle's, the vessel's is not
    CHECK(layers[2].own_surfaces == vec2{1, 1});
    CHECK(layers[3].own_surfaces == vec2{0, 1});
    CHECK(layers[4].own_surfaces == vec2{0, 0});
    for (const layer& each : layers)
        for (const int end : {0, 1})
            CHECK(each.own_normals[end] == vec3{0, 0, end == 0 ? each.own_surfaces.x : each.own_surfaces.y});
}

TEST_CASE("layers: the normal of an object's own surface is that of a plane at any angle to the line") {
    using namespace sheath_test;
    for (const float angle : {10_deg, 35_deg, 50_deg}) {
        const float c = std::cos(angle), s = std::sin(angle);
        scene body{tissue::fat};
        body.add(slab(10_mm, 15_mm), tissue::muscle, {.at = {.rotation = mat3{{c, 0, -s}, {0, 1, 0}, {s, 0, c}}}});
        body.build(exec::seq);
        const std::vector<layer> layers = layers_of(body, 60_mm);
        REQUIRE(layers.size() == 3);
        for (const vec3 normal : layers[1].own_normals) CHECK(length(normal - vec3{s, 0, c}) < 1e-5F);
        CHECK(std::fabs(layers[1].own_surfaces.x - c) < 1e-5F);
    }
}

TEST_CASE("layers: two muscles that touch share one surface") {
    using namespace sheath_test;
    scene body{tissue::fat};
    body.add(slab(10_mm, 20_mm), tissue::muscle);
    body.add(slab(20_mm, 40_mm), tissue::muscle);
    body.build(exec::seq);
    const std::vector<layer> layers = layers_of(body, 60_mm);
    REQUIRE(layers.size() == 4);
    CHECK(layers[1].own_surfaces.y + layers[2].own_surfaces.x == 1);
    CHECK(layers[1].own_surfaces.x == 1);
    CHECK(layers[2].own_surfaces.y == 1);
}
