#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/label.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "echoes.hpp"

// Lines that need more memory than they start with: nothing is cut in silence.

using namespace insonify;

namespace line_tracer_test {
namespace {

// Without speckle, and without the faint diffraction of surfaces that are tilted out of the aperture.
auto surfaces_within_the_aperture() {
    return physical<>{.specular = {.lobe = specular_return::lobe_shape::aperture}}.with_scattering(no_scatterers{});
}

// Two media in turns, of r = 1 / 201: what goes on falls by T = 1 - r^2 at each surface.
constexpr medium light{.density = 1000, .sound_speed = 1540}, heavy{.density = 1010, .sound_speed = 1540};
constexpr double reflected = 1.0 / 201 / 201;
const medium& in_turns(std::uint32_t i) { return i % 2 == 0 ? light : heavy; }

// Boxes, one in the other, whose upper surfaces lie at 10 mm, 10.01 mm, ...: the next ones only below the picture.
scene nested_boxes(std::uint32_t count) {
    scene body{light};
    for (std::uint32_t i = 0; i < count; ++i) {
        const float in = 10_um * static_cast<float>(i), side = 50_mm - 0.1F * in;
        body.add(make_box({-side, -side, 10_mm + in}, {side, side, 200_mm - in}), in_turns(i + 1));
    }
    body.build(exec::par);
    return body;
}
// Slabs, one on the other, from 10 mm on; the last one ends far below the picture.
scene stacked_slabs(std::uint32_t count) {
    scene body{light};
    for (std::uint32_t i = 0; i < count; ++i) {
        const float z = 10_mm + 10_um * static_cast<float>(i);
        body.add(make_box({-5_mm, -5_mm, z}, {5_mm, 5_mm, i + 1 < count ? z + 10_um : 300_mm}), in_turns(i + 1));
    }
    body.build(exec::par);
    return body;
}

const linear_array probe{.lines = 3, .width = 1_mm, .frequency = 5_MHz};
constexpr acquisition scan{.depth = 50_mm, .samples = 5000}; // sample k stands half way between two surfaces

// I_t plus the bright band of the next surface within 1 mm.
double expected_at(std::uint32_t sample, std::uint32_t surfaces) {
    const std::uint32_t above = sample < 1000 ? 0 : std::min(sample - 999, surfaces);
    const bool bright = sample >= 900 && above < surfaces;
    return std::pow(1 - reflected, above) * (bright ? 1 + reflected : 1);
}
double worst_error(const scan_lines& lines, std::uint32_t surfaces) {
    double worst = 0;
    for (std::uint32_t line = 0; line < lines.count; ++line)
        for (std::uint32_t k = 0; k < lines.samples; ++k)
            worst = std::max(worst, std::fabs(static_cast<double>(lines(line, k)) / expected_at(k, surfaces) - 1));
    return worst;
}

} // namespace
} // namespace line_tracer_test

TEST_CASE("3000 nested objects: the intensities of their closed form, by rays and by slices") {
    using namespace line_tracer_test;
    const scene body = nested_boxes(3000);
    REQUIRE(expected_at(4999, 3000) < 0.93); // 3000 surfaces are seen in it
    const double rays =
        worst_error(trace(exec::seq, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::rays}), 3000);
    const double slices =
        worst_error(trace(exec::par, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::slices}), 3000);
    const double best = worst_error(trace(exec::par_unseq, body, probe, pose{}, law2011{}, scan), 3000);
    MESSAGE("largest relative errors: rays ", rays, ", slices ", slices, ", best ", best);
    CHECK(rays < 2e-4);
    CHECK(slices < 2e-4);
    CHECK(best < 2e-4);
    const label_lines labels = label(exec::par, body, probe, pose{}, {.depth = 50_mm, .samples = 5000});
    for (std::uint32_t k = 0; k < 5000; ++k)
        REQUIRE(labels(1, k) == (k < 1000 ? background_label : std::min(k - 1000, 2999U)));
}

TEST_CASE("3000 stacked objects: the intensities of their closed form, by rays, by slices and by pixels") {
    using namespace line_tracer_test;
    const scene body = stacked_slabs(3000);
    const double rays =
        worst_error(trace(exec::seq, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::rays}), 3000);
    const double slices =
        worst_error(trace(exec::par, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::slices}), 3000);
    MESSAGE("largest relative errors: rays ", rays, ", slices ", slices);
    CHECK(rays < 2e-4);
    CHECK(slices < 2e-4);
    const acquisition coarse{.depth = 50_mm, .samples = 200};
    const scan_lines pixels = trace_pixels(exec::par, body, probe, pose{}, law2011{}, coarse);
    double worst = 0;
    for (std::uint32_t k = 0; k < 200; ++k) // 0.25 mm apart: sample k stands where number 25 k + 12 stands above
        worst = std::max(worst, std::fabs(static_cast<double>(pixels(1, k)) / expected_at(25 * k + 12, 3000) - 1));
    MESSAGE("by pixels ", worst);
    CHECK(worst < 2e-4);
}

TEST_CASE("a probe inside 1000 nested objects finds itself in the innermost, and leaves them one by one") {
    using namespace line_tracer_test;
    scene body{light};
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const float half = 10_mm + 10_um * static_cast<float>(i);
        body.add(make_box(-vec3{half}, vec3{half}), in_turns(i + 1));
    }
    body.build(exec::par);
    line_tracer<law2011> by_rays;
    by_rays.trace(exec::par, body, probe, pose{}, law2011{}, {.depth = 30_mm, .samples = 3000}, {line_search::rays});
    for (const label_lines& labels : {label(exec::par, body, probe, pose{}, {.depth = 30_mm, .samples = 3000}),
                                      label(exec::par, by_rays.layers(), {.depth = 30_mm, .samples = 3000})})
        for (std::uint32_t k = 0; k < 3000; ++k)
            REQUIRE(labels(1, k) == (k < 1000 ? 0 : k < 1999 ? k - 999 : background_label));
}

TEST_CASE("paths through 600 nested objects have the echoes of straight lines, where nothing bends") {
    using namespace line_tracer_test;
    const scene body = nested_boxes(600);
    const auto model = physical{}.with_scattering(no_scatterers{});
    const linear_array one{.lines = 1, .width = 1_mm, .frequency = 5_MHz};
    const acquisition fine{.depth = 20_mm, .samples = 2000};
    const iq_lines straight = trace(exec::par, body, one, pose{}, model, fine);
    const iq_lines bent = trace(exec::par, body, one, pose{}, model, fine, paths{{.bounces = 0}});
    float largest = 0, worst = 0;
    for (std::size_t i = 0; i < straight.values.size(); ++i) {
        largest = std::max(largest, length(straight.values[i]));
        worst = std::max(worst, length(straight.values[i] - bent.values[i]));
    }
    MESSAGE("largest echo ", largest, ", largest difference ", worst);
    CHECK(largest > 2e-3F);
    CHECK(worst < 2e-3F * largest);
}

TEST_CASE("sixty reflections within a plate, more than branches fit at first, are a ladder of T r^(2 n - 1)") {
    // r = 9/11 at both of its surfaces, which lie 0.1 mm apart in media of the display's speed.
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.add(make_box({-50_mm, -50_mm, 10_mm}, {50_mm, 50_mm, 10.1_mm}), medium{.density = 10000, .sound_speed = 1540});
    body.build(exec::par);
    const linear_array one{.lines = 1, .width = 1_mm, .frequency = 5_MHz};
    const auto found =
        echoes_test::echoes_of(trace(exec::seq, body, one, pose{}, physical{}, {.depth = 16.05_mm, .samples = 1605},
                                     paths{{.bounces = 200, .min_amplitude = 1e-20F}}),
                               0);
    const double r = 9.0 / 11;
    REQUIRE(found.size() >= 60);
    CHECK(found[0].amplitude == doctest::Approx(r).epsilon(1e-3).scale(1e-30));
    for (std::size_t n = 1; n < 60; ++n) {
        CHECK(std::fabs(found[n].depth - (10e-3 + 0.1e-3 * static_cast<double>(n))) < 5e-6);
        CHECK(found[n].amplitude ==
              doctest::Approx((1 - r * r) * std::pow(r, 2 * static_cast<double>(n) - 1)).epsilon(5e-3).scale(1e-30));
    }
}

TEST_CASE(
    "a path that is mirrored aside into 100 slabs has all their echoes, though the line itself meets few surfaces") {
    // A wall at 45 degrees, of r = 1 - 1/500, 20 mm deep; slabs 0.1 mm thick from 5 mm beside the line on.
    using namespace line_tracer_test;
    scene body{light};
    body.add(make_box({-9_mm, -9_mm, 0}, {9_mm, 9_mm, 9_mm}), medium{.density = 999000, .sound_speed = 1540},
             {.priority = 1, .at = look_at({0, 0, 20_mm}, {1, 0, 1 + 20_mm}, {1, 0, -1})});
    for (std::uint32_t i = 0; i < 100; ++i) {
        const float x = -5_mm - 0.1_mm * static_cast<float>(i);
        body.add(make_box({x - 0.1_mm, -2_mm, 18_mm}, {x, 2_mm, 22_mm}), in_turns(i + 1));
    }
    body.build(exec::par);
    const linear_array one{.lines = 1, .width = 1_mm, .frequency = 5_MHz};
    const auto found = echoes_test::echoes_of(trace(exec::seq, body, one, pose{}, surfaces_within_the_aperture(),
                                                    {.depth = 36_mm, .samples = 3600}, paths{{.bounces = 1}}),
                                              0);
    REQUIRE(found.size() == 100); // the last slab is of the medium around it
    for (std::uint32_t i = 0; i < 100; ++i) {
        CHECK(std::fabs(found[i].depth - (25e-3 + 0.1e-3 * i)) < 5e-6);
        CHECK(found[i].amplitude ==
              doctest::Approx(std::pow(0.998, 2) / 201 * std::pow(1 - reflected, i)).epsilon(5e-3).scale(1e-30));
    }
}

TEST_CASE("surfaces that are hidden in an object of precedence fill the memory, but hide nothing before or behind it") {
    // Three plates, and between them two boxes of higher priority that hide a hundred slabs each: ten surfaces in all.
    using namespace line_tracer_test;
    const auto along = [](const pose& at, scene& body) {
        const auto add = [&](float from, float to, const medium& inside, int priority) {
            body.add(make_box({-2_mm, -2_mm, from}, {2_mm, 2_mm, to}), inside, {.priority = priority, .at = at});
        };
        for (const float part : {0_mm, 10_mm}) {
            add(part + 5_mm, part + 6_mm, heavy, 0);
            for (std::uint32_t i = 0; i < 100; ++i) {
                const float from = part + 8_mm + 0.05_mm * static_cast<float>(i);
                add(from, from + 0.05_mm, in_turns(i + 1), 0);
            }
            add(part + 7_mm, part + 14_mm, heavy, 1);
        }
        add(25_mm, 26_mm, heavy, 0);
    };
    const double depths[] = {5e-3, 6e-3, 7e-3, 14e-3, 15e-3, 16e-3, 17e-3, 24e-3, 25e-3, 26e-3};
    const linear_array one{.lines = 1, .width = 1_mm, .frequency = 5_MHz};

    scene straight{light};
    along(pose{}, straight);
    straight.build(exec::par);
    const acquisition fine{.depth = 30_mm, .samples = 3000};
    for (const scan_lines& lines :
         {trace(exec::seq, straight, one, pose{}, law2011{}, fine, straight_lines{line_search::rays}),
          trace(exec::seq, straight, one, pose{}, law2011{}, fine, straight_lines{line_search::slices}),
          trace_pixels(exec::seq, straight, one, pose{}, law2011{}, fine)})
        for (std::uint32_t k = 0; k < 3000; ++k) {
            const double z = (k + 0.5) * 1e-5;
            const auto above = std::count_if(std::begin(depths), std::end(depths), [&](double d) { return d < z; });
            const bool bright = above < 10 && depths[above] - z < 1e-3;
            REQUIRE(static_cast<double>(lines(0, k)) ==
                    doctest::Approx(std::pow(1 - reflected, above) * (bright ? 1 + reflected : 1))
                        .epsilon(2e-6)
                        .scale(1e-30));
        }

    // Beside the line, behind a mirror at 45 degrees that is 20 mm deep: only a path meets them.
    scene mirrored{light};
    mirrored.add(make_box({-9_mm, -9_mm, 0}, {9_mm, 9_mm, 9_mm}), medium{.density = 999000, .sound_speed = 1540},
                 {.priority = 2, .at = look_at({0, 0, 20_mm}, {1, 0, 1 + 20_mm}, {1, 0, -1})});
    along(look_at({0, 0, 20_mm}, {-1, 0, 20_mm}, {0, 0, 1}), mirrored);
    mirrored.build(exec::par);
    const auto found = echoes_test::echoes_of(trace(exec::seq, mirrored, one, pose{}, surfaces_within_the_aperture(),
                                                    {.depth = 48_mm, .samples = 4800}, paths{{.bounces = 1}}),
                                              0);
    REQUIRE(found.size() == 10);
    for (std::size_t i = 0; i < 10; ++i) CHECK(std::fabs(found[i].depth - 20e-3 - depths[i]) < 5e-6);
}
