#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/scene.hpp>
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
