#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/queries.hpp>
#include <insonify/scene/scene.hpp>
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;

namespace deform_test {
namespace {

/// Tissue sinks below a probe, and less with depth.
struct pressed {
    float depth = 0;
    vec3 operator()(vec3 rest) const {
        const float across = std::exp(-rest.x * rest.x / (2 * 15_mm * 15_mm));
        return {rest.x, rest.y, rest.z + depth * across * std::exp(-rest.z / 20_mm)};
    }
};

float largest_difference(std::span<const vec3> a, std::span<const vec3> b) {
    float worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = max(worst, length(a[i] - b[i]));
    return worst;
}
std::vector<vec3> copy_of(std::span<const vec3> points) { return {points.begin(), points.end()}; }

template <class Call>
std::string message_of(const Call& call) {
    try {
        call();
    } catch (const geometry_error& e) {
        return e.what();
    }
    return "nothing was thrown";
}

struct body_of_two {
    scene body{tissue::muscle};
    object_id bone = body.add(make_sphere({0, 0, 30_mm}, 8_mm, 3), tissue::bone);
    object_id vessel = body.add(make_sphere({0, 0, 0}, 3_mm, 3), tissue::blood,
                                {.at = look_at({10_mm, 0, 15_mm}, {20_mm, 5_mm, 15_mm}, {0, 1, 0})});
    body_of_two() { body.build(exec::par); }
};

} // namespace
} // namespace deform_test

TEST_CASE("deform moves each vertex from rest to where the map puts it, in the world") {
    deform_test::body_of_two two;
    scene& body = two.body;
    const std::vector<vec3> rest = deform_test::copy_of(body.positions(two.vessel));
    const deform_test::pressed map{.depth = 3_mm};
    const pose at = body[two.vessel].at;
    for (int call = 0; call < 3; ++call) body.deform(exec::par, map); // calls do not add up
    float worst = 0, moved = 0;
    const scene& seen = body;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        worst = max(worst, length(at.point(seen.positions(two.vessel)[i]) - map(at.point(rest[i]))));
        moved = max(moved, length(seen.positions(two.vessel)[i] - rest[i]));
    }
    MESSAGE("vertices are within ", worst * 1e9F, " nm of the map, which moves them by up to ", moved * 1e3F, " mm");
    CHECK(worst < 1e-8F);
    CHECK(moved > 1_mm);
    // Queries see the deformed surface: the top of the bone, which was at 22 mm.
    const auto top = first_surface(body, {.origin = {0, 0, 0}}, [&](object_id id) { return id == two.bone; });
    REQUIRE(top.has_value());
    CHECK(std::fabs(top->distance - map({0, 0, 22_mm}).z) < 1e-6F);
}

TEST_CASE("deform: the identity leaves everything at rest, to the last bit") {
    deform_test::body_of_two two;
    scene& body = two.body;
    const std::vector<vec3> rest = deform_test::copy_of(std::as_const(body).positions(two.vessel));
    body.deform(exec::par, deform_test::pressed{.depth = 3_mm});
    CHECK(deform_test::largest_difference(std::as_const(body).positions(two.vessel), rest) > 1_mm);
    body.deform(exec::par, deform_test::pressed{});
    CHECK(deform_test::copy_of(std::as_const(body).positions(two.vessel)) == rest);
}

TEST_CASE("deform: only the objects that are named follow, the others return to rest") {
    deform_test::body_of_two two;
    scene& body = two.body;
    const std::vector<vec3> rest = deform_test::copy_of(std::as_const(body).positions(two.bone));
    body.deform(exec::par, deform_test::pressed{.depth = 3_mm});
    body.deform(exec::par, deform_test::pressed{.depth = 2_mm}, std::array{two.vessel});
    CHECK(deform_test::copy_of(std::as_const(body).positions(two.bone)) == rest);
    CHECK(body.rest_of({0, 0, 25_mm}, two.bone) == vec3{0, 0, 25_mm});
    for (const std::optional<object_id> follows : {std::optional{two.vessel}, std::optional<object_id>{}}) {
        const vec3 before = body.rest_of({0, 0, 15_mm}, follows); // of the vessel and of the background
        CHECK(std::fabs(deform_test::pressed{.depth = 2_mm}(before).z - 15_mm) < 1_um);
    }
    CHECK_THROWS_AS(body.deform(exec::par, deform_test::pressed{}, std::array{object_id{17}}), usage_error);
}

TEST_CASE("rest_of inverts the map") {
    deform_test::body_of_two two;
    const deform_test::pressed map{.depth = 5_mm};
    two.body.deform(exec::par, map);
    float worst = 0;
    for (float x = -20_mm; x <= 20_mm; x += 1.3_mm)
        for (float z = 0; z < 60_mm; z += 1.7_mm)
            worst = max(worst, length(two.body.rest_of(map({x, 2_mm, z}), two.bone) - vec3{x, 2_mm, z}));
    MESSAGE("error of the inverse at most ", worst * 1e6F, " um");
    CHECK(worst < 0.5_um);
}

TEST_CASE("rest_of follows an object that is placed after it was deformed") {
    deform_test::body_of_two two;
    const deform_test::pressed map{.depth = 3_mm};
    two.body.deform(exec::par, map);
    const vec3 rest = two.body.rest_of({10_mm, 0, 16_mm}, two.vessel);
    const pose moved = pose{.translation = {5_mm, -7_mm, 1_mm}};
    two.body.place(two.vessel, moved * two.body[two.vessel].at);
    CHECK(length(two.body.rest_of(moved.point({10_mm, 0, 16_mm}), two.vessel) - rest) < 1e-7F);
}

TEST_CASE("deform: a scene that is built again keeps its rest") {
    deform_test::body_of_two two;
    scene& body = two.body;
    const std::vector<vec3> rest = deform_test::copy_of(std::as_const(body).positions(two.bone));
    body.deform(exec::par, deform_test::pressed{.depth = 3_mm});
    body.add(make_sphere({20_mm, 0, 30_mm}, 2_mm, 1), tissue::fat);
    body.build(exec::par);
    scene copy = body;
    copy.deform(exec::par, deform_test::pressed{});
    CHECK(deform_test::copy_of(std::as_const(copy).positions(two.bone)) == rest);
    CHECK(deform_test::copy_of(std::as_const(body).positions(two.bone)) != rest); // a copy is deep
    CHECK(body.rest_of({0, 0, 20_mm}).z < 19.9_mm);
    CHECK(copy.rest_of({0, 0, 20_mm}) == vec3{0, 0, 20_mm});
}

TEST_CASE(
    "deform: a map that folds over, or that is not finite, is an error that names the place, and leaves all at rest") {
    deform_test::body_of_two two;
    scene& body = two.body;
    const std::vector<vec3> rest = deform_test::copy_of(std::as_const(body).positions(two.bone));
    body.deform(exec::par, deform_test::pressed{.depth = 3_mm});
    // Between z = 24 and 34 mm the lower half of the bone comes to lie above the upper one.
    const auto folding = [](vec3 p) { return p - vec3{0, 0, 20_mm / (1 + std::exp(-(p.z - 29_mm) / 1_mm))}; };
    const std::string folded = deform_test::message_of([&] { body.deform(exec::par, folding); });
    MESSAGE(folded);
    CHECK(folded.find("deform: the map folds over near (") == 0);
    CHECK(deform_test::copy_of(std::as_const(body).positions(two.bone)) == rest);
    CHECK(body.rest_of({0, 0, 25_mm}, two.bone) == vec3{0, 0, 25_mm});
    const auto hole = [](vec3 p) { return p.z > 30_mm ? vec3{INFINITY} : p; };
    const std::string infinite = deform_test::message_of([&] { body.deform(exec::par, hole); });
    MESSAGE(infinite);
    CHECK(infinite.find("deform: the map gives a point that is not finite for (") == 0);
    CHECK_THROWS_AS(scene{}.deform(exec::par, folding), usage_error);
}

TEST_CASE("deform: the same vertices on any number of threads, and for lambdas that capture") {
    deform_test::body_of_two one, other;
    float depth = 2_mm;
    const auto map = [depth](vec3 p) { return deform_test::pressed{depth}(p); };
    for (int i = 0; i < 2; ++i) one.body.deform(exec::seq, map);
    other.body.deform(exec::par.threads(5), map);
    CHECK(deform_test::copy_of(std::as_const(one.body).positions(one.bone)) ==
          deform_test::copy_of(std::as_const(other.body).positions(other.bone)));
    CHECK(one.body.rest_of({1_mm, 0, 20_mm}) == other.body.rest_of({1_mm, 0, 20_mm}));
}
