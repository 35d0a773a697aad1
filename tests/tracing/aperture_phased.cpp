#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/tracing/trace.hpp>
#include "shaded_lines.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

/// The aperture of a phased array: its elements lie on the flat face, all its lines begin at the middle.
namespace aperture_phased_test {
namespace {

using aperture_shading_test::absorber, aperture_shading_test::arrival_model, aperture_shading_test::body,
    aperture_shading_test::max_unevenness, aperture_shading_test::scan;

constexpr phased_array fine{.lines = 512, .width = 20_mm, .frequency = 5_MHz, .focus = 30_mm};

/// The fraction of the aperture |e| < z / 2F from which a straight line reaches a point at a distance from the face's middle
/// along a line of this angle, past a half plane that absorbs all that crosses x < edge at a depth; mm, radians.
double free_part(double angle, double distance, double edge, double depth) {
    const double x = distance * std::sin(angle), z = distance * std::cos(angle), half = std::min(distance / 4, 10.0);
    const double first = (edge - x * depth / z) / (1 - depth / z); // e (1 - d/z) + x d/z > edge
    return std::clamp((half - first) / (2 * half), 0.0, 1.0);
}

/// Radians over which a level that grows with the angle rises from 10 to 90 %.
template <class Level>
double rise(const Level& level, double from, double to) {
    const auto place = [&](double wanted) {
        double low = from, high = to;
        for (int i = 0; i < 60; ++i) {
            const double middle = 0.5 * (low + high);
            (level(middle) < wanted ? low : high) = middle;
        }
        return low;
    };
    return place(0.9) - place(0.1);
}

scene half_plane(float edge, float depth) {
    scene s{body};
    s.add(make_box({-200_mm, -30_mm, depth - 0.1_mm}, {edge, 30_mm, depth}), absorber);
    s.build(exec::par);
    return s;
}

} // namespace
} // namespace aperture_phased_test

TEST_CASE("phased array: the edge of a shadow is as wide as its aperture makes it, in the middle and at 30 degrees") {
    using namespace aperture_phased_test;
    for (const float degrees : {-30.0F, 0.0F, 30.0F})
        for (const std::uint32_t behind : {10U, 20U}) {
            const float angle = degrees * 1_deg, depth = 20_mm * std::cos(angle), edge = 20_mm * std::sin(angle);
            const std::uint32_t distance = 20 + behind; // mm
            const auto expected_at = [&](double at) {
                return std::pow(
                    free_part(at, distance, 1e3 * static_cast<double>(edge), 1e3 * static_cast<double>(depth)), 1.5);
            };
            const double around = static_cast<double>(angle);
            const double expected = distance * rise(expected_at, around - 0.4, around + 0.4);
            for (const std::uint32_t directions : {16U, 64U}) {
                const iq_lines arrived = trace(exec::par_unseq, half_plane(edge, depth), fine, pose{}, arrival_model{},
                                               scan, straight_lines{.directions = directions});
                const auto found_at = [&](double at) {
                    const double line = (at / (3.14159265358979 / 2) + 0.5) * fine.lines - 0.5;
                    const auto before = static_cast<std::uint32_t>(line);
                    const double part = line - before, a = static_cast<double>(arrived(before, distance - 1).y),
                                 b = static_cast<double>(arrived(before + 1, distance - 1).y);
                    return a + part * (b - a);
                };
                const double found = distance * rise(found_at, around - 0.25, around + 0.25);
                MESSAGE(degrees, " degrees, ", behind, " mm behind the edge, ", directions, " directions: ", found,
                        " mm, expected ", expected);
                CHECK(std::fabs(found / expected - 1) < (directions == 64 ? 0.025 : 0.05));
            }
        }
}

TEST_CASE("phased array: without obstacles, and behind shells around the middle of its face, gains are 1") {
    using namespace aperture_phased_test;
    const scene muscle = scene{tissue::muscle}.build(exec::par);
    CHECK(max_unevenness(muscle, phased_array{}, pose{}, scan) < 1e-4F);
    scene shells{tissue::muscle};
    shells.add(make_sphere({0, 0, 0}, 50_mm, 7), tissue::fat);
    shells.add(make_sphere({0, 0, 0}, 35_mm, 7), tissue::liver);
    shells.build(exec::par);
    const float uneven = max_unevenness(shells, phased_array{}, pose{}, scan);
    MESSAGE("shells: gains of 1 within ", uneven);
    CHECK(uneven < 0.01F); // the shells are polyhedra
}

TEST_CASE("phased array: plane layers keep the level of the straight line within half a decibel up to 30 degrees") {
    using namespace aperture_phased_test;
    scene layers{tissue::muscle};
    layers.add(make_box({-200_mm, -200_mm, -5_mm}, {200_mm, 200_mm, 15_mm}), tissue::fat); // contains the face
    layers.add(make_box({-200_mm, -200_mm, 30_mm}, {200_mm, 200_mm, 90_mm}), tissue::liver);
    layers.build(exec::par);
    const phased_array probe{.lines = 128, .field_of_view = 60_deg};
    const iq_lines shaded = trace(exec::par_unseq, layers, probe, pose{}, arrival_model{}, scan),
                   alone = trace(exec::par_unseq, layers, probe, pose{}, arrival_model{}, scan,
                                 straight_lines{.directions = 1});
    double worst = 0;
    for (std::uint32_t i = 0; i < shaded.count; ++i)
        for (const std::uint32_t k : {9U, 20U, 40U, 60U})
            worst = std::max(worst, 20 * std::fabs(std::log10(static_cast<double>(shaded(i, k).y / alone(i, k).y))));
    MESSAGE("plane layers: within ", worst, " dB");
    CHECK(worst < 0.5);
}

TEST_CASE(
    "phased array: shading by rays and by slices agree, with objects around and beside the face, on any threads") {
    using namespace aperture_phased_test;
    using search = line_search;
    scene s{body};
    s.add(make_sphere({8_mm, 0, 30_mm}, 4_mm, 4), tissue::bone);
    s.add(make_sphere({-16_mm, 1_mm, 16_mm}, 2_mm, 4), absorber);
    s.add(make_box({-7_mm, -30_mm, -5_mm}, {30_mm, 30_mm, 6_mm}), tissue::fat); // contains a part of the face
    s.add(make_box({-40_mm, -30_mm, 2_mm}, {-8_mm, 30_mm, 5_mm}), absorber);    // beside all lines of the probe
    s.build(exec::par);
    const pose at = look_at({3_mm, 1_mm, 4_mm}, {10_mm, -5_mm, 39_mm}, {1, 0, 0});
    scene moved{body};
    for (const auto& [shape, of] : {std::pair{make_sphere({8_mm, 0, 30_mm}, 4_mm, 4), tissue::bone},
                                    {make_box({-7_mm, -30_mm, -5_mm}, {30_mm, 30_mm, 6_mm}), tissue::fat}})
        moved.add(shape, of, {.at = at});
    moved.build(exec::par);
    const auto check = [](const scene& all, const pose& of_probe) {
        const phased_array probe{.lines = 96, .field_of_view = 80_deg};
        const acquisition how{.depth = 48_mm, .samples = 64, .planes = 3};
        const iq_lines sliced = trace(exec::seq, all, probe, of_probe, arrival_model{}, how,
                                      straight_lines{.search = search::slices}),
                       by_rays = trace(exec::seq, all, probe, of_probe, arrival_model{}, how,
                                       straight_lines{.search = search::rays});
        std::size_t apart = 0;
        for (std::size_t i = 0; i < sliced.values.size(); ++i)
            apart += length(sliced.values[i] - by_rays.values[i]) > 1e-3F ? 1 : 0;
        CHECK(apart < sliced.values.size() / 200); // lines through vertices and edges
        CHECK(trace(exec::par.threads(3), all, probe, of_probe, arrival_model{}, how,
                    straight_lines{.search = search::slices}) == sliced);
    };
    check(s, pose{});
    check(moved, at);
}

TEST_CASE("phased array: the lines beyond its sector continue it, within 89 degrees") {
    detail::line_fan fan;
    REQUIRE(fan.assign(phased_array{.lines = 91, .field_of_view = 91_deg})); // -45 to 45 degrees
    REQUIRE(fan.extend(10, 1_deg) == 10);
    REQUIRE(fan.size() == 111);
    for (std::uint32_t i = 0; i < fan.size(); ++i) {
        const float angle = (static_cast<float>(i) - 55) * 1_deg;
        CHECK(length(fan[i].along - vec2{std::sin(angle), std::cos(angle)}) < 1e-5F);
        CHECK(fan.gap(20_mm * fan[i].along - vec2{1e-5F, 0}) == i);
    }
    CHECK(fan.extend(100, 1_deg) == 34);
}
