#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/scene/queries.hpp>
#include "brute_force.hpp"
#include <atomic>
#include <doctest/doctest.h>
#include <limits>
#include <map>
#include <thread>

using namespace insonify;

namespace queries_test {
namespace {

using brute_force::random_point, brute_force::vec;

const auto every_object = [](object_id) { return true; };

// Compares at random points. Within 2 um of a surface rounding may put a point on either side.
int compare_at_points(const scene& body, std::uint64_t seed, std::uint64_t count) {
    int inside = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const vec3 p = 0.035F * random_point(seed, i);
        bool in_doubt = false;
        for (const object& one : body.objects()) in_doubt = in_doubt || brute_force::distance(one, vec{p}) < 2e-6;
        if (in_doubt) continue;
        CAPTURE(seed);
        CAPTURE(i);
        const object* expected = brute_force::object_at(body, vec{p});
        const std::optional<object_id> found = object_at(body, p);
        REQUIRE(found.has_value() == (expected != nullptr));
        if (expected != nullptr) REQUIRE(*found == expected->id);
        REQUIRE(medium_at(body, p) == (expected != nullptr ? expected->inside : body.background()));
        inside += expected != nullptr;
    }
    return inside;
}

struct answer {
    std::optional<object_id> inside{};
    float first = 0, nearest = 0;
    bool operator==(const answer& other) const {
        return inside == other.inside && first == other.first && nearest == other.nearest;
    }
};

void compare_along_ray(const scene& body, const ray& r, const auto& accepts) {
    const auto expected = brute_force::crossings(body, r, accepts);
    const std::optional<surface_point> found = first_surface(body, r, accepts);
    const double metres = glm::length(vec{r.direction});
    // A crossing within 2 um of either end of the ray may be left out, or taken in.
    for (const auto& one : expected)
        for (const float end : {r.min_distance, r.max_distance})
            if (std::fabs(one.distance - static_cast<double>(end)) * metres < 2e-6) return;
    REQUIRE(found.has_value() == !expected.empty());
    if (!found) return;
    CHECK(std::fabs(static_cast<double>(found->distance) - expected[0].distance) * metres < 2e-7);
    const bool alone = expected.size() == 1 || (expected[1].distance - expected[0].distance) * metres > 1e-6;
    if (alone) {
        CHECK(found->object == expected[0].object);
        CHECK(found->face == expected[0].face);
    }
    const brute_force::corners face = brute_force::face_of(body[found->object], found->face);
    CHECK(glm::length(vec{found->point} - (vec{r.origin} + expected[0].distance * vec{r.direction})) < 2e-7);
    CHECK(glm::length(vec{found->normal} - face.normal()) < 1e-4);
}

void compare_nearest(const scene& body, object_id id, vec3 p) {
    const object& one = body[id];
    const double expected = brute_force::distance(one, vec{p});
    const std::optional<surface_point> found = nearest_surface(body, id, p);
    REQUIRE(found);
    CHECK(found->object == id);
    CHECK(std::fabs(static_cast<double>(found->distance) - expected) < 1e-7 + 1e-5 * expected);
    const brute_force::corners face = brute_force::face_of(one, found->face);
    CHECK(brute_force::distance(face, vec{found->point}) < 1e-7);
    CHECK(std::fabs(glm::length(vec{p} - vec{found->point}) - expected) < 2e-7 + 1e-5 * expected);
    if (glm::length(glm::cross(face.b - face.a, face.c - face.a)) > 1e-8)
        CHECK(glm::length(vec{found->normal} - face.normal()) < 1e-3);
}

} // namespace
} // namespace queries_test

TEST_CASE("object_at and medium_at agree with parity in double precision, in random scenes that overlap and nest") {
    constexpr std::uint64_t first_seed = 41;
    MESSAGE("first seed ", first_seed);
    int inside = 0;
    for (std::uint64_t seed = first_seed; seed < first_seed + 6; ++seed)
        inside += queries_test::compare_at_points(brute_force::random_scene(seed), seed, 300);
    CHECK(inside > 400); // of 1800
    CHECK(inside < 1700);
}

TEST_CASE("a nested object gives the medium by its smaller volume, unless the outer one has the higher priority") {
    for (const int outer_priority : {-1, 0, 1}) {
        scene body{medium{.density = 1}};
        const object_id outer =
            body.add(make_sphere({0, 0, 0}, 20_mm, 3), medium{.density = 2}, {.priority = outer_priority});
        const object_id inner = body.add(make_sphere({0, 0, 0}, 10_mm, 3), medium{.density = 3});
        body.build(exec::seq);
        CHECK(object_at(body, {0, 0, 5_mm}) == (outer_priority > 0 ? outer : inner));
        CHECK(medium_at(body, {0, 0, 5_mm}).density == (outer_priority > 0 ? 2 : 3));
        CHECK(object_at(body, {0, 0, 15_mm}) == outer);
        CHECK(medium_at(body, {0, 0, 15_mm}).density == 2);
        CHECK_FALSE(object_at(body, {0, 0, 25_mm}).has_value());
        CHECK(medium_at(body, {0, 0, 25_mm}).density == 1);
    }
}

TEST_CASE("of equal objects in one place the one added last gives the medium") {
    scene body{medium{}};
    body.add(make_box({-1_mm, -1_mm, -1_mm}, {1_mm, 1_mm, 1_mm}), medium{.density = 2});
    const object_id last = body.add(make_box({-1_mm, -1_mm, -1_mm}, {1_mm, 1_mm, 1_mm}), medium{.density = 3});
    body.build(exec::seq);
    CHECK(object_at(body, {0.3_mm, 0.2_mm, 0.1_mm}) == last);
}

TEST_CASE("queries follow objects that are placed, deformed or given another medium") {
    scene body = brute_force::random_scene(77);
    const std::vector<object> objects = body.objects();
    for (std::uint64_t frame = 0; frame < 3; ++frame) {
        for (std::size_t i = 0; i < objects.size(); ++i) {
            const std::uint64_t own = hash_bits(frame, i);
            if (i % 2 == 0) {
                const vec3 at = 0.02F * brute_force::random_point(own, 0);
                body.place(objects[i].id, look_at(at, at + brute_force::random_point(own, 1), {0.3F, 0.4F, 0.5F}));
            }
            if (i % 3 == 0) {
                const float shear = hash_uniform(own, 9) - 0.5F; // precedence is by the volumes as built: they stay
                for (vec3& p : body.positions(objects[i].id)) p.x += shear * p.y;
            }
        }
        body.update(exec::par);
        body.set_medium(objects[4].id, medium{.density = 2000 + static_cast<float>(frame)});
        CHECK(queries_test::compare_at_points(body, 100 + frame, 200) > 40);
        for (std::uint64_t i = 0; i < 50; ++i) {
            const ray r{.origin = 0.05F * brute_force::random_point(frame, 2 * i),
                        .direction = normalize(brute_force::random_point(frame, 2 * i + 1))};
            queries_test::compare_along_ray(body, r, queries_test::every_object);
            queries_test::compare_nearest(body, objects[i % objects.size()].id, r.origin);
        }
    }
}

TEST_CASE("first_surface agrees with all triangles in double precision, for rays of any length from in- and outside") {
    constexpr std::uint64_t seed = 5;
    MESSAGE("seed ", seed);
    int found = 0;
    for (std::uint64_t one = 0; one < 3; ++one) {
        const scene body = brute_force::random_scene(seed + one);
        for (std::uint64_t i = 0; i < 200; ++i) {
            CAPTURE(one);
            CAPTURE(i);
            ray r{.origin = 0.04F * brute_force::random_point(one, 2 * i),
                  .direction = brute_force::random_point(one, 2 * i + 1)};
            queries_test::compare_along_ray(body, r, queries_test::every_object);
            const auto odd = [](object_id id) { return static_cast<std::uint32_t>(id) % 2 == 1; };
            queries_test::compare_along_ray(body, r, odd);
            r.min_distance = 0.05F * hash_uniform(one, 7000 + i);
            r.max_distance = r.min_distance + 0.05F * hash_uniform(one, 9000 + i);
            queries_test::compare_along_ray(body, r, queries_test::every_object);
            found += first_surface(body, r).has_value();
        }
    }
    CHECK(found > 50); // of 600
    CHECK(found < 550);
}

TEST_CASE("from inside, the first surface is the one on the way out, and its normal points outwards") {
    scene body{medium{}};
    const object_id ball = body.add(make_sphere({0, 0, 0}, 10_mm, 4), medium{});
    body.build(exec::seq);
    const auto out = first_surface(body, {.origin = {0, 0, 2_mm}, .direction = {0, 0, 2}});
    REQUIRE(out);
    CHECK(out->object == ball);
    CHECK(out->distance ==
          doctest::Approx(4e-3).epsilon(0.01).scale(1e-30)); // 8 mm in units of a direction of length 2
    CHECK(out->normal.z > 0.99F);
    const auto in = first_surface(body, {.origin = {0, 0, -30_mm}});
    REQUIRE(in);
    CHECK(in->distance == doctest::Approx(20e-3).epsilon(0.01).scale(1e-30));
    CHECK(in->normal.z < -0.99F);
    CHECK_FALSE(first_surface(body, {.origin = {0, 0, -30_mm}, .max_distance = 19_mm}));
    CHECK_FALSE(first_surface(body, {.origin = {0, 0, -30_mm}, .direction = {0, 0, -1}}));
    CHECK_FALSE(first_surface(body, {.origin = {0, 0, -30_mm}}, [&](object_id id) { return id != ball; }));
}

TEST_CASE("of surfaces at one distance the first is that of the object that has precedence, in whatever order added") {
    constexpr std::uint32_t count = 30; // the very same box, so that no rounding tells them apart
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        scene body{medium{}};
        object_id highest{};
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t priority = (7 * i + 11 * seed) % count; // each once
            const object_id id = body.add(make_box({-5_mm, -5_mm, -5_mm}, {5_mm, 5_mm, 5_mm}), medium{},
                                          {.priority = static_cast<int>(priority)});
            if (priority == count - 1) highest = id;
        }
        body.build(exec::seq);
        for (const vec3 along : {vec3{1, 0, 0}, vec3{0, -1, 0}, vec3{0, 0, 1}}) {
            const auto found =
                first_surface(body, {.origin = -15_mm * along + vec3{0.3_mm, 0.1_mm, 0.2_mm}, .direction = along});
            REQUIRE(found);
            CHECK(found->object == highest);
        }
    }
}

TEST_CASE("nearest_surface agrees with all triangles in double precision, on rough, placed and degenerate meshes") {
    constexpr std::uint64_t seed = 8;
    MESSAGE("seed ", seed);
    scene body{medium{}};
    mesh rough = make_sphere({0, 0, 0}, 15_mm, 3);
    for (std::size_t i = 0; i < rough.positions.size(); ++i) rough.positions[i] *= 0.7F + 0.6F * hash_uniform(seed, i);
    mesh soup;
    for (std::uint32_t i = 0; i < 300; ++i) {
        const vec3 a = 0.02F * queries_test::random_point(seed, 3000 + 3 * i);
        const vec3 b = a + 5_mm * queries_test::random_point(seed, 3001 + 3 * i);
        const vec3 c = a + 5_mm * queries_test::random_point(seed, 3002 + 3 * i);
        const vec3 third = i % 10 == 0   ? 0.5F * (a + b)
                           : i % 10 == 1 ? a
                                         : c; // without area: a segment, a doubled corner
        soup.positions.insert(soup.positions.end(), {a, i % 10 == 2 ? a : b, i % 10 == 2 ? a : third});
        soup.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const object_id ids[] = {body.add(rough, medium{}),
                             body.add(rough, medium{}, {.at = look_at({40_mm, 5_mm, -9_mm}, {0, 1, 2}, {3, 1, 0})}),
                             body.add(soup, medium{}),
                             body.add(make_box({-1_mm, -2_mm, -3_mm}, {1_mm, 2_mm, 3_mm}), medium{})};
    body.build(exec::par);
    for (const object_id id : ids)
        for (std::uint64_t i = 0; i < 300; ++i) {
            CAPTURE(static_cast<std::uint32_t>(id));
            CAPTURE(i);
            queries_test::compare_nearest(body, id, 0.05F * queries_test::random_point(seed + 1, i));
        }
    CHECK(nearest_surface(body, ids[3], {0, 0, 0})->distance == doctest::Approx(1e-3).scale(1e-30));
    CHECK(nearest_surface(body, ids[3], {0, 0, 13_mm})->point == vec3{0, 0, 3_mm});
    CHECK(nearest_surface(body, ids[3], {4_mm, 0, 7_mm})->distance ==
          doctest::Approx(5e-3).scale(1e-30)); // 3 and 4 mm off an edge
}

TEST_CASE("an object without faces has no nearest surface, contains nothing and is hit by no ray") {
    scene body{medium{}};
    const object_id nothing = body.add(mesh{}, medium{.density = 3});
    body.build(exec::seq);
    CHECK_FALSE(nearest_surface(body, nothing, {0, 0, 0}));
    CHECK_FALSE(object_at(body, {0, 0, 0}));
    CHECK_FALSE(first_surface(body, {}));
    CHECK(medium_at(body, {0, 0, 0}) == medium{});
    const scene empty = scene{medium{}}.build(exec::seq);
    CHECK_FALSE(object_at(empty, {0, 0, 0}));
    CHECK_FALSE(first_surface(empty, {}));
}

TEST_CASE("queries refuse points that are not finite, unknown ids and scenes that were not built") {
    scene body{medium{}};
    const object_id ball = body.add(make_sphere({0, 0, 0}, 10_mm, 2), medium{});
    CHECK_THROWS_AS(object_at(body, {0, 0, 0}), usage_error);
    CHECK_THROWS_AS(medium_at(body, {0, 0, 0}), usage_error);
    CHECK_THROWS_AS(first_surface(body, {}), usage_error);
    CHECK_THROWS_AS(nearest_surface(body, ball, {0, 0, 0}), usage_error);
    body.build(exec::seq);
    for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        CHECK_THROWS_AS(object_at(body, {wrong, 0, 0}), usage_error);
        CHECK_THROWS_AS(medium_at(body, {0, wrong, 0}), usage_error);
        CHECK_THROWS_AS(nearest_surface(body, ball, {0, 0, wrong}), usage_error);
    }
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    for (const ray& wrong :
         {ray{.origin = {nan, 0, 0}}, ray{.origin = {0, 0, -infinity}}, ray{.direction = {nan, 0, 1}},
          ray{.direction = {0, infinity, 1}}, ray{.direction = {0, 0, 0}}, ray{.direction = {0, 1e-31F, 0}},
          ray{.min_distance = nan}, ray{.max_distance = nan}})
        CHECK_THROWS_WITH_AS(
            first_surface(body, wrong),
            "first_surface: the ray needs a finite origin, a finite direction that is not 0, and limits "
            "that are not NaN",
            usage_error);
    CHECK(first_surface(body, {.origin = {0, 0, -20_mm}, .direction = {0, 0, 1e-29F}})); // short, but a direction
    CHECK(first_surface(body, {.origin = {0, 0, -20_mm}, .max_distance = infinity}));
    CHECK_THROWS_WITH_AS(body.rest_of({0, nan, 0}), "rest_of: the point is not finite; give three numbers of metres",
                         usage_error);
    CHECK_THROWS_AS(nearest_surface(body, object_id{17}, {0, 0, 0}), usage_error);
    body.remove(ball);
    body.build(exec::seq);
    CHECK_THROWS_AS(nearest_surface(body, ball, {0, 0, 0}), usage_error);
}

#if !defined(__EMSCRIPTEN__) || defined(__EMSCRIPTEN_PTHREADS__) // threads of the test's own
TEST_CASE("snapshots answer as the scene of their frame did, while it moves on") {
    const mesh rest = make_sphere({0, 0, 0}, 10_mm, 3);
    scene body{tissue::fat};
    const object_id ball = body.add(rest, tissue::muscle),
                    tool = body.add(make_sphere({0, 0, 0}, 1_mm, 2), tissue::steel);
    body.add(make_sphere({0, 30_mm, 0}, 5_mm, 2), tissue::bone); // does not move
    body.build(exec::par);
    const auto move_to = [&](std::uint64_t frame) {
        const float fraction = 0.02F * static_cast<float>(frame);
        std::span<vec3> now = body.positions(ball);
        for (std::size_t i = 0; i < now.size(); ++i) now[i] = (1 + fraction) * rest.positions[i];
        body.place(tool, {.translation = {0, fraction * 10_mm, -40_mm}});
        body.update(exec::seq);
    };
    const auto asked = [&](const scene& of) {
        const auto first = first_surface(of, {.origin = {1_mm, 2_mm, -30_mm}});
        return queries_test::answer{object_at(of, {0, 0, 11_mm}), first ? first->distance : -1,
                                    nearest_surface(of, tool, {3_mm, 0, 0})->distance};
    };
    constexpr std::uint64_t frames = 40;
    std::map<std::uint64_t, queries_test::answer> expected;
    for (std::uint64_t frame = 0; frame <= frames; ++frame) {
        move_to(frame);
        const scene frozen = body;
        expected.emplace(frame, asked(frozen));
    }
    move_to(0);
    scene_snapshots snapshots{body};
    std::atomic<bool> done{false};
    std::atomic<int> wrong{0}, answers{0};
    const auto read = [&] {
        std::uint64_t last = 0;
        scene_snapshots::handle held = snapshots.newest();
        for (int i = 0; last < frames; ++i) {
            if (i % 3 == 0) held = snapshots.newest(); // else that frame again
            wrong += !(asked(held->body) == expected.at(held->frame)) || held->frame < last;
            last = held->frame;
            ++answers;
        }
    };
    std::thread haptics{read}, refits{[&] {
        while (!done)
            if (!snapshots.publish(exec::seq)) std::this_thread::yield();
    }};
    for (std::uint64_t frame = 1; frame <= frames; ++frame) {
        move_to(frame);
        while (!snapshots.take(exec::seq, body, frame)) std::this_thread::yield();
    }
    haptics.join();
    done = true;
    refits.join();
    CHECK(wrong == 0);
    CHECK(answers > 0);
    CHECK(snapshots.newest()->frame == frames);
    CHECK(!(expected[0] == expected[frames]));
}
#endif

TEST_CASE("snapshots refuse another scene, and a frame while the one before waits") {
    scene body;
    const object_id ball = body.add(make_sphere({0, 0, 0}, 10_mm, 2), tissue::muscle);
    CHECK_THROWS_AS(scene_snapshots{body}, usage_error);
    body.build(exec::seq);
    scene_snapshots snapshots{body, 7};
    CHECK(snapshots.newest()->frame == 7);
    CHECK(!snapshots.publish(exec::seq));
    CHECK(snapshots.take(exec::seq, body, 8));
    CHECK(!snapshots.take(exec::seq, body, 9));
    CHECK(snapshots.newest()->frame == 7);
    CHECK(snapshots.publish(exec::seq));
    const auto held = snapshots.newest();
    CHECK(held->frame == 8);
    body.positions(ball)[3].x = std::numeric_limits<float>::infinity();
    CHECK_THROWS_AS(snapshots.take(exec::seq, body, 9), geometry_error);
    CHECK(!snapshots.publish(exec::seq));
    body.add(make_sphere({0, 0, 0}, 5_mm, 2), tissue::fat);
    CHECK_THROWS_WITH_AS(
        snapshots.take(exec::seq, body, 9),
        "scene_snapshots: the scene has other objects than when the snapshots were made; make new ones "
        "after add or remove",
        usage_error);
}

TEST_CASE("many threads may query a scene at once, straight after its objects have moved") {
    constexpr std::size_t count = 400;
    for (std::uint64_t round = 0; round < 10; ++round) {
        scene body = brute_force::random_scene(round);
        for (const object& one : body.objects())
            for (vec3& p : body.positions(one.id)) p *= 1.2F;
        body.update(exec::seq);
        const scene copy = body;
        const auto ask = [](const scene& of, std::size_t i) {
            const vec3 p = 0.045F * queries_test::random_point(9, i);
            const auto first = first_surface(of, {.origin = p, .direction = normalize(-p)});
            return queries_test::answer{object_at(of, p), first ? first->distance : -1,
                                        nearest_surface(of, of.objects()[i % 9].id, p)->distance};
        };
        std::vector<queries_test::answer> found(count);
        for_each_index(exec::par.threads(8), count, [&](std::size_t i) { found[i] = ask(body, i); });
        for (std::size_t i = 0; i < count; ++i) REQUIRE(found[i] == ask(copy, i));
    }
}
