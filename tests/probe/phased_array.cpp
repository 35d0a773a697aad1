#include <insonify/probe/phased_array.hpp>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

namespace phased_array_test {
static_assert(transducer<phased_array>);

TEST_CASE("phased_array: every line starts at the centre of the face, steered in equal steps") {
    const phased_array probe{.lines = 3, .field_of_view = 90_deg};
    for (std::uint32_t i = 0; i < 3; ++i) CHECK(probe.beam(static_cast<float>(i)).origin == vec3{0, 0, 0});
    CHECK(probe.beam(1).direction == vec3{0, 0, 1});
    CHECK(probe.beam(0).direction.x == doctest::Approx(-0.5).scale(1e-30)); // -30 degrees
    CHECK(probe.beam(0).direction.z == doctest::Approx(0.86602540).scale(1e-30));
    CHECK(probe.beam(2.5F).direction.x == doctest::Approx(0.70710678).scale(1e-30)); // the end of the field
}

TEST_CASE("phased_array: locate finds the line and the distance from the face") {
    const phased_array probe{.lines = 3, .field_of_view = 90_deg};
    const vec2 found = probe.locate({-30_mm, 51.961524_mm}); // 60 mm at -30 degrees
    CHECK(found.x == doctest::Approx(0).scale(1).epsilon(1e-5));
    CHECK(found.y == doctest::Approx(0.06).scale(1e-30));
    CHECK(probe.locate({0, 0}).y == 0);
}

TEST_CASE("phased_array: the defaults pass, a width or field of view out of range is refused") {
    CHECK_NOTHROW(phased_array{}.check());
    CHECK_NOTHROW(phased_array{.field_of_view = 180_deg}.check());
    for (const float bad :
         {0.0F, -1.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_THROWS_AS((phased_array{.width = bad}.check()), usage_error);
        CHECK_THROWS_AS((phased_array{.field_of_view = bad}.check()), usage_error);
    }
    CHECK_THROWS_AS((phased_array{.field_of_view = 90}.check()), usage_error); // degrees instead of radians
    CHECK_THROWS_AS((phased_array{.lines = 0}.check()), usage_error);
}

} // namespace phased_array_test
