#include <insonify/acoustics/tissue.hpp>
#include <insonify/examinations.hpp>
#include <insonify/geometry/shapes.hpp>
#include "plain.hpp"
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

} // namespace

TEST_CASE("examinations: each shows its tissue at the level that its attenuation and gain leave") {
    // 1 + (-55 dB + backscatter - 2.5 dB + 25 dB + gain over loss at the mean depth) / 60 dB; 2.5 dB is how far the mean
    // of decibels lies below the decibels of the mean power.
    struct {
        double measured, expected;
    } const rows[] = {
        {mean_grey(presets::nerve_block, tissue::fat), 0.358 + 2 * (0.85 - 0.6) * 7.5 * 2 / 60},
        {mean_grey(presets::abdomen, tissue::liver), 0.458 - 2 * 0.52 * (std::pow(3.5, 1.05) - 3.5) * 9 / 60},
        {mean_grey(presets::heart, tissue::heart), 0.392 + 2 * (0.5 * 2.5 - 0.45 * std::pow(2.5, 1.1)) * 10 / 60},
        {mean_grey(presets::intravascular, tissue::vessel_wall), 0.508}};
    for (const auto& row : rows) {
        MESSAGE("grey ", row.measured, ", expected ", row.expected);
        CHECK(std::fabs(row.measured - row.expected) < 0.03);
    }
}

} // namespace examinations_test
