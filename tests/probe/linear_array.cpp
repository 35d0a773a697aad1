#include <insonify/probe/linear_array.hpp>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

namespace linear_array_test {
static_assert(transducer<linear_array>);

TEST_CASE("linear_array: the lines are parallel, from a flat face, half a pitch inside its ends") {
    const linear_array probe{.lines = 4, .width = 40_mm, .frequency = 5_MHz};
    for (std::uint32_t i = 0; i < 4; ++i) {
        const ray beam = probe.beam(static_cast<float>(i));
        CHECK(beam.origin.x == doctest::Approx(-0.015 + 0.010 * i).scale(1e-30));
        CHECK(beam.origin.y == 0);
        CHECK(beam.origin.z == 0);
        CHECK(beam.direction == vec3{0, 0, 1});
    }
    CHECK(probe.beam(0.5F).origin.x == doctest::Approx(-0.010).scale(1e-30));
}

TEST_CASE("linear_array: locate finds the line and the depth of a point") {
    const linear_array probe{.lines = 4, .width = 40_mm};
    const vec2 found = probe.locate({5_mm, 22_mm});
    CHECK(found.x == doctest::Approx(2).scale(1e-30));
    CHECK(found.y == doctest::Approx(0.022).scale(1e-30));
    CHECK(probe.locate({20_mm, 0}).x == doctest::Approx(3.5).scale(1e-30));
    CHECK(probe.locate({30_mm, 0}).x == doctest::Approx(4.5).scale(1e-30)); // outside the field too
}

TEST_CASE("linear_array: the defaults pass, a width out of range is refused") {
    CHECK_NOTHROW(linear_array{}.check());
    for (const float bad :
         {0.0F, -38_mm, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
        CHECK_THROWS_AS((linear_array{.width = bad}.check()), usage_error);
    CHECK_THROWS_AS((linear_array{.lines = 0}.check()), usage_error);
}

} // namespace linear_array_test
