#include <insonify/geometry/needle.hpp>
#include <insonify/geometry/pose.hpp>
#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

using namespace insonify;

TEST_CASE("look_at is the inverse of glm::lookAt, with z pointing forwards") {
    const vec3 from{0.3F, -0.2F, 0.1F}, towards{-0.4F, 0.5F, 0.9F}, lateral{1, 0.2F, 0};
    const pose at = look_at(from, towards, lateral);
    // glm::lookAt faces -z with y up; look_at faces z with x lateral.
    const vec3 z = glm::normalize(towards - from), x = glm::normalize(lateral - glm::dot(lateral, z) * z);
    const glm::mat4 view_matrix = glm::lookAt(from, towards, glm::cross(z, x));
    const vec3 p{0.01F, 0.02F, 0.03F};
    const glm::vec4 seen = view_matrix * glm::vec4{at.point(p), 1};
    CHECK(std::fabs(seen.z) == doctest::Approx(p.z).scale(1e-30).epsilon(1e-4));
    CHECK(std::fabs(seen.y) == doctest::Approx(p.y).scale(1e-30).epsilon(1e-4));
    CHECK(std::fabs(seen.x) == doctest::Approx(p.x).scale(1e-30).epsilon(1e-4));
    CHECK(is_rigid(at));
    CHECK(length(at.direction({1, 0, 0}) - x) < 1e-6F);
    CHECK(length(at.direction({0, 0, 1}) - z) < 1e-6F);
    CHECK(length(at.direction({0, 1, 0}) - glm::cross(z, x)) < 1e-6F);
}

TEST_CASE("the usual probe pose is the identity") { CHECK(look_at({0, 0, 0}, {0, 0, 1}, {1, 0, 0}) == pose{}); }

TEST_CASE("look_at refuses a lateral direction along the line of sight, and coincident points") {
    CHECK_THROWS_AS(look_at({0, 0, 0}, {0, 0, 1}, {0, 0, 2}), geometry_error);
    CHECK_THROWS_AS(look_at({0, 0, 0}, {0, 0, 0}, {1, 0, 0}), geometry_error);
    CHECK_THROWS_AS(look_at({0, 0, 0}, {0, 0, 1}, {0, 0, 0}), geometry_error);
    CHECK_THROWS_AS(look_at({0, std::numeric_limits<float>::quiet_NaN(), 0}, {0, 0, 1}, {1, 0, 0}), geometry_error);
}

TEST_CASE("a pose and its inverse undo each other, and compose as functions do") {
    const pose a = look_at({0.1F, 0.2F, 0.3F}, {1, 1, 1}, {1, 0, 0}), b = look_at({-1, 0, 0.5F}, {0, 2, 0}, {0, 0, 1});
    const vec3 p{0.4F, -0.6F, 0.2F};
    CHECK(length(inverse(a).point(a.point(p)) - p) < 1e-6F);
    CHECK(length(a.local_point(a.point(p)) - p) < 1e-6F);
    CHECK(length(a.local_direction(a.direction(p)) - p) < 1e-6F);
    CHECK(length((a * b).point(p) - a.point(b.point(p))) < 1e-6F);
}

TEST_CASE("far from the origin local coordinates keep their precision") {
    const pose far_away{.translation = {1000, 1000, 1000}};
    CHECK(far_away.local_point({1000.25F, 1000.5F, 1000}) == vec3{0.25F, 0.5F, 0});
}

TEST_CASE("a scale, a reflection or NaN is not a rigid transform") {
    CHECK(is_rigid(pose{}));
    CHECK_FALSE(is_rigid(pose{.rotation = mat3{0.001F}}));
    CHECK_FALSE(is_rigid(pose{.rotation = mat3{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}));
    CHECK_FALSE(is_rigid(pose{.translation = {std::numeric_limits<float>::infinity(), 0, 0}}));
}

TEST_CASE("orthonormalised: products of poses stay rigid, and turn as far as the angles add up to") {
    const float step_angle = 0.001F;
    const pose step{mat3{vec3{std::cos(step_angle), std::sin(step_angle), 0},
                         vec3{-std::sin(step_angle), std::cos(step_angle), 0}, vec3{0, 0, 1}},
                    {1e-6F, 0, 0}};
    pose at, skewed;
    for (int i = 0; i < 40000; ++i) {
        at = orthonormalised(at * step);
        skewed.rotation[0] *= 1.00001F; // as rounding does, only faster
        if (i < 2000) CHECK_UNARY(is_rigid(orthonormalised(skewed)));
    }
    CHECK(is_rigid(at));
    CHECK(std::fabs(dot(at.rotation[0], at.rotation[0]) - 1) < 1e-6F);
    const float angle = std::remainder(40000 * step_angle, 2 * pi);
    CHECK(std::fabs(std::remainder(std::atan2(at.rotation[0].y, at.rotation[0].x) - angle, 2 * pi)) < 0.01F);
    // Of a symmetric stretch nothing is left.
    const pose stretched{mat3{vec3{1.01F, 0.02F, 0}, vec3{0.02F, 0.98F, 0}, vec3{0, 0, 1.02F}}, {1, 2, 3}};
    const pose found = orthonormalised(stretched);
    for (int i = 0; i < 3; ++i) CHECK(length(found.rotation[i] - mat3{1}[i]) < 1e-6F);
    CHECK(found.translation == vec3{1, 2, 3});
    CHECK_THROWS_AS(orthonormalised({mat3{2}, {}}), geometry_error);
    CHECK_THROWS_AS(orthonormalised({mat3{vec3{1, 0, 0}, vec3{0, 1, 0}, vec3{0, 0, -1}}, {}}), geometry_error);
    CHECK_THROWS_AS(orthonormalised({mat3{1}, {std::nanf(""), 0, 0}}), geometry_error);
}

TEST_CASE("needle_pose: the tip, the direction and the side of the bevel") {
    const pose at = needle_pose({1, 2, 3}, {0, 3, 4}, {0, 0, -2});
    CHECK(at.translation == vec3{1, 2, 3});
    CHECK(length(at.rotation[2] - vec3{0, 0.6F, 0.8F}) < 1e-6F);
    CHECK(length(at.rotation[0] - vec3{0, 0.8F, -0.6F}) < 1e-6F); // the bevel, across the needle
    CHECK(is_rigid(at));
    CHECK_THROWS_AS(needle_pose({}, {0, 0, 1}, {0, 0, -1}), geometry_error);
    CHECK_THROWS_AS(needle_pose({}, {0, 0, 0}, {1, 0, 0}), geometry_error);
}
