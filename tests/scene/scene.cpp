#include <insonify/acoustics/tissue.hpp>
#include <insonify/scene/queries.hpp>
#include <insonify/scene/scene.hpp>
#include "layers_along.hpp"
#include <doctest/doctest.h>
#include <limits>
#include <utility>

using namespace insonify;

TEST_CASE("set_medium takes effect at once, before and after build") {
    scene body{tissue::water};
    const object_id box = body.add(scene_test::cube(10_mm, 20_mm), tissue::bone);
    body.set_medium(box, tissue::fat);
    body.build(exec::par);
    CHECK(body.media()[scene_test::along(body, {})[1].medium] == tissue::fat);
    body.set_medium(box, tissue::liver);
    CHECK(body.media().size() == 2);
    CHECK(body.media()[scene_test::along(body, {})[1].medium] == tissue::liver);
    CHECK(body[box].inside == tissue::liver);
    CHECK_THROWS_AS(body.set_medium(box, medium{.density = 0}), usage_error);
    CHECK_THROWS_AS(body.set_medium(object_id{7}, tissue::fat), usage_error);
    CHECK(body[box].inside == tissue::liver);
}

TEST_CASE("a copy of a scene is deep: it lives on when the original has gone or moved") {
    scene copy{tissue::water};
    {
        scene original{tissue::water};
        const object_id box = original.add(scene_test::cube(10_mm, 20_mm), tissue::bone);
        original.build(exec::par);
        copy = original;
        for (vec3& p : original.positions(box)) p.z += 40_mm;
        original.update(exec::par);
    }
    scene_test::check_layers(scene_test::along(copy, {}),
                             {{scene_test::outside, 0}, {0, 10_mm}, {scene_test::outside, 20_mm}});
    const scene moved = std::move(copy);
    CHECK(scene_test::along(moved, {}).size() == 3);
}

TEST_CASE("objects are found by name") {
    scene body{tissue::water};
    body.add(scene_test::cube(10_mm, 20_mm), tissue::bone, {.name = "rib"});
    const object_id vein = body.add(scene_test::cube(10_mm, 20_mm), tissue::blood, {.name = "vein"});
    CHECK(body.find("vein") == vein);
    CHECK_FALSE(body.find("artery"));
}

TEST_CASE("removed objects are gone, and ids are never used again") {
    scene body{tissue::water};
    const object_id first = body.add(scene_test::cube(10_mm, 20_mm), tissue::bone);
    const object_id second = body.add(scene_test::cube(30_mm, 40_mm), tissue::fat);
    body.remove(first);
    const object_id third = body.add(scene_test::cube(50_mm, 60_mm), tissue::muscle);
    CHECK(third != first);
    CHECK(third != second);
    body.build(exec::par);
    CHECK(scene_test::along(body, {}).size() == 5);
    CHECK_THROWS_AS(body.positions(first), usage_error);
    CHECK_THROWS_AS(body.place(first, pose{}), usage_error);
    CHECK_THROWS_AS(body.remove(first), usage_error);
    CHECK(body.objects().size() == 2);
}

TEST_CASE("a scene that was not built since the last add or remove cannot be used, an empty one can") {
    scene body{tissue::water};
    CHECK_THROWS_AS(body.require_built(), usage_error);
    body.build(exec::seq);
    body.require_built();
    body.update(exec::seq);
    scene_test::check_layers(scene_test::along(body, {}), {{scene_test::outside, 0}});
    const object_id box = body.add(scene_test::cube(10_mm, 20_mm), tissue::bone);
    CHECK_THROWS_AS(body.require_built(), usage_error);
    CHECK_THROWS_AS(body.update(exec::seq), usage_error);
    body.build(exec::seq);
    body.remove(box);
    CHECK_THROWS_AS(body.require_built(), usage_error);
    const scene built = scene{tissue::fat}.build(exec::par);
    built.require_built();
}

TEST_CASE("a scene that was moved from is empty and asks for build") {
    scene body{tissue::fat};
    body.add(make_sphere({0, 0, 0}, 1_cm, 2), tissue::bone);
    body.build(exec::seq);
    const scene other = std::move(body);
    CHECK(other.is_built());
    CHECK(body.objects().empty()); // NOLINT(bugprone-use-after-move)
    CHECK_THROWS_AS(first_surface(body, {{0, 0, -1}, {0, 0, 1}}), usage_error);
    body.add(make_sphere({0, 0, 0}, 2_cm, 2), tissue::bone);
    body.build(exec::seq);
    CHECK(first_surface(body, {{0, 0, -1}, {0, 0, 1}}));
}

TEST_CASE("bad meshes, media and poses are refused with a sentence") {
    scene body{tissue::water};
    mesh wild = scene_test::cube(0, 1);
    wild.positions[3].y = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH_AS(body.add(wild, tissue::fat, {.name = "lump"}),
                         "object 'lump': vertex 3 is not finite; repair the mesh (`validate` reports more)",
                         geometry_error);
    mesh astray = scene_test::cube(0, 1);
    astray.faces[2].y = 99;
    CHECK_THROWS_AS(body.add(astray, tissue::fat), geometry_error);
    CHECK_THROWS_AS(body.add(scene_test::cube(0, 1), medium{.density = -1}), usage_error);
    CHECK_THROWS_AS(body.add(scene_test::cube(0, 1), tissue::fat, {.at = {.rotation = mat3{2}}}), geometry_error);
    CHECK_THROWS_AS(scene{medium{.sound_speed = 0}}, usage_error);
    CHECK(body.objects().empty()); // nothing was taken over
    const object_id fine = body.add(scene_test::cube(0, 1), tissue::fat);
    CHECK_THROWS_AS(body.place(fine, {.rotation = mat3{0.5F}}), geometry_error);
}
