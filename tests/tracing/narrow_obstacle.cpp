#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

/// Speckle below a wire that lies in the slice, as a needle does.
namespace narrow_obstacle_shadow_test {
namespace {

constexpr float image_depth = 45_mm;
const linear_array probe{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz};
constexpr medium scatterers{.density = 1000, .sound_speed = 1540, .backscatter = 1};
constexpr medium opaque{.density = 1000, .sound_speed = 1540, .attenuation = 1e6F};

double decibels(double power) { return 10 * std::log10(power); }

struct wire {
    float depth, radius, height = 0, tilt = 0;
    float crease = 30_deg;

    scene body() const {
        const vec3 middle{0, height, depth}, half = 60_mm * vec3{std::cos(tilt), 0, std::sin(tilt)};
        scene made{scatterers};
        made.add(make_cylinder(middle - half, middle + half, radius, 48), opaque, {.crease_angle = crease});
        return std::move(made).build(exec::par);
    }
};

/// Power of the middle lines, summed, at depths of 38 to 43 mm.
double power(const scene& body, std::uint32_t planes) {
    const iq_lines echoes =
        trace(exec::par_unseq, body, probe, pose{}, physical<>{.min_ringing = 1},
              {.depth = image_depth, .samples = 3000, .planes = planes}, straight_lines{.directions = 1});
    double sum = 0;
    for (std::uint32_t line = 64; line < 192; ++line)
        for (std::uint32_t k = 2534; k < 2866; ++k)
            sum += glm::dot(glm::dvec2{echoes(line, k)}, glm::dvec2{echoes(line, k)});
    return sum;
}

/// What of a Gaussian beam passes the wire on the same lines.
double beside(const wire& one) {
    double sum = 0;
    for (std::uint32_t line = 64; line < 192; ++line) {
        const float depth = one.depth + probe.beam(static_cast<float>(line)).origin.x * std::tan(one.tilt);
        const float half = beam_of(probe, image_depth).elevation_sigma(depth);
        sum += 0.5 * (std::erfc(static_cast<double>((one.radius + one.height) / half)) +
                      std::erfc(static_cast<double>((one.radius - one.height) / half)));
    }
    return sum / 128;
}

} // namespace

TEST_CASE("below a wire along the slice there is what passes beside it out of the slice, with one plane") {
    const double open = power(scene{scatterers}.build(exec::par), 1),
                 open_by_three = power(scene{scatterers}.build(exec::par), 3);
    double furthest = 0, furthest_by_three = 0;
    for (const float depth : {12_mm, 18_mm, 25_mm})
        for (const float radius : {0.25_mm, 0.36_mm, 0.5_mm})
            for (const wire& one : {wire{depth, radius}, wire{depth, radius, 0.2_mm}, wire{depth, radius, 0, 20_deg}}) {
                const scene body = one.body();
                const double expected = decibels(beside(one)), found = decibels(power(body, 1) / open),
                             by_three = decibels(power(body, 3) / open_by_three);
                MESSAGE("wire of ", one.radius * 2e3F, " mm, ", one.depth * 1e3F, " mm deep, ", one.height * 1e3F,
                        " mm beside the slice, tilted by ", one.tilt * 180 / pi, " degrees: ", found, ", by 3 planes ",
                        by_three, " dB; expected ", expected);
                furthest = std::max(furthest, std::fabs(found - expected));
                furthest_by_three = std::max(furthest_by_three, std::fabs(by_three - expected));
            }
    MESSAGE("at most ", furthest, " dB off, by 3 planes ", furthest_by_three);
    CHECK(furthest < 0.1);
    CHECK(furthest_by_three < 4);
}

TEST_CASE("below a wire it is as dark however little reaches it") {
    constexpr medium rare{.density = 1, .sound_speed = 1540};
    for (int plates = 0; plates < 6; ++plates) { // each lets 1.6e-5 of the amplitude through
        const auto below = [&](scene made) {
            for (int i = 0; i < plates; ++i) {
                const float from = static_cast<float>(1 + i) * 1_mm;
                made.add(make_box({-60_mm, -60_mm, from}, {60_mm, 60_mm, from + 0.4_mm}), rare);
            }
            return power(std::move(made).build(exec::par), 1);
        };
        const double darker = decibels(below(wire{18_mm, 0.36_mm}.body()) / below(scene{scatterers}));
        MESSAGE("behind ", plates, " plates: ", darker, " dB; expected -8.3");
        CHECK(std::fabs(darker + 8.298) < 0.1);
    }
}

TEST_CASE("below a needle of steel, which sound passes fast, a plate is displayed where it is without the needle") {
    constexpr medium silent{.density = 1000, .sound_speed = 1540}, heavy{.density = 1500, .sound_speed = 1540};
    const auto depth_of_plate = [&](bool with) {
        scene made{silent};
        if (with)
            made.add(make_cylinder({-60_mm, 0, 18_mm}, {60_mm, 0, 18_mm}, 0.25_mm, 48), tissue::steel,
                     {.crease_angle = 30_deg});
        made.add(make_box({-60_mm, -60_mm, 35_mm}, {60_mm, 60_mm, 60_mm}), heavy);
        const iq_lines echoes =
            trace(exec::par, std::move(made).build(exec::par), probe, pose{}, physical<>{.min_ringing = 1},
                  {.depth = image_depth, .samples = 3000}, straight_lines{.directions = 1});
        double sum = 0, moment = 0; // of the samples from 30 mm on
        for (std::uint32_t k = 2000; k < 3000; ++k) {
            const double amplitude = glm::length(glm::dvec2{echoes(128, k)});
            sum += amplitude;
            moment += amplitude * (k + 0.5) * static_cast<double>(image_depth) / 3000;
        }
        return moment / sum;
    };
    const double apart = 1e3 * (depth_of_plate(true) - depth_of_plate(false));
    MESSAGE("displayed ", apart, " mm deeper; by what passes through the needle alone it would be -0.37");
    CHECK(std::fabs(apart) < 0.02);
}

TEST_CASE("below a tilted wire there is what passes beside it, whatever the sound speed in the wire") {
    constexpr medium attenuating{.density = 1000, .sound_speed = 1540, .attenuation = 100, .backscatter = 1};
    const auto below = [&](float radius, float sound_speed) {
        const vec3 along = 60_mm * vec3{std::cos(25_deg), 0, std::sin(25_deg)}, middle{0, 0, 18_mm};
        scene made{attenuating};
        made.add(make_cylinder(middle - along, middle + along, radius, 48),
                 {.density = 1000 * 1540 / sound_speed, .sound_speed = sound_speed, .attenuation = 1e6F},
                 {.crease_angle = 30_deg});
        return power(std::move(made).build(exec::par), 1);
    };
    for (const float radius : {0.35_mm, 0.75_mm, 1.25_mm}) {
        const double brighter = decibels(below(radius, 3000) / below(radius, 1540));
        MESSAGE("wire of ", radius * 2e3F, " mm: below a fast one ", brighter, " dB brighter; expected 0");
        CHECK(std::fabs(brighter) < 0.15);
    }
}

TEST_CASE("below a wire of facets, whose width is unknown, it is dark") {
    const double open = power(scene{scatterers}.build(exec::par), 1);
    CHECK(decibels(power(wire{18_mm, 0.36_mm, 0, 0, 0_deg}.body(), 1) / open) < -100);
}

} // namespace narrow_obstacle_shadow_test
