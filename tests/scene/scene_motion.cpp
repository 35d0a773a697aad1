#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include "layers_along.hpp"
#include <doctest/doctest.h>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;

namespace motion_test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();

std::vector<vec3> copy_of(const scene& body, object_id id) {
    const std::span<const vec3> now = body.positions(id);
    return {now.begin(), now.end()};
}

template <class Call>
std::string refusal_of(const Call& call) {
    try {
        call();
    } catch (const geometry_error& e) {
        return e.what();
    }
    return "it was accepted";
}

const std::string remedy =
    " was moved to a point that is not finite; all objects are back where they were before: check the "
    "simulation, or the formula, that moved it";

/// Two balls of which one is in its third frame.
struct two_balls {
    scene body{tissue::water};
    object_id still = body.add(make_sphere({0, 0, 10_mm}, 4_mm, 3), tissue::bone);
    object_id heart = body.add(make_sphere({0, 0, 30_mm}, 8_mm, 4), tissue::muscle, {.name = "heart"});
    two_balls() {
        body.build(exec::seq);
        for (int frame = 0; frame < 3; ++frame) beat();
    }
    void beat() {
        for (vec3& p : body.positions(heart)) p.z += 1_mm;
        body.update(exec::seq);
    }
};

} // namespace
} // namespace motion_test

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
    for (int frame = 0; frame < 16; ++frame) CHECK_FALSE(current(body));
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

namespace motion_test {

TEST_CASE("a frame with a vertex that is not finite is refused by `update`, and the last one stays") {
    for (const float wild : {nan, infinity, -infinity})
        for (const std::size_t vertex : {0U, 1277U, 2561U}) {
            two_balls two;
            scene& body = two.body;
            const std::vector<vec3> heart = copy_of(body, two.heart), still = copy_of(body, two.still);
            const aabb box = body.box();
            for (vec3& p : body.positions(two.still)) p.x += 1_mm; // a good part of a bad frame
            for (vec3& p : body.positions(two.heart)) p.z += 1_mm;
            body.positions(two.heart)[vertex].y = wild;
            CHECK(refusal_of([&] { body.update(exec::par); }) ==
                  "object 'heart': vertex " + std::to_string(vertex) + remedy);
            CHECK(copy_of(body, two.heart) == heart);
            CHECK(copy_of(body, two.still) == still);
            CHECK(body.box().lower == box.lower);
            CHECK(body.box().upper == box.upper);
            CHECK_FALSE(body.awaits_update(two.heart));
            CHECK_FALSE(body.awaits_update(two.still));
            const std::vector<scene_test::stretch> expected = {{scene_test::outside, 0},
                                                               {scene_test::id(two.still), 6_mm},
                                                               {scene_test::outside, 14_mm},
                                                               {scene_test::id(two.heart), 25_mm},
                                                               {scene_test::outside, 41_mm}};
            scene_test::check_layers(scene_test::along(body, {}), expected, 0.1F, 2e-3);
            body.update(exec::par); // which has nothing to follow
            scene_test::check_layers(scene_test::along(body, {}), expected, 0.1F, 2e-3);
            two.beat(); // the next good frame
            CHECK(copy_of(body, two.heart)[5].z == heart[5].z + 1_mm);
        }
}

TEST_CASE("a frame that is not finite is refused by `build`, and before the first frame, in a copy and after a "
          "removal, too") {
    two_balls two;
    scene copy = two.body;
    const std::vector<vec3> heart = copy_of(copy, two.heart);
    copy.positions(two.heart)[3] = {nan, nan, nan};
    CHECK(refusal_of([&] { copy.build(exec::par); }) == "object 'heart': vertex 3" + remedy);
    CHECK(copy_of(copy, two.heart) == heart);
    CHECK(copy.is_built());
    copy.remove(two.still);
    copy.positions(two.heart)[0].x = infinity;
    CHECK(refusal_of([&] { copy.build(exec::par); }) == "object 'heart': vertex 0" + remedy);
    CHECK(copy_of(copy, two.heart) == heart);
    copy.build(exec::par);
    copy.positions(two.heart)[0].x = infinity;
    CHECK(refusal_of([&] { copy.update(exec::par); }) == "object 'heart': vertex 0" + remedy);
    CHECK(copy_of(copy, two.heart) == heart);

    scene fresh{tissue::water};
    const mesh ball = make_sphere({0, 0, 30_mm}, 8_mm, 2);
    const object_id unnamed = fresh.add(ball, tissue::bone);
    fresh.positions(unnamed)[7].z = nan;
    CHECK(refusal_of([&] { fresh.build(exec::par); }) == "object 0: vertex 7" + remedy);
    CHECK(copy_of(fresh, unnamed) == ball.positions);
    CHECK_FALSE(fresh.is_built());
}

TEST_CASE("a frame that is refused leaves the last deformation or frame, whichever came later") {
    two_balls two;
    scene& body = two.body;
    const std::vector<vec3> rest = copy_of(body, two.heart);
    body.deform(exec::par, [](vec3 p) { return p + vec3{2_mm, 0, 0}; });
    const std::vector<vec3> deformed = copy_of(body, two.heart);
    body.positions(two.heart)[9].x = nan;
    CHECK(refusal_of([&] { body.update(exec::par); }) == "object 'heart': vertex 9" + remedy);
    CHECK(copy_of(body, two.heart) == deformed);

    body.positions(two.heart)[9].x = nan; // `deform` puts the body to rest where it throws
    CHECK(refusal_of([&] { body.deform(exec::par, [](vec3 p) { return p; }); }) == "object 'heart': vertex 9" + remedy);
    CHECK(copy_of(body, two.heart) == rest);
    scene_test::check_layers(scene_test::along(body, {}),
                             {{scene_test::outside, 0},
                              {scene_test::id(two.still), 6_mm},
                              {scene_test::outside, 14_mm},
                              {scene_test::id(two.heart), 25_mm},
                              {scene_test::outside, 41_mm}},
                             0.1F, 2e-3);
}

TEST_CASE("where a map folds over at a vertex only, trees and boxes return to rest as well") {
    scene body{tissue::water};
    const object_id ball = body.add(make_sphere({0, 0, 30_mm}, 8_mm, 3), tissue::bone);
    body.build(exec::par);
    const aabb box = body.box(ball);
    body.deform(exec::par, [](vec3 p) { return p + vec3{0, 0, 5_mm}; });
    CHECK(scene_test::along(body, {})[1].begin == doctest::Approx(27_mm).scale(1e-30).epsilon(1e-3));
    const vec3 vertex = body.rest_positions(ball)[0]; // the first to be checked
    const auto hole = [vertex](vec3 p) { return p == vertex ? vec3{nan, nan, nan} : p + vec3{0, 0, 5_mm}; };
    CHECK_THROWS_AS(body.deform(exec::par, hole), geometry_error);
    CHECK(body.box(ball).lower == box.lower);
    CHECK(scene_test::along(body, {})[1].begin == doctest::Approx(22_mm).scale(1e-30).epsilon(1e-3));
}

} // namespace motion_test
