#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/pulse.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace steered_test {
namespace {

static_assert(transducer<steered<linear_array>>);
static_assert(transducer<steered<refined<convex_array>>>);
static_assert(transducer<refined<steered<convex_array>>>);
static_assert(detail::comparable<steered<refined<linear_array>>>);

template <class Probe>
void check_inverse(const Probe& probe) {
    for (const float angle : {-30_deg, -10_deg, 0.0F, 4_deg, 25_deg}) {
        const steered<Probe> look{probe, angle};
        look.check();
        double worst_line = 0, worst_depth = 0;
        for (float line = is_full_circle(probe) ? 0.0F : -0.5F; line < static_cast<float>(probe.lines) - 0.4F;
             line += 7.25F)
            for (const float depth : {0.1_mm, 5_mm, 60_mm}) {
                const vec3 point = look.beam(line).at(depth);
                const vec2 found = look.locate({point.x, point.z});
                worst_line = std::max(worst_line, std::fabs(static_cast<double>(found.x - line)));
                worst_depth = std::max(worst_depth, std::fabs(static_cast<double>(found.y - depth)));
            }
        MESSAGE((angle / 1_deg), " degrees: ", worst_line, " lines, ", worst_depth * 1e6, " um");
        CHECK(worst_line < 2e-3);
        CHECK(worst_depth < 2e-7);
    }
}

} // namespace

TEST_CASE("steered: every line is turned about its origin on the face") {
    const linear_array probe{.lines = 4, .width = 40_mm};
    const steered<linear_array> look{probe, 30_deg};
    for (std::uint32_t i = 0; i < 4; ++i) {
        const ray line = look.beam(static_cast<float>(i));
        CHECK(line.origin == probe.beam(static_cast<float>(i)).origin);
        CHECK(line.direction.x == doctest::Approx(0.5).scale(1e-30));
        CHECK(line.direction.z == doctest::Approx(0.8660254).scale(1e-30));
    }
    const convex_array curved{.lines = 5, .radius = 50_mm, .field_of_view = 50_deg};
    const steered<convex_array> turned{curved, -20_deg};
    for (const float line : {-0.5F, 1.0F, 3.7F}) {
        const vec3 before = curved.beam(line).direction, after = turned.beam(line).direction;
        CHECK(dot(before, after) == doctest::Approx(std::cos(20_deg)).scale(1e-30));
        CHECK(before.z * after.x - before.x * after.z == doctest::Approx(-std::sin(20_deg)).scale(1e-30));
        CHECK(turned.beam(line).origin == curved.beam(line).origin);
    }
}

TEST_CASE("steered: locate is the inverse of beam, for every kind of probe") {
    check_inverse(linear_array{});
    check_inverse(refined{linear_array{}, 3});
    check_inverse(convex_array{.radius = 50_mm, .field_of_view = 70_deg});
    check_inverse(convex_array{.radius = 10_mm, .field_of_view = 150_deg});
    check_inverse(phased_array{});
    check_inverse(radial_array{.lines = 100, .radius = 5_mm});
}

TEST_CASE("steered: the aperture is foreshortened") {
    const steered<linear_array> look{{.width = 40_mm, .fnumber = 2}, 30_deg};
    const beam_model beam = beam_of(look, 60_mm);
    CHECK(beam.fnumber(10_mm) == doctest::Approx(2 / 0.8660254).scale(1e-30));
    CHECK(beam.aperture == doctest::Approx(40e-3 * 0.8660254).scale(1e-30));
    CHECK(line_spacing(look, 30_mm) ==
          doctest::Approx(line_spacing(linear_array{.width = 40_mm}, 30_mm) * 0.8660254).scale(1e-30));
}

TEST_CASE("steered: the next line begins further along the lines by the sine of the angle, at any depth") {
    const linear_array flat{};
    CHECK(line_advance(flat) == 0);
    CHECK(line_advance(steered{flat, 10_deg}) == doctest::Approx(38e-3 / 192 * 0.17364818).scale(1e-30));
    CHECK(line_advance(steered{flat, -10_deg}) == doctest::Approx(-38e-3 / 192 * 0.17364818).scale(1e-30));
    const convex_array curved{};
    CHECK(line_advance(curved) == 0);
    const steered look{curved, 10_deg};
    CHECK(line_advance(look) == doctest::Approx(60e-3 * 1.0471976 / 192 * 0.17364818).scale(1e-30).epsilon(1e-3));
    // The distance of a point from the wave front of the next line, by projection.
    for (const float depth : {10_mm, 80_mm}) {
        const ray one = look.beam(100), next = look.beam(101);
        const vec3 point = 0.5F * (one.at(depth) + next.at(depth));
        const float difference = dot(point - one.origin, one.direction) - dot(point - next.origin, next.direction);
        CHECK(difference == doctest::Approx(line_advance(look)).scale(1e-30).epsilon(1e-2));
    }
    CHECK(line_advance(phased_array{}) == 0);
    CHECK(line_advance(radial_array{}) == 0);
}

TEST_CASE("steered: an angle out of range is refused") {
    CHECK_THROWS_WITH_AS((steered{linear_array{}, 50_deg}.check()),
                         "steered: the angle is 50_deg; it must be from -45_deg to 45_deg", usage_error);
    CHECK_THROWS_AS((steered{linear_array{}, std::nanf("")}.check()), usage_error);
    CHECK_THROWS_AS((steered{linear_array{.lines = 0}, 0}.check()), usage_error);
}

} // namespace steered_test
