#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/tracing/read/ground_truth.hpp>
#include "ground_truth_scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace ground_truth_test {
namespace {

// Muscle of 1.70 MRayl and 1 dB/cm, and a medium as hard and deaf as classic teaching has bone: 7.80 MRayl, 5 dB/cm.
constexpr medium soft{.density = 1700.0F / 1.54F, .sound_speed = 1540, .attenuation = 1_dB_per_cm};

constexpr medium hard{.density = 7800.0F / 4.08F, .sound_speed = 4080, .attenuation = 5_dB_per_cm};

scene with_box(const medium& background, const medium& inside, float from, float to) {
    scene body{background};
    body.add(make_box({-50_mm, -50_mm, from}, {50_mm, 50_mm, to}), inside);
    body.build(exec::par);
    return body;
}

float transmitted_at(const scene& body, float frequency, float depth,
                     label_settings::depth_grid grid = label_settings::depth_grid::geometric) {
    const auto k = static_cast<std::uint32_t>(depth / 0.1_mm);
    return ground_truth(exec::par, body, middle_line(frequency), pose{},
                        physical<>{.bandwidth = pulse_bandwidth::narrow},
                        {.depth = 80_mm, .samples = 800, .grid = grid})
        .transmitted(0, k);
}

} // namespace
} // namespace ground_truth_test

TEST_CASE("the shadow of a bone block is 40 log10 T - 2 (a2 - a1) f d") { // V17
    using namespace ground_truth_test;
    const scene body = with_box(soft, hard, 20_mm, 40_mm), beside = scene{soft}.build(exec::par);
    struct {
        float frequency;
        double expected;
    } const rows[] = {{2.5_MHz, -49.2}, {5_MHz, -89.2}, {7.5_MHz, -129.2}};
    for (const auto& row : rows) {
        const double shadow = decibels(transmitted_at(body, row.frequency, 60.05_mm)) -
                              decibels(transmitted_at(beside, row.frequency, 60.05_mm));
        MESSAGE((row.frequency * 1e-6F), " MHz: shadow ", shadow, " dB, expected ", row.expected);
        CHECK(std::fabs(shadow - row.expected) < 0.1);
    }
}

TEST_CASE("behind a cyst that attenuates less everything is enhanced by 2 (a - a_cyst) f d") { // V16
    using namespace ground_truth_test;
    medium tissue = tissue::tmm_high, cyst = tissue::tmm_cyst;
    tissue.attenuation = 0.7_dB_per_cm;
    cyst.attenuation = 0.05_dB_per_cm;
    const scene body = with_box(tissue, cyst, 20_mm, 40_mm), beside = scene{tissue}.build(exec::par);
    const double enhanced =
        decibels(transmitted_at(body, 5_MHz, 50.05_mm)) - decibels(transmitted_at(beside, 5_MHz, 50.05_mm));
    MESSAGE("enhancement ", enhanced, " dB, expected 13.0");
    CHECK(std::fabs(enhanced - 13.0) < 0.01);
}

TEST_CASE(
    "in one medium the transmitted amplitude falls by 2 a f^b on each metre, on the displayed grid of the display") {
    using namespace ground_truth_test; // V6
    const scene body = scene{medium{.density = 1075, .sound_speed = 1580, .attenuation = 1_dB_per_cm}}.build(exec::par);
    const scene steep =
        scene{medium{.sound_speed = 1540, .attenuation = 0.5_dB_per_cm, .attenuation_power = 1.5F}}.build(exec::par);
    struct {
        float frequency;
        double displayed, steep; // dB/cm
    } const rows[] = {{2.5_MHz, 5.13, 3.9528}, {5_MHz, 10.26, 11.1803}, {7.5_MHz, 15.39, 20.5396}};
    for (const auto& row : rows) {
        const auto slope = [&](const scene& one, label_settings::depth_grid grid) {
            return (decibels(transmitted_at(one, row.frequency, 10.05_mm, grid)) -
                    decibels(transmitted_at(one, row.frequency, 60.05_mm, grid))) /
                   5;
        };
        MESSAGE((row.frequency * 1e-6F), " MHz: ", slope(body, label_settings::depth_grid::displayed),
                " dB a displayed cm, expected ", row.displayed);
        CHECK(slope(body, label_settings::depth_grid::displayed) ==
              doctest::Approx(row.displayed).epsilon(1e-3).scale(1e-30));
        CHECK(slope(body, label_settings::depth_grid::geometric) ==
              doctest::Approx(2 * static_cast<double>(row.frequency) * 1e-6).epsilon(1e-4).scale(1e-30));
        CHECK(slope(steep, label_settings::depth_grid::geometric) ==
              doctest::Approx(row.steep).epsilon(1e-4).scale(1e-30));
    }
}
