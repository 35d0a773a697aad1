#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/gas_reverberation.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace gas_test {
namespace {

constexpr linear_array probe{.lines = 16, .width = 4_mm, .frequency = 5_MHz};
constexpr acquisition scan{.depth = 45_mm, .samples = 9000, .planes = 1};
constexpr medium tissue_above{.density = 1000, .sound_speed = 1540, .attenuation = 0.5_dB_per_cm};

/// Gas from 20 mm on, below a plate from 9 to 12 mm whose surfaces echo.
scene plate_above_gas() {
    scene body{tissue_above};
    body.add(make_box({-30_mm, -30_mm, 9_mm}, {30_mm, 30_mm, 12_mm}),
             medium{.density = 900, .sound_speed = 1540, .attenuation = 1.0_dB_per_cm});
    body.add(make_box({-30_mm, -30_mm, 20_mm}, {30_mm, 30_mm, 90_mm}), tissue::air);
    return std::move(body).build(exec::par);
}

/// The sum of the samples around a displayed depth: an echo is divided between two.
vec2 echo_at(const iq_lines& echoes, float depth) {
    vec2 sum{0, 0};
    const auto middle = static_cast<std::uint32_t>(depth / echoes.depth * static_cast<float>(echoes.samples));
    for (std::uint32_t k = middle - 3; k <= middle + 3; ++k) sum += echoes(8, k);
    return sum;
}
double decibels(vec2 of) { return 20 * std::log10(static_cast<double>(length(of))); }

} // namespace
} // namespace gas_test

TEST_CASE("gas: surfaces above it have a mirror image behind it, and repeat with its own echo where sound returns from "
          "the face") {
    using namespace gas_test;
    const scene body = plate_above_gas();
    const physical<> model{.bandwidth = pulse_bandwidth::narrow};
    const iq_lines bare = trace(exec::par, body, probe, pose{}, model, scan);
    const line_layers found = find_layers(exec::par, body, probe, pose{}, scan);
    const iq_lines seen = add_gas_reverberation(exec::par, bare, found, probe.frequency);
    CHECK(add_gas_reverberation(exec::seq, bare, found, probe.frequency) == seen);
    // dB there and back at 5 MHz: 5 dB/cm of tissue, 10 of the plate.
    const double to_gas = 5 * 1.7 + 10 * 0.3, at_9 = 5 * 0.9, at_12 = 5 * 0.9 + 10 * 0.3;
    // The image of z lies at 40 mm - z; its sound crosses what is between z and the gas twice more.
    CHECK(decibels(echo_at(seen, 28_mm)) - decibels(echo_at(bare, 12_mm)) ==
          doctest::Approx(-2 * (to_gas - at_12)).epsilon(0.01));
    CHECK(decibels(echo_at(seen, 31_mm)) - decibels(echo_at(bare, 9_mm)) ==
          doctest::Approx(-2 * (to_gas - at_9)).epsilon(0.01));
    // From gas to the face and back to gas; from gas to the face to a surface, and the other way round.
    // The lens has 1.224 MRayl, the tissue 1.54.
    const double face = 20 * std::log10((1.54 - 1.224) / (1.54 + 1.224));
    CHECK(decibels(echo_at(seen, 40_mm)) - decibels(echo_at(bare, 20_mm)) ==
          doctest::Approx(face - to_gas).epsilon(0.01));
    const iq_lines faced = add_gas_reverberation(exec::par, bare, found, probe.frequency, {.mirror = 0});
    CHECK(decibels(echo_at(faced, 29_mm)) - decibels(echo_at(bare, 9_mm)) ==
          doctest::Approx(face + 20 * std::log10(2.0) - to_gas).epsilon(0.01));
    // An echo at a depth z has the phase -4 pi f z / c0, and the sign of its reflection.
    const auto phase = [](vec2 echo, float depth) {
        const double turn = 2 * 3.14159265358979 * std::fmod(2 * 5e6 * static_cast<double>(depth) / 1540, 1.0);
        return static_cast<double>(echo.x) * std::cos(turn) - static_cast<double>(echo.y) * std::sin(turn);
    };
    CHECK(phase(echo_at(bare, 12_mm), 12_mm) > 0); // from fat to tissue
    CHECK(phase(echo_at(seen, 28_mm), 28_mm) / static_cast<double>(length(echo_at(seen, 28_mm))) > 0.99);
}

TEST_CASE("gas: the mirror image of speckle has the level that paths find, plane or curved") {
    using namespace gas_test;
    constexpr linear_array wide{.lines = 64, .width = 10_mm, .frequency = 5_MHz};
    constexpr medium speckled{.density = 1060, .sound_speed = 1540, .attenuation = 0.5_dB_per_cm, .backscatter = 1};
    for (const float radius : {0.0F, 9_mm, 18_mm}) {
        scene body{speckled};
        if (radius == 0)
            body.add(make_box({-40_mm, -40_mm, 15_mm}, {40_mm, 40_mm, 60_mm}), tissue::air);
        else
            body.add(make_sphere({0, 0, 15_mm + radius}, radius, 6), tissue::air);
        body.build(exec::par);
        const acquisition image{.depth = 30_mm, .samples = 1200, .planes = 1};
        double straight = 0, followed = 0;
        for (std::uint32_t seed = 1; seed <= 8; ++seed) {
            const physical<> model{.scattering = {.seed = seed}};
            const auto power = [&](const iq_lines& echoes) {
                double sum = 0;
                for (std::uint32_t line = 24; line < 40; ++line)
                    for (std::uint32_t k = 640; k < 1000; ++k) // 16 to 25 mm
                        sum += static_cast<double>(dot(echoes(line, k), echoes(line, k)));
                return sum;
            };
            straight += power(add_gas_reverberation(exec::par, trace(exec::par, body, wide, pose{}, model, image),
                                                    find_layers(exec::par, body, wide, pose{}, image), probe.frequency,
                                                    {.face = 0}));
            followed += power(trace(exec::par, body, wide, pose{}, model, image, paths{}));
        }
        const double difference = 10 * std::log10(straight / followed);
        MESSAGE("gas of radius ", radius * 1e3F, " mm: ", difference, " dB over paths, expected 0");
        CHECK(std::fabs(difference) < 1.5);
    }
}

TEST_CASE("gas: lines without it, or that start in it, are left as they are; bad input is refused") {
    using namespace gas_test;
    scene body{tissue_above};
    body.add(make_box({-30_mm, -30_mm, 8_mm}, {30_mm, 30_mm, 12_mm}), tissue::bone);
    body.build(exec::par);
    const iq_lines bare = trace(exec::par, body, probe, pose{}, physical<>{}, scan);
    const line_layers found = find_layers(exec::par, body, probe, pose{}, scan);
    CHECK(add_gas_reverberation(exec::par, bare, found, probe.frequency) == bare);

    scene in_gas{tissue::air};
    in_gas.add(make_box({-30_mm, -30_mm, 8_mm}, {30_mm, 30_mm, 12_mm}), tissue::bone);
    in_gas.build(exec::par);
    CHECK(add_gas_reverberation(exec::par, bare, find_layers(exec::par, in_gas, probe, pose{}, scan),
                                probe.frequency) == bare);

    CHECK_THROWS_WITH_AS(
        add_gas_reverberation(exec::par, bare, line_layers{}, probe.frequency),
        "add_gas_reverberation: the layers have 0 lines and the echoes 16; give those that find_layers "
        "finds for their probe",
        usage_error);
    CHECK_THROWS_AS(add_gas_reverberation(exec::par, bare, found, probe.frequency, {.mirror = 2}), usage_error);
    CHECK_THROWS_AS(add_gas_reverberation(exec::par, bare, found, probe.frequency, {.face = -1}), usage_error);
}
