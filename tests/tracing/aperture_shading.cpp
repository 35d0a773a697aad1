// Covers tracing/aperture/turned_line.hpp.
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include "../plain.hpp"
#include "shaded_lines.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace aperture_shading_test {
namespace {

double decibels(double ratio) { return 20 * std::log10(ratio); }

/// Width over which the amplitudes of a row of lines rise from 10 to 90 % of the last one, metres.
double rise(const std::vector<double>& row, double spacing) {
    const auto place = [&](double level) {
        std::size_t i = 0;
        while (row[i + 1] < level * row.back()) ++i;
        return static_cast<double>(i) + (level * row.back() - row[i]) / (row[i + 1] - row[i]);
    };
    return (place(0.9) - place(0.1)) * spacing;
}

} // namespace
} // namespace aperture_shading_test

TEST_CASE("the edge of a shadow widens with the distance behind an absorbing half plane") {
    using namespace aperture_shading_test;
    const scene half = sheet(-60_mm, 0, 10_mm, absorber);
    const iq_lines arrived = trace(exec::par_unseq, half, fine, pose{}, arrival_model{}, scan);
    // A sum of waves of random scatterers, F/2, 7.5 MHz: rms from 10 to 90 %.
    for (const auto& [behind, expected] : {std::pair{5U, 1.86}, {10U, 3.55}, {20U, 7.12}}) {
        std::vector<double> row;
        for (std::uint32_t i = 0; i < fine.lines; ++i)
            row.push_back(static_cast<double>(arrived(i, 10 + behind - 1).y));
        const double found = 1e3 * rise(row, 38e-3 / 768);
        MESSAGE("F/2, ", behind, " mm behind the edge: ", found, " mm, expected ", expected);
        CHECK(std::fabs(found / expected - 1) < 0.05);
    }
    // Where the edge is, half of the aperture is free: 1/4 for surfaces, 2^-1.5 for speckle.
    for (const std::uint32_t k : {14U, 19U, 29U}) {
        CHECK(std::fabs(decibels(static_cast<double>(arrived(384, k).x)) + 12.04) < 0.5);
        CHECK(std::fabs(decibels(static_cast<double>(arrived(384, k).y)) + 9.03) < 0.5);
    }
}

TEST_CASE("the shadow of a strip thinner than the aperture fills again") {
    using namespace aperture_shading_test;
    const scene strip = sheet(-0.36_mm, 0.36_mm, 10_mm, absorber);
    // The same by waves: rms at the middle, here of the lines within a millimetre of it.
    for (const std::uint32_t directions : {16U, 64U}) {
        const iq_lines arrived = trace(exec::par_unseq, strip, fine, pose{}, arrival_model{}, scan,
                                       straight_lines{.directions = directions});
        for (const auto& [behind, expected] : {std::pair{5U, -5.6}, {10U, -3.0}, {20U, -1.4}}) {
            double sum = 0;
            std::uint32_t count = 0;
            const std::uint32_t around = behind < 10 ? 4 : behind == 10 ? 8 : 16; // lines: less than the umbra's width
            for (std::uint32_t i = 384 - around; i < 384 + around; ++i, ++count)
                sum += std::pow(static_cast<double>(arrived(i, 10 + behind - 1).y), 2);
            const double found = decibels(std::sqrt(sum / count));
            MESSAGE(directions, " directions, ", behind, " mm behind the strip: ", found, " dB, expected ", expected);
            CHECK(std::fabs(found - expected) < (directions == 64 ? 0.5 : 1.7));
        }
    }
}

TEST_CASE("what plane surfaces let through is what the straight line says, at any angle and by any array") {
    using namespace aperture_shading_test;
    const medium soft{.density = 1050, .sound_speed = 1580}, hard{.density = 1900, .sound_speed = 3500};
    for (const float degrees : {0.0F, 10.0F, 20.0F, 24.0F}) {
        const float angle = degrees * 1_deg;
        scene plates{soft}; // lossless: from one side the way through a tilted plate is longer than from the other
        plates.add(make_box({-400_mm, -400_mm, -1_mm}, {400_mm, 400_mm, 2_mm}), hard,
                   {.at = look_at({0, 0, 25_mm}, {std::sin(angle), 0, 25_mm + std::cos(angle)},
                                  {std::cos(angle), 0, -std::sin(angle)})});
        plates.build(exec::par);
        const acquisition deep{.depth = 64_mm, .samples = 64, .planes = 1};
        const float linear = max_unevenness(plates, linear_array{.lines = 128, .width = 38_mm}, pose{}, deep);
        MESSAGE("bone at ", degrees, " degrees, linear array: gains of 1 within ", linear);
        CHECK(linear < 2e-3F);
    }
    scene shells{tissue::muscle}; // around the apex of a convex array
    shells.add(make_sphere({0, 0, -60_mm}, 90_mm, 7), tissue::fat);
    shells.add(make_sphere({0, 0, -60_mm}, 80_mm, 7), tissue::bone);
    shells.build(exec::par);
    const float convex = max_unevenness(
        shells, convex_array{.lines = 128, .radius = 60_mm, .field_of_view = 60_deg, .frequency = 3.5_MHz}, pose{},
        {.depth = 64_mm, .samples = 64});
    MESSAGE("shells, convex array: gains of 1 within ", convex);
    CHECK(convex < 0.03F); // the shells are polyhedra
}

TEST_CASE("behind a wire within a full circle of lines the shadow fills, to both sides alike, wherever line 0 is") {
    using namespace aperture_shading_test;
    const radial_array probe{.lines = 128, .radius = 5_mm, .frequency = 7.5_MHz};
    for (const float turn : {0.0F, 1.0F, 2.5F}) {
        scene s{body};
        const vec3 at = 10_mm * vec3{std::sin(turn), 0, std::cos(turn)}, across{0, 20_mm, 0};
        s.add(make_cylinder(at - across, at + across, 0.7_mm, 48), absorber);
        s.build(exec::par);
        const iq_lines arrived =
            trace(exec::par_unseq, s, probe, pose{}, arrival_model{}, {.depth = 32_mm, .samples = 64});
        // Of all lines, those behind the wire: the fewest arrive just behind it, more further away.
        const auto darkest = [&](std::uint32_t k) {
            float smallest = 1;
            for (std::uint32_t i = 0; i < probe.lines; ++i) smallest = std::min(smallest, arrived(i, k).y);
            return smallest;
        };
        CHECK(darkest(12) < 0.05F); // 6.5 mm from the face, 0.8 mm behind the wire
        CHECK(darkest(40) > 0.2F);
        CHECK(darkest(40) < 0.95F);
    }
}

TEST_CASE("speckle behind a needle adds up, although sound that went through it is early") {
    using namespace aperture_shading_test;
    // A wire of steel across the slice, 20 mm above: what comes past it fills the shadow, at the depth it has there.
    const linear_array probe{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz};
    scene needle{plain(tissue::muscle)}, none{plain(tissue::muscle)};
    needle.add(make_cylinder({0, -20_mm, 8_mm}, {0, 20_mm, 8_mm}, 0.4_mm, 48), tissue::steel);
    needle.build(exec::par);
    none.build(exec::par);
    double with = 0, without = 0;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        physical<> model{};
        model.scattering.seed = seed;
        for (const scene* s : {&needle, &none}) {
            iq_lines lines = trace(exec::par_unseq, *s, probe, pose{}, model, {.depth = 40_mm, .samples = 1344});
            lines = convolve(exec::par_unseq, std::move(lines), nominal_pulse(probe), probe);
            double& sum = s == &needle ? with : without;
            for (std::uint32_t i = 126; i < 130; ++i)
                for (std::uint32_t k = 940; k < 1040; ++k) sum += static_cast<double>(dot(lines(i, k), lines(i, k)));
        }
    }
    const double found = decibels(std::sqrt(with / without));
    MESSAGE("20 to 23 mm behind a needle: ", found, " dB, expected -1.4 (free aperture)");
    CHECK(std::fabs(found + 1.4) < 1);
}

TEST_CASE("a shadow is never brighter than no obstacle, whatever the bandwidth under attenuation") {
    using namespace aperture_shading_test;
    const linear_array probe{.lines = 128, .width = 38_mm, .frequency = 7.5_MHz};
    scene strip{tissue::muscle}, none{tissue::muscle};
    medium weak = tissue::muscle; // 30 dB there and back
    weak.attenuation = 30 / (2 * 0.5e-3F) / 7.5F;
    weak.attenuation_power = 1;
    strip.add(make_box({-0.3_mm, -20_mm, 9_mm}, {0.3_mm, 20_mm, 9.5_mm}), weak);
    strip.build(exec::par);
    none.build(exec::par);
    for (const pulse_bandwidth bandwidth : {pulse_bandwidth::narrow, pulse_bandwidth::broad}) {
        const arrival_model model{{.bandwidth = bandwidth}};
        const iq_lines with = trace(exec::par_unseq, strip, probe, pose{}, model, scan),
                       without = trace(exec::par_unseq, none, probe, pose{}, model, scan);
        for (const std::uint32_t k : {10U, 12U, 15U, 20U, 40U}) {
            const double speckle = decibels(static_cast<double>(with(64, k).y / without(64, k).y));
            CHECK(speckle < 0.3);
            CHECK(speckle > -12);
        }
    }
}

TEST_CASE("speckle reaches the bottom of the picture beside and behind objects of another sound speed") {
    using namespace aperture_shading_test;
    const medium gel{.density = 1000, .sound_speed = 1480, .backscatter = 1};
    medium fast = gel;
    fast.sound_speed = 1700;
    scene beside{gel};
    beside.add(make_box({-60_mm, -30_mm, 5_mm}, {0, 30_mm, 25_mm}), fast);
    beside.build(exec::par);
    fast.sound_speed = 3000;
    scene behind{tissue::muscle};
    behind.add(make_box({-1_mm, -30_mm, 16_mm}, {1_mm, 30_mm, 24_mm}), fast);
    behind.build(exec::par);
    for (const auto& [s, depth] : {std::pair{&beside, 36_mm}, {&behind, 22_mm}}) {
        const iq_lines echoes = trace(exec::par_unseq, *s, linear_array{.lines = 128}, pose{}, physical<>{},
                                      {.depth = depth, .samples = 1024});
        for (std::uint32_t line = 0; line < 128; ++line) {
            float bottom = 0;
            for (std::uint32_t k = 1000; k < 1016; ++k) bottom = std::max(bottom, length(echoes(line, k)));
            CHECK(bottom > 0);
        }
    }
}
