#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
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

TEST_CASE("gas: the mirror image of speckle has the level of the spread sound, plane or curved, by straight lines and "
          "by paths") {
    using namespace gas_test;
    constexpr medium speckled{.density = 1060, .sound_speed = 1540, .backscatter = 1};
    constexpr float gas_depth = 15_mm;
    for (const float radius : {0.0F, 9_mm, 18_mm, -60_mm, -20_mm, -10_mm}) { // below 0: a ball of tissue in gas
        scene body{radius < 0 ? tissue::air : speckled};
        if (radius < 0)
            body.add(make_sphere({0, 0, gas_depth + radius}, -radius, 7), speckled);
        else if (radius == 0)
            body.add(make_box({-40_mm, -40_mm, gas_depth}, {40_mm, 40_mm, 60_mm}), tissue::air);
        else
            body.add(make_sphere({0, 0, gas_depth + radius}, radius, 6), tissue::air);
        body.build(exec::par);
        for (const std::uint32_t lines : {64U, 192U}) {
            const linear_array wide{.lines = lines, .width = 16_mm, .frequency = 5_MHz};
            const acquisition image{.depth = 30_mm, .samples = 1200, .planes = 1};
            constexpr int bands = 3, rows = 120; // of 3 mm, from 16 mm on
            double tissue[bands] = {}, straight[bands] = {}, own[bands] = {}, followed[bands] = {}; // power
            for (std::uint32_t seed = 1; seed <= 8; ++seed) {
                const physical<> model{.scattering = {.seed = seed}};
                const auto add_power = [&](const iq_lines& echoes, double* to, bool in_front = false) {
                    for (std::uint32_t line = 3 * lines / 8; line < 5 * lines / 8; ++line)
                        for (std::uint32_t k = 640; k < 640 + bands * rows; ++k) {
                            const vec2 echo = echoes(line, in_front ? image.samples - k : k);
                            to[(k - 640) / rows] += static_cast<double>(dot(echo, echo));
                        }
                };
                const iq_lines bare = trace(exec::par, body, wide, pose{}, model, image);
                const line_layers found = find_layers(exec::par, body, wide, pose{}, image);
                add_power(bare, own, true);
                add_power(add_reverberation(exec::par, bare, found, wide, model, {.face = 0}), straight);
                // A curved mirror has the sound of each line pass elsewhere: levels are those behind the kernel.
                add_power(convolve(exec::par, bare, pulse{}, wide), tissue, true);
                add_power(
                    convolve(exec::par, trace(exec::par, body, wide, pose{}, model, image, paths{}), pulse{}, wide),
                    followed);
            }
            for (int band = 0; band < bands; ++band) {
                double expected = 0, narrowest = 1;
                for (int row = 0; row < rows; ++row) {
                    const double from_gas = (1.0 + 3 * band + (row + 0.5) * 3 / rows) * 1e-3,
                                 spread = radius == 0 ? 1 : std::fabs(1 + 2 * from_gas / static_cast<double>(radius));
                    expected += 1 / (std::max(spread, 0.5) * std::max(spread, 0.5)) / rows;
                    narrowest = std::min(narrowest, spread);
                }
                const auto over_expected = [&](double power, double reference) {
                    return 10 * std::log10(power / reference / expected);
                };
                const double by_lines = over_expected(straight[band], own[band]),
                             by_paths = over_expected(followed[band], tissue[band]);
                MESSAGE("gas of radius ", radius * 1e3F, " mm, ", lines, " lines, ", 16 + 3 * band,
                        " mm deep: straight ", by_lines, ", paths ", by_paths, " dB, expected 0");
                CHECK(std::fabs(by_lines) < 0.5);
                CHECK(std::fabs(by_paths) <
                      (narrowest > 0.5 ? 1.0 : 2.5)); // in a focus the bound on the gain is a convention
            }
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

namespace gas_test {
namespace {

constexpr linear_array wide{.lines = 96, .width = 30_mm, .frequency = 5_MHz};
constexpr acquisition hazy{.depth = 45_mm, .samples = 3000, .planes = 1};

/// Bone in uniform speckle, with or without a bright plate at 12 mm, seen by a probe that is moved.
struct bone_scene {
    mesh bone = make_box({-30_mm, -30_mm, 20_mm}, {30_mm, 30_mm, 90_mm});
    medium within = tissue::bone;
    float attenuation = 0;
    bool has_plate = false;
    std::uint32_t seed = 1;
    vec3 moved{0, 0, 0};
    reverberation_settings settings{};

    template <class Policy>
    iq_lines seen(const Policy& policy, const linear_array& by) const {
        const medium speckled{.density = 1050, .sound_speed = 1540, .attenuation = attenuation, .backscatter = 1};
        scene body{speckled};
        medium plate = speckled;
        plate.density = 1100;
        if (has_plate) body.add(make_box({-30_mm, -30_mm, 12_mm}, {30_mm, 30_mm, 12.4_mm}), plate);
        body.add(bone, within);
        body.build(exec::par);
        physical<> model{.bandwidth = pulse_bandwidth::narrow};
        model.scattering.seed = seed;
        const pose at{.translation = moved};
        return add_reverberation(policy, trace(policy, body, by, at, model, hazy),
                                 find_layers(policy, body, by, at, hazy), by, model, settings);
    }
};

/// Sample at a displayed depth.
std::uint32_t slot(float depth) {
    return static_cast<std::uint32_t>(depth / hazy.depth * static_cast<float>(hazy.samples));
}
/// Mean power of a displayed depth, of the lines in the middle.
double power(const iq_lines& echoes, float from, float to) {
    double sum = 0, count = 0;
    for (std::uint32_t line = echoes.count * 2 / 5; line < echoes.count * 3 / 5; ++line)
        for (std::uint32_t k = slot(from); k < slot(to); ++k, ++count)
            sum += static_cast<double>(dot(echoes(line, k), echoes(line, k)));
    return sum / count;
}
/// Mean power at h behind flat bone at 20 mm, relative to that in front of it: each echo from h' in front, h' < 20 mm,
/// is spread evenly over h' - 5 mm to h' + 5 mm, and folded there at the surface.
double haze_at(double h) {
    const double r = (1910.0 * 3500 - 1050.0 * 1540) / (1910.0 * 3500 + 1050.0 * 1540);
    double sum = 0;
    constexpr int steps = 1000;
    for (int i = 0; i < steps; ++i) {
        const double u = -5e-3 + 10e-3 * (i + 0.5) / steps;
        for (const double source : {h - u, -h - u})
            if (source > 0 && source < 20e-3) sum += 1 / ((1 + source / 10e-3) * (1 + source / 10e-3)) / steps;
    }
    return r * r * r * r * sum;
}

} // namespace
} // namespace gas_test

TEST_CASE("reverberation: the shadow of flat bone begins with the power of what it mirrors, and darkens") {
    using namespace gas_test;
    for (const float attenuation : {0.0F, 0.5_dB_per_cm}) { // at 1 MHz
        constexpr float depths[] = {20.7_mm, 23_mm, 28_mm, 34_mm};
        constexpr double half_squared = 0.25; // the default haze, as power
        double before = 0, behind[4] = {};
        for (std::uint32_t seed = 1; seed <= 8; ++seed) {
            const iq_lines full = bone_scene{.attenuation = attenuation, .seed = seed}.seen(exec::par, wide);
            const auto compensated = [&](float from) { // the 2 mm from there on; 5 MHz, there and back
                return power(full, from, from + 2_mm) *
                       std::pow(10.0, static_cast<double>((from + 1_mm) * 2 * 5 * attenuation / 10));
            };
            before += 0.5 * (compensated(8_mm) + compensated(16_mm)) / 8;
            for (int i = 0; i < 4; ++i) behind[i] += compensated(depths[i]) / 8;
        }
        for (int i = 0; i < 4; ++i) {
            const double level = 10 * std::log10(behind[i] / before),
                         expected = 10 * std::log10(half_squared * haze_at(static_cast<double>(depths[i]) - 19e-3));
            MESSAGE(attenuation, " dB/m, ", depths[i] * 1e3F, " mm: ", level, " dB of the tissue in front, expected ",
                    expected);
            CHECK(std::fabs(level - expected) < 1.5);
        }
    }
}

TEST_CASE("reverberation: haze shows no image, and is that of bone alone") {
    using namespace gas_test;
    const iq_lines plated = bone_scene{.has_plate = true}.seen(exec::par, wide);
    double together = 0, alone = 0; // the image of the plate, at 27.8 mm, would be the same in all lines
    for (std::uint32_t k = slot(27.3_mm); k < slot(28.3_mm); ++k) {
        vec2 sum{0, 0};
        for (std::uint32_t line = 0; line < 96; ++line) {
            sum += plated(line, k) / 96.0F;
            alone += static_cast<double>(dot(plated(line, k), plated(line, k))) / 96;
        }
        together += static_cast<double>(dot(sum, sum));
    }
    MESSAGE("power of the mean of all lines at the image of the plate: ", together / alone, " of the mean power");
    CHECK(together < 0.1 * alone);
    CHECK(bone_scene{.has_plate = true}.seen(exec::seq, wide) == plated);
    const iq_lines none = bone_scene{.has_plate = true, .settings = {.haze = 0}}.seen(exec::par, wide);
    CHECK(power(none, 22_mm, 36_mm) < 1e-6 * power(plated, 22_mm, 36_mm));
    CHECK(bone_scene{.within = tissue::steel}.seen(exec::par, wide) ==
          bone_scene{.within = tissue::steel, .settings = {.haze = 0}}.seen(exec::par, wide));
    CHECK(power(bone_scene{.within = tissue::bone_trabecular}.seen(exec::par, wide), 22_mm, 26_mm) > 0);
    // Sound diverges behind a ball: 1 / (1 + 2 h / 8 mm).
    const iq_lines round = bone_scene{.bone = make_sphere({0, 0, 28_mm}, 8_mm, 6)}.seen(exec::par, wide);
    const iq_lines flat = bone_scene{}.seen(exec::par, wide);
    CHECK(power(round, 30_mm, 34_mm) < 0.2 * power(flat, 30_mm, 34_mm));
    // A hollow neither focuses nor spreads it: bone with a round roof of 10 mm radius, 20 mm below the face in the middle.
    mesh hollow = make_box({-30_mm, -30_mm, 10_mm}, {30_mm, 30_mm, 40_mm}, 6);
    for (vec3& p : hollow.positions)
        if (p.z < 11_mm) p.z = std::fmax(20_mm - (p.x * p.x + p.y * p.y) / 20_mm, 10_mm);
    const double kept =
        power(bone_scene{.bone = hollow}.seen(exec::par, wide), 30_mm, 34_mm) / power(flat, 30_mm, 34_mm);
    MESSAGE("haze behind a hollow: ", 10 * std::log10(kept), " dB of that behind flat bone, expected 0");
    CHECK(std::fabs(10 * std::log10(kept)) < 0.5);
}

TEST_CASE(
    "reverberation: haze stays with resting tissue when the probe moves, and does not depend on the spacing of lines") {
    using namespace gas_test;
    const auto displayed = [&](const linear_array& by, vec3 moved) {
        return envelope(exec::par,
                        convolve(exec::par, bone_scene{.moved = moved}.seen(exec::par, by), nominal_pulse(by), by));
    };
    const scan_lines rest = displayed(wide, {0, 0, 0}), closer = displayed(wide, {0, 0, 0.03_mm}); // by two samples
    const auto correlation = [&](float from, float to, std::uint32_t shift) {
        double ab = 0, aa = 0, bb = 0, a = 0, b = 0, count = 0;
        for (std::uint32_t line = 20; line < 76; ++line)
            for (std::uint32_t k = slot(from); k < slot(to); ++k, ++count) {
                const auto x = static_cast<double>(closer(line, k)), y = static_cast<double>(rest(line, k + shift));
                ab += x * y, aa += x * x, bb += y * y, a += x, b += y;
            }
        return (ab - a * b / count) / std::sqrt((aa - a * a / count) * (bb - b * b / count));
    };
    const double tissue = correlation(8_mm, 18_mm, 2), haze = correlation(22_mm, 32_mm, 2);
    MESSAGE("moved by 0.03 mm: tissue correlates by ", tissue, ", haze by ", haze);
    CHECK(haze > 0.9);
    const auto level = [](const scan_lines& lines) { // of haze, relative to tissue
        double sum[2] = {};
        for (std::uint32_t line = lines.count / 4; line < lines.count * 3 / 4; ++line)
            for (std::uint32_t k = 0; k < slot(10_mm); ++k) {
                const float before = lines(line, slot(8_mm) + k), behind = lines(line, slot(22_mm) + k);
                sum[0] += static_cast<double>(before * before);
                sum[1] += static_cast<double>(behind * behind);
            }
        return 10 * std::log10(sum[1] / sum[0]);
    };
    linear_array dense = wide;
    dense.lines = 288;
    const double coarse_db = level(rest), dense_db = level(displayed(dense, {0, 0, 0}));
    MESSAGE("haze under the tissue: 96 lines ", coarse_db, " dB, 288 lines ", dense_db, " dB");
    CHECK(std::fabs(coarse_db - dense_db) < 1);
}

TEST_CASE("reverberation: bone at the face, at the edge of the picture, or with few samples leaves finite echoes") {
    using namespace gas_test;
    for (const float depth : {0.02_mm, 0.3_mm, 1_mm, 4_mm, 44.9_mm, 60_mm}) {
        const bone_scene at{.bone = make_box({-30_mm, -30_mm, depth}, {30_mm, 30_mm, 90_mm})};
        for (const vec2 one : at.seen(exec::par, wide).values) REQUIRE(is_finite(one.x + one.y));
    }
    scene body{medium{.density = 1050, .sound_speed = 1540, .backscatter = 1}};
    body.add(make_box({-30_mm, -30_mm, 20_mm}, {30_mm, 30_mm, 90_mm}), tissue::bone);
    body.build(exec::par);
    const acquisition few{.depth = 45_mm, .samples = 9, .planes = 1};
    const iq_lines seen = add_reverberation(exec::par, trace(exec::par, body, wide, pose{}, physical{}, few),
                                            find_layers(exec::par, body, wide, pose{}, few), wide, physical{});
    for (const vec2 one : seen.values) CHECK(is_finite(one.x + one.y));
}
