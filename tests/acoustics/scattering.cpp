#include <insonify/acoustics/scatterers/scattering.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace scattering_test {
namespace {
// A minimal field: one scatterer in the middle.
struct single {
    template <class Emit>
    void scatter(const material_line&, float begin, float end, float, Emit&& emit) const {
        const float real = 1, imaginary = 0;
        emit(scatterer_run{.first = 0.5F * (begin + end), .count = 1, .real = &real, .imaginary = &imaginary});
    }
    float covariance(float, float) const { return 1; }
};
struct no_covariance {
    void scatter(const material_line&, float, float, float, void (*)(const scatterer_run&)) const {}
};
} // namespace
static_assert(scattering_field<single> && scattering_field<no_scatterers>);
static_assert(!scattering_field<no_covariance> && !scattering_field<int>);
} // namespace scattering_test

TEST_CASE("scattering: a line in coordinates of an object has the points of the line in the world") {
    const pose at = look_at({10_mm, -5_mm, 3_mm}, {12_mm, 4_mm, 9_mm}, {0, 0, 1});
    const line_frame world{.origin = {1_mm, 2_mm, 3_mm}, .along = normalize(vec3{1, 2, -1}), .elevation = {0, 0, 1}};
    const material_line inside = in_object(world, at, 7, 5e9F);
    CHECK(inside.object == 7);
    CHECK(inside.scatterer_density == 5e9F);
    for (const float distance : {0.0F, 20_mm})
        CHECK(length(at.point(inside.at(distance)) - (world.origin + distance * world.along)) < 1e-8F);
    CHECK(length(at.direction(inside.elevation) - world.elevation) < 1e-6F);
}
