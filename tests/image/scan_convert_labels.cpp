#include <insonify/core/units.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace label_image_test {
namespace {

// Every sample has a different label, which identifies the source of a pixel.
label_lines numbered(std::uint32_t count, std::uint32_t samples, float depth) {
    label_lines lines{count, samples, depth};
    for (std::uint32_t i = 0; i < lines.values.size(); ++i) lines.values[i] = i;
    return lines;
}

struct place {
    double line, depth;
};

// Line and depth of a pixel in a sector, in double precision.
place in_fan(std::uint32_t lines, double radius, double field_of_view, vec2 point) {
    const double x = static_cast<double>(point.x), z = static_cast<double>(point.y) + radius;
    return {(std::atan2(x, z) / field_of_view + 0.5) * lines - 0.5, std::hypot(x, z) - radius};
}

// Compares every pixel with the nearest sample, except half way between two.
template <class Probe, class Locate>
void check_pixels(const Probe& probe, float depth, std::uint32_t samples, uvec2 size, const Locate& locate) {
    const label_lines lines = numbered(probe.lines, samples, depth);
    const scan_map map = make_scan_map(exec::par, probe, {.depth = depth, .samples = samples}, {.size = size});
    const label_image picture = scan_convert(exec::par, lines, map);
    CHECK(picture.size == map.size);
    CHECK(picture == scan_convert(exec::seq, lines, probe, {.size = size}));
    std::size_t wrong = 0, inside = 0, outside = 0, doubtful = 0;
    for (std::uint32_t y = 0; y < map.size.y; ++y)
        for (std::uint32_t x = 0; x < map.size.x; ++x) {
            const place at = locate(map.point(x, y));
            const double sample = at.depth / static_cast<double>(depth) * samples - 0.5;
            const double line_fraction = at.line - std::floor(at.line), fraction = sample - std::floor(sample);
            if (std::fabs(line_fraction - 0.5) < 1e-3 || std::fabs(fraction - 0.5) < 1e-3) {
                ++doubtful; // this includes the border of the field
                continue;
            }
            const double line = std::round(at.line), k = std::round(sample);
            const bool seen = line >= 0 && line < probe.lines && k >= 0 && k < samples;
            const label_id expected = seen ? static_cast<label_id>(line * samples + k) : background_label;
            if (picture(x, y) != expected) ++wrong;
            ++(seen ? inside : outside);
        }
    MESSAGE(inside, " pixels inside the field, ", outside, " outside, ", doubtful, " half way between two samples");
    CHECK(wrong == 0);
    CHECK(inside > map.size.x * map.size.y / 4);
    CHECK(doubtful < map.size.x * map.size.y / 50);
}

} // namespace
} // namespace label_image_test

TEST_CASE(
    "an image of labels has the nearest sample of each pixel, and the background label outside the field of view") {
    using namespace label_image_test;
    check_pixels(linear_array{.lines = 37, .width = 38_mm}, 50_mm, 211, {330, 0}, [](vec2 point) {
        return place{(static_cast<double>(point.x) / 0.038 + 0.5) * 37 - 0.5, static_cast<double>(point.y)};
    });
    const convex_array convex{.lines = 41, .radius = 40_mm, .field_of_view = 1.2F};
    check_pixels(convex, 70_mm, 97, {0, 301}, [](vec2 point) { return in_fan(41, 0.04, 1.2, point); });
    const phased_array phased{.lines = 29, .field_of_view = 1.5F};
    check_pixels(phased, 70_mm, 300, {301, 0}, [](vec2 point) { return in_fan(29, 0, 1.5, point); });
}

TEST_CASE("a single line or sample of labels fills the whole field of view") {
    for (const uvec2 counts : {uvec2{1, 1}, uvec2{1, 30}, uvec2{30, 1}}) {
        label_lines lines{counts.x, counts.y, 20_mm};
        for (label_id& value : lines.values) value = 7;
        const label_image picture =
            scan_convert(exec::par, lines, linear_array{.lines = counts.x, .width = 10_mm}, {.size = {50, 100}});
        for (const label_id pixel : picture.pixels) CHECK(pixel == 7);
    }
}

TEST_CASE("an image of labels is equal for any number of threads, and lines that do not match the map are refused") {
    const convex_array probe{};
    const label_lines lines = label_image_test::numbered(192, 100, 80_mm);
    const scan_map map = make_scan_map(exec::par, probe, {.depth = 80_mm, .samples = 100});
    const label_image reference = scan_convert(exec::seq, lines, map);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
        CHECK(scan_convert(exec::par.threads(threads), lines, map) == reference);
    const auto refused = "scan_convert: the number of lines, of samples or the depth differs from that of the map; "
                         "make a new one with make_scan_map";
    CHECK_THROWS_WITH_AS(scan_convert(exec::par, label_lines{192, 101, 80_mm}, map), refused, usage_error);
    CHECK_THROWS_WITH_AS(scan_convert(exec::par, label_lines{191, 100, 80_mm}, map), refused, usage_error);
    CHECK_THROWS_WITH_AS(scan_convert(exec::par, label_lines{192, 100, 81_mm}, map), refused, usage_error);
    CHECK_THROWS_AS(scan_convert(exec::par, label_lines{}, probe), usage_error);
    label_lines torn = lines;
    torn.values.pop_back();
    CHECK_THROWS_WITH_AS(scan_convert(exec::par, torn, map), refused, usage_error);
}

TEST_CASE("nearest-neighbour values are not interpolated, nor mixed with the background") {
    const phased_array probe{.lines = 16};
    scan_lines lines{16, 40, 60_mm};
    for (std::size_t i = 0; i < lines.values.size(); ++i) lines.values[i] = static_cast<float>(i);
    const scan_map map =
        make_scan_map(exec::par, probe, {.depth = 60_mm, .samples = 40}, {.size = {300, 0}, .background = -1});
    const image picture = scan_convert_nearest(exec::par, lines, map);
    const label_image expected = scan_convert(exec::par, label_image_test::numbered(16, 40, 60_mm), map);
    CHECK(picture.size == expected.size);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
        REQUIRE(picture.pixels[i] ==
                (expected.pixels[i] == background_label ? -1.0F : static_cast<float>(expected.pixels[i])));
}
