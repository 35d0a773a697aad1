#include <insonify/acoustics/tissue.hpp>
#include <insonify/examinations.hpp>
#include <insonify/geometry/shapes.hpp>
#include "plain.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace examinations_test {
namespace {

/// Mean grey of the field of view: the corners are marked by a background of -1.
template <class Probe>
double mean_grey(const examination<Probe>& how, const medium& tissue) {
    b_mode_settings settings = how.settings;
    settings.background = -1;
    settings.size = {160, 0};
    settings.planes = 1;
    const image picture = b_mode(exec::par_unseq, scene{plain(tissue)}.build(exec::par), how.probe, pose{}, settings);
    double sum = 0, count = 0;
    for (const float grey : picture.pixels)
        if (grey >= 0) {
            sum += static_cast<double>(grey);
            count += 1;
        }
    return sum / count;
}

/// Mean grey of speckle whose mean power changes linearly with depth, dB per metre, over a field of view that widens from
/// an arc of a radius: the power of speckle is distributed exponentially.
double expected_grey(const b_mode_settings& how, double radius, double level_db, double db_per_metre) {
    const int steps = 200;
    double sum = 0, weights = 0;
    for (int i = 0; i < steps; ++i)
        for (int j = 0; j < steps; ++j) {
            const double depth = (i + 0.5) / steps * static_cast<double>(how.depth), weight = radius + depth;
            const double power = -std::log((j + 0.5) / steps);
            const double level = level_db + db_per_metre * depth + 10 * std::log10(power);
            const double grey =
                1 + (level - static_cast<double>(how.reference_db)) / static_cast<double>(how.dynamic_range_db);
            sum += weight * static_cast<double>(how.grey(static_cast<float>(grey)));
            weights += weight;
        }
    return sum / weights;
}

} // namespace

TEST_CASE("examinations: each shows its tissue at the level that its attenuation and gain leave") {
    const auto level = [](const medium& tissue) {
        return -55 + 20 * std::log10(static_cast<double>(tissue.backscatter));
    };
    examination<linear_array> nerve = presets::nerve_block;
    examination<convex_array> abdomen = presets::abdomen;
    nerve.settings.compound.angles = abdomen.settings.compound.angles = 1; // the speckle of one look
    struct {
        double measured, expected;
    } const rows[] = {
        // dB per metre there and back: of the gain, less those of the tissue
        {mean_grey(nerve, tissue::fat),
         expected_grey(nerve.settings, 1e6, level(tissue::fat), 200 * (0.85 - 0.6) * 7.5)},
        {mean_grey(abdomen, tissue::liver),
         expected_grey(abdomen.settings, 0.06, level(tissue::liver), -200 * 0.52 * (std::pow(3.5, 1.05) - 3.5))},
        {mean_grey(presets::heart, tissue::heart), expected_grey(presets::heart.settings, 0, level(tissue::heart),
                                                                 200 * (0.5 * 2.5 - 0.45 * std::pow(2.5, 1.1)))},
        {mean_grey(presets::intravascular, tissue::vessel_wall),
         expected_grey(presets::intravascular.settings, 0.5e-3, level(tissue::vessel_wall), 0)}};
    for (const auto& row : rows) {
        MESSAGE("grey ", row.measured, ", expected ", row.expected);
        CHECK(std::fabs(row.measured - row.expected) < 0.03);
    }
}

// Clinical images of calf and thigh, of 256 grey levels: muscle has a mean of 54 to 115 (medians of two scanners), fat lies
// 16 below to 22 above it, and the fascia at least 85 above it.
TEST_CASE("examinations: muscle, fat and the fascia between them have the greys of clinical images") {
    scene body{tissue::fat};
    const pose tilted = look_at({0, 0, 8_mm}, {std::sin(4_deg) * 1_m, 0, 8_mm + std::cos(4_deg) * 1_m}, {1, 0, 0});
    body.add(make_box({-40_mm, -40_mm, 0}, {40_mm, 40_mm, 60_mm}), tissue::muscle,
             {.at = tilted, .fibres = {1, 0, 0.05F}});
    body.build(exec::par);
    b_mode_settings how = presets::nerve_block.settings;
    how.size = {190, 200}; // 0.2 mm
    how.planes = 3;
    const image seen = b_mode(exec::par_unseq, body, presets::nerve_block.probe, pose{}, how);
    double muscle = 0, fat = 0, fascia = 0, black = 0;
    for (std::uint32_t x = 20; x < 170; ++x) {
        float peak = 0;
        for (std::uint32_t y = 8; y < 28; ++y) fat += 255.0 * static_cast<double>(seen(x, y)) / (150 * 20);
        for (std::uint32_t y = 32; y < 50; ++y) peak = std::max(peak, seen(x, y));
        for (std::uint32_t y = 55; y < 175; ++y) {
            muscle += 255.0 * static_cast<double>(seen(x, y)) / (150 * 120);
            black += seen(x, y) < 3 / 255.0F ? 1.0 / (150 * 120) : 0;
        }
        fascia += 255.0 * static_cast<double>(peak) / 150;
    }
    MESSAGE("muscle ", muscle, ", fat ", fat, ", fascia ", fascia, ", black ", 100 * black, " %");
    CHECK(muscle > 54);
    CHECK(muscle < 115);
    CHECK(fat > muscle - 16);
    CHECK(fat < muscle + 22);
    CHECK(fascia > muscle + 85);
    CHECK(fascia < 250); // not white, though a plane border is brighter than an uneven one
    CHECK(black < 0.02);
}

} // namespace examinations_test
