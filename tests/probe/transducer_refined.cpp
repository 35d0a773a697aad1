#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <doctest/doctest.h>

using namespace insonify;

static_assert(transducer<refined<linear_array>>);

TEST_CASE("a refined probe covers the same field of view with more lines") {
    const convex_array probe{.lines = 10, .radius = 50_mm, .field_of_view = 60_deg};
    const refined<convex_array> fine{probe, 4};
    const convex_array expected{.lines = 40, .radius = 50_mm, .field_of_view = 60_deg};
    CHECK(fine.lines == 40);
    CHECK(fine.frequency == probe.frequency);
    fine.check();
    for (const float line : {-0.5F, 0.0F, 7.3F, 39.0F, 39.5F}) {
        CHECK(length(fine.beam(line).origin - expected.beam(line).origin) < 1e-6F);
        CHECK(length(fine.beam(line).direction - expected.beam(line).direction) < 1e-6F);
        const vec3 point = fine.beam(line).at(30_mm);
        const vec2 back = fine.locate({point.x, point.z});
        CHECK(back.x == doctest::Approx(line).epsilon(1e-4));
        CHECK(back.y == doctest::Approx(30_mm).epsilon(1e-4));
    }
}
