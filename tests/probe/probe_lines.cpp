#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/probe_lines.hpp>
#include <insonify/probe/radial_array.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace probe_lines_test {
namespace {

// What `transducer` requires, and no more.
struct pencil {
    std::uint32_t lines = 3;
    float frequency = 5_MHz;

    ray beam(float line) const { return {.origin = {line * 2_mm, 0, 0}, .direction = {0, 0, 1}}; }
    vec2 locate(vec2 point) const { return {point.x / 2_mm, point.y}; }
    void check() const {}
};

} // namespace
} // namespace probe_lines_test

TEST_CASE("probe_lines: the lines of any probe, bit for bit, also steered and refined") {
    const auto check = [](const auto& probe) {
        const detail::probe_lines data{probe};
        REQUIRE(data.size() == probe.lines);
        REQUIRE(data.lines().size() == probe.lines);
        for (std::uint32_t i = 0; i < probe.lines; ++i) {
            const ray beam = probe.beam(static_cast<float>(i));
            CHECK((data[i].origin == beam.origin && data[i].direction == beam.direction));
            if constexpr (requires { probe.scatterer_axis(0.0F); })
                CHECK(data[i].scatterer_axis == probe.scatterer_axis(static_cast<float>(i)));
            else
                CHECK(data[i].scatterer_axis == beam.direction);
        }
        CHECK(data.settings().frequency == probe.frequency);
        CHECK(data.settings().full_circle == is_full_circle(probe));
    };
    check(linear_array{});
    check(convex_array{.lines = 33});
    check(phased_array{.lines = 64});
    check(radial_array{.lines = 90});
    check(probe_lines_test::pencil{});
    check(steered{refined{convex_array{}, 1.7F}, 15_deg});
}

TEST_CASE("probe_settings: what a probe states, and the documented values of what it lacks") {
    const detail::probe_settings stated{linear_array{.fnumber = 3, .focus = 17_mm, .elevation_height = 7_mm}};
    CHECK((stated.fnumber == 3 && stated.focus == 17_mm && stated.elevation_height == 7_mm));
    CHECK(stated.aperture == linear_array{}.aperture());
    const detail::probe_settings lacking{probe_lines_test::pencil{}};
    CHECK((lacking.fnumber == 2 && lacking.focus == 0 && lacking.elevation_height == 5_mm));
    CHECK((lacking.elevation_focus == 20_mm && lacking.side_lobes == 0 && lacking.aperture == FLT_MAX));
    CHECK(lacking.bandwidth == fractional_bandwidth(probe_lines_test::pencil{}));
    CHECK(lacking.spacing(30_mm) == doctest::Approx(2e-3).scale(1e-30));
    CHECK(lacking.advance() == 0);
}

TEST_CASE("probe_lines: equal for equal probes; settings out of range are errors") {
    CHECK(detail::probe_lines{linear_array{}} == detail::probe_lines{linear_array{}});
    CHECK_FALSE(detail::probe_lines{linear_array{}} == detail::probe_lines{linear_array{.lines = 191}});
    CHECK_FALSE(detail::probe_lines{linear_array{}} == detail::probe_lines{linear_array{.elevation_focus = 21_mm}});
    CHECK_FALSE(detail::probe_lines{linear_array{}} == detail::probe_lines{steered{linear_array{}, 1_deg}});
    CHECK_THROWS_AS(detail::probe_lines{linear_array{.lines = 0}}, usage_error);
    CHECK_THROWS_WITH_AS(detail::probe_lines{linear_array{.lines = 1U << 25U}},
                         "probe: lines is 33554432; at most 2^24 can be traced", usage_error);
    CHECK_THROWS_AS(detail::probe_settings{linear_array{.fnumber = 0}}, usage_error);
}
