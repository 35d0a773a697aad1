#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include "layers_along.hpp"
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("a line through nested objects finds each medium on the way in and on the way out") {
    scene body{tissue::gel};
    const object_id skin = body.add(scene_test::cube(10_mm, 90_mm), tissue::skin);
    const object_id liver = body.add(scene_test::cube(20_mm, 80_mm), tissue::liver);
    const object_id vessel = body.add(scene_test::cube(40_mm, 50_mm), tissue::blood);
    body.build(exec::par);
    using scene_test::id, scene_test::outside;
    const std::vector<layer> layers = scene_test::along(body, {.origin = {1_mm, 2_mm, 0}});
    scene_test::check_layers(layers, {{outside, 0},
                                      {id(skin), 10_mm},
                                      {id(liver), 20_mm},
                                      {id(vessel), 40_mm},
                                      {id(liver), 50_mm},
                                      {id(skin), 80_mm},
                                      {outside, 90_mm}});
    CHECK(body.media()[layers[3].medium] == tissue::blood);
    CHECK(body.media()[layers[6].medium] == tissue::gel);
    const scene_view flat = body.view_for_rays(exec::par);
    for (const layer& one : layers) {
        REQUIRE(one.place < flat.places.size());
        CHECK((one.place == 0 ? outside : flat.objects[one.place - 1].id) == one.object);
    }
}

TEST_CASE("where surfaces touch, the angle is that of the one that the change of medium is due to") {
    scene body{tissue::gel};
    const object_id box = body.add(scene_test::cube(10_mm, 30_mm), tissue::liver, {.priority = 1});
    mesh slanted = make_box({-20_mm, -20_mm, -20_mm}, {20_mm, 20_mm, 0}); // its end, 0.4 um before that of the other
    for (vec3& p : slanted.positions)                                     // turned by 30 degrees
        p = vec3{1_mm, 2_mm, 29.9996_mm} + vec3{0.8660254F * p.x + 0.5F * p.z, p.y, 0.8660254F * p.z - 0.5F * p.x};
    body.add(slanted, tissue::fat);
    body.build(exec::par);
    const std::vector<layer> layers = scene_test::along(body, {.origin = {1_mm, 2_mm, 20_mm}});
    REQUIRE(layers.size() == 2);
    CHECK(layers[0].object == scene_test::id(box));
    CHECK(layers[1].object == scene_test::outside);
    CHECK(layers[1].cosine == doctest::Approx(1).scale(1e-30));
}

TEST_CASE("where objects overlap the higher priority counts, then the smaller volume, then the later one") {
    using scene_test::id, scene_test::outside;
    scene body{tissue::water};
    const object_id large = body.add(scene_test::cube(10_mm, 50_mm), tissue::muscle, {.priority = 1});
    const object_id tiny = body.add(scene_test::cube(20_mm, 30_mm), tissue::fat);
    body.build(exec::par);
    scene_test::check_layers(scene_test::along(body, {.origin = {1_mm, 2_mm, 0}}),
                             {{outside, 0}, {id(large), 10_mm}, {outside, 50_mm}});

    scene by_volume{tissue::water};
    const object_id big = by_volume.add(scene_test::cube(10_mm, 50_mm), tissue::muscle);
    const object_id small_one = by_volume.add(scene_test::cube(40_mm, 60_mm), tissue::fat);
    by_volume.build(exec::par);
    scene_test::check_layers(scene_test::along(by_volume, {.origin = {1_mm, 2_mm, 0}}),
                             {{outside, 0}, {id(big), 10_mm}, {id(small_one), 40_mm}, {outside, 60_mm}});
    // The other way round the same places have the same media.
    scene_test::check_layers(scene_test::along(by_volume, {.origin = {1_mm, 2_mm, 70_mm}, .direction = {0, 0, -1}}),
                             {{outside, 0}, {id(small_one), 10_mm}, {id(big), 30_mm}, {outside, 60_mm}});

    scene twins{tissue::water};
    twins.add(scene_test::cube(10_mm, 50_mm), tissue::muscle);
    const object_id later = twins.add(scene_test::cube(10_mm, 50_mm), tissue::fat);
    twins.build(exec::par);
    scene_test::check_layers(scene_test::along(twins, {.origin = {1_mm, 2_mm, 0}}),
                             {{outside, 0}, {id(later), 10_mm}, {outside, 50_mm}});
    CHECK(tiny != large);
}

TEST_CASE("a probe may start inside objects, or on a surface") {
    using scene_test::id, scene_test::outside;
    scene body{tissue::water};
    const object_id outer = body.add(make_sphere({0, 0, 0}, 30_mm, 4), tissue::muscle);
    const object_id inner = body.add(make_sphere({0, 0, 0}, 10_mm, 4), tissue::bone);
    const object_id slab = body.add(scene_test::cube(60_mm, 80_mm), tissue::fat);
    body.build(exec::par);
    const std::vector<layer> layers = scene_test::along(body, {.origin = {0.1_mm, 0.2_mm, 0}});
    REQUIRE(layers.size() == 5);
    CHECK(layers[0].object == id(inner));
    CHECK(layers[1].object == id(outer));
    CHECK(layers[2].object == outside);
    CHECK(layers[3].object == id(slab));
    // On the slab's face: the face belongs to the probe, and makes no echo, to whichever side rounding puts it.
    for (const float shift : {0.0F, 0.3e-6F, -0.3e-6F})
        scene_test::check_layers(scene_test::along(body, {.origin = {1_mm, 2_mm, 60_mm + shift}}),
                                 {{id(slab), 0}, {outside, 20_mm - shift}});
}

TEST_CASE("faces that touch make one interface, also through different poses") {
    using scene_test::id, scene_test::outside;
    const pose turned = look_at({3_mm, 1_mm, 17_mm}, {40_mm, 25_mm, 60_mm}, {1, 0, 0});
    scene body{tissue::water};
    const object_id upper = body.add(scene_test::cube(10_mm, 30_mm), tissue::muscle);
    mesh below = scene_test::cube(30_mm, 50_mm);
    for (vec3& p : below.positions) p = turned.local_point(p);
    const object_id lower = body.add(below, tissue::fat, {.at = turned});
    body.build(exec::par);
    for (int i = 0; i < 200; ++i) {
        const ray line{.origin = {static_cast<float>(i) * 0.05_mm - 5_mm, 1.3_mm, 0}};
        scene_test::check_layers(scene_test::along(body, line),
                                 {{outside, 0}, {id(upper), 10_mm}, {id(lower), 30_mm}, {outside, 50_mm}});
    }
}

TEST_CASE("equal media share an index, so that no interface lies between them") {
    scene body{tissue::muscle};
    body.add(scene_test::cube(10_mm, 30_mm), tissue::muscle);
    body.add(scene_test::cube(40_mm, 50_mm), tissue::fat);
    body.build(exec::par);
    const std::vector<layer> layers = scene_test::along(body, {.origin = {1_mm, 2_mm, 0}});
    REQUIRE(layers.size() == 5);
    CHECK(layers[0].medium == layers[1].medium);
    CHECK(layers[1].medium == layers[2].medium);
    CHECK(layers[2].medium != layers[3].medium);
    CHECK(body.media().size() == 2);
}

TEST_CASE("the cosine of incidence is that between line and surface") {
    scene body{tissue::water};
    const pose tilted = look_at({0, 0, 0}, {0, std::sin(30_deg), std::cos(30_deg)}, {1, 0, 0});
    body.add(make_box({-50_mm, -50_mm, 20_mm}, {50_mm, 50_mm, 30_mm}), tissue::bone, {.at = tilted});
    body.build(exec::par);
    const std::vector<layer> layers = scene_test::along(body, {});
    REQUIRE(layers.size() == 3);
    CHECK(layers[0].cosine == 1);
    CHECK(layers[1].cosine == doctest::Approx(std::cos(30_deg)).epsilon(1e-5).scale(1e-30));
    CHECK(layers[1].begin == doctest::Approx(20_mm / std::cos(30_deg)).epsilon(1e-5).scale(1e-30));
}

TEST_CASE("more objects than a machine word has bits keep their order") {
    scene body{tissue::water};
    std::vector<scene_test::stretch> expected{{scene_test::outside, 0}};
    for (int i = 0; i < 150; ++i) { // Russian dolls
        const float border = 1_mm + 0.2_mm * static_cast<float>(i);
        const float width = 50_mm - border;
        body.add(make_box({-width, -width, border}, {width, width, 100_mm - border}), tissue::fat);
    }
    for (int i = 0; i < 150; ++i) {
        const float border = 1_mm + 0.2_mm * static_cast<float>(i);
        expected.push_back({static_cast<std::uint32_t>(i), border});
    }
    body.build(exec::par);
    const std::vector<layer> layers = scene_test::along(body, {.origin = {0.1_mm, 0.2_mm, 0}}, 50_mm);
    scene_test::check_layers(layers, expected, 50_mm);
}

TEST_CASE("an open mesh is legal: lines that miss the hole see it closed") {
    scene body{tissue::water};
    mesh open = make_sphere({0, 0, 50_mm}, 10_mm, 3);
    open.faces.pop_back();
    body.add(open, tissue::bone);
    body.add(mesh{}, tissue::fat); // an empty one as well
    body.build(exec::par);
    int closed = 0;
    for (int i = 0; i < 100; ++i)
        closed += scene_test::along(body, {.origin = {static_cast<float>(i) * 0.1_mm - 5_mm, 0.3_mm, 0}}).size() == 3;
    CHECK(closed >= 90);
}
