#include <insonify/probe/convex_array.hpp>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

namespace convex_array_test {
static_assert(transducer<convex_array>);

TEST_CASE("convex_array: the middle line leaves the origin straight down") {
    const convex_array probe{.lines = 3, .radius = 60_mm, .field_of_view = 60_deg};
    const ray beam = probe.beam(1);
    CHECK(beam.origin == vec3{0, 0, 0});
    CHECK(beam.direction == vec3{0, 0, 1});
}

TEST_CASE("convex_array: a line at 20 degrees is normal to the face") {
    const convex_array probe{.lines = 3, .radius = 60_mm, .field_of_view = 60_deg};
    const ray beam = probe.beam(2);                                      // (2.5 / 3 - 1 / 2) * 60 = 20 degrees
    CHECK(beam.direction.x == doctest::Approx(0.34202014).scale(1e-30)); // sin 20
    CHECK(beam.direction.y == 0);
    CHECK(beam.direction.z == doctest::Approx(0.93969262).scale(1e-30));               // cos 20
    CHECK(beam.origin.x == doctest::Approx(0.06 * 0.34202014).scale(1e-30));           // R sin 20
    CHECK(beam.origin.z == doctest::Approx(0.06 * (0.93969262 - 1)).scale(1e-30));     // R cos 20 - R
    const vec2 found = probe.locate({0.1F * 0.34202014F, 0.1F * 0.93969262F - 0.06F}); // 40 mm along it
    CHECK(found.x == doctest::Approx(2).scale(1e-30));
    CHECK(found.y == doctest::Approx(0.04).scale(1e-30));
}

TEST_CASE("convex_array: points behind the face have a negative depth") {
    CHECK(convex_array{}.locate({0, -5_mm}).y == doctest::Approx(-0.005).scale(1e-30));
}

TEST_CASE("convex_array: the defaults pass, a radius or field of view out of range is refused") {
    CHECK_NOTHROW(convex_array{}.check());
    CHECK_NOTHROW(convex_array{.radius = 10_mm, .field_of_view = 360_deg}.check());
    for (const float bad :
         {0.0F, -1.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_THROWS_AS((convex_array{.radius = bad}.check()), usage_error);
        CHECK_THROWS_AS((convex_array{.field_of_view = bad}.check()), usage_error);
    }
    CHECK_THROWS_AS((convex_array{.field_of_view = 60}.check()), usage_error); // degrees instead of radians
    CHECK_THROWS_AS((convex_array{.lines = 0}.check()), usage_error);
}

} // namespace convex_array_test
