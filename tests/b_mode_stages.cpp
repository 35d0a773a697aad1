#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <doctest/doctest.h>

using namespace insonify;

namespace b_mode_stages_test {
namespace {

// Fat over muscle, and air at one side of the face.
scene phantom() {
    scene body{tissue::fat};
    body.add(make_box({-60_mm, -30_mm, 6_mm}, {60_mm, 30_mm, 90_mm}), tissue::muscle);
    body.add(make_sphere({4_mm, 0, 15_mm}, 3_mm, 4), tissue::blood);
    body.add(make_box({8_mm, -30_mm, -20_mm}, {60_mm, 30_mm, 3_mm}), tissue::air, {.priority = 1});
    body.build(exec::par);
    return body;
}

bool same_bits(const image& a, const image& b) {
    return a.size == b.size && a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0;
}

// The chain of the guide, with every setting passed to its stage.
template <class Probe>
image by_stages(const scene& body, const Probe& probe, const pose& at, const b_mode_settings& knobs,
                persistence& fading) {
    const auto policy = exec::par_unseq;
    const refined fine{probe, rays_per_line(probe, knobs.depth)},
        traced{probe, knobs.interpolates_lines ? min(rays_per_line(probe, knobs.depth, 0.25F), fine.rays) : fine.rays};
    pulse sent = nominal_pulse(probe);
    sent.ring_down_db = knobs.ring_down_db;
    const acquisition scan{.depth = knobs.depth,
                           .samples = samples_for(knobs.depth, sent.sigma_z(probe.frequency)),
                           .planes = knobs.planes,
                           .frame = knobs.frame};
    line_tracer<> tracer; // has the layers that it found
    iq_lines echoes = tracer.trace(policy, body, traced, at, physical{}, scan);
    echoes = add_reverberation(policy, std::move(echoes), tracer.layers(), traced, physical{}, knobs.reverberation);
    echoes = add_near_field(policy, std::move(echoes), tracer.layers(), traced, knobs.near_field);
    echoes = convolve(policy, std::move(echoes), sent, traced);
    if (traced.lines != fine.lines) echoes = resample_lines(policy, echoes, traced, fine);
    echoes = add_electronic_noise(policy, std::move(echoes),
                                  {.level_db = knobs.noise.level_db, .seed = knobs.noise.seed, .frame = knobs.frame});
    scan_lines lines =
        tgc(policy, envelope(policy, echoes), probe.frequency,
            {.attenuation = knobs.tgc > 0 ? knobs.tgc : automatic_tgc(policy, body, traced, at, knobs.depth),
             .max_db = knobs.time_gain.max_db,
             .sliders = knobs.time_gain.sliders,
             .curve = knobs.time_gain.curve,
             .bandwidth = probe.bandwidth});
    lines = log_compress(policy, std::move(lines),
                         {.dynamic_range_db = knobs.dynamic_range_db,
                          .reference_db = knobs.reference_db,
                          .gain_db = knobs.gain_db,
                          .reject_db = knobs.reject_db});
    lines = map_grey(policy, fading.add(policy, lines, at), knobs.grey);
    return scan_convert(policy, lines, fine, {.size = knobs.size, .background = knobs.background});
}

} // namespace

TEST_CASE("b_mode: the stages by hand draw the same picture to the bit, whatever knob is turned") {
    const scene body = phantom();
    const b_mode_settings usual{.depth = 35_mm, .size = {160, 0}, .planes = 3};
    const auto compare = [&](const char* knob, const b_mode_settings& turned, const auto& probe, bool changes = true) {
        CAPTURE(knob);
        persistence fading{turned.persistence}, none{};
        const image seen = b_mode(exec::par_unseq, body, probe, pose{}, turned);
        CHECK(same_bits(seen, by_stages(body, probe, pose{}, turned, fading)));
        CHECK(same_bits(seen, by_stages(body, probe, pose{}, usual, none)) != changes);
    };
    const linear_array probe{.lines = 60, .width = 30_mm, .frequency = 6_MHz};
    const auto turn = [&](const char* knob, const auto& change, bool changes = true) {
        b_mode_settings turned = usual;
        change(turned);
        compare(knob, turned, probe, changes);
    };
    turn(
        "none", [](b_mode_settings&) {}, false);
    turn("dynamic_range_db", [](b_mode_settings& s) { s.dynamic_range_db = 50; });
    turn("reference_db", [](b_mode_settings& s) { s.reference_db = -35; });
    turn("gain_db", [](b_mode_settings& s) { s.gain_db = 5; });
    turn("tgc", [](b_mode_settings& s) { s.tgc = 65; });
    turn("background", [](b_mode_settings& s) {
        s.background = 0.5F;
        s.size = {300, 100};
    });
    turn("time_gain.max_db", [](b_mode_settings& s) { s.time_gain.max_db = 20; });
    turn("time_gain.sliders", [](b_mode_settings& s) { s.time_gain.sliders = {0, 3, -6, 0, 0, 2, 4, 6}; });
    turn("time_gain.curve", [](b_mode_settings& s) { s.time_gain.curve = {{0, 0}, {10_mm, 12}, {35_mm, 30}}; });
    turn("reject_db", [](b_mode_settings& s) { s.reject_db = -75; });
    turn("grey",
         [](b_mode_settings& s) { s.grey = {.gamma = 0.9F, .contrast = 0.2F, .reject = 0.3F, .shoulder = 0.8F}; });
    turn("noise", [](b_mode_settings& s) { s.noise = {.level_db = -100, .seed = 7}; });
    turn("frame", [](b_mode_settings& s) { s.frame = 12; });
    turn("near_field", [](b_mode_settings& s) { s.near_field = {.shown = near_field_settings::lines::all}; });
    scene with_gas = body;
    with_gas.add(make_sphere({-9_mm, 0, 14_mm}, 4_mm, 4), tissue::air);
    with_gas.build(exec::par);
    b_mode_settings half = usual;
    half.reverberation = {.mirror = 0.5F};
    const auto compare_gas = [&](const auto& seen_by) {
        persistence none{};
        const image seen = b_mode(exec::par_unseq, with_gas, seen_by, pose{}, half);
        CHECK(same_bits(seen, by_stages(with_gas, seen_by, pose{}, half, none)));
        CHECK_FALSE(same_bits(seen, b_mode(exec::par_unseq, with_gas, seen_by, pose{}, usual)));
    };
    compare_gas(probe);
    compare_gas(convex_array{.lines = 48, .radius = 40_mm, .frequency = 3.5_MHz});
    turn(
        "persistence", [](b_mode_settings& s) { s.persistence = 0.6F; }, false); // one frame has no past

    b_mode_settings sparse = usual;
    sparse.interpolates_lines = true;
    compare("interpolates_lines", sparse, probe, false); // the beam needs more lines than the probe has
    compare("interpolates_lines", sparse, linear_array{.lines = 160, .width = 30_mm, .frequency = 6_MHz, .fnumber = 3});

    const b_mode_settings all{.depth = 35_mm,
                              .size = {200, 120},
                              .dynamic_range_db = 66,
                              .reference_db = -30,
                              .gain_db = 2,
                              .planes = 3,
                              .background = 0.1F,
                              .time_gain = {.max_db = 50, .sliders = {-3, 0, 0, 1, 2, 2, 0, 0}},
                              .reject_db = -80,
                              .grey = {.contrast = 0.1F, .reject = 0.25F, .shoulder = 0.85F},
                              .persistence = 0.4F,
                              .noise = {.level_db = -120, .seed = 3},
                              .frame = 5,
                              .near_field = {.shown = near_field_settings::lines::all}};
    compare("all, linear", all, probe);
    compare("all, convex", all, convex_array{.lines = 48, .radius = 40_mm, .frequency = 3.5_MHz});
}

TEST_CASE("b_mode: a clip with persistence is the clip of the stages, and restarts where a setting changes") {
    const scene body = phantom();
    const linear_array probe{.lines = 40, .width = 30_mm, .frequency = 5_MHz};
    scanner<linear_array> machine{
        probe, {.depth = 30_mm, .size = {80, 0}, .planes = 1, .persistence = 0.5F, .noise = {.level_db = -100}}};
    b_mode_settings& knobs = machine.settings;
    knobs.ring_down_db = -16;
    persistence fading{0.5F};
    for (; knobs.frame < 4; ++knobs.frame)
        CHECK(same_bits(machine.scan(exec::par_unseq, body, pose{}), by_stages(body, probe, pose{}, knobs, fading)));
    CHECK_FALSE(same_bits(machine.picture(), b_mode(exec::par_unseq, body, probe, pose{}, knobs)));
    const auto restarts = [&](const linear_array& with) {
        machine.probe = with;
        CHECK(
            same_bits(machine.scan(exec::par_unseq, body, pose{}), b_mode(exec::par_unseq, body, with, pose{}, knobs)));
        ++knobs.frame;
    };
    knobs.gain_db = 3;
    restarts(probe);
    restarts({.lines = 40, .width = 30_mm, .frequency = 5_MHz, .fnumber = 3});
    knobs.persistence = 0;
    restarts({.lines = 40, .width = 30_mm, .frequency = 5_MHz, .fnumber = 3});
    knobs.persistence = 0.5F;
    restarts({.lines = 40, .width = 30_mm, .frequency = 5_MHz, .fnumber = 3});
    knobs.persistence = 1;
    for (int i = 0; i < 2; ++i) CHECK_THROWS_AS(machine.scan(exec::par_unseq, body, pose{}), usage_error);
}

TEST_CASE("b_mode: the same number of the frame gives the same picture, another number other noise") {
    const scene body = phantom();
    const linear_array probe{.lines = 60, .width = 30_mm, .frequency = 6_MHz};
    scanner<linear_array> machine{probe, {.depth = 50_mm, .size = {160, 0}, .planes = 1}};
    b_mode_settings& knobs = machine.settings;
    const image first = machine.scan(exec::par_unseq, body, pose{});
    knobs.frame = 1;
    CHECK_FALSE(same_bits(machine.scan(exec::par_unseq, body, pose{}), first));
    knobs.frame = 0;
    CHECK(same_bits(machine.scan(exec::par_unseq, body, pose{}), first));
    CHECK(same_bits(b_mode(exec::par_unseq.threads(3), body, probe, pose{}, knobs), first));
}

TEST_CASE("b_mode: the default noise ends the picture in texture, and leaves a shadow at 4 cm near black") {
    // Behind bone there is nothing but noise: -135 dB and a gain of 2 * 1 * 7.5 MHz * z, at most 60 dB. The mean of the
    // decibels of an exponential distribution lies 2.51 dB below the decibels of its mean, so
    // grey = 1 + (-135 - 2.51 + gain + 25) / 60, and a little more since values below 0 are clipped.
    scene body{tissue::muscle};
    body.add(make_box({-40_mm, -30_mm, 5_mm}, {40_mm, 30_mm, 8_mm}), tissue::bone);
    body.build(exec::par);
    const linear_array probe{.lines = 192, .frequency = 7.5_MHz};
    const image seen = b_mode(exec::par_unseq, body, probe, pose{}, {.depth = 80_mm, .size = {200, 400}, .tgc = 100});
    const auto mean = [&](std::uint32_t top, std::uint32_t bottom) {
        double sum = 0;
        for (std::uint32_t y = top; y < bottom; ++y)
            for (std::uint32_t x = 0; x < seen.size.x; ++x) sum += static_cast<double>(seen(x, y));
        return sum / ((bottom - top) * seen.size.x);
    };
    const double at_4_cm = mean(195, 205) * 255, deep = mean(350, 400);
    const double expected = 1 + (-135 - 2.51 + 60 + 25) / 60;
    MESSAGE("gray level of the shadow at 4 cm: ", at_4_cm, " of 255; deep: ", deep, ", expected ", expected);
    CHECK(deep == doctest::Approx(expected).scale(1e-30).epsilon(0.1)); // some are clipped at black
    CHECK(at_4_cm < 64);
    const image silent = b_mode(exec::par_unseq, body, probe, pose{},
                                {.depth = 80_mm, .size = {200, 400}, .tgc = 100, .noise = {.level_db = no_level_db}});
    CHECK(*std::max_element(silent.pixels.end() - 200 * 50, silent.pixels.end()) == 0);
}

TEST_CASE("b_mode: automatic gain stays from frame to frame, and follows the probe on request") {
    scene body{tissue::muscle};
    body.add(make_box({-200_mm, -30_mm, -50_mm}, {0, 30_mm, 90_mm}), tissue::fat); // 60 dB/m; muscle has 100
    body.build(exec::par);
    const linear_array probe{.lines = 40, .width = 30_mm, .frequency = 5_MHz};
    const pose over_fat{.translation = {-50_mm, 0, 0}}, over_muscle{.translation = {50_mm, 0, 0}};
    b_mode_settings knobs{.depth = 40_mm, .size = {80, 0}, .planes = 1};
    const auto with = [&](float tgc, const pose& at) {
        b_mode_settings given = knobs;
        given.tgc = tgc;
        return b_mode(exec::par_unseq, body, probe, at, given);
    };
    scanner<linear_array> machine{probe};
    const auto next = [&](const pose& at) {
        machine.settings = knobs;
        return machine.scan(exec::par_unseq, body, at);
    };
    CHECK(same_bits(next(over_fat), with(60, over_fat)));
    CHECK(same_bits(next(over_muscle), with(60, over_muscle)));
    CHECK(same_bits(b_mode(exec::par_unseq, body, probe, over_muscle, knobs), with(100, over_muscle)));
    knobs.time_gain.chosen = b_mode_settings::time_gain_settings::choice::every_frame;
    CHECK(same_bits(next(over_muscle), with(100, over_muscle)));
    CHECK(same_bits(next(over_fat), with(60, over_fat)));
    knobs.time_gain.chosen = b_mode_settings::time_gain_settings::choice::first_frame;
    knobs.depth = 30_mm;
    CHECK(same_bits(next(over_muscle), with(100, over_muscle)));
}

TEST_CASE("rays_per_line: more lines never trace fewer lines in all, and 192 no more than 208") {
    for (const float frequency : {3.5_MHz, 5_MHz, 7.5_MHz, 12_MHz})
        for (const float fnumber : {2.0F, 3.0F, 5.5F}) {
            const auto traced = [&](std::uint32_t lines) {
                const linear_array probe{.lines = lines, .frequency = frequency, .fnumber = fnumber};
                return refined{probe, rays_per_line(probe, 40_mm)}.lines;
            };
            std::uint32_t before = 0;
            for (std::uint32_t lines = 1; lines <= 640; ++lines) {
                const std::uint32_t now = traced(lines);
                INFO(lines, " lines trace ", now);
                REQUIRE(now >= before);
                REQUIRE(now >= lines);
                REQUIRE(now <= 4 * lines);
                before = now;
            }
            CHECK(traced(192) <= traced(208));
        }
    const linear_array probe{.lines = 100, .width = 38_mm, .frequency = 7.5_MHz};
    const beam_model beam = beam_of(probe, 40_mm);
    const float needed = 38_mm / (0.5F * beam.lateral_width(beam.focus));
    const float traced = 100 * rays_per_line(probe, 40_mm);
    MESSAGE("lines traced: ", traced, ", expected ", needed);
    CHECK(std::fabs(traced - std::ceil(needed)) < 0.1F);
    const convex_array sector{.lines = 48};
    CHECK(rays_per_line(sector, 120_mm) >= 1);
    const linear_array many{.lines = 400, .width = 38_mm, .frequency = 7.5_MHz};
    CHECK(std::fabs(400 * rays_per_line(many, 40_mm, 0.25F) - std::ceil(needed)) < 0.1F);
}

// Of speckle on lines that are all traced, and on lines of which some are interpolated.
TEST_CASE("b_mode: interpolated lines have the level, the distribution and the width of traced ones") {
    medium even = tissue::liver;
    even.structure = {};
    even.attenuation = 0;
    const scene body = scene{even}.build(exec::par);
    const linear_array probe{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz, .fnumber = 2.5F};
    physical field;
    field.scattering.cell = 0.3_mm;
    const auto measure = [&](bool interpolates) {
        scanner machine{probe, b_mode_settings{.depth = 40_mm, .planes = 1, .interpolates_lines = interpolates}, field};
        double power = 0, squares = 0, products = 0, count = 0;
        for (int slice = 0; slice < 12; ++slice) {
            machine.scan(exec::par_unseq, body, {.translation = {0, 3_mm * static_cast<float>(slice), 0}});
            const iq_lines& echoes = machine.echoes();
            CHECK(echoes.count == 256);
            for (std::uint32_t line = 20; line < 230; ++line)
                for (std::uint32_t k = echoes.samples * 3 / 8; k < echoes.samples * 5 / 8; ++k) {
                    const double here = static_cast<double>(dot(echoes(line, k), echoes(line, k)));
                    power += here;
                    squares += here * here;
                    products += static_cast<double>(dot(echoes(line, k), echoes(line + 3, k)));
                    ++count;
                }
        }
        return std::array{10 * std::log10(power / count), squares / count / (power / count * power / count),
                          products / power};
    };
    const beam_model beam = beam_of(probe, 40_mm);
    double width = 0; // mean over the depths of the correlation between lines
    for (int i = 0; i < 50; ++i) {
        const double sigma = static_cast<double>(beam.lateral_sigma(15_mm + 0.2_mm * (static_cast<float>(i) + 0.5F))),
                     apart = 3 * 38e-3 / 256;
        width += std::exp(-apart * apart / (4 * sigma * sigma)) / 50;
    }
    const std::array traced = measure(false), interpolated = measure(true);
    MESSAGE("level ", traced[0], " and ", interpolated[0], " dB; mean square of the power ", traced[1], " and ",
            interpolated[1], ", expected 2; correlation over three lines ", traced[2], " and ", interpolated[2],
            ", expected ", width);
    for (const auto& found : {traced, interpolated}) {
        CHECK(std::fabs(found[0] - traced[0]) < 0.2);
        CHECK(std::fabs(found[1] - 2) < 0.1);
        CHECK(std::fabs(found[2] - width) < 0.02);
    }
}

} // namespace b_mode_stages_test
