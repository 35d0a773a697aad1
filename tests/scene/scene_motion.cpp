#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include "layers_along.hpp"
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("placing moves an object rigidly, at once; moving vertices takes an update") {
    using scene_test::id, scene_test::outside;
    scene body{tissue::water};
    const object_id box = body.add(scene_test::cube(10_mm, 20_mm), tissue::bone);
    body.build(exec::par);
    body.place(box, {.translation = {0, 0, 30_mm}});
    scene_test::check_layers(scene_test::along(body, {}), {{outside, 0}, {id(box), 40_mm}, {outside, 50_mm}});
    body.place(box, {.translation = {0, 0, 5_mm}}); // replaces the former pose
    scene_test::check_layers(scene_test::along(body, {}), {{outside, 0}, {id(box), 15_mm}, {outside, 25_mm}});
    for (vec3& p : body.positions(box)) p.z += 1_mm; // object coordinates
    body.update(exec::par);
    scene_test::check_layers(scene_test::along(body, {}), {{outside, 0}, {id(box), 16_mm}, {outside, 26_mm}});
    CHECK(std::as_const(body).positions(box)[0].z == doctest::Approx(body[box].surface.positions[0].z).scale(1e-30));
}

TEST_CASE("trees follow vertices that moved, however far, as soon as rays are traced") {
    scene body{tissue::water};
    const object_id moving = body.add(make_sphere({0, 0, 0}, 10_mm, 4), tissue::bone);
    const object_id resting = body.add(make_sphere({50_mm, 0, 0}, 10_mm, 4), tissue::bone);
    body.build(exec::par);
    const aabb before = body.box(resting);
    std::span<vec3> now = body.positions(moving);
    for (vec3& p : now) p.z += 30_mm;
    body.update(exec::par);
    CHECK(body.box(resting).lower == before.lower);
    CHECK(body.box(moving).upper.z == doctest::Approx(40_mm).epsilon(1e-4).scale(1e-30));
    std::size_t current = 0;
    for (const object_view& one : body.view_for_slices(exec::par).objects) current += one.tree_is_current;
    CHECK(current == 1);
    for (const object_view& one : body.view_for_rays(exec::par).objects) CHECK(one.tree_is_current);
    scene_test::check_layers(scene_test::along(body, {.origin = {1_mm, 2_mm, 0}}),
                             {{scene_test::outside, 0},
                              {scene_test::id(moving), 30_mm - std::sqrt(95.0F) * 1_mm},
                              {scene_test::outside, 30_mm + std::sqrt(95.0F) * 1_mm}},
                             0.1F, 2e-3);
}

TEST_CASE("an object at rest for some updates, or sliced a few times, gets its tree back") {
    const auto current = [](const scene& body) { return body.view_for_slices(exec::seq).objects[0].tree_is_current; };
    scene body{tissue::water};
    const object_id ball = body.add(make_sphere({0, 0, 0}, 10_mm, 3), tissue::bone);
    body.build(exec::seq);
    body.positions(ball)[0].x += 1_mm;
    body.update(exec::seq);
    CHECK_FALSE(current(body));
    body.update(exec::seq);
    body.update(exec::seq);
    CHECK(current(body));
    body.positions(ball)[0].x += 1_mm;
    body.update(exec::seq);
    for (int frame = 0; frame < 3; ++frame) CHECK_FALSE(current(body));
    CHECK(current(body));
}

TEST_CASE("many threads may bring a scene's trees up to date at once") {
    scene body{tissue::water};
    for (int i = 0; i < 20; ++i) body.add(make_sphere({static_cast<float>(i) * 5_mm, 0, 30_mm}, 2_mm, 3), tissue::bone);
    body.build(exec::par);
    for (int round = 0; round < 20; ++round) {
        for (const object& one : body.objects())
            for (vec3& p : body.positions(one.id)) p.z += 0.1_mm;
        body.update(exec::par);
        const scene& shared = body;
        std::vector<std::uint8_t> all(8);
        for_each_index(exec::par.threads(8), all.size(), [&](std::size_t i) {
            const scene_view flat = i % 2 == 0 ? shared.view_for_rays(exec::seq) : shared.view_for_slices(exec::par);
            bool trees = true;
            for (const object_view& one : flat.objects) trees = trees && one.tree_is_current;
            all[i] = (trees || i % 2 == 1) && flat.objects.size() == 20;
        });
        for (const std::uint8_t one : all) REQUIRE(one == 1);
    }
}
