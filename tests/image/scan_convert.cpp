#include <insonify/core/units.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include "scan_lines.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <doctest/doctest.h>

using namespace insonify;

namespace scan_convert_test {
namespace {

/// Position of sample k of line i, derived independently in double precision.
struct centre {
    double x = 0;
    double z = 0;
};

double fraction(std::uint32_t i, std::uint32_t n) { return (static_cast<double>(i) + 0.5) / n - 0.5; }

centre centre_of(const linear_array& p, std::uint32_t line, double depth) {
    return {fraction(line, p.lines) * static_cast<double>(p.width), depth};
}

centre fan_centre(double radius, double angle, double depth) {
    return {(radius + depth) * std::sin(angle), (radius + depth) * std::cos(angle) - radius};
}

centre centre_of(const convex_array& p, std::uint32_t line, double depth) {
    return fan_centre(static_cast<double>(p.radius), fraction(line, p.lines) * static_cast<double>(p.field_of_view),
                      depth);
}

centre centre_of(const phased_array& p, std::uint32_t line, double depth) {
    return fan_centre(0, fraction(line, p.lines) * static_cast<double>(p.field_of_view), depth);
}

centre centre_of(const steered_array& p, std::uint32_t line, double depth) {
    return {fraction(line, p.lines) * static_cast<double>(p.width) + depth * 0.34202014, depth * 0.93969262};
}

/// Lines that image a round spot: a function of the distance from it.
template <class Probe>
scan_lines lines_of_spot(const Probe& probe, centre spot, double sigma, float depth, std::uint32_t samples) {
    scan_lines lines{probe.lines, samples, depth};
    for (std::uint32_t i = 0; i < probe.lines; ++i)
        for (std::uint32_t k = 0; k < samples; ++k) {
            const centre at = centre_of(probe, i, (fraction(k, samples) + 0.5) * static_cast<double>(depth));
            const double d2 = (at.x - spot.x) * (at.x - spot.x) + (at.z - spot.z) * (at.z - spot.z);
            lines(i, k) = static_cast<float>(std::exp(-d2 / (2 * sigma * sigma)));
        }
    return lines;
}

/// In pixel coordinates.
centre centroid(const image& picture) {
    centre sum{};
    double weight = 0;
    for (std::uint32_t y = 0; y < picture.size.y; ++y)
        for (std::uint32_t x = 0; x < picture.size.x; ++x) {
            const double v = static_cast<double>(picture(x, y));
            sum.x += v * (x + 0.5);
            sum.z += v * (y + 0.5);
            weight += v;
        }
    return {sum.x / weight, sum.z / weight};
}

/// The largest displacement of a grid of points in the image, in pixels.
/// @param middle  centre of the image, metres
template <class Probe>
double worst_of_grid(const Probe& probe, float depth, uvec2 size, double pitch, centre middle) {
    double worst = 0;
    int points = 0;
    const scan_map map = make_scan_map(exec::par, probe, {.depth = depth, .samples = 400}, {.size = size});
    CHECK(map.size == size);
    CHECK(static_cast<double>(map.pitch.x) == doctest::Approx(pitch).scale(1e-30).epsilon(1e-3));
    CHECK(static_cast<double>(map.pitch.y) == doctest::Approx(pitch).scale(1e-30).epsilon(1e-3));
    const double sigma = 3 * pitch;
    for (double x = -0.06; x < 0.061; x += 0.015)
        for (double z = 0.007; z < 0.08; z += 0.015) {
            // only spots that are entirely in the field of view
            const vec2 at = probe.locate({static_cast<float>(x), static_cast<float>(z)});
            const vec2 left = probe.locate({static_cast<float>(x - 5 * sigma), static_cast<float>(z - 5 * sigma)});
            const vec2 right = probe.locate({static_cast<float>(x + 5 * sigma), static_cast<float>(z - 5 * sigma)});
            const float lines = static_cast<float>(probe.lines);
            if (left.x < 0 || right.x > lines - 1 || at.y < 0.004F || at.y > depth - 0.004F) continue;
            const image picture = scan_convert(exec::par, lines_of_spot(probe, {x, z}, sigma, depth, map.samples), map);
            const centre seen = centroid(picture);
            const double column = (x - middle.x) / pitch + 0.5 * size.x;
            const double row = (z - middle.z) / pitch + 0.5 * size.y;
            worst = std::max(worst, std::hypot(seen.x - column, seen.z - row));
            ++points;
        }
    CHECK(points >= 9);
    MESSAGE(points, " points, the worst off by ", worst, " pixels");
    return worst;
}

} // namespace

TEST_CASE("scan_convert: a grid of points lands within half a pixel") {
    CHECK(worst_of_grid(linear_array{.lines = 400, .width = 60_mm}, 80_mm, {300, 400}, 0.0002, {0, 0.04}) < 0.5);
    // 60 degrees of radius 60 mm and depth 80 mm: from 60 cos 30 - 60 to 80 mm, 140 mm wide
    CHECK(worst_of_grid(convex_array{.lines = 400, .radius = 60_mm, .field_of_view = 60_deg}, 80_mm, {700, 441}, 0.0002,
                        {0, (0.08 + 0.06 * (0.8660254 - 1)) / 2}) < 0.5);
    // 90 degrees and depth 80 mm: 113.137 mm wide
    CHECK(worst_of_grid(phased_array{.lines = 400, .field_of_view = 90_deg}, 80_mm, {566, 400}, 0.0002, {0, 0.04}) <
          0.5);
    // 40 mm wide, then 80 sin 20 further; 80 cos 20 deep
    CHECK(worst_of_grid(steered_array{}, 80_mm, {337, 376}, 0.0002,
                        {0.5 * 0.08 * 0.34202014, 0.5 * 0.08 * 0.93969262}) < 0.5);
}

TEST_CASE("scan_convert: a pixel at a sample has its value") {
    const linear_array probe{.lines = 30, .width = 30_mm};
    scan_lines lines{30, 40, 40_mm};
    for (std::size_t i = 0; i < lines.values.size(); ++i) lines.values[i] = static_cast<float>((i * 7919) % 997) / 997;
    const image picture = scan_convert(exec::seq, lines, probe, {.size = {30, 40}});
    for (std::uint32_t x = 0; x < 30; ++x)
        for (std::uint32_t y = 0; y < 40; ++y) CHECK(std::fabs(picture(x, y) - lines(x, y)) < 1e-5F);
}

TEST_CASE("scan_convert: bilinear between lines and samples, constant beyond the outermost") {
    const linear_array probe{.lines = 20, .width = 20_mm};
    scan_lines lines{20, 10, 20_mm};
    for (std::uint32_t i = 0; i < 20; ++i)
        for (std::uint32_t k = 0; k < 10; ++k) lines(i, k) = static_cast<float>(2 * i + 5 * k + i * k);
    const image picture = scan_convert(exec::seq, lines, probe, {.size = {200, 200}});
    for (std::uint32_t x = 0; x < 200; ++x)
        for (std::uint32_t y = 0; y < 200; ++y) {
            const double i = std::clamp((x + 0.5) / 10 - 0.5, 0.0, 19.0);
            const double k = std::clamp((y + 0.5) / 20 - 0.5, 0.0, 9.0);
            REQUIRE(static_cast<double>(picture(x, y)) ==
                    doctest::Approx(2 * i + 5 * k + i * k).scale(1e-30).epsilon(1e-4));
        }
}

TEST_CASE("scan_convert: bilinear between two lines of two samples") {
    const linear_array probe{.lines = 2, .width = 2_mm};
    scan_lines lines{2, 2, 2_mm};
    lines.values = {1, 2, 3, 4};
    const image picture = scan_convert(exec::seq, lines, probe, {.size = {8, 8}});
    const auto fraction = [](std::uint32_t pixel) { // of the second one, which lies 4 pixels beyond the first
        return std::clamp((static_cast<float>(pixel) + 0.5F) / 4 - 0.5F, 0.0F, 1.0F);
    };
    for (std::uint32_t x = 0; x < 8; ++x)
        for (std::uint32_t y = 0; y < 8; ++y)
            CHECK(std::fabs(picture(x, y) - (1 + 2 * fraction(x) + fraction(y))) < 1e-5F);
}

TEST_CASE("scan_convert: a rectangular field of view fills the image, whatever its aspect ratio") {
    const linear_array probe{.lines = 20, .width = 20_mm};
    scan_lines lines{20, 10, 40_mm};
    for (std::uint32_t i = 0; i < 20; ++i)
        for (std::uint32_t k = 0; k < 10; ++k) lines(i, k) = static_cast<float>(i + 100 * k);
    for (const uvec2 size : {uvec2{200, 800}, {100, 40}, {20, 100}}) {
        const scan_map map = make_scan_map(exec::seq, probe, {.depth = 40_mm, .samples = 10}, {.size = size});
        const vec2 pitch{20_mm / static_cast<float>(size.x), 40_mm / static_cast<float>(size.y)};
        CHECK(static_cast<double>(map.pitch.x) == doctest::Approx(pitch.x).scale(1e-30).epsilon(1e-5));
        CHECK(static_cast<double>(map.pitch.y) == doctest::Approx(pitch.y).scale(1e-30).epsilon(1e-5));
        const image picture = scan_convert(exec::seq, lines, map);
        double worst = 0;
        for (std::uint32_t y = 0; y < size.y; ++y)
            for (std::uint32_t x = 0; x < size.x; ++x) {
                const double i = std::clamp((x + 0.5) * 20 / size.x - 0.5, 0.0, 19.0);
                const double k = std::clamp((y + 0.5) * 10 / size.y - 0.5, 0.0, 9.0);
                worst = std::max(worst, std::fabs(static_cast<double>(picture(x, y)) - i - 100 * k));
                const vec2 at = map.point(x, y), back = map.pixel(at) - vec2{0.5F, 0.5F};
                worst = std::max(worst, std::hypot(static_cast<double>(back.x) - x, static_cast<double>(back.y) - y));
            }
        MESSAGE(size.x, " x ", size.y, ": off by ", worst);
        CHECK(worst < 1e-2);
    }
}

TEST_CASE("scan_convert: a sector is centred in images of another aspect ratio, the rest is background") {
    const phased_array probe{.lines = 60, .field_of_view = 60_deg}; // 40 mm wide, 40 mm deep
    const scan_lines lines = filled(60, 10, 40_mm, 1);
    const auto filled_box = [&](uvec2 size) { // first and last column, first and last row
        const image picture = scan_convert(exec::seq, lines, probe, {.size = size, .background = 0.25F});
        std::array<std::uint32_t, 4> box{size.x, 0, size.y, 0};
        for (std::uint32_t y = 0; y < size.y; ++y)
            for (std::uint32_t x = 0; x < size.x; ++x)
                if (picture(x, y) == 1)
                    box = {std::min(box[0], x), std::max(box[1], x), std::min(box[2], y), std::max(box[3], y)};
                else
                    REQUIRE(picture(x, y) == 0.25F);
        return box;
    };
    const auto off = [&](uvec2 size, std::array<std::uint32_t, 4> expected) { // in pixels
        const std::array<std::uint32_t, 4> box = filled_box(size);
        int worst = 0;
        for (std::size_t i = 0; i < 4; ++i)
            worst = std::max(worst, std::abs(static_cast<int>(box[i]) - static_cast<int>(expected[i])));
        return worst;
    };
    CHECK(off({160, 80}, {40, 119, 0, 79}) <= 1); // the corners of the arc may miss the centres of pixels
    CHECK(off({80, 160}, {0, 79, 40, 119}) <= 1);
}

TEST_CASE("scan_convert: a size of 0 is chosen to fit the field of view") {
    const acquisition scan{.depth = 45_mm, .samples = 10};
    const linear_array probe{.lines = 4, .width = 60_mm};
    const auto size = [&](uvec2 asked) { return make_scan_map(exec::seq, probe, scan, {.size = asked}).size; };
    CHECK(size({512, 0}) == uvec2{512, 384});
    CHECK(size({0, 384}) == uvec2{512, 384});
    CHECK(size({0, 0}) == uvec2{512, 384});
    CHECK(size({512, 384}) == uvec2{512, 384});
    CHECK(size({1, 0}) == uvec2{1, 1});
}

TEST_CASE("scan_convert: the field of view of a sector extends half a line beyond the outermost lines") {
    const phased_array probe{.lines = 9, .field_of_view = 90_deg};
    const std::uint32_t rows = 200;
    const image picture =
        scan_convert(exec::seq, filled(9, 50, 100_mm, 1), probe, {.size = {2 * rows, rows}, .background = 0});
    int inside = 0;
    for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < 2 * rows; ++x) {
            const double across = x + 0.5 - rows, down = y + 0.5;
            const double beyond_arc = std::hypot(across, down) - rows, beyond_side = std::fabs(across) - down;
            if (std::fabs(beyond_arc) < 0.01 || std::fabs(beyond_side) < 0.01) continue; // on the border
            const bool in_fan = beyond_arc < 0 && beyond_side < 0;
            REQUIRE(picture(x, y) == (in_fan ? 1 : 0));
            inside += in_fan;
        }
    CHECK(inside == doctest::Approx(3.14159265 / 4 * rows * rows).scale(1e-30).epsilon(0.02));
}

TEST_CASE("scan_convert: a curved face separates background and field of view") {
    const convex_array probe{.lines = 64, .radius = 60_mm, .field_of_view = 60_deg};
    const scan_map map = make_scan_map(exec::seq, probe, {.depth = 80_mm, .samples = 64}, {.size = {700, 0}});
    const image picture = scan_convert(exec::seq, filled(64, 64, 80_mm, 1), map);
    const auto grey = [&](float x, float z) {
        const vec2 at = map.pixel({x, z});
        return picture(static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y));
    };
    CHECK(grey(0, 1_mm) == 1);
    CHECK(grey(0, -1_mm) == 0);
    CHECK(grey(0, 79_mm) == 1);
    CHECK(grey(-25_mm, -4_mm) == 1); // 61.3 mm from the apex, at 24.1 degrees
    CHECK(grey(-25_mm, -7_mm) == 0); // 58.6 mm
    CHECK(grey(40_mm, 0) == 0);      // 33.7 degrees
}

TEST_CASE("scan_convert: the field of view of a full circle is an annulus") {
    const convex_array probe{.lines = 64, .radius = 10_mm, .field_of_view = 360_deg};
    const scan_map map = make_scan_map(exec::seq, probe, {.depth = 30_mm, .samples = 64}, {.size = {200, 0}});
    CHECK(map.size == uvec2{200, 200});
    const image picture = scan_convert(exec::seq, filled(64, 64, 30_mm, 1), map);
    CHECK(picture(100, 100) == 0);
    for (const uvec2 inside : {uvec2{100, 20}, uvec2{20, 100}, uvec2{180, 100}, uvec2{100, 180}, uvec2{40, 40}})
        CHECK(picture(inside.x, inside.y) == 1);
    CHECK(picture(5, 5) == 0);
}

TEST_CASE("scan_convert: a single line and a single sample are legal") {
    const linear_array one{.lines = 1, .width = 10_mm};
    scan_lines column{1, 10, 10_mm};
    for (std::uint32_t k = 0; k < 10; ++k) column(0, k) = static_cast<float>(k);
    const image picture = scan_convert(exec::seq, column, one, {.size = {10, 10}});
    for (std::uint32_t y = 0; y < 10; ++y)
        CHECK(picture(7, y) == doctest::Approx(static_cast<double>(y)).scale(1).epsilon(1e-5));
    const image level = scan_convert(exec::seq, filled(1, 1, 10_mm, 0.5F), one, {.size = {10, 10}});
    CHECK(std::count(level.pixels.begin(), level.pixels.end(), 0.5F) == 100);
}

TEST_CASE("scan_convert: a full circle has no seam") {
    const auto check_circle = [](const auto& probe, vec2 axis) {
        const acquisition scan{.depth = 5_mm, .samples = 100};
        const scan_map map = make_scan_map(exec::par, probe, scan, {.size = {301, 301}, .background = -5});
        scan_lines lines{probe.lines, scan.samples, scan.depth};
        for (std::uint32_t line = 0; line < probe.lines; ++line)
            for (std::uint32_t k = 0; k < scan.samples; ++k)
                lines(line, k) = probe.beam(static_cast<float>(line)).direction.z; // smooth across the seam
        label_lines labels{probe.lines, scan.samples, scan.depth};
        for (std::uint32_t line = 0; line < probe.lines; ++line)
            for (std::uint32_t k = 0; k < scan.samples; ++k) labels(line, k) = line;

        const image picture = scan_convert(exec::seq, lines, map);
        const label_image nearest = scan_convert(exec::seq, labels, map);
        double worst = 0;
        std::uint32_t inside = 0;
        for (std::uint32_t y = 0; y < 301; ++y)
            for (std::uint32_t x = 0; x < 301; ++x) {
                const vec2 from_axis = map.point(x, y) - axis;
                const float distance = length(from_axis);
                if (distance < 1.01_mm || distance > 5.99_mm) continue;
                ++inside;
                worst = std::max(
                    worst, std::fabs(static_cast<double>(picture(x, y)) - static_cast<double>(from_axis.y / distance)));
                const float line = probe.locate(map.point(x, y)).x;
                const auto lines_in_all = static_cast<float>(probe.lines);
                const float apart = std::fabs(line - static_cast<float>(nearest(x, y)));
                REQUIRE(std::min(apart, lines_in_all - apart) < 0.51F);
            }
        CHECK(inside > 50000);
        CHECK(worst < 1e-3); // linear between lines 2 pi / 96 apart
    };
    check_circle(radial_array{.lines = 96, .radius = 1_mm}, {0, 0});
    check_circle(convex_array{.lines = 96, .radius = 1_mm, .field_of_view = 360_deg}, {0, -1_mm});
}

} // namespace scan_convert_test
