#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include "line_memory.hpp"
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

namespace scene_test {
namespace {

// What lies along a line, as (object, begin) pairs; the background is object ~0.
struct stretch {
    std::uint32_t object;
    float begin;
};
std::vector<layer> along(const scene& body, const ray& line, float depth = 0.1F) {
    line_memory memory;
    line_crossings found = memory.found();
    const scene_view flat = body.view_for_rays(exec::seq);
    REQUIRE(find_crossings(flat, line, depth, found));
    const view<const layer> layers =
        stack_layers(flat, {.origin = line.origin, .along = line.direction}, depth, found, view<layer>{memory.layers});
    return {layers.begin(), layers.end()};
}

void check_layers(const std::vector<layer>& layers, const std::vector<stretch>& expected, float depth = 0.1F,
                  double tolerance = 1e-5) {
    REQUIRE(layers.size() == expected.size());
    for (std::size_t i = 0; i < layers.size(); ++i) {
        CHECK(layers[i].object == expected[i].object);
        CHECK(layers[i].begin == doctest::Approx(expected[i].begin).epsilon(tolerance).scale(1e-30));
        CHECK(layers[i].end == (i + 1 < layers.size() ? layers[i + 1].begin : depth));
    }
}

constexpr std::uint32_t outside = ~0U;
std::uint32_t id(object_id object) { return static_cast<std::uint32_t>(object); }

mesh cube(float from, float to) { return make_box({-20_mm, -20_mm, from}, {20_mm, 20_mm, to}); }

} // namespace
} // namespace scene_test

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
