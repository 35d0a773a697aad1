#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/paper/picture.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

namespace blur_test {
namespace {

template <class Probe>
scan_map map_for(const Probe& probe, uvec2 size, float background = 0) {
    return make_scan_map(exec::par, probe, {.depth = 80_mm, .samples = 100}, {.size = size, .background = background});
}

image random_picture(const scan_map& map) {
    image picture{map.size, map.background};
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
        if (map.first[i] != scan_map::outside) picture.pixels[i] = hash_uniform(1, i);
    return picture;
}

/// Mean and standard deviation of the angle (radians) and of the radius (metres) about a point, weighted by brightness.
struct spread {
    double angle = 0, angle_deviation = 0, radius = 0, radius_deviation = 0;
};
spread spread_about(const image& picture, const scan_map& map, double apex_z) {
    double w = 0, a = 0, aa = 0, r = 0, rr = 0;
    for (std::uint32_t y = 0; y < map.size.y; ++y)
        for (std::uint32_t x = 0; x < map.size.x; ++x) {
            const vec2 at = map.point(x, y);
            const double v = static_cast<double>(picture(x, y));
            const double dx = static_cast<double>(at.x), dz = static_cast<double>(at.y) - apex_z;
            const double angle = std::atan2(dx, dz), radius = std::hypot(dx, dz);
            w += v, a += v * angle, aa += v * angle * angle, r += v * radius, rr += v * radius * radius;
        }
    a /= w, r /= w;
    return {a, std::sqrt(std::fmax(0, aa / w - a * a)), r, std::sqrt(std::fmax(0, rr / w - r * r))};
}

} // namespace

TEST_CASE("radial_blur: a uniform field stays uniform up to its border, without bleeding of the background") {
    const auto level = [](const auto& probe) {
        const scan_map map = map_for(probe, {300, 260}, 0.75F);
        image picture{map.size, 0.75F};
        for (std::size_t i = 0; i < picture.pixels.size(); ++i)
            if (map.first[i] != scan_map::outside) picture.pixels[i] = 0.5F;
        const image blurred = radial_blur(exec::par, picture, probe, map, {.lines = 20, .frames = 7});
        for (std::size_t i = 0; i < picture.pixels.size(); ++i)
            REQUIRE(blurred.pixels[i] == doctest::Approx(picture.pixels[i]).epsilon(1e-6).scale(1e-30));
    };
    level(linear_array{});
    level(convex_array{});
    level(phased_array{});
}

TEST_CASE("radial_blur: zero displacement, or a single frame, changes nothing") {
    const convex_array probe{};
    const scan_map map = map_for(probe, {300, 260});
    const image picture = random_picture(map);
    for (const radial_blur_settings& none : {radial_blur_settings{.lines = 0}, radial_blur_settings{.frames = 1}}) {
        const image blurred = radial_blur(exec::par, picture, probe, map, none);
        double worst = 0;
        for (std::size_t i = 0; i < picture.pixels.size(); ++i)
            worst = std::fmax(worst, static_cast<double>(std::fabs(blurred.pixels[i] - picture.pixels[i])));
        CHECK(worst < 1e-3); // a pixel found through beam and locate, with rounding errors
    }
}

TEST_CASE("radial_blur: a sector is rotated about its apex, by the same angle at every depth") {
    const convex_array probe{.lines = 120, .radius = 60_mm, .field_of_view = 60_deg};
    const scan_map map = map_for(probe, {1400, 0});
    for (const float depth : {15_mm, 40_mm, 70_mm}) {
        const ray beam = probe.beam(40);
        const vec3 spot = beam.at(depth);
        image picture{map.size};
        for (std::uint32_t y = 0; y < map.size.y; ++y)
            for (std::uint32_t x = 0; x < map.size.x; ++x) {
                const vec2 d = (map.point(x, y) - vec2{spot.x, spot.z}) / 0.4_mm;
                picture(x, y) = std::exp(-0.5F * (d.x * d.x + d.y * d.y));
            }
        const image blurred = radial_blur(exec::par, picture, probe, map, {.lines = 6, .frames = 48});
        const spread before = spread_about(picture, map, -0.06), after = spread_about(blurred, map, -0.06);
        CHECK(after.angle == doctest::Approx(before.angle).epsilon(1e-3).scale(1e-30));
        CHECK(after.radius == doctest::Approx(before.radius).epsilon(1e-4).scale(1e-30));
        CHECK(after.radius_deviation == doctest::Approx(before.radius_deviation).epsilon(0.02).scale(1e-30));
        // a box of +-6 lines of 0.5 degrees has a standard deviation of 6 / sqrt(3) lines
        const double box = 6 / std::sqrt(3.0) * 0.5 * 3.14159265 / 180;
        CHECK(after.angle_deviation ==
              doctest::Approx(std::hypot(before.angle_deviation, box)).epsilon(0.02).scale(1e-30));
    }
}

TEST_CASE("radial_blur: a linear array is translated, by the same distance at every depth") {
    const linear_array probe{.lines = 80, .width = 40_mm};
    const scan_map map = map_for(probe, {400, 0}); // pixels of 0.1 mm, 5 per line
    image picture{map.size};
    for (const std::uint32_t row : {100U, 400U, 700U}) picture(200, row) = 1;
    const image blurred = radial_blur(exec::par, picture, probe, map, {.lines = 4.5F, .frames = 9});
    // nine frames, one line or five pixels apart
    for (std::uint32_t y = 0; y < map.size.y; ++y)
        for (std::uint32_t x = 0; x < map.size.x; ++x) {
            const bool copy = (y == 100 || y == 400 || y == 700) && x >= 180 && x <= 220 && x % 5 == 0;
            REQUIRE(std::fabs(blurred(x, y) - (copy ? 1.0F / 9 : 0.0F)) < 1e-3F);
        }
}

TEST_CASE("radial_blur: bit-equal for any number of threads") {
    const phased_array probe{};
    const scan_map map = map_for(probe, {200, 0});
    const image picture = random_picture(map);
    const image reference = radial_blur(exec::seq, picture, probe, map);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
        CHECK(radial_blur(exec::par.threads(threads), picture, probe, map) == reference);
}

TEST_CASE("radial_blur: inputs that do not match and settings out of range are refused") {
    const phased_array probe{};
    const scan_map map = map_for(probe, {200, 0});
    const image picture = random_picture(map);
    CHECK_THROWS_AS(radial_blur(exec::seq, image{{200, 7}}, probe, map), usage_error);
    CHECK_THROWS_AS(radial_blur(exec::seq, image{}, probe, map), usage_error);
    CHECK_THROWS_AS(radial_blur(exec::seq, picture, phased_array{.lines = 7}, map), usage_error);
    CHECK_THROWS_AS(radial_blur(exec::seq, picture, probe, map, {.frames = 0}), usage_error);
    for (const float bad : {-1.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
        CHECK_THROWS_AS(radial_blur(exec::seq, picture, probe, map, {.lines = bad}), usage_error);
}

} // namespace blur_test
