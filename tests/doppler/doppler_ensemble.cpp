#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/random.hpp>
#include <insonify/doppler/doppler_ensemble.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>

using namespace insonify;

namespace doppler_ensemble_test {
namespace {

constexpr float depth = 40_mm, prf = 4_kHz;
constexpr std::uint32_t samples = 1024;
const linear_array probe{.lines = 96, .width = 24_mm, .frequency = 5_MHz};

// A smooth plate from 30 mm on, below tissue with the speed of sound that a scanner assumes, without loss.
scene plate_below(float backscatter) {
    scene body{medium{.density = 1040, .sound_speed = display_speed, .backscatter = backscatter}};
    body.add(make_box({-60_mm, -60_mm, 30_mm}, {60_mm, 60_mm, 80_mm}), {.density = 2000, .sound_speed = display_speed});
    body.build(exec::par);
    return body;
}

// A vessel in muscle.
struct vessel {
    scene body{tissue::muscle};
    poiseuille stream{.from = {-30_mm, 0, 5_mm}, .to = {30_mm, 0, 35_mm}, .radius = 4_mm, .peak_velocity = 0.4_m_per_s};

    vessel() {
        stream.object = body.add(make_cylinder(stream.from, stream.to, stream.radius, 48), tissue::blood);
        body.build(exec::par);
    }
};

/// Angle between the echoes of two pulses, of some samples and of as many that are `shift` deeper.
double angle(const iq_lines& first, const iq_lines& second, std::uint32_t begin, std::uint32_t end, int shift) {
    double real = 0, imaginary = 0;
    for (std::uint32_t line = 16; line < 80; ++line)
        for (std::uint32_t n = begin; n < end; ++n) {
            const vec2 a = first(line, n), b = second(line, static_cast<std::uint32_t>(static_cast<int>(n) + shift));
            real += static_cast<double>(dot(a, b));
            imaginary += static_cast<double>(a.x * b.y - a.y * b.x);
        }
    return std::atan2(imaginary, real);
}

} // namespace

TEST_CASE("ensemble: the phase of the echoes of a rigid motion is 4 pi f0 v T / c0, by less than a sample too") {
    const scene plate_alone = plate_below(0), tissue = plate_below(1);
    double worst = 0;
    for (const double steps : {1.0, 0.25, -0.125}) { // samples from pulse to pulse
        const auto velocity = static_cast<float>(steps * static_cast<double>(depth) / samples * 4000);
        const auto field = [=](object_id, vec3, float) { return vec3{0, 0, velocity}; };
        const auto echoes_of = [&](const scene& body) {
            return doppler_ensemble(
                exec::par_unseq, body, probe, pose{}, field,
                {.depth = depth, .samples = samples, .prf = prf, .pulses = 9, .burst = 0, .noise_db = no_level_db});
        };
        const iq_ensemble of_plate = echoes_of(plate_alone), of_tissue = echoes_of(tissue);
        for (const int lag : {1, 3, 4, 8}) {
            const double moved = steps * lag, cycles = 2 * 5e6 * moved * 0.04 / samples / 1540;
            const auto error = [&](const iq_ensemble& echoes, std::uint32_t begin, std::uint32_t end) {
                const double found = angle(echoes.pulses[0], echoes.pulses[static_cast<std::size_t>(lag)], begin, end,
                                           static_cast<int>(std::lround(moved)));
                return std::remainder(found + 2 * std::numbers::pi * cycles, 2 * std::numbers::pi);
            };
            const double plate = error(of_plate, 768, 769);
            worst = std::max(worst, std::fabs(plate));
            double speckle = 0;
            if (moved == std::round(moved)) { // else the samples lie elsewhere between the scatterers
                speckle = error(of_tissue, 100, 700);
                worst = std::max(worst, std::fabs(speckle));
            }
            MESSAGE(steps, " samples a pulse, lag ", lag, ": expected ", -2 * std::numbers::pi * cycles,
                    " rad; errors of the plate ", plate, " and of speckle ", speckle);
        }
    }
    MESSAGE("largest error ", worst, " rad, expected below 1e-3");
    CHECK(worst < 1e-3);
}

TEST_CASE("ensemble: what rests has the echoes of `trace`, the same for all pulses") {
    const vessel v;
    const auto rest = [](object_id, vec3, float) { return vec3{0, 0, 0}; };
    for (const std::uint32_t planes : {1U, 3U}) {
        const acquisition scan{.depth = depth, .samples = 512, .planes = planes, .frame = 7};
        const ensemble_echoes found = trace_ensemble(exec::par_unseq, v.body, probe, pose{}, physical{}, rest, scan,
                                                     {.interval = 1 / prf, .count = 3});
        CHECK(found.resting == trace(exec::par_unseq, v.body, probe, pose{}, physical{}, scan));
        for (const iq_lines& each : found.moving)
            for (const vec2 value : each.values) CHECK_UNARY(value == vec2{0, 0});
    }
}

TEST_CASE("ensemble: moving blood keeps its level, pulse after pulse, and the first pulse has the echoes of `trace`") {
    const vessel v;
    const auto power = [](const iq_lines& lines) {
        double sum = 0;
        for (const vec2 value : lines.values) sum += static_cast<double>(dot(value, value));
        return sum;
    };
    const acquisition scan{.depth = depth, .samples = 1024};
    const ensemble_echoes found = trace_ensemble(exec::par_unseq, v.body, probe, pose{}, physical{}, v.stream, scan,
                                                 {.interval = 1 / prf, .count = 40});
    const iq_lines still = trace(exec::par_unseq, v.body, probe, pose{}, physical{}, scan);
    double difference = 0;
    for (std::size_t i = 0; i < still.values.size(); ++i) {
        const vec2 d = found.resting.values[i] + found.moving[0].values[i] - still.values[i];
        difference += static_cast<double>(dot(d, d));
    }
    const double level = 10 * std::log10(power(found.moving[39]) / power(found.moving[0]));
    MESSAGE("the first pulse differs by ", 10 * std::log10(difference / power(found.moving[0])),
            " dB of the blood, expected below -30; the last one's level by ", level, " dB, expected 0");
    CHECK(difference < 1e-3 * power(found.moving[0])); // gains are interpolated over shorter runs
    CHECK(std::fabs(level) < 0.3);
}

TEST_CASE("ensemble: a train in parts is the same train; threads do not matter") {
    const vessel v;
    ensemble_settings settings{.depth = depth, .samples = 512, .prf = prf, .pulses = 6, .time = 0.25F};
    const iq_ensemble whole = doppler_ensemble(exec::par_unseq, v.body, probe, pose{}, v.stream, settings),
                      alone = doppler_ensemble(exec::unseq, v.body, probe, pose{}, v.stream, settings),
                      three = doppler_ensemble(exec::par_unseq.threads(3), v.body, probe, pose{}, v.stream, settings);
    settings.first = 4;
    settings.pulses = 2;
    const iq_ensemble end = doppler_ensemble(exec::par_unseq, v.body, probe, pose{}, v.stream, settings);
    for (std::size_t k = 0; k < 6; ++k) {
        CHECK(whole.pulses[k] == alone.pulses[k]);
        CHECK(whole.pulses[k] == three.pulses[k]);
    }
    CHECK(end.pulses[0] == whole.pulses[4]);
    CHECK(end.pulses[1] == whole.pulses[5]);
    settings.time = 0.5F;
    CHECK(end.pulses[0] != doppler_ensemble(exec::par_unseq, v.body, probe, pose{}, v.stream, settings).pulses[0]);
}

TEST_CASE("ensemble: settings out of range are refused") {
    const vessel v;
    const auto attempt = [&](const ensemble_settings& settings) {
        doppler_ensemble(exec::seq, v.body, probe, pose{}, v.stream, settings);
    };
    CHECK_THROWS_WITH(attempt({.prf = 4e6F}), "doppler: the prf is 4e+06 Hz; it must be 1 Hz to 1 MHz, such as 4_kHz");
    CHECK_THROWS_AS(attempt({.pulses = 0}), usage_error);
    CHECK_THROWS_AS(attempt({.time = std::nanf("")}), usage_error);
    CHECK_THROWS_AS(attempt({.depth = 40}), usage_error);
    CHECK_THROWS_AS(doppler_ensemble(exec::seq, v.body, probe, pose{}, poiseuille{}), usage_error);
}

TEST_CASE("ensemble: a rough surface has the phase of its motion, at any angle") {
    for (const float tilt : {0.0F, 4_deg, 8_deg}) {
        scene body{medium{.density = 1040, .sound_speed = display_speed}};
        const object_id plate =
            body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 50_mm}),
                     {.density = 2000, .sound_speed = display_speed, .roughness = 30_um},
                     {.at = look_at({0, 0, 25_mm}, {std::sin(tilt), 0, 25_mm + std::cos(tilt)}, {1, 0, 0})});
        body.build(exec::par);
        const float speed = 30_mm; // a second, towards the probe
        const auto moves = [&](object_id of, vec3, float) {
            return of == plate ? vec3{0, 0, -speed / std::cos(tilt)} : vec3{0, 0, 0}; // of the plate's own axis
        };
        const iq_ensemble echoes =
            doppler_ensemble(exec::par_unseq, body, probe, pose{}, physical{}, moves,
                             {.depth = depth, .samples = samples, .prf = prf, .pulses = 2, .noise_db = -FLT_MAX});
        // Of the distance along the normal, which is the shortest: that along the line shortens by another 1 / cos, 1 %.
        const double expected = 4 * std::numbers::pi * 5e6 * static_cast<double>(speed) /
                                static_cast<double>(std::cos(tilt)) / static_cast<double>(display_speed * prf);
        CAPTURE(tilt);
        CHECK(angle(echoes.pulses[0], echoes.pulses[1], 0, samples, 0) ==
              doctest::Approx(expected).epsilon(0.03).scale(0));
    }
}

TEST_CASE("ensemble: surfaces that move into what was their shadow are as loud as before") {
    // Vessels across the slice, which reflect totally where lines graze them, in water that moves by up to their height.
    const linear_array few{.lines = 32, .width = 30_mm};
    for (std::uint64_t i = 0; i < 40; ++i) {
        const auto within = [i](std::uint64_t number, float size) { // -size to size
            return size * (2 * hash_uniform(7, 8 * i + number) - 1);
        };
        scene body{tissue::water};
        body.add(make_cylinder({-25_mm, within(0, 3_mm), 19_mm}, {25_mm, within(1, 3_mm), 19_mm + within(2, 3_mm)},
                               3_mm + within(3, 2_mm), 24),
                 tissue::blood);
        body.build(exec::par);
        const vec3 velocity = 0.2F * normalize(vec3{within(4, 1), within(5, 1), within(6, 1)});
        const ensemble_echoes echoes = trace_ensemble(exec::par_unseq, body, few, pose{}, physical{},
                                                      [&](object_id, vec3, float) { return velocity; },
                                                      {.depth = 35_mm}, {.interval = 1 / prf, .count = 8});
        const auto loudest = [](const iq_lines& lines) {
            float found = 0;
            for (const vec2 echo : lines.values) found = max(found, length(echo));
            return found;
        };
        CAPTURE(i);
        for (const iq_lines& of_pulse : echoes.moving) CHECK(loudest(of_pulse) <= 2 * loudest(echoes.moving[0]));
    }
}

TEST_CASE("ensemble: what moves in slow media is there from the depth on at which it is displayed") {
    for (const float sound_speed : {1540.0F, 1100.0F, 800.0F}) {
        scene body{medium{.density = 1000, .sound_speed = sound_speed, .backscatter = 0.1F, .flowing = true}};
        body.build(exec::par);
        const auto flows = [](object_id, vec3, float) { return vec3{0, 0, 0.1F}; };
        const auto power_below = [&](float from) {
            const iq_ensemble echoes =
                doppler_ensemble(exec::par_unseq, body, probe, pose{}, physical{}, flows,
                                 {.depth = depth, .samples = samples, .pulses = 1, .from = from, .noise_db = -FLT_MAX});
            double power = 0;
            for (std::uint32_t line = 16; line < 80; ++line)
                for (std::uint32_t n = 5 * samples / 8; n < 3 * samples / 4; ++n)
                    power += static_cast<double>(dot(echoes.pulses[0](line, n), echoes.pulses[0](line, n)));
            return power;
        };
        CHECK(power_below(24_mm) == doctest::Approx(power_below(0)).epsilon(1e-3).scale(0));
    }
}

} // namespace doppler_ensemble_test
