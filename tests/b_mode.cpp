#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/paths.hpp>
#include "plain.hpp"
#include <doctest/doctest.h>

using namespace insonify;

namespace b_mode_test {
namespace {

// Mean grey of a rectangle given in metres of the slice plane, in a picture of a linear array 40 mm wide and deep.
float mean(const image& picture, vec2 from, vec2 to) {
    double sum = 0;
    int count = 0;
    for (std::uint32_t y = 0; y < picture.size.y; ++y)
        for (std::uint32_t x = 0; x < picture.size.x; ++x) {
            const vec2 p{(static_cast<float>(x) + 0.5F) / static_cast<float>(picture.size.x) * 40_mm - 20_mm,
                         (static_cast<float>(y) + 0.5F) / static_cast<float>(picture.size.y) * 40_mm};
            if (p.x < from.x || p.x > to.x || p.y < from.y || p.y > to.y) continue;
            sum += static_cast<double>(picture(x, y));
            ++count;
        }
    return static_cast<float>(sum / count);
}

scene phantom() {
    scene body{plain(tissue::muscle)};
    medium faint = tissue::blood;
    faint.backscatter = amplitude_of_decibels(-20);
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 5), faint);
    body.add(make_sphere({8_mm, 0, 20_mm}, 5_mm, 5), tissue::bone);
    body.build(exec::par);
    return body;
}

const linear_array probe{.lines = 128, .width = 40_mm, .frequency = 7.5_MHz};
const b_mode_settings settings{.depth = 40_mm, .size = {256, 256}, .noise = {.level_db = no_level_db}};

} // namespace
} // namespace b_mode_test

TEST_CASE("in the picture blood is darker than muscle, bone is bright and casts a shadow") {
    const image picture =
        b_mode(exec::par_unseq, b_mode_test::phantom(), b_mode_test::probe, pose{}, b_mode_test::settings);
    const float muscle = b_mode_test::mean(picture, {-2_mm, 13_mm}, {2_mm, 17_mm});
    const float shadow = b_mode_test::mean(picture, {6_mm, 28_mm}, {10_mm, 38_mm});
    const float behind_blood = b_mode_test::mean(picture, {-9_mm, 21_mm}, {-7_mm, 25_mm});
    const float beside = b_mode_test::mean(picture, {-2_mm, 21_mm}, {0, 25_mm});
    // -20 against -6 dB of liver on 60 dB are 0.23, less the 4.6 dB that 4 mm of blood attenuate less than muscle: 0.16.
    constexpr std::uint32_t seeds = 8;
    float darker = 0, bone = 0;
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
        const image seen = b_mode(exec::par_unseq, b_mode_test::phantom(), b_mode_test::probe, pose{},
                                  physical<>{.scattering = {.seed = seed}, .seed = seed}, b_mode_test::settings);
        bone += b_mode_test::mean(seen, {7.5_mm, 14.55_mm}, {8.5_mm, 14.75_mm}) / seeds; // 15 mm, displayed
        darker += (b_mode_test::mean(seen, {-2_mm, 13_mm}, {2_mm, 17_mm}) -
                   b_mode_test::mean(seen, {-10_mm, 13_mm}, {-6_mm, 17_mm})) /
                  seeds;
    }
    MESSAGE("blood is darker than muscle by ", darker, " of the range, expected 0.156");
    CHECK(darker == doctest::Approx(0.156).epsilon(0.15).scale(1e-30));
    CHECK(muscle > 0.2F);
    // A ball of 5 mm returns (1 + q^2)^(-1/4) of a plate's echo in either direction, q = 0.3 across the lines and 1.26 out of
    // the slice: 2.2 dB or 0.037 less.
    MESSAGE("bone ", bone, ", expected above 0.863");
    CHECK(bone > 0.9F - 0.037F);
    CHECK(shadow < 0.02F);
    CHECK(behind_blood > beside + 0.03F); // blood attenuates less than muscle
}

TEST_CASE("blood is nearly black in muscle") {
    scene body{tissue::muscle};
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 5), tissue::blood);
    body.build(exec::par);
    const image picture =
        b_mode(exec::par_unseq, body, b_mode_test::probe, pose{}, {.depth = 40_mm, .size = {256, 256}});
    const float blood = b_mode_test::mean(picture, {-10_mm, 13_mm}, {-6_mm, 17_mm});
    MESSAGE("blood ", blood, ", muscle ", b_mode_test::mean(picture, {0, 13_mm}, {12_mm, 17_mm}));
    CHECK(blood < 0.08F);
}

TEST_CASE("the picture is the same on any number of threads and each time, and all of it is grey") {
    const scene body = b_mode_test::phantom();
    const image picture = b_mode(exec::seq, body, b_mode_test::probe, pose{}, b_mode_test::settings);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
        CHECK(b_mode(exec::par.threads(threads), body, b_mode_test::probe, pose{}, b_mode_test::settings) == picture);
    const image simd = b_mode(exec::par_unseq, body, b_mode_test::probe, pose{}, b_mode_test::settings);
    std::size_t apart = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        REQUIRE(picture.pixels[i] >= 0);
        REQUIRE(picture.pixels[i] <= 1);
        apart += std::fabs(simd.pixels[i] - picture.pixels[i]) > 0.02F ? 1 : 0;
    }
    MESSAGE(apart, " of ", picture.pixels.size(), " pixels differ by more than 0.02 between scalar and SIMD");
    CHECK(apart * 1000 <= picture.pixels.size());
}

TEST_CASE("a clip of one scanner shows what pictures drawn one by one show, whatever changes between frames") {
    scene body = b_mode_test::phantom();
    scanner machine{b_mode_test::probe, b_mode_test::settings};
    linear_array& probe = machine.probe;
    b_mode_settings& settings = machine.settings;
    physical<>& model = machine.model;
    const auto check = [&](const pose& at) {
        CHECK(machine.scan(exec::par_unseq, body, at) == b_mode(exec::par_unseq, body, probe, at, model, settings));
    };
    check(pose{});
    check({.translation = {1_mm, 2_mm, 0}});
    settings.depth = 30_mm;
    check(pose{});
    settings.planes = 1;
    settings.size = {200, 0};
    check(pose{});
    probe.lines = 100;
    probe.focus = 10_mm;
    check(pose{});
    model.scattering.cell = 0.3_mm;
    check(pose{});
    settings.background = 0.5F;
    settings.samples = 1500;
    check({.translation = {0, 0, -1_mm}});
}

TEST_CASE(
    "a bright object entering the frame changes nothing beside it, but for the part of the aperture that it covers") {
    scene body{plain(tissue::muscle)};
    medium faint = tissue::blood;
    faint.backscatter = amplitude_of_decibels(-20);
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 5), faint);
    body.build(exec::par);
    const scene bright = b_mode_test::phantom();
    const auto beside = [&](const scene& of, std::uint32_t directions) {
        const image seen = b_mode(exec::par, of, b_mode_test::probe, pose{}, physical{}, b_mode_test::settings,
                                  straight_lines{.directions = directions});
        return b_mode_test::mean(seen, {-20_mm, 0}, {-1_mm, 40_mm});
    };
    CHECK(beside(body, 1) == beside(bright, 1));
    CHECK(beside(body, 16) == doctest::Approx(beside(bright, 16)).epsilon(2e-3).scale(1e-30));
}

TEST_CASE("a needle in plane shadows partly, with one plane as with seven") {
    // 0.7 mm of steel at 40 degrees, thinner than the beam's height: sound passes beside it.
    scene plain{tissue::muscle}, body{tissue::muscle};
    plain.build(exec::par);
    body.add(make_cylinder({-12_mm, 0, 4_mm}, {4_mm, 0, 17.4_mm}, 0.35_mm, 48), tissue::steel, {.priority = 1});
    body.build(exec::par);
    const linear_array probe{
        .lines = 256, .width = 40_mm, .frequency = 7.5_MHz, .focus = 18_mm, .elevation_focus = 18_mm};
    for (const std::uint32_t planes : {1U, 7U}) {
        const auto grey = [&](const scene& of) { // below the needle
            return b_mode_test::mean(b_mode(exec::par_unseq, of, probe, pose{},
                                            {.depth = 40_mm, .size = {256, 256}, .tgc = 100, .planes = planes}),
                                     {-8_mm, 22_mm}, {0, 30_mm});
        };
        const float below = grey(body), without = grey(plain);
        MESSAGE(planes, " planes: grey below the needle ", below, ", without it ", without);
        CHECK(below > 0.3F * without);
        CHECK(below < 0.95F * without);
    }
}

TEST_CASE("anechoic media are black, without noise") {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 20_mm}, 8_mm, 5), tissue::water);
    body.build(exec::par);
    const image picture = b_mode(exec::par_unseq, body, b_mode_test::probe, pose{}, b_mode_test::settings);
    CHECK(b_mode_test::mean(picture, {-2_mm, 18_mm}, {2_mm, 22_mm}) == 0);
}

TEST_CASE("a sector picture has the size asked for, or one that fits") {
    const scene body = b_mode_test::phantom();
    CHECK(b_mode(exec::par, body, convex_array{.lines = 64}, pose{}, {.depth = 60_mm, .size = {100, 80}}).size ==
          uvec2{100, 80});
    CHECK(b_mode(exec::par, body, convex_array{.lines = 64}, pose{}, {.depth = 60_mm}).size.x == 512);
    CHECK_THROWS_AS(b_mode(exec::par, body, convex_array{}, pose{}, {.depth = 60_mm, .size = {1U << 30U, 1U << 30U}}),
                    usage_error);
    CHECK_THROWS_AS(b_mode(exec::par, body, convex_array{}, pose{}, {.depth = 60_mm, .dynamic_range_db = 0}),
                    usage_error);
    CHECK_THROWS_AS(b_mode(exec::par, body, convex_array{}, pose{}, {.depth = 0}), usage_error);
}

TEST_CASE("a picture along paths is the chain of its stages by hand, drawn once and by a scanner") {
    const scene body = b_mode_test::phantom();
    const paths how{{.bounces = 2, .face_reflection = 0.1F}};
    const b_mode_settings settings{.depth = 30_mm,
                                   .size = {160, 120},
                                   .gain_db = 3,
                                   .planes = 3,
                                   .background = 0.25F,
                                   .noise = {.level_db = no_level_db}};
    const auto compare = [&](const auto& probe) {
        const refined fine{probe, rays_per_line(probe, settings.depth)};
        const pulse sent = nominal_pulse(probe);
        const std::uint32_t samples = samples_for(settings.depth, sent.sigma_z(probe.frequency));
        const acquisition scan{.depth = settings.depth, .samples = samples, .planes = settings.planes};
        const iq_lines echoes = trace(exec::par_unseq, body, fine, pose{}, physical{}, scan, how);
        scan_lines lines = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, sent, fine));
        const float attenuation = std::clamp(tissue::muscle.attenuation, 50.0F, 100.0F);
        lines = tgc(exec::par_unseq, std::move(lines), probe.frequency,
                    {.attenuation = attenuation, .bandwidth = probe.bandwidth});
        lines = log_compress(exec::par_unseq, std::move(lines),
                             {.dynamic_range_db = 60, .reference_db = -25, .gain_db = 3});
        const image expected =
            scan_convert(exec::par_unseq, lines, fine, {.size = settings.size, .background = settings.background});
        CHECK(b_mode(exec::par_unseq, body, probe, pose{}, physical{}, settings, how) == expected);
        scanner machine{probe, settings, physical{}, how};
        for (int i = 0; i < 2; ++i) CHECK(machine.scan(exec::par_unseq, body, pose{}) == expected);
        CHECK(b_mode(exec::par_unseq, body, probe, pose{}, settings) != expected); // straight lines are another picture
    };
    compare(linear_array{.lines = 48, .width = 30_mm, .frequency = 5_MHz});
    compare(convex_array{.lines = 48, .radius = 40_mm, .frequency = 3.5_MHz});
}

TEST_CASE("where nothing bends and no second reflection is heard, paths draw what straight lines draw") {
    // Equal speeds; r = 1/401 at most, so that what is reflected twice stays below `min_amplitude`.
    scene body{medium{.density = 1000, .sound_speed = 1540, .attenuation = 50, .backscatter = 1}};
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 5),
             medium{.density = 1005, .sound_speed = 1540, .attenuation = 30, .backscatter = 0.1F});
    body.add(make_box({2_mm, -9_mm, 12_mm}, {12_mm, 9_mm, 22_mm}),
             medium{.density = 1002, .sound_speed = 1540, .attenuation = 70, .backscatter = 2});
    body.build(exec::par);
    const image straight = b_mode(exec::par_unseq, body, b_mode_test::probe, pose{}, physical{}, b_mode_test::settings,
                                  straight_lines{.directions = 1});
    const image bent =
        b_mode(exec::par_unseq, body, b_mode_test::probe, pose{}, physical{}, b_mode_test::settings, paths{});
    std::size_t apart = 0;
    double sum = 0;
    for (std::size_t i = 0; i < straight.pixels.size(); ++i) {
        const float difference = std::fabs(straight.pixels[i] - bent.pixels[i]);
        apart += difference > 0.02F ? 1 : 0;
        sum += static_cast<double>(difference);
    }
    MESSAGE(apart, " of ", straight.pixels.size(), " pixels differ by more than 0.02; mean difference ",
            sum / static_cast<double>(straight.pixels.size()));
    CHECK(apart * 1000 <= straight.pixels.size());
    CHECK(sum < 1e-3 * static_cast<double>(straight.pixels.size()));
    CHECK(b_mode_test::mean(straight, {-2_mm, 13_mm}, {1_mm, 17_mm}) > 0.2F); // there is something to see
}
