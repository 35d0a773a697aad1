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
    const auto cosines = [&](std::size_t i) { return vec2{layers[i].own_begin.cosine, layers[i].own_end.cosine}; };
    CHECK(cosines(0) == vec2{0, 0});
    CHECK(cosines(1) == vec2{1, 0}); // its upper surface is the muscle's, the vessel's is not
    CHECK(cosines(2) == vec2{1, 1});
    CHECK(cosines(3) == vec2{0, 1});
    CHECK(cosines(4) == vec2{0, 0});
    for (const layer& each : layers)
        for (const object_surface& own : {each.own_begin, each.own_end}) CHECK(own.normal == vec3{0, 0, own.cosine});
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
        for (const object_surface& own : {layers[1].own_begin, layers[1].own_end})
            CHECK(length(own.normal - vec3{s, 0, c}) < 1e-5F);
        CHECK(std::fabs(layers[1].own_begin.cosine - c) < 1e-5F);
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
    CHECK(layers[1].own_end.cosine + layers[2].own_begin.cosine == 1);
    CHECK(layers[1].own_begin.cosine == 1);
    CHECK(layers[2].own_end.cosine == 1);
}
