#include <insonify/acoustics/laws.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/trace.hpp>
#include "../slab.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "echoes.hpp"

using namespace insonify;

namespace curved_surfaces_test {
namespace {

constexpr medium water{.density = 1000, .sound_speed = 1540}, metal{.density = 2000, .sound_speed = 1540};
constexpr float top = 20_mm;

double decibels(double amplitude) { return 20 * std::log10(amplitude); }

/// The largest echo of the middle lines, dB.
double peak(const scene& body, const linear_array& probe, std::uint32_t planes) {
    const iq_lines echoes =
        trace(exec::par_unseq, body, probe, pose{}, physical<>{}, {.depth = 40_mm, .planes = planes});
    const scan_lines seen = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, pulse{}, probe));
    float largest = 0;
    for (std::uint32_t i = probe.lines / 2 - 12; i < probe.lines / 2 + 12; ++i)
        for (std::uint32_t k = 0; k < seen.samples; ++k) largest = std::max(largest, seen(i, k));
    return decibels(static_cast<double>(largest));
}
/// A mesh in water, nearest to the probe at `top` and displaced, relative to a plate there.
double against_plate(mesh shape, const linear_array& probe, std::uint32_t planes, vec3 displaced) {
    for (vec3& p : shape.positions) p += displaced + vec3{0, 0, top};
    scene body{water}, flat{water};
    body.add(std::move(shape), metal);
    flat.add(make_box({-40_mm, -40_mm, top}, {40_mm, 40_mm, top + 10_mm}), metal);
    return peak(body.build(exec::par), probe, planes) - peak(flat.build(exec::par), probe, planes);
}
/// Loss by a curvature in one direction, of a kernel whose middle is `offset` from the surface's, dB.
double loss(double radius, double sigma, double frequency, double offset = 0) {
    const double q = 4 * 3.14159265358979 * frequency / 1540 * sigma * sigma / radius, x = offset / sigma;
    return decibels(std::pow(1 + q * q, -0.25) * std::exp(-0.5 * x * x * q * q / (1 + q * q)));
}
bool agrees(double measured, double expected) {
    return std::fabs(measured - expected) < std::max(0.5, 0.1 * std::fabs(expected));
}

mesh wire_across(float radius) { return make_cylinder({0, -20_mm, radius}, {0, 20_mm, radius}, radius, 96); }
mesh wire_along(float radius) { return make_cylinder({-20_mm, 0, radius}, {20_mm, 0, radius}, radius, 96); }

/// A cylinder of steel in the slice, tilted and rolled about its axis, in muscle without speckle.
scene needle(float diameter, float tilt, std::uint32_t sides, float roll, const medium& inside = tissue::steel) {
    medium silent = tissue::muscle;
    silent.backscatter = 0;
    mesh shaft = make_cylinder({-40_mm, 0, 0}, {40_mm, 0, 0}, diameter / 2, sides);
    const float c = std::cos(tilt), s = std::sin(tilt);
    for (vec3& p : shaft.positions) {
        p = {p.x, std::cos(roll) * p.y - std::sin(roll) * p.z, std::sin(roll) * p.y + std::cos(roll) * p.z};
        p = {c * p.x - s * p.z, p.y, s * p.x + c * p.z + top};
    }
    scene body{silent};
    body.add(std::move(shaft), inside);
    return std::move(body).build(exec::par);
}

} // namespace
} // namespace curved_surfaces_test

TEST_CASE("a wire across the slice loses (1 + (2 k sigma^2 / a)^2)^(-1/4), wherever it lies between the lines") {
    using namespace curved_surfaces_test;
    for (const float frequency : {5_MHz, 7.5_MHz})
        for (const std::uint32_t lines : {192U, 384U}) {
            const linear_array probe{.lines = lines, .width = 38_mm, .frequency = frequency};
            const double sigma = static_cast<double>(beam_of(probe, 40_mm).lateral_sigma(top));
            for (const float radius : {0.3_mm, 0.5_mm, 1_mm, 2_mm, 4_mm})
                for (const float part : {0.5F, 0.25F, 0.0F}) { // of the line spacing, from the nearest line
                    const float place = (0.5F - part) * 38_mm / static_cast<float>(lines);
                    const double measured = against_plate(wire_across(radius), probe, 1, {place, 0, 0});
                    const double expected = loss(static_cast<double>(radius), sigma, static_cast<double>(frequency),
                                                 static_cast<double>(part) * 38e-3 / lines);
                    MESSAGE(frequency * 1e-6F, " MHz, ", lines, " lines, radius ", radius * 1e3F, " mm, ", part,
                            " of the spacing beside a line: ", measured, " dB (expected ", expected, ")");
                    // At 192 lines and 7.5 MHz the spacing is more than half the beam's width.
                    const double margin = lines == 192 && frequency > 6_MHz ? 0.3 : 0;
                    CHECK(std::fabs(measured - expected) < margin + std::max(0.5, 0.1 * std::fabs(expected)));
                }
        }
}

TEST_CASE("a wire along the slice loses by its curvature out of it, a ball by both, in any number of planes") {
    using namespace curved_surfaces_test;
    for (const float frequency : {5_MHz, 7.5_MHz}) {
        const linear_array probe{.lines = 256, .width = 38_mm, .frequency = frequency};
        const beam_model beam = beam_of(probe, 40_mm);
        const double x = static_cast<double>(beam.lateral_sigma(top)),
                     y = static_cast<double>(beam.elevation_sigma(top)), f = static_cast<double>(frequency);
        const float on_a_line = 0.5F * 38_mm / 256;
        for (const std::uint32_t planes : {1U, 3U, 5U}) {
            for (const float radius : {0.36_mm, 1_mm, 4_mm})
                for (const float beside : {0.0F, 0.2_mm}) {
                    const double measured = against_plate(wire_along(radius), probe, planes, {0, beside, 0});
                    const double expected = loss(static_cast<double>(radius), y, f, static_cast<double>(beside));
                    MESSAGE(frequency * 1e-6F, " MHz, ", planes, " planes, wire of ", radius * 1e3F, " mm, ",
                            beside * 1e3F, " mm beside the slice: ", measured, " dB (expected ", expected, ")");
                    CHECK(agrees(measured, expected));
                }
            for (const float radius : {0.5_mm, 1_mm, 3_mm}) {
                const double measured =
                    against_plate(make_sphere({0, 0, radius}, radius, 5), probe, planes, {on_a_line, 0, 0});
                const double expected =
                    loss(static_cast<double>(radius), x, f) + loss(static_cast<double>(radius), y, f);
                MESSAGE(frequency * 1e-6F, " MHz, ", planes, " planes, ball of ", radius * 1e3F, " mm: ", measured,
                        " dB (expected ", expected, ")");
                CHECK(agrees(measured, expected));
            }
        }
    }
}

TEST_CASE("a needle of 24 sides is that of 192, at any tilt, however it is rolled") {
    using namespace curved_surfaces_test;
    const linear_array probe{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz};
    for (const std::uint32_t planes : {1U, 5U})
        for (const float tilt : {0_deg, 5_deg, 10_deg, 20_deg, 30_deg, 45_deg, 60_deg}) {
            const double fine = peak(needle(0.718_mm, tilt, 192, 0), probe, planes);
            for (const float roll : {0_deg, 3.3_deg, 7.5_deg}) {
                const double coarse = peak(needle(0.718_mm, tilt, 24, roll), probe, planes);
                MESSAGE(planes, " planes, tilted by ", tilt / 1_deg, " degrees, rolled by ", roll / 1_deg, ": ", coarse,
                        " dB with 24 sides, ", fine, " with 192");
                CHECK(std::fabs(coarse - fine) < 1);
            }
        }
}

TEST_CASE(
    "a needle in muscle mirrors: its echo falls with its tilt as that of a plane mirror, and is lost when steep") {
    using namespace curved_surfaces_test;
    const linear_array probe{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz};
    const double wavelengths = 20e-3 * 7.5e6 / 1540;
    medium polished = tissue::steel;
    polished.roughness = 1e-9F; // a mirror
    for (const std::uint32_t gauge : {18U, 22U, 25U}) {
        const float diameter = needle_diameter(gauge);
        const double flat = peak(needle(diameter, 0, 48, 0, polished), probe, 1);
        for (const float tilt : {3_deg, 5_deg, 8_deg, 10_deg}) {
            const double fallen = peak(needle(diameter, tilt, 48, 0, polished), probe, 1) - flat;
            const double expected =
                decibels(static_cast<double>(specular_return{}(tilt, 2, static_cast<float>(wavelengths))));
            MESSAGE(gauge, " gauge at ", tilt / 1_deg, " degrees: ", fallen,
                    " dB of the flat needle's (mirror: ", expected, ")");
            CHECK(std::fabs(fallen - expected) < 1);
        }
        // What is left of a steep one is diffuse: Lambert's law for 2 um, behind total reflection.
        for (const float tilt : {20_deg, 30_deg, 45_deg}) {
            const double left = peak(needle(diameter, tilt, 48, 0), probe, 1) - flat,
                         c = std::cos(static_cast<double>(tilt));
            const double phase = 2 * 2 * 3.14159265358979 * 7.5e6 / 1580 * 2e-6 * c;
            const double of_mirror = decibels(c * std::sqrt(0.166 / (2 * 4) * -std::expm1(-phase * phase)));
            const double rms = of_mirror - loss(static_cast<double>(diameter) / 2,
                                                static_cast<double>(beam_of(probe, 40_mm).elevation_sigma(top)), 7.5e6);
            MESSAGE(gauge, " gauge at ", tilt / 1_deg, " degrees: ", left,
                    " dB of the flat needle's, the largest of the middle lines (rms of the diffuse echo: ", rms, ")");
            CHECK(left > rms);
            CHECK(left < rms + 9);
        }
    }
}

TEST_CASE("behind a curved mirror sound spreads: 1 / sqrt((1 + 2 s / (a cos i)) (1 + 2 s cos i / a))") {
    using namespace curved_surfaces_test;
    // A ball, or a plate, turns the line by a right angle towards a wall.
    constexpr linear_array one_line{.lines = 1, .width = 1_mm, .frequency = 5_MHz};
    constexpr medium mirror{.density = 20000, .sound_speed = 1540};
    for (const float radius : {4_mm, 8_mm})
        for (const float distance : {2_mm, 5_mm, 10_mm}) {
            const auto echo_of_wall = [&](mesh shape) {
                scene body{water};
                body.add(std::move(shape), mirror);
                body.add(make_box({distance, -40_mm, 0.1_mm}, {distance + 10_mm, 40_mm, 60_mm}), metal);
                body.build(exec::par);
                const auto found =
                    echoes_test::echoes_of(trace(exec::par, body, one_line, pose{}, physical<>{},
                                                 {.depth = 35_mm, .samples = 3500}, paths{{.bounces = 1}}),
                                           0);
                double largest = 0;
                for (const auto& one : found)
                    if (std::fabs(one.depth - 20e-3 - static_cast<double>(distance)) < 0.1e-3)
                        largest = std::max(largest, std::fabs(static_cast<double>(one.amplitude)));
                return decibels(largest);
            };
            const float side = radius * std::sqrt(0.5F);
            const double spread = echo_of_wall(make_sphere({-side, 0, 20_mm + side}, radius, 6)) -
                                  echo_of_wall(slab({0, 0, 20_mm}, {1, 0, -1}, 10_mm, 5_mm));
            const double a = static_cast<double>(radius), s = static_cast<double>(distance), c = std::sqrt(0.5);
            const double expected = -decibels(std::sqrt((1 + 2 * s / (a * c)) * (1 + 2 * s * c / a)));
            MESSAGE("radius ", radius * 1e3F, " mm, wall at ", distance * 1e3F, " mm: ", spread, " dB (expected ",
                    expected, ")");
            CHECK(std::fabs(spread - expected) < 0.3);
        }
}

TEST_CASE("where all incidence is normal, surfaces have the level of planes under lines that diverge") {
    using namespace curved_surfaces_test;
    for (const float radius : {4_mm, 12_mm, 25_mm}) {
        scene body{metal};
        body.add(make_cylinder({0, -20_mm, 0}, {0, 20_mm, 0}, radius, 192), water); // around the apex
        const phased_array probe{.lines = 193, .frequency = 3_MHz};
        const iq_lines echoes = trace(exec::par_unseq, body.build(exec::par), probe, pose{},
                                      physical<>{.angle = angle::normal}, {.depth = 40_mm});
        const scan_lines seen = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, pulse{}, probe));
        const double level = decibels(static_cast<double>(*std::max_element(seen.values.begin(), seen.values.end())));
        MESSAGE("cylinder of ", radius * 1e3F, " mm: ", level, " dB (expected ", decibels(1.0 / 3), ")");
        CHECK(std::fabs(level - decibels(1.0 / 3)) < 0.5);
    }
}

TEST_CASE("a plane has its own level under lines that diverge, however close to the probe") {
    using namespace curved_surfaces_test;
    const double reflected = decibels(1.0 / 3); // of twice the impedance
    const auto level = [&](const auto& probe, float depth, std::uint32_t planes) {
        scene body{water};
        body.add(make_box({-80_mm, -80_mm, depth}, {80_mm, 80_mm, depth + 20_mm}), metal);
        body.build(exec::par);
        const iq_lines echoes =
            trace(exec::par_unseq, body, probe, pose{}, physical<>{}, {.depth = 40_mm, .planes = planes});
        const scan_lines seen = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, pulse{}, probe));
        return decibels(static_cast<double>(*std::max_element(seen.values.begin(), seen.values.end())));
    };
    for (const float depth : {4_mm, 6_mm, 12_mm, 25_mm})
        for (const std::uint32_t planes : {1U, 5U}) {
            const double phased = level(phased_array{.lines = 193, .frequency = 3_MHz}, depth, planes),
                         convex = level(convex_array{.lines = 193, .radius = 10_mm, .frequency = 6_MHz}, depth, planes),
                         radial = level(radial_array{.lines = 360, .frequency = 9_MHz}, depth, planes);
            MESSAGE("at ", depth * 1e3F, " mm, ", planes, " planes: phased ", phased, ", convex ", convex, ", radial ",
                    radial, " dB (expected ", reflected, ")");
            for (const double each : {phased, convex, radial}) CHECK(std::fabs(each - reflected) < 0.5);
        }
}
