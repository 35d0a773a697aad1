#include <insonify/acoustics/layer.hpp>
#include <array>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("layer: the F-number of an aperture is that of the step that contains the depth") {
    const std::array<float, 3> fnumbers{1, 2, 4};
    const line_aperture aperture{.fnumbers = fnumbers, .spacing = 10_mm};
    CHECK(aperture.fnumber(0) == 1);
    CHECK(aperture.fnumber(9.9_mm) == 1);
    CHECK(aperture.fnumber(10.1_mm) == 2);
    CHECK(aperture.fnumber(25_mm) == 4);
    CHECK(aperture.fnumber(-1_mm) == 1); // outside: the nearest step
    CHECK(aperture.fnumber(1_m) == 4);
    CHECK(line_aperture{}.fnumber(10_mm) == 2);
}
