#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/probe/presets.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <doctest/doctest.h>
#include <numeric>
#include <vector>

using namespace insonify;

namespace in_use_test {
namespace {

constexpr int columns = 150, rows = 120; // 15 mm x 12 mm, 10 pixels per mm

/// Inverse of the standard normal distribution. Source: bisection of std::erfc.
double normal_quantile(double p) {
    double below = -6, above = 6;
    for (int i = 0; i < 40; ++i) {
        const double middle = (below + above) / 2;
        (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? below : above) = middle;
    }
    return below;
}

/// Gaussian smoothing with a standard deviation of 0.5 mm along one axis; mirrored at the borders.
std::vector<double> smoothed(const std::vector<double>& z, int count, int step, int other_count, int other_step) {
    std::vector<double> out(z.size());
    for (int j = 0; j < other_count; ++j)
        for (int i = 0; i < count; ++i) {
            double sum = 0, weights = 0;
            for (int d = -20; d <= 20; ++d) {
                int k = i + d;
                if (k < 0) k = -1 - k;
                if (k >= count) k = 2 * count - 1 - k;
                const double w = std::exp(-d * d / 50.0);
                sum += w * z[static_cast<std::size_t>(k * step + j * other_step)];
                weights += w;
            }
            out[static_cast<std::size_t>(i * step + j * other_step)] = sum / weights;
        }
    return out;
}

/// Full width at half maximum, mm, of the autocovariance of a window of a picture: axial, lateral. As measured on real
/// pictures: gray levels are ranked to a normal distribution and variations above 0.5 mm removed.
vec2 cell_of(std::vector<double> z) {
    std::vector<std::size_t> order(z.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return z[a] < z[b]; });
    for (std::size_t r = 0; r < order.size(); ++r)
        z[order[r]] = normal_quantile((static_cast<double>(r) + 0.5) / static_cast<double>(z.size()));
    const std::vector<double> low = smoothed(smoothed(z, columns, 1, rows, columns), rows, columns, columns, 1);
    for (std::size_t i = 0; i < z.size(); ++i) z[i] -= low[i];
    const auto covariance = [&](int dx, int dy) {
        double sum = 0;
        for (int y = 0; y + dy < rows; ++y)
            for (int x = 0; x + dx < columns; ++x)
                sum += z[static_cast<std::size_t>(y * columns + x)] *
                       z[static_cast<std::size_t>((y + dy) * columns + x + dx)];
        return sum / ((rows - dy) * (columns - dx));
    };
    const auto width = [&](int dx, int dy) {
        double before = covariance(0, 0);
        const double half = before / 2;
        for (int i = 1; i < 60; ++i) {
            const double here = covariance(i * dx, i * dy);
            if (here < half) return static_cast<float>(0.2 * (i - 1 + (before - half) / (before - here)));
            before = here;
        }
        return 12.0F;
    };
    return {width(0, 1), width(1, 0)};
}

/// Mean cell of four windows at depths of 8 to 25 mm in muscle, along its fibres.
vec2 cell_of(const linear_array& probe) {
    scene body{tissue::muscle};
    body.set_background_fibres({1, 0, 0});
    body.build(exec::par);
    vec2 sum{0, 0};
    const image seen = b_mode(exec::par_unseq, body, probe, pose{},
                              {.depth = 40_mm,
                               .size = {static_cast<std::uint32_t>(probe.width * 1e4F + 0.5F), 400},
                               .gain_db = 10,
                               .noise = {.level_db = no_level_db}});
    for (const std::uint32_t top : {80U, 130U})
        for (const std::uint32_t left : {20U, 200U}) {
            std::vector<double> z;
            for (std::uint32_t y = 0; y < rows; ++y)
                for (std::uint32_t x = 0; x < columns; ++x) z.push_back(static_cast<double>(seen(left + x, top + y)));
            sum += 0.25F * cell_of(z);
        }
    return sum;
}

} // namespace

TEST_CASE("speckle cells: presets in use have those of clinical pictures, transducers have finer ones") {
    const linear_array l7{.frequency = 7_MHz, .focus = 20_mm}, l9{.frequency = 9_MHz, .focus = 20_mm};
    for (const linear_array& one : {presets::in_use(l7), presets::in_use(presets::l11_5v),
                                    presets::in_use(presets::l12_3v), presets::in_use(l9)}) {
        const vec2 cell = cell_of(one);
        MESSAGE(one.frequency, " Hz: ", cell.x, " x ", cell.y, " mm, expected 0.23 to 0.33 x 0.7 to 1.1 mm");
        CHECK(cell.x >= 0.23F);
        CHECK(cell.x <= 0.33F);
        CHECK(cell.y >= 0.7F);
        CHECK(cell.y <= 1.1F);
    }
    const vec2 own = cell_of(presets::l11_5v);
    MESSAGE("the transducer's own: ", own.x, " x ", own.y, " mm");
    CHECK(own.x < 0.2F);
    CHECK(own.y < 0.95F);
}

TEST_CASE("presets in use: a narrower bandwidth or a larger F-number of the transducer stays") {
    static_assert(presets::in_use(linear_array{.fnumber = 6, .bandwidth = 0.2F}).bandwidth == 0.2F);
    static_assert(presets::in_use(linear_array{.fnumber = 6, .bandwidth = 0.2F}).fnumber == 6);
    static_assert(presets::in_use(presets::p4_2v).bandwidth == presets::p4_2v.bandwidth); // 0.74 of 2.72 MHz: 2.0 MHz
    static_assert(presets::in_use(presets::l11_5v).width == presets::l11_5v.width);
}

} // namespace in_use_test
