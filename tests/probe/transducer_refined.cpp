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
        CHECK(back.x == doctest::Approx(line).scale(1).epsilon(1e-4));
        CHECK(back.y == doctest::Approx(30_mm).scale(1e-30).epsilon(1e-4));
    }
}

TEST_CASE("a section of a refined probe has its lines, from the first one on") {
    const refined<linear_array> fine{linear_array{.lines = 10, .width = 40_mm}, 3};
    const refined<linear_array> all_but_ends = fine.section(2, 28), some = all_but_ends.section(3, 10);
    CHECK(all_but_ends.lines == 26);
    CHECK(some.lines == 7);
    for (const float line : {-0.5F, 0.0F, 2.25F, 6.0F}) {
        const ray found = some.beam(line), expected = fine.beam(line + 5);
        CHECK(found.origin == expected.origin);
        CHECK(found.direction == expected.direction);
        const vec3 point = found.at(20_mm);
        CHECK(some.locate({point.x, point.z}).x == doctest::Approx(line).scale(1).epsilon(1e-4));
    }
    CHECK(fine.section(0, 30) == fine);
    CHECK(some != fine.section(5, 13));
}
