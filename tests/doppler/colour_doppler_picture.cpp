#include <insonify/core/units.hpp>
#include <insonify/doppler/colour_doppler.hpp>
#include <insonify/probe/linear_array.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace doppler_picture_test {
namespace {

const linear_array probe{.lines = 8, .width = 8_mm};

/// Lines of one velocity and power.
flow_lines even(float velocity, float power) {
    flow_lines lines;
    lines.reshape(8, 10, 10_mm);
    lines.max_velocity = 0.3F;
    for (flow_sample& each : lines.values) each = {.velocity = velocity, .power = power, .variance = 0};
    return lines;
}

} // namespace

TEST_CASE("Doppler picture: velocity by pixel, 0 where power or velocity is too small") {
    const image picture = doppler_picture(exec::par, even(-0.2F, 1e-9F), probe, {.size = {80, 100}});
    CHECK(picture.size == uvec2{80, 100});
    for (const float pixel : picture.pixels) CHECK(pixel == doctest::Approx(-0.2).scale(1e-30).epsilon(1e-4));
    for (const float pixel : doppler_picture(exec::par, even(-0.2F, 1e-13F), probe).pixels) CHECK(pixel == 0);
    for (const float pixel : doppler_picture(exec::par, even(0.02F, 1), probe, {.min_velocity = 0.03F}).pixels)
        CHECK(pixel == 0);
    CHECK(picture == doppler_picture(exec::seq, even(-0.2F, 1e-9F), probe, {.size = {80, 100}}));
    CHECK_THROWS_AS(doppler_picture(exec::seq, flow_lines{}, probe), usage_error);
}

TEST_CASE("Doppler picture: between aliased velocities there is none of 0") {
    flow_lines lines = even(0.28F, 1);
    for (std::uint32_t k = 5; k < 10; ++k)
        for (std::uint32_t line = 0; line < 8; ++line) lines(line, k).velocity = -0.28F; // 0.32 m/s, aliased
    float slowest = 1;
    for (const float pixel : doppler_picture(exec::par, lines, probe, {.size = {80, 100}}).pixels)
        slowest = std::min(slowest, std::fabs(pixel));
    MESSAGE("the slowest pixel has ", slowest, " m/s, expected at least 0.28");
    CHECK(slowest > 0.279F);
}

TEST_CASE("colour overlay: red towards the probe, blue away, grey where tissue is bright or there is no flow") {
    image grey{{8, 10}, 0.2F};
    grey(3, 4) = 0.9F;
    const colour_image towards = colour_overlay(exec::par, grey, even(0.2F, 1e-9F), probe),
                       away = colour_overlay(exec::par, grey, even(-0.2F, 1e-9F), probe),
                       none = colour_overlay(exec::par, grey, even(0.2F, 1e-14F), probe),
                       power = colour_overlay(exec::par, grey, even(0.2F, 1e-9F), probe, {.map = doppler_map::power});
    CHECK(towards(0, 0).x > towards(0, 0).z);
    CHECK(away(0, 0).z > away(0, 0).x);
    CHECK(none(0, 0) == vec3{0.2F});
    CHECK(power(0, 0).x > power(0, 0).z);
    CHECK(towards(3, 4) == vec3{0.9F});
    CHECK(colour_overlay(exec::par, grey, even(0.2F, 1), probe, {.max_grey = 1})(3, 4) != vec3{0.9F});
    const char* const refusal = "colour_overlay: the image has no pixels, not as many as its size says, or not the "
                                "size of the map";
    const flow_lines none_flows = even(0, 1);
    const scan_map turned =
        make_scan_map(exec::seq, probe, {.depth = none_flows.depth, .samples = none_flows.samples}, {.size = {10, 8}});
    CHECK_THROWS_WITH(colour_overlay(exec::par, grey, none_flows, turned), refusal);
    grey.pixels.pop_back();
    CHECK_THROWS_WITH(colour_overlay(exec::par, grey, none_flows, probe), refusal);
}

TEST_CASE("colour maps: brighter with speed and power, within the range of displays") {
    float before = -1;
    for (int i = 1; i <= 20; ++i) {
        const float fraction = static_cast<float>(i) / 20;
        const vec3 red = velocity_colour(fraction), blue = velocity_colour(-fraction), warm = power_colour(fraction);
        CHECK(red.x + red.y + red.z >= before);
        CHECK(red.x == blue.z);
        CHECK(red.y == blue.y);
        before = red.x + red.y + red.z;
        for (const vec3 colour : {red, blue, warm})
            for (int channel = 0; channel < 3; ++channel) CHECK_UNARY(colour[channel] >= 0 && colour[channel] <= 1);
    }
}

} // namespace doppler_picture_test
