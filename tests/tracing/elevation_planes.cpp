#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/presets.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/tracing/plan/frame_plan.hpp>
#include <doctest/doctest.h>

using namespace insonify;
using detail::elevation_planes;

namespace elevation_planes_test {
namespace {

const linear_array probe{.frequency = 7.5_MHz};
constexpr float image_depth = 61_mm;

elevation_planes planes_of(const auto& any_probe, std::uint32_t count) {
    return {beam_of(any_probe, image_depth), count, image_depth, detail::lines_follow_depth(any_probe)};
}

} // namespace
} // namespace elevation_planes_test

TEST_CASE("the rms height of the planes follows the beam at every depth, weighted by power: sigma / sqrt(2)") {
    using namespace elevation_planes_test;
    const auto max_deviation = [](const auto& any_probe, std::uint32_t count) {
        const beam_model beam = beam_of(any_probe, image_depth);
        const elevation_planes planes = planes_of(any_probe, count);
        double worst = 0;
        for (float depth = 5_mm; depth <= 60_mm; depth += 0.25_mm) {
            const auto weights = planes.at(depth);
            double squares = 0, powers = 0, amplitudes = 0;
            for (std::uint32_t i = 0; i < count; ++i) {
                const double power = std::pow(static_cast<double>(weights.random[i]), 2);
                squares += power * std::pow(static_cast<double>(planes[i].height(depth)), 2);
                powers += power;
                amplitudes += static_cast<double>(weights.coherent[i]);
            }
            REQUIRE(std::fabs(powers - 1) + std::fabs(amplitudes - 1) < 0.01); // linear between depths of a table
            const double expected = static_cast<double>(beam.elevation_sigma(depth)) / std::sqrt(2.0);
            worst = std::max(worst, std::fabs(std::sqrt(squares) / expected - 1));
            if (any_probe.frequency == probe.frequency && std::fmod(depth + 1e-6F, 5_mm) < 0.1_mm)
                MESSAGE(count, " planes, ", (depth * 1e3F), " mm deep: rms ", (std::sqrt(squares) * 1e3),
                        " mm, expected ", (expected * 1e3));
        }
        return worst;
    };
    for (const std::uint32_t count : {5U, 7U}) {
        CHECK(max_deviation(probe, count) < 0.1);
        CHECK(max_deviation(presets::l11_5v, count) < 0.1);
        CHECK(max_deviation(presets::c5_2v, count) < 0.1);
        CHECK(max_deviation(presets::p4_2v, count) < 0.1);
    }
}

TEST_CASE("weights of planes are finite and continuous, where planes cross, coincide and lie far outside of the beam") {
    using namespace elevation_planes_test;
    const auto check = [](const elevation_planes& planes) {
        auto before = planes.at(0);
        for (float depth = 0.05_mm; depth < image_depth; depth += 0.05_mm) {
            const auto now = planes.at(depth);
            for (std::uint32_t i = 0; i < planes.count(); ++i) {
                REQUIRE(std::fabs(now.random[i] - before.random[i]) < 0.02F);
                REQUIRE(std::fabs(now.coherent[i] - before.coherent[i]) < 0.02F);
                if (i > 0) { // pairs
                    const std::uint32_t twin = i % 2 == 0 ? i - 1 : i + 1;
                    REQUIRE(planes[i].height(depth) == -planes[twin].height(depth));
                    REQUIRE(now.coherent[i] == doctest::Approx(now.coherent[twin]).epsilon(1e-3).scale(1e-30));
                }
            }
            before = now;
        }
    };
    for (const std::uint32_t count : {1U, 3U, 5U, 7U}) {
        check(planes_of(probe, count));
        check(planes_of(radial_array{}, count)); // parallel
        check(planes_of(linear_array{.elevation_height = 1e-6F}, count));
    }
}

TEST_CASE("a single plane is the slice plane: weights of exactly 1, and the lines of the probe bit for bit") {
    using namespace elevation_planes_test;
    const pose at = look_at({3_mm, 1_mm, 4_mm}, {10_mm, -5_mm, 9_mm}, {1, 2, 3});
    const auto check = [&](const auto& any_probe) {
        const elevation_planes planes = planes_of(any_probe, 1);
        CHECK((planes[0].offset == 0 && planes[0].slope == 0 && planes.at(20_mm).strip[0] == vec2{0, 0}));
        for (const float depth : {0.0F, 20_mm, 1.0F})
            CHECK((planes.at(depth).coherent[0] == 1 && planes.at(depth).random[0] == 1));
        const detail::probe_lines lines{any_probe};
        const detail::frame_lines frame{.lines = lines.lines(), .at = at};
        for (std::uint32_t i = 0; i < any_probe.lines; ++i) {
            const ray expected = any_probe.beam(static_cast<float>(i));
            CHECK(frame.line(i, 0).origin == at.point(expected.origin));
            CHECK(frame.line(i, 0).path() == at.direction(expected.direction));
        }
    };
    check(linear_array{.lines = 32});
    check(convex_array{.lines = 33});
    check(radial_array{.lines = 34});
}
