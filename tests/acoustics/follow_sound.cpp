#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/core/units.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace narrow_obstacle_test {
namespace {

/// A layer between the upper and the lower half of an ellipse, met at height 0.
/// @param along   semi-axis along the line, metres
/// @param across  semi-axis out of the slice plane, metres
/// @param middle  height of its centre, metres
double ellipse(double along, double across, double middle, double strip) {
    const double chord = std::sqrt(1 - middle * middle / (across * across)), depth = 20e-3;
    const double steepness = along / across * middle / across / chord,
                 curvature = along / (across * across * chord * chord * chord);
    const layer above{.begin = static_cast<float>(depth - along * chord),
                      .end = static_cast<float>(depth + along * chord),
                      .slope = {0, static_cast<float>(steepness)},
                      .curvature = {0, static_cast<float>(curvature), 0}};
    const layer behind{.slope = {0, static_cast<float>(-steepness)},
                       .curvature = {0, static_cast<float>(-curvature), 0}};
    return static_cast<double>(detail::power_beside(above, behind, static_cast<float>(strip)));
}

} // namespace

TEST_CASE("power_beside: what lies outside of an ellipse, wherever it is met") {
    for (const double along : {0.2e-3, 0.5e-3, 2e-3})
        for (const double across : {0.2e-3, 0.5e-3})
            for (const double strip : {0.3e-3, 1e-3})
                for (const double part : {-0.9, -0.5, 0.0, 0.3, 0.8}) {
                    const double middle = part * across, upper = (across + middle) / strip,
                                 lower = (across - middle) / strip;
                    const double expected = 0.5 * (std::erfc(upper) + std::erfc(lower));
                    CHECK(ellipse(along, across, middle, strip) ==
                          doctest::Approx(expected).scale(1e-30).epsilon(2e-4));
                }
}

TEST_CASE("power_beside: nothing beside facets, tubes, wide obstacles and where a line stands for itself alone") {
    const layer facets{.begin = 10_mm, .end = 10.5_mm}, wall{.begin = 10_mm, .end = 10.1_mm, .curvature = {0, 2000, 0}};
    CHECK(detail::power_beside(facets, layer{}, 1_mm) == 0);
    CHECK(detail::power_beside(wall, layer{.curvature = {0, 2500, 0}}, 1_mm) == 0); // both surfaces curve alike
    CHECK(ellipse(5e-3, 5e-3, 0, 0.5e-3) < 1e-6);
    CHECK(ellipse(0.2e-3, 0.2e-3, 0, 0) == 0);
}

} // namespace narrow_obstacle_test
