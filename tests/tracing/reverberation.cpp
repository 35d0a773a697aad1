#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/reverberation.hpp>
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

/// Gas from 20 mm on, below a weak plate from 5 to 7 mm and a strong one from 9 to 12 mm.
scene plates_above_gas() {
    scene body{tissue_above};
    body.add(make_box({-30_mm, -30_mm, 5_mm}, {30_mm, 30_mm, 7_mm}),
             medium{.density = 1010, .sound_speed = 1540, .attenuation = 0.5_dB_per_cm});
    body.add(make_box({-30_mm, -30_mm, 9_mm}, {30_mm, 30_mm, 12_mm}),
             medium{.density = 1800, .sound_speed = 1540, .attenuation = 1.0_dB_per_cm});
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
    const scene body = plates_above_gas();
    const physical<> model{.bandwidth = pulse_bandwidth::narrow};
    const iq_lines bare = trace(exec::par, body, probe, pose{}, model, scan);
    const line_layers found = find_layers(exec::par, body, probe, pose{}, scan);
    const iq_lines seen = add_reverberation(exec::par, bare, found, probe, model);
    CHECK(add_reverberation(exec::seq, bare, found, probe, model) == seen);
    const auto level = [](const iq_lines& echoes, float depth) { return decibels(echo_at(echoes, depth)); };
    // dB there and back at 5 MHz: 5 dB/cm of tissue, 10 of the strong plate, and at each of its surfaces.
    const double r = (1800.0 - 1000) / (1800 + 1000), surface = -20 * std::log10(1 - r * r);
    const double to_gas = 5 * 1.7 + 10 * 0.3 + 2 * surface, at_5 = 5 * 0.5;
    // The image of z lies at 40 mm - z; its sound crosses what is between z and the gas twice more.
    CHECK(level(seen, 35_mm) - level(bare, 5_mm) == doctest::Approx(-2 * (to_gas - at_5)).scale(1e-30).epsilon(0.005));
    // From gas to the face and back to gas; from gas to the face to a surface, and the other way round. The lens has
    // 1.224 MRayl, the tissue 1.54.
    const double face = 20 * std::log10((1.54 - 1.224) / (1.54 + 1.224));
    CHECK(level(seen, 40_mm) - level(bare, 20_mm) == doctest::Approx(face - to_gas).scale(1e-30).epsilon(0.005));
    const iq_lines faced = add_reverberation(exec::par, bare, found, probe, model, {.mirror = 0});
    CHECK(level(faced, 29_mm) - level(bare, 9_mm) ==
          doctest::Approx(face + 20 * std::log10(2.0) - to_gas).scale(1e-30).epsilon(0.005));
    // An echo at a depth z has the phase -4 pi f z / c0.
    const vec2 image = echo_at(seen, 35_mm);
    const double turn = 2 * 3.14159265358979 * std::fmod(2 * 5e6 * 35e-3 / 1540, 1.0);
    CHECK(std::fabs(static_cast<double>(image.x) * std::cos(turn) - static_cast<double>(image.y) * std::sin(turn)) >
          0.99 * static_cast<double>(length(image)));
}

TEST_CASE("gas: the mirror image of speckle has the level that paths find, plane or curved") {
    using namespace gas_test;
    constexpr linear_array wide{.lines = 64, .width = 10_mm, .frequency = 5_MHz};
    constexpr medium speckled{.density = 1060, .sound_speed = 1540, .attenuation = 0.5_dB_per_cm, .backscatter = 1};
    for (const float radius : {0.0F, 9_mm, 18_mm, -60_mm, -20_mm, -10_mm}) { // below 0: a ball of tissue in gas
        scene body{radius < 0 ? tissue::air : speckled};
        if (radius < 0)
            body.add(make_sphere({0, 0, 15_mm + radius}, -radius, 7), speckled);
        else if (radius == 0)
            body.add(make_box({-40_mm, -40_mm, 15_mm}, {40_mm, 40_mm, 60_mm}), tissue::air);
        else
            body.add(make_sphere({0, 0, 15_mm + radius}, radius, 6), tissue::air);
        body.build(exec::par);
        const acquisition image{.depth = 30_mm, .samples = 1200, .planes = 1};
        double straight[3] = {}, followed[3] = {}; // power in bands of 3 mm, from 16 mm on
        for (std::uint32_t seed = 1; seed <= 8; ++seed) {
            const physical<> model{.scattering = {.seed = seed}};
            const auto add_power = [&](const iq_lines& echoes, double* to) {
                for (std::uint32_t line = 24; line < 40; ++line)
                    for (std::uint32_t k = 640; k < 1000; ++k)
                        to[(k - 640) / 120] += static_cast<double>(dot(echoes(line, k), echoes(line, k)));
            };
            add_power(add_reverberation(exec::par, trace(exec::par, body, wide, pose{}, model, image),
                                        find_layers(exec::par, body, wide, pose{}, image), wide, model, {.face = 0}),
                      straight);
            add_power(trace(exec::par, body, wide, pose{}, model, image, paths{}), followed);
        }
        for (int band = 0; band < 3; ++band) {
            const double difference = 10 * std::log10(straight[band] / followed[band]);
            MESSAGE("gas of radius ", radius * 1e3F, " mm, ", 16 + 3 * band, " mm deep: ", difference,
                    " dB over paths, expected 0");
            CHECK(std::fabs(difference) < 1.2);
        }
    }
}

TEST_CASE("gas: depths are those at which the model displays, and a tilted surface sends no sound back to the face") {
    using namespace gas_test;
    scene body{medium{.density = 930, .sound_speed = 1455}};
    body.add(make_box({-30_mm, -30_mm, 20_mm}, {30_mm, 30_mm, 90_mm}), tissue::air);
    body.build(exec::par);
    for (const timing how : {timing::sound_speed, timing::uniform}) {
        const physical<> model{.timing = how};
        const float shown = how == timing::uniform ? 20_mm : 20_mm * 1540 / 1455;
        const iq_lines seen = add_reverberation(exec::par, trace(exec::par, body, probe, pose{}, model, scan),
                                                find_layers(exec::par, body, probe, pose{}, scan), probe, model);
        CHECK(decibels(echo_at(seen, 2 * shown)) - decibels(echo_at(seen, shown)) > -40); // it repeats there
    }
    const auto repeated = [&](float tilt, const auto& seen_by) {
        scene tilted{tissue_above};
        const pose turned =
            look_at({0, 0, 20_mm}, vec3{0, 0, 20_mm} + vec3{std::sin(tilt), 0, std::cos(tilt)}, {0, 1, 0});
        tilted.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 90_mm}), tissue::air, {.at = turned});
        tilted.build(exec::par);
        const iq_lines zeros{seen_by.lines, scan.samples, scan.depth};
        iq_lines ones = zeros;
        for (vec2& value : ones.values) value = {1, 0};
        const iq_lines seen = add_reverberation(exec::par, ones, find_layers(exec::par, tilted, seen_by, pose{}, scan),
                                                seen_by, physical<>{}, {.mirror = 0});
        return static_cast<double>(length(seen(8, 6000) - ones(8, 6000)));
    };
    CHECK(repeated(0, probe) > 0.01);
    CHECK(repeated(25_deg, probe) < 0.02 * repeated(0, probe));
    CHECK(repeated(0, steered<linear_array>{probe, 20_deg}) < 0.02 * repeated(0, probe)); // oblique to the face
}

TEST_CASE("gas: lines without it, or that start in it, are left as they are; bad input is refused") {
    using namespace gas_test;
    scene body{tissue_above};
    body.add(make_box({-30_mm, -30_mm, 8_mm}, {30_mm, 30_mm, 12_mm}), tissue::bone);
    body.build(exec::par);
    const iq_lines bare = trace(exec::par, body, probe, pose{}, physical<>{}, scan);
    const line_layers found = find_layers(exec::par, body, probe, pose{}, scan);
    CHECK(add_reverberation(exec::par, bare, found, probe, physical<>{}) == bare);

    scene in_gas{tissue::air};
    in_gas.add(make_box({-30_mm, -30_mm, 8_mm}, {30_mm, 30_mm, 12_mm}), tissue::bone);
    in_gas.build(exec::par);
    CHECK(add_reverberation(exec::par, bare, find_layers(exec::par, in_gas, probe, pose{}, scan), probe,
                            physical<>{}) == bare);

    CHECK_THROWS_WITH_AS(add_reverberation(exec::par, bare, line_layers{}, probe, physical<>{}),
                         "add_reverberation: the layers have 0 lines and the probe 16; give those that find_layers "
                         "finds for this probe",
                         usage_error);
    CHECK_THROWS_WITH_AS(add_reverberation(exec::par, iq_lines{}, found, probe, physical<>{}),
                         "add_reverberation: the echoes must have as many lines as the probe, and a value for "
                         "every sample",
                         usage_error);
    CHECK_THROWS_AS(add_reverberation(exec::par, bare, found, probe, physical<>{}, {.mirror = 2}), usage_error);
    CHECK_THROWS_AS(add_reverberation(exec::par, bare, found, probe, physical<>{}, {.face = -1}), usage_error);
    CHECK_THROWS_AS(add_reverberation(exec::par, bare, found, probe, physical<>{}, {.haze = NAN}), usage_error);
}

TEST_CASE(
    "reverberation: the shadow of flat bone has the power of what it mirrors, without its surfaces; that of a ball "
    "darkens") {
    using namespace gas_test;
    constexpr linear_array wide{.lines = 96, .width = 30_mm, .frequency = 5_MHz};
    constexpr medium speckled{.density = 1050, .sound_speed = 1540, .backscatter = 1};
    constexpr acquisition image{.depth = 45_mm, .samples = 3000, .planes = 1};
    // Mean power of a displayed depth, of the lines in the middle.
    const auto slot = [&](float depth) {
        return static_cast<std::uint32_t>(depth / image.depth * static_cast<float>(image.samples));
    };
    const auto power = [&](const iq_lines& echoes, float from, float to) {
        double sum = 0, count = 0;
        for (std::uint32_t line = 40; line < 56; ++line)
            for (auto k = slot(from); k < slot(to); ++k) {
                sum += static_cast<double>(dot(echoes(line, k), echoes(line, k)));
                ++count;
            }
        return sum / count;
    };
    const auto seen = [&](mesh bone, const reverberation_settings& settings, std::uint32_t seed,
                          bool has_plate = true) {
        scene body{speckled};
        medium plate = speckled; // its faces are brighter than the speckle
        plate.density = 1100;
        if (has_plate) body.add(make_box({-30_mm, -30_mm, 12_mm}, {30_mm, 30_mm, 12.4_mm}), plate);
        body.add(std::move(bone), tissue::bone);
        body.build(exec::par);
        const physical<> model{.scattering = {.seed = seed}};
        return add_reverberation(exec::par, trace(exec::par, body, wide, pose{}, model, image),
                                 find_layers(exec::par, body, wide, pose{}, image), wide, model, settings);
    };
    const mesh block = make_box({-30_mm, -30_mm, 20_mm}, {30_mm, 30_mm, 90_mm}),
               ball = make_sphere({0, 0, 28_mm}, 8_mm, 6);
    constexpr float depths[] = {22_mm, 26_mm, 30_mm, 34_mm};         // the image of the plate lies at 27.8 mm
    double before = 0, behind[4] = {}, usual = 0, near = 0, far = 0; // those of a ball relative to what it mirrors
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        const iq_lines hazy = seen(block, {.haze = 1}, seed), round = seen(ball, {.haze = 1}, seed, false);
        before += 0.5 * (power(hazy, 4_mm, 11_mm) + power(hazy, 14_mm, 19_mm));
        for (int i = 0; i < 4; ++i) behind[i] += power(hazy, depths[i], depths[i] + 4_mm);
        usual += power(seen(block, {}, seed), 22_mm, 26_mm);
        near += power(round, 20.5_mm, 22_mm) / power(round, 15_mm, 19_mm);
        far += power(round, 32_mm, 34_mm) / power(round, 2_mm, 12_mm);
        CHECK(power(seen(block, {.haze = 0}, seed), 22_mm, 36_mm) < 1e-6 * power(hazy, 22_mm, 36_mm));
    }
    const double r = (1910.0 * 3500 - 1050.0 * 1540) / (1910.0 * 3500 + 1050.0 * 1540), expected = 40 * std::log10(r);
    for (int i = 0; i < 4; ++i) {
        const double level = 10 * std::log10(behind[i] / before);
        MESSAGE(depths[i] * 1e3F, " mm: ", level, " dB of the tissue in front, expected ", expected);
        CHECK(std::fabs(level - expected) < 1.5); // the plate counts up to three times as much as the tissue around
    }
    CHECK(usual == doctest::Approx(0.16 * behind[0]));
    // Behind a ball of 8 mm radius sound diverges: 1 / (1 + 2 h / 8 mm) at h behind it.
    const double falls = 10 * std::log10(near / far), diverges = 20 * std::log10((1 + 13 / 4.0) / (1 + 1.25 / 4.0));
    MESSAGE("from 1.25 to 13 mm behind a ball the haze falls by ", falls, " dB, expected ", diverges);
    CHECK(std::fabs(falls - diverges) < 1.5);
}
