#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "echoes.hpp"

using namespace insonify;

namespace paths_test {
namespace {

using echoes_test::echo, echoes_test::echoes_of;

mesh slab(float from, float to) { return make_box({-60_mm, -60_mm, from}, {60_mm, 60_mm, to}); }
constexpr linear_array one_line{.lines = 1, .width = 1_mm, .frequency = 5_MHz};

} // namespace
} // namespace paths_test

TEST_CASE("paths and beams agree where nothing bends and nothing is reflected twice") {
    scene body{medium{.density = 1000, .sound_speed = 1540, .attenuation = 50, .backscatter = 0.5F}};
    body.add(make_sphere({0, 0, 20_mm}, 5_mm, 4),
             medium{.density = 1300, .sound_speed = 1540, .attenuation = 100, .backscatter = 0.7F});
    body.add(make_sphere({-8_mm, 0, 15_mm}, 3_mm, 4), medium{.density = 900, .sound_speed = 1540, .roughness = 20_um});
    body.build(exec::par);
    const linear_array probe{.lines = 96};
    const acquisition scan{.depth = 40_mm, .samples = 1600, .planes = 3};
    const straight_lines alone{.search = line_search::rays, .directions = 1};
    const iq_lines beams = trace(exec::par, body, probe, pose{}, physical<>{}, scan, alone);
    const iq_lines followed = trace(exec::par, body, probe, pose{}, physical<>{}, scan, paths{{.bounces = 0}});
    float largest = 0, worst = 0;
    for (std::size_t i = 0; i < beams.values.size(); ++i) {
        largest = std::max(largest, length(beams.values[i]));
        worst = std::max(worst, length(beams.values[i] - followed.values[i]));
    }
    MESSAGE("largest echo ", largest, ", largest difference ", worst);
    CHECK(largest > 1e-2F);
    // Depths of 40 mm in floats are good to some 1e-8 m: 6e-4 radians of phase at 7.5 MHz.
    CHECK(worst < 1e-3F * largest);
}

TEST_CASE("paths and beams agree on a probe that stands on a surface, above it or in it, and inside nested objects") {
    for (const float shift : {-5_mm, -0.3_um, 0.0F, 0.3_um, 1_mm}) {
        scene body{medium{.density = 1000, .sound_speed = 1540}};
        body.add(paths_test::slab(shift, 30_mm), medium{.density = 1200, .sound_speed = 1540, .attenuation = 50});
        body.add(make_sphere({0, 0, 4_mm}, 9_mm, 4), medium{.density = 1100, .sound_speed = 1540, .attenuation = 80});
        body.build(exec::par);
        const acquisition scan{.depth = 40_mm, .samples = 1600};
        const iq_lines beams = trace(exec::par, body, linear_array{.lines = 32}, pose{}, physical<>{}, scan,
                                     straight_lines{.search = line_search::rays, .directions = 1});
        const iq_lines followed =
            trace(exec::par, body, linear_array{.lines = 32}, pose{}, physical<>{}, scan, paths{{.bounces = 0}});
        float largest = 0, worst = 0;
        for (std::size_t i = 0; i < beams.values.size(); ++i) {
            largest = std::max(largest, length(beams.values[i]));
            worst = std::max(worst, length(beams.values[i] - followed.values[i]));
        }
        CHECK(largest > 1e-3F);
        CHECK(worst < 1e-3F * largest);
    }
}

TEST_CASE("water in water has no echo along any path") {
    scene body{tissue::water};
    body.add(make_sphere({1_mm, 0, 20_mm}, 8_mm, 4), tissue::water);
    body.build(exec::par);
    for (const vec2 v : trace(exec::par, body, linear_array{.lines = 32}, pose{}, physical<>{},
                              {.depth = 40_mm, .samples = 1600}, paths{})
                            .values)
        CHECK(v == vec2{0, 0});
}

TEST_CASE("a metal needle rings: a ladder of echoes, at its thickness and its loss a bounce") { // V20
    // Z 1.698 MRayl against steel: r = 0.9278; 0.718 mm of 5740 m/s are 0.1926 mm as displayed.
    medium steel = tissue::steel;
    steel.attenuation = 0;
    steel.roughness = 0;
    scene body{medium{.density = 1075, .sound_speed = 1580}};
    body.add(paths_test::slab(20_mm, 20.718_mm), steel);
    body.build(exec::par);
    const acquisition scan{.depth = 24_mm, .samples = 2400};
    const auto found = paths_test::echoes_of(
        trace(exec::par, body, paths_test::one_line, pose{}, physical<>{}, scan, paths{{.bounces = 12}}), 0);
    REQUIRE(found.size() > 8);
    MESSAGE("V20: first internal echo ", found[1].decibels() - found[0].decibels(),
            " dB re top (expected -17.13), then ", found[2].decibels() - found[1].decibels(),
            " dB an echo (expected -1.302), spacing ", (found[2].depth - found[1].depth) * 1e3, " mm (expected 0.193)");
    CHECK(std::fabs(found[0].amplitude - 0.9278) < 1e-3);
    CHECK(std::fabs(found[1].decibels() - found[0].decibels() + 17.13) < 0.05);
    for (std::size_t i = 1; i < found.size() && i < 9; ++i) {
        CHECK(std::fabs(found[i].depth - found[i - 1].depth - 0.1926e-3) < 5e-6); // half a sample
        if (i > 1) CHECK(std::fabs(found[i].decibels() - found[i - 1].decibels() + 1.302) < 0.05);
    }
}

TEST_CASE("the water in a needle rings: a ladder of its own") { // V20
    // Z 1.479 MRayl against 45.3: r = 0.9368, twice a bounce; 0.413 mm of 1482 m/s are 0.429 mm as displayed.
    medium steel = tissue::steel, water = tissue::water;
    steel.attenuation = water.attenuation = 0;
    steel.roughness = 0;
    scene body{steel};
    body.add(paths_test::slab(20_mm, 20.413_mm), water);
    body.build(exec::par);
    const acquisition scan{.depth = 12_mm, .samples = 1200}; // 20 mm of steel are 5.4 mm as displayed
    const auto found = paths_test::echoes_of(
        trace(exec::par, body, paths_test::one_line, pose{}, physical<>{}, scan, paths{{.bounces = 12}}), 0);
    REQUIRE(found.size() > 6);
    MESSAGE("V20, lumen: ", found[2].decibels() - found[1].decibels(), " dB a bounce (expected -1.134), spacing ",
            (found[2].depth - found[1].depth) * 1e3, " mm (expected 0.429)");
    for (std::size_t i = 1; i < 6; ++i) {
        CHECK(std::fabs(found[i].depth - found[i - 1].depth - 0.4292e-3) < 5e-6); // half a sample
        if (i > 1) CHECK(std::fabs(found[i].decibels() - found[i - 1].decibels() + 1.134) < 0.05);
    }
}

TEST_CASE("a plate and the probe's face reverberate at n z with (r_plate r_face)^n") { // V20
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.add(paths_test::slab(10_mm, 90_mm), medium{.density = 2000, .sound_speed = 1540}); // r = 1/3
    body.build(exec::par);
    const acquisition scan{.depth = 49_mm, .samples = 4890};
    const auto found = paths_test::echoes_of(trace(exec::par, body, paths_test::one_line, pose{}, physical<>{}, scan,
                                                   paths{{.bounces = 10, .face_reflection = 0.5F}}),
                                             0);
    REQUIRE(found.size() == 4);
    double expected = 1.0 / 3;
    for (std::size_t n = 0; n < found.size(); ++n, expected *= 0.5 / 3) {
        CHECK(found[n].amplitude == doctest::Approx(expected).epsilon(1e-3).scale(1e-30));
        CHECK(std::fabs(found[n].depth - 10e-3 * static_cast<double>(n + 1)) < 5e-6);
    }
}

TEST_CASE("a target below a tilted plane is seen where refraction puts it") { // V5
    // Fat above, muscle below a plane tilted by 20 degrees; a small ball 40 mm below it along the normal of the probe.
    // The beam that meets the plane under the ball's undeviated place misses it; one 1.259 mm aside hits it.
    scene body{tissue::fat};
    medium muscle = tissue::muscle;
    muscle.backscatter = 0;
    muscle.roughness = 0;
    const float tilt = 20_deg;
    const pose tilted =
        look_at({0, 0, 20_mm}, {std::sin(tilt), 0, 20_mm + std::cos(tilt)}, {std::cos(tilt), 0, -std::sin(tilt)});
    body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 100_mm}), muscle, {.at = tilted});
    const float deep = 60_mm;
    body.add(make_sphere({0, 0, deep}, 0.3_mm, 3), tissue::air, {.priority = 1});
    body.build(exec::par);
    const linear_array probe{.lines = 401, .width = 20.05_mm, .frequency = 5_MHz}; // 50 um apart
    struct by_cosine {
        float operator()(float angle, float, float) const { return std::cos(angle); }
    };
    const auto model = physical<>{}.with_specular(by_cosine{}).with_scattering(no_scatterers{});
    const iq_lines lines =
        trace(exec::par, body, probe, pose{}, model, {.depth = 66_mm, .samples = 3300}, paths{{.bounces = 0}});
    double sum = 0, moment = 0;
    for (std::uint32_t i = 0; i < lines.count; ++i) {
        double energy = 0;
        for (std::uint32_t k = 2900; k < lines.samples; ++k)
            energy += static_cast<double>(dot(lines(i, k), lines(i, k)));
        const double x = (static_cast<double>(i) - 200) * 50e-6;
        sum += energy;
        moment += energy * x;
    }
    REQUIRE(sum > 0);
    MESSAGE("V5: image of the target shifted by ", std::fabs(moment / sum) * 1e3, " mm");
    // The shift that the geometry of this scene gives: the ray bends by 1.802 degrees at the plane.
    double expected = 0;
    for (int step = 0; step < 100; ++step) { // x where a beam meets the plane, so that it ends at x = 0, z = 60 mm
        const double z = 20e-3 + 0 - expected * std::tan(static_cast<double>(tilt)) * -1;
        expected = (60e-3 - z) * std::tan(1.8022 * 3.14159265 / 180);
    }
    CHECK(std::fabs(std::fabs(moment / sum) - expected) < 50e-6);
    CHECK(40e-3 * std::tan(1.8022 * 3.14159265 / 180) ==
          doctest::Approx(1.2586e-3).epsilon(1e-3).scale(1e-30)); // as published
}

TEST_CASE("behind a mirror stands the image of what is before it") {
    // An air wall at 45 degrees turns the beam sideways onto a small target: seen below the wall, at the path's length.
    scene body{tissue::water};
    const pose turned = look_at({0, 0, 20_mm}, {1, 0, 1 + 20_mm}, {1, 0, -1});
    body.add(make_box({-20_mm, -20_mm, 0}, {20_mm, 20_mm, 30_mm}), tissue::air, {.at = turned});
    body.add(make_sphere({-10_mm, 0, 20_mm}, 1_mm, 5), medium{.density = 1910, .sound_speed = 3500});
    body.build(exec::par);
    const float scale = 1540.0F / 1482;
    const linear_array probe{.lines = 41, .width = 4.1_mm, .frequency = 5_MHz};
    const iq_lines lines =
        trace(exec::par, body, probe, pose{}, physical<>{}, {.depth = 40_mm, .samples = 2000}, paths{{.bounces = 2}});
    const auto found = paths_test::echoes_of(lines, 20);
    bool seen = false;
    for (const auto& e : found)
        seen = seen || (std::fabs(e.depth - static_cast<double>(29_mm * scale)) < 40e-6 && e.amplitude > 0.05);
    CHECK(seen); // 20 mm down and 9 mm across, to the ball's near side
    for (const auto& e :
         paths_test::echoes_of(trace(exec::par, body, probe, pose{}, physical<>{}, {.depth = 40_mm, .samples = 2000},
                                     straight_lines{line_search::rays}),
                               20))
        CHECK(std::fabs(e.depth - static_cast<double>(29_mm * scale)) > 40e-6);
}

TEST_CASE("behind a curved mirror stands one image, not one of each line") {
    // A thin rough plate, whose image on the sides of a tube of gas is steep: there the paths of neighbouring lines meet it
    // far apart.
    const medium around{.density = 1050, .sound_speed = 1540, .attenuation = 0.1_dB_per_cm};
    scene body{around};
    body.add(paths_test::slab(6_mm, 6.5_mm),
             medium{.density = 950, .sound_speed = 1540, .attenuation = 0.1_dB_per_cm, .roughness = 60_um});
    body.add(make_tube({{{0, -40_mm, 26_mm}, vec2{10_mm}}, {{0, 40_mm, 26_mm}, vec2{10_mm}}}, {.segments = 256}),
             tissue::air);
    body.build(exec::par);
    const acquisition scan{.depth = 36_mm, .samples = 1440, .planes = 1};
    const auto image_of = [&](std::uint32_t lines) { // mean power by depth of eight plates, from 2 mm below its top on
        const linear_array probe{.lines = lines, .width = 20_mm, .frequency = 9_MHz};
        std::vector<double> power(200);
        for (std::uint32_t seed = 0; seed < 8; ++seed) {
            physical<> model{};
            model.seed = seed;
            const iq_lines seen =
                convolve(exec::par, trace(exec::par, body, probe, pose{}, model, scan, paths{}), pulse{}, probe);
            for (std::uint32_t k = 0; k < power.size(); ++k)
                for (std::uint32_t line = 0; line < lines; ++line) {
                    const vec2 echo = seen(line, 1130 + k);
                    power[k] += static_cast<double>(dot(echo, echo)) / (8 * lines);
                }
        }
        return power;
    };
    const auto total = [](const std::vector<double>& power) {
        double sum = 0;
        for (const double one : power) sum += one;
        return sum;
    };
    // A smooth image has some power at every depth: the least within a millimetre, over the mean.
    const auto evenness = [](const std::vector<double>& power) {
        double smallest = 0, mean = 0;
        for (std::size_t k = 0; k + 40 <= power.size(); k += 40) {
            smallest += *std::min_element(power.begin() + static_cast<std::ptrdiff_t>(k),
                                          power.begin() + static_cast<std::ptrdiff_t>(k) + 40);
            for (std::size_t i = k; i < k + 40; ++i) mean += power[i] / 40;
        }
        return smallest / mean;
    };
    const std::vector<double> fine = image_of(1024);
    for (const std::uint32_t lines : {64U, 128U, 256U}) {
        const std::vector<double> coarse = image_of(lines);
        const double level = 10 * std::log10(total(coarse) / total(fine));
        MESSAGE(lines, " lines: ", level, " dB of 1,024 lines, least over mean ", evenness(coarse), ", of these ",
                evenness(fine));
        CHECK(std::fabs(level) < 1.5);
        CHECK(evenness(coarse) > 0.5 * evenness(fine));
    }
}

TEST_CASE("the parts of a divided line are in the objects that they are in") {
    // A slab of bright tissue, narrower than a line is wide, in front of a tube of gas: its image ends where it does.
    const medium around{.density = 1050, .sound_speed = 1540, .backscatter = 0.5F};
    medium bright = around;
    bright.backscatter = 5;
    scene body{around};
    body.add(make_tube({{{0, -40_mm, 26_mm}, vec2{10_mm}}, {{0, 40_mm, 26_mm}, vec2{10_mm}}}, {.segments = 256}),
             tissue::air, {.priority = 1});
    body.add(make_box({-0.1_mm, -30_mm, 8_mm}, {0.1_mm, 30_mm, 20_mm}), bright);
    body.build(exec::par);
    const auto level = [&](float spacing) { // of the image of what is above the slab, from 25 to 31 mm
        const linear_array probe{.lines = 3, .width = 3 * spacing, .frequency = 7.5_MHz};
        const iq_lines seen = trace(exec::par, body, probe, pose{}, physical<>{},
                                    {.depth = 32_mm, .samples = 1280, .planes = 1}, paths{});
        double power = 0;
        for (std::uint32_t k = 1000; k < 1240; ++k) power += static_cast<double>(dot(seen(1, k), seen(1, k)));
        return 10 * std::log10(power);
    };
    CHECK(std::fabs(level(0.05_mm) - level(1_mm)) < 4); // of one line, so of few echoes
}

TEST_CASE("behind a curved mirror the level does not depend on the number of lines where these diverge, either") {
    const medium speckled{.density = 1060, .sound_speed = 1540, .backscatter = 1};
    scene body{speckled};
    body.add(make_tube({{{0, -60_mm, 60_mm}, vec2{15_mm}}, {{0, 60_mm, 60_mm}, vec2{15_mm}}}, {.segments = 256}),
             tissue::air);
    body.build(exec::par);
    const acquisition scan{.depth = 90_mm, .samples = 1800, .planes = 1};
    const auto image_over_tissue = [&](std::uint32_t lines) { // 74 to 83 mm deep, over its mirror image
        const phased_array probe{.lines = lines};
        double power[2] = {};
        for (std::uint32_t seed = 1; seed <= 6; ++seed) {
            const iq_lines seen =
                convolve(exec::par,
                         trace(exec::par, body, probe, pose{}, physical<>{.scattering = {.seed = seed}}, scan, paths{}),
                         pulse{}, probe);
            for (std::uint32_t line = 7 * lines / 16; line < 9 * lines / 16; ++line)
                for (std::uint32_t k = 1480; k < 1660; ++k)
                    for (const int image : {0, 1}) {
                        const vec2 echo = seen(line, image == 1 ? k : 1800 - k);
                        power[image] += static_cast<double>(dot(echo, echo));
                    }
        }
        return 10 * std::log10(power[1] / power[0]);
    };
    const double few = image_over_tissue(64), many = image_over_tissue(1024);
    MESSAGE("phased array: ", few, " dB by 64 lines, ", many, " dB by 1,024");
    CHECK(std::fabs(few - many) < 1);
}

TEST_CASE("paths are bit-equal on any number of threads, and refuse settings out of range") {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 20_mm}, 6_mm, 3), tissue::bone);
    body.add(make_sphere({-10_mm, 0, 15_mm}, 4_mm, 3), tissue::fat);
    body.build(exec::par);
    const acquisition scan{.depth = 40_mm, .samples = 800};
    const iq_lines reference = trace(exec::seq, body, linear_array{.lines = 48}, pose{}, physical<>{}, scan, paths{});
    for (const std::uint32_t threads : {2U, 3U, 8U})
        CHECK(trace(exec::par.threads(threads), body, linear_array{.lines = 48}, pose{}, physical<>{}, scan, paths{}) ==
              reference);
    CHECK_THROWS_AS(trace(exec::par, body, linear_array{}, pose{}, physical<>{}, scan, paths{{.min_amplitude = 0}}),
                    usage_error);
    CHECK_THROWS_AS(trace(exec::par, body, linear_array{}, pose{}, physical<>{}, scan, paths{{.face_reflection = 2}}),
                    usage_error);
}

TEST_CASE("a wall along the slice, which only tilted elevation planes meet, reflects all and lets no path through") {
    medium fast = tissue::water; // beyond the critical angle
    fast.sound_speed *= 1.1F;
    scene body{tissue::water};
    body.add(make_box({-30_mm, 0.4_mm, 22_mm}, {30_mm, 40_mm, 90_mm}), fast);
    body.add(make_box({-30_mm, 1_mm, 45_mm}, {30_mm, 39_mm, 46_mm}), tissue::bone); // within it
    body.build(exec::seq);
    const iq_lines lines = trace(exec::seq, body, linear_array{.lines = 16, .width = 10_mm}, pose{},
                                 physical{}.with_scattering(no_scatterers{}), {.depth = 60_mm, .planes = 3}, paths{});
    float highest = 0;
    for (std::uint32_t k = 0; k < lines.samples; ++k) {
        const float depth = (static_cast<float>(k) + 0.5F) * lines.depth / static_cast<float>(lines.samples);
        if (depth > 35_mm && depth < 50_mm) highest = std::max(highest, length(lines(8, k)));
    }
    CHECK(highest < 1e-6F); // 0.04 for a path that is reflected and transmitted at once
}
