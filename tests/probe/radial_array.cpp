#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

static_assert(transducer<radial_array>);

TEST_CASE("radial_array: lines run outwards from the face on all sides") {
    const radial_array probe{.lines = 8, .radius = 1_mm};
    const double pi_d = std::acos(-1.0);
    for (int i = 0; i < 8; ++i) {
        const double angle = ((i + 0.5) / 8 - 0.5) * 2 * pi_d;
        const ray beam = probe.beam(static_cast<float>(i));
        CHECK(beam.direction.x == doctest::Approx(std::sin(angle)).scale(1e-30));
        CHECK(beam.direction.y == 0);
        CHECK(beam.direction.z == doctest::Approx(std::cos(angle)).scale(1e-30));
        CHECK(length(beam.origin - 1_mm * beam.direction) < 1e-9F);
    }
    const vec3 ahead = probe.beam(3.5F).at(4_mm);
    CHECK(length(ahead - vec3{0, 0, 5_mm}) < 1e-7F);
}

TEST_CASE("radial_array: locate is the inverse of beam, all around") {
    const radial_array probe{.lines = 64, .radius = 0.7_mm};
    for (float line = -0.45F; line < 63.5F; line += 0.37F)
        for (const float depth : {0.0F, 0.1_mm, 8_mm}) {
            const vec3 point = probe.beam(line).at(depth);
            const vec2 back = probe.locate({point.x, point.z});
            REQUIRE(std::fabs(back.x - line) < 1e-3F);
            REQUIRE(std::fabs(back.y - depth) < 1e-7F);
        }
    CHECK(probe.locate({0, 0}).y == -0.7_mm); // on the axis, behind the face
}

TEST_CASE("radial_array: its field of view is a full circle, as is that of a convex array of 360 degrees") {
    CHECK(is_full_circle(radial_array{}));
    CHECK(is_full_circle(refined<radial_array>{radial_array{}, 3}));
    CHECK(is_full_circle(convex_array{.field_of_view = 360_deg}));
    CHECK_FALSE(is_full_circle(convex_array{.field_of_view = 359_deg}));
    CHECK_FALSE(is_full_circle(radial_array{.lines = 1}));
}

TEST_CASE("radial_array: a setting out of range is refused") {
    CHECK_NOTHROW(radial_array{}.check());
    CHECK_THROWS_AS(radial_array{.lines = 0}.check(), usage_error);
    for (const float bad : {0.0F, -1.0F, std::numeric_limits<float>::infinity()}) {
        CHECK_THROWS_AS(radial_array{.radius = bad}.check(), usage_error);
        CHECK_THROWS_AS(radial_array{.bandwidth = bad}.check(), usage_error);
    }
}
