#include <insonify/core/units.hpp>
#include <insonify/image/m_mode.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <utility>

using namespace insonify;

namespace m_mode_test {
namespace {

// Two lines; the second has the brightness start + slope * depth.
scan_lines ramp(float start, float slope, std::uint32_t samples = 100, float depth = 50_mm) {
    scan_lines lines{2, samples, depth};
    for (std::uint32_t k = 0; k < samples; ++k)
        lines(1, k) = start + slope * (static_cast<float>(k) + 0.5F) / static_cast<float>(samples) * depth;
    return lines;
}

} // namespace

TEST_CASE("m_mode: columns are the lines in order of time, the newest at the right") {
    m_mode sweep{{.columns = 5, .background = -1}};
    for (int i = 1; i <= 8; ++i) {
        sweep.add(ramp(static_cast<float>(i), 0), 1);
        const image seen = sweep.picture();
        REQUIRE(seen.size == uvec2{5, 100});
        for (std::uint32_t x = 0; x < 5; ++x) {
            const int moment = i - 4 + static_cast<int>(x);
            CHECK(seen(x, 0) == (moment < 1 ? -1.0F : static_cast<float>(moment)));
            CHECK(seen(x, 99) == seen(x, 0));
        }
    }
    CHECK(sweep.count() == 5);
    CHECK(sweep.depth() == 50_mm);
}

TEST_CASE("m_mode: what was moved from begins anew") {
    m_mode sweep{{.columns = 5}};
    sweep.add(ramp(1, 0), 1);
    const m_mode other = std::move(sweep);
    CHECK(other.picture()(4, 99) == 1);
    CHECK(sweep.picture().pixels.empty()); // NOLINT(bugprone-use-after-move)
    sweep.add(ramp(2, 0), 1);
    CHECK(sweep.picture()(4, 99) == 2);
    CHECK(sweep.count() == 1);
}

TEST_CASE("m_mode: a moving interface draws its motion, row by depth") {
    // A bright sample at the depth 20 mm + 5 mm sin(t), of 250 samples over 50 mm.
    m_mode motion{{.columns = 64}};
    for (int i = 0; i < 64; ++i) {
        scan_lines lines{3, 250, 50_mm};
        const double z = 20e-3 + 5e-3 * std::sin(0.2 * i);
        lines(2, static_cast<std::uint32_t>(z / 50e-3 * 250)) = 1;
        motion.add(lines, 2);
    }
    const image seen = motion.picture();
    double worst = 0;
    for (std::uint32_t x = 0; x < 64; ++x)
        for (std::uint32_t y = 0; y < 250; ++y)
            if (seen(x, y) == 1)
                worst = std::max(worst, std::fabs((y + 0.5) / 250 * 50e-3 - (20e-3 + 5e-3 * std::sin(0.2 * x))));
    MESSAGE("largest error of depth: ", 1e3 * worst, " mm, expected at most half a row, 0.1 mm");
    CHECK(worst <= 0.1001e-3);
}

TEST_CASE("m_mode: rows are linear between samples, constant beyond the first and the last") {
    m_mode sweep{{.columns = 1, .rows = 37}};
    sweep.add(ramp(0.25F, 10), 1);
    const image seen = sweep.picture();
    double worst = 0;
    for (std::uint32_t y = 1; y < 36; ++y)
        worst = std::max(worst, std::fabs(static_cast<double>(seen(0, y)) - (0.25 + 10 * 0.05 * (y + 0.5) / 37)));
    MESSAGE("largest error on a ramp: ", worst, ", expected 0");
    CHECK(worst < 1e-6);
    m_mode fine{{.columns = 1, .rows = 400}};
    fine.add(ramp(0.25F, 10), 1);
    CHECK(fine.picture()(0, 0) == ramp(0.25F, 10)(1, 0));
    CHECK(fine.picture()(0, 399) == ramp(0.25F, 10)(1, 99));
}

TEST_CASE(
    "m_mode: starts anew where the depth changes; settings out of range and lines that do not exist are refused") {
    m_mode sweep{{.columns = 4, .rows = 10}};
    for (int i = 0; i < 3; ++i) sweep.add(ramp(1, 0), 1);
    sweep.add(ramp(1, 0, 200), 1); // other samples, the same rows
    CHECK(sweep.count() == 4);
    sweep.add(ramp(1, 0, 100, 40_mm), 1);
    CHECK(sweep.count() == 1);
    CHECK(sweep.depth() == 40_mm);
    CHECK(sweep.picture()(2, 5) == 0);
    CHECK(sweep.picture()(3, 5) == 1);
    CHECK(m_mode{}.picture().pixels.empty());
    CHECK_THROWS_AS(sweep.add(ramp(1, 0), 2), usage_error);
    CHECK_THROWS_AS(sweep.add(scan_lines{}, 0), usage_error);
    CHECK_THROWS_AS(m_mode{{.columns = 0}}, usage_error);
    CHECK_THROWS_AS(m_mode{{.rows = 1U << 20U}}, usage_error);
    CHECK_THROWS_AS(m_mode{{.background = NAN}}, usage_error);
}

} // namespace m_mode_test
