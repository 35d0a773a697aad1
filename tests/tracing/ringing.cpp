#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <utility>

#include "echoes.hpp"

using namespace insonify;

namespace ringing_test {
namespace {

using echoes_test::echo, echoes_test::echoes_of;

constexpr linear_array one_line{.lines = 1, .width = 1_mm, .frequency = 5_MHz};
constexpr acquisition scan{.depth = 24_mm, .samples = 2400};
constexpr medium tissue_of_v20{.density = 1075, .sound_speed = 1580};

medium polished_steel() {
    medium steel = tissue::steel;
    steel.attenuation = 0;
    steel.roughness = 0;
    return steel;
}
scene slab_in(const medium& around, const medium& inside, float thickness, float wedge = 0) {
    scene body{around};
    mesh slab = make_box({-60_mm, -60_mm, 20_mm}, {60_mm, 60_mm, 20_mm + thickness});
    for (vec3& p : slab.positions)
        if (p.z > 20_mm) p.z += wedge * p.x;
    body.add(std::move(slab), inside);
    return std::move(body).build(exec::par);
}
std::vector<echo> straight(const scene& body, const physical<>& model = {}) {
    return echoes_of(trace(exec::par, body, one_line, pose{}, model, scan), 0);
}

} // namespace
} // namespace ringing_test

TEST_CASE("straight lines: a metal needle rings at its thickness and its loss a bounce, as paths do") { // V20
    using namespace ringing_test;
    const scene body = slab_in(tissue_of_v20, polished_steel(), 0.718_mm);
    const auto found = straight(body);
    const auto followed =
        echoes_of(trace(exec::par, body, one_line, pose{}, physical<>{}, scan, paths{{.bounces = 12}}), 0);
    REQUIRE(found.size() > 12);
    REQUIRE(followed.size() > 8);
    MESSAGE("V20, straight lines: first internal echo ", found[1].decibels() - found[0].decibels(),
            " dB re top (expected -17.13), then ", found[2].decibels() - found[1].decibels(),
            " dB an echo (expected -1.302), spacing ", (found[2].depth - found[1].depth) * 1e3, " mm (expected 0.193)");
    CHECK(std::fabs(found[1].decibels() - found[0].decibels() + 17.13) < 0.05);
    for (std::size_t i = 1; i < 9; ++i) {
        CHECK(std::fabs(found[i].depth - found[i - 1].depth - 0.1926e-3) < 5e-6); // half a sample
        if (i > 1) CHECK(std::fabs(found[i].decibels() - found[i - 1].decibels() + 1.302) < 0.05);
        CHECK(std::fabs(found[i].depth - followed[i].depth) < 1e-6);
        CHECK(std::fabs(found[i].decibels() - followed[i].decibels()) < 0.05);
    }
}

TEST_CASE("straight lines: the water in a needle rings, a ladder of its own") { // V20
    using namespace ringing_test;
    medium water = tissue::water;
    water.attenuation = 0;
    const auto found = echoes_of(trace(exec::par, slab_in(polished_steel(), water, 0.413_mm), one_line, pose{},
                                       physical<>{}, {.depth = 12_mm, .samples = 1200}),
                                 0);
    REQUIRE(found.size() > 6);
    MESSAGE("V20, lumen: ", found[2].decibels() - found[1].decibels(), " dB a bounce (expected -1.134), spacing ",
            (found[2].depth - found[1].depth) * 1e3, " mm (expected 0.429)");
    for (std::size_t i = 2; i < 6; ++i) {
        CHECK(std::fabs(found[i].depth - found[i - 1].depth - 0.4292e-3) < 5e-6);
        CHECK(std::fabs(found[i].decibels() - found[i - 1].decibels() + 1.134) < 0.05);
    }
}

TEST_CASE("layers that are soft, thick or told not to ring keep their two echoes") {
    using namespace ringing_test;
    CHECK(straight(slab_in(tissue_of_v20, medium{.density = 950, .sound_speed = 1450}, 0.7_mm)).size() == 2);
    CHECK(straight(slab_in(tissue_of_v20, medium{.density = 1910, .sound_speed = 3500}, 0.7_mm)).size() == 2);
    CHECK(straight(slab_in(tissue_of_v20, polished_steel(), 12_mm)).size() == 2); // 3.2 mm as displayed
    CHECK(straight(slab_in(tissue_of_v20, polished_steel(), 0.7_mm), physical<>{.min_ringing = 1}).size() == 2);
    CHECK_THROWS_AS(physical<>{.min_ringing = 0}.check(), usage_error);
}

TEST_CASE("a wedge of steel rings less than a slab of the same thickness") {
    using namespace ringing_test;
    double former = 0;
    for (const float wedge : {0.0F, 0.03F, 0.1F}) {
        const auto found = straight(slab_in(tissue_of_v20, polished_steel(), 0.718_mm, wedge));
        REQUIRE(found.size() > 2);
        const double fall = found[2].decibels() - found[1].decibels();
        MESSAGE("surfaces at ", wedge, " radians: ", fall, " dB from one to the next");
        if (wedge > 0) CHECK(fall < former - 0.1);
        former = fall;
    }
}

TEST_CASE("below a flat needle stand its reverberations, and its shadow beside them stays") {
    using namespace ringing_test;
    medium silent = tissue::muscle;
    const auto picture = [&](float ringing, float backscatter) {
        silent.backscatter = backscatter;
        scene body{silent};
        mesh shaft = make_cylinder({-30_mm, 0, 15_mm}, {30_mm, 0, 15_mm}, 0.359_mm, 48);
        body.add(std::move(shaft), tissue::steel);
        body.build(exec::par);
        const linear_array probe{.lines = 128};
        const iq_lines lines = trace(exec::par_unseq, body, probe, pose{}, physical<>{.min_ringing = ringing},
                                     {.depth = 40_mm, .planes = 5});
        return envelope(exec::par_unseq, convolve(exec::par_unseq, lines, pulse{}, probe));
    };
    const auto rms = [](const scan_lines& lines, float from, float to) {
        double sum = 0, count = 0;
        for (std::uint32_t i = 32; i < 96; ++i)
            for (std::uint32_t k = 0; k < lines.samples; ++k) {
                const float depth = (static_cast<float>(k) + 0.5F) * lines.depth / static_cast<float>(lines.samples);
                if (depth < from || depth > to) continue;
                sum += static_cast<double>(lines(i, k)) * static_cast<double>(lines(i, k));
                ++count;
            }
        return 10 * std::log10(sum / count);
    };
    const double rings = rms(picture(0.5F, 0), 15.2_mm, 17_mm), single = rms(picture(1, 0), 15.2_mm, 17_mm);
    MESSAGE("0.5 to 2.5 mm below the needle, without speckle: ", rings, " dB with reverberation, ", single, " without");
    CHECK(rings > single + 3);
    const double shadow = rms(picture(0.5F, 1), 22_mm, 30_mm), before = rms(picture(1, 1), 22_mm, 30_mm);
    MESSAGE("7 to 15 mm below it, in muscle: ", shadow, " dB, ", before, " without reverberation");
    CHECK(std::fabs(shadow - before) < 0.5);
}

TEST_CASE("the reverberations of a tilted needle are as far below it on every line") {
    using namespace ringing_test;
    const linear_array fine{.lines = 192, .width = 38_mm, .frequency = 9_MHz};
    for (const auto& [gauge, tilt] : {std::pair{22U, 5_deg}, {22U, 12_deg}, {18U, 9_deg}, {14U, 7_deg}}) {
        scene body{tissue_of_v20};
        const vec3 direction{std::cos(tilt), 0, std::sin(tilt)}, tip = vec3{0, 0, 18_mm} + 30_mm * direction;
        body.add(make_needle(needle_diameter(gauge), 80_mm), polished_steel(),
                 {.at = look_at(tip, tip + direction, {std::sin(tilt), 0, -std::cos(tilt)}), .crease_angle = 12_deg});
        body.build(exec::par);
        const iq_lines seen =
            convolve(exec::par, trace(exec::par, body, fine, pose{}, physical{}, scan), nominal_pulse(fine), fine);
        double smallest = 1e30, largest = 0;
        for (std::uint32_t line = 70; line < 120; ++line) { // 1 to 2 mm below its axis
            const float needle = 18_mm + fine.beam(static_cast<float>(line)).origin.x * std::tan(tilt);
            double power = 0;
            for (std::uint32_t k = 0; k < seen.samples; ++k) {
                const float below = (static_cast<float>(k) + 0.5F) * 10_um - needle * 1540 / 1580;
                if (below > 1_mm && below < 2_mm) power += static_cast<double>(dot(seen(line, k), seen(line, k)));
            }
            smallest = std::fmin(smallest, power);
            largest = std::fmax(largest, power);
        }
        MESSAGE(gauge, " gauge at ", tilt / 1_deg, " degrees: lines differ by ", 10 * std::log10(largest / smallest),
                " dB, expected less than 3");
        CHECK(10 * std::log10(largest / smallest) < 3);
    }
}

TEST_CASE("a needle that crosses the slice at a small angle rings along its whole length") {
    using namespace ringing_test;
    const linear_array probe{.lines = 128, .width = 38_mm, .frequency = 7.5_MHz};
    for (const std::uint32_t planes : {3U, 5U}) {
        scene body{tissue_of_v20};
        const float aside = 0.5_deg; // 0.26 mm from one side of the slice to the other
        const vec3 along{std::cos(aside), std::sin(aside), 0}, middle{0, 0, 15_mm};
        body.add(make_cylinder(middle - 40_mm * along, middle + 40_mm * along, 0.6_mm, 64), polished_steel(),
                 {.crease_angle = 30_deg});
        body.build(exec::par);
        const iq_lines seen = convolve(exec::par_unseq,
                                       trace(exec::par_unseq, body, probe, pose{}, physical{},
                                             {.depth = 24_mm, .samples = 2400, .planes = planes}),
                                       nominal_pulse(probe), probe);
        double smallest = 1e30, largest = 0;
        for (std::uint32_t line = 14; line < 114; ++line) { // 1 to 4 mm below it
            double power = 0;
            for (std::uint32_t k = 1520; k < 1820; ++k) power += static_cast<double>(dot(seen(line, k), seen(line, k)));
            smallest = std::fmin(smallest, power);
            largest = std::fmax(largest, power);
        }
        MESSAGE(planes, " planes: lines differ by ", 10 * std::log10(largest / smallest), " dB, expected less than 6");
        CHECK(10 * std::log10(largest / smallest) < 6);
    }
}
