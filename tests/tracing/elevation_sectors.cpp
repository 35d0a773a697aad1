#include <insonify/acoustics/physical.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/presets.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

/// Elevation planes tilt with z, the beam widens with the depth along each line.
namespace elevation_sectors_test {
namespace {

constexpr float image_depth = 120_mm;

double decibels(double ratio) { return 20 * std::log10(ratio); }

/// The largest deviation of the planes' rms height, weighted by power, from the beam's, sigma / sqrt(2), on the line nearest to
/// an angle; dB.
template <class Probe>
double max_deviation(const std::string& what, const Probe& probe, std::uint32_t count, float angle, float until) {
    const beam_model beam = beam_of(probe, image_depth);
    const detail::elevation_planes base{beam, count, image_depth, detail::lines_follow_depth(probe)};
    detail::planes_of_lines planes;
    planes.assign(exec::seq, probe, base);
    const auto line =
        static_cast<std::uint32_t>(std::lround(line_at_fraction(angle / probe.field_of_view, probe.lines) - 0.01F));
    const ray along = probe.beam(static_cast<float>(line));
    const detail::elevation_planes& own = planes[planes.set_of_line()[line]];
    double worst = 0, where = 0;
    for (float depth = 10_mm; depth <= until; depth += 1_mm) {
        const auto weights = own.at(depth);
        double squares = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            const double height = static_cast<double>(base[i].height(along.at(depth).z)); // where the line is
            REQUIRE(std::fabs(height - static_cast<double>(own[i].height(depth))) < 5e-5);
            squares += std::pow(static_cast<double>(weights.random[i]) * height, 2);
        }
        const double off = decibels(std::sqrt(2 * squares) / static_cast<double>(beam.elevation_sigma(depth)));
        if (std::fabs(off) > std::fabs(worst)) worst = off, where = static_cast<double>(depth);
    }
    MESSAGE(what, ", ", count, " planes, ", angle / 1_deg, " degrees, to ", until * 1e3F, " mm: rms height off by ",
            worst, " dB at most, ", where * 1e3, " mm deep");
    return std::fabs(worst);
}

} // namespace
} // namespace elevation_sectors_test

TEST_CASE("on sectors the rms height of the planes is the beam's in the middle, and as far off as the page says at the "
          "edges") {
    using namespace elevation_sectors_test;
    const convex_array wide{.field_of_view = 90_deg};
    for (const std::uint32_t count : {5U, 7U}) {
        CHECK(max_deviation("phased array", phased_array{}, count, 0, 120_mm) < 0.9);
        CHECK(max_deviation("convex array", convex_array{}, count, 0, 120_mm) < 0.9);
        // To the elevation focus, 60 mm.
        CHECK(max_deviation("phased array", phased_array{}, count, 30_deg, 60_mm) < 1.5);
        CHECK(max_deviation("phased array", phased_array{}, count, 45_deg, 60_mm) < 2);
        CHECK(max_deviation("convex array", convex_array{}, count, 29_deg, 60_mm) < 2);
        CHECK(max_deviation("wide convex array", wide, count, 45_deg, 60_mm) < 2.5);
        // To twice as deep.
        CHECK(max_deviation("phased array", phased_array{}, count, 30_deg, 120_mm) < 3.5);
        CHECK(max_deviation("phased array", phased_array{}, count, 45_deg, 120_mm) < 6.5);
        CHECK(max_deviation("convex array", convex_array{}, count, 29_deg, 120_mm) < 5);
        CHECK(max_deviation("wide convex array", wide, count, 45_deg, 120_mm) < 11);
    }
}

TEST_CASE("parallel lines share one set of plane weights, lines of a sector have those of their angle") {
    using namespace elevation_sectors_test;
    const auto sets = [](const auto& probe, std::uint32_t count) {
        const detail::elevation_planes base{beam_of(probe, image_depth), count, image_depth,
                                            detail::lines_follow_depth(probe)};
        detail::planes_of_lines planes;
        planes.assign(exec::seq, probe, base);
        for (std::uint32_t i = 0; i < probe.lines; ++i) // to both sides alike
            REQUIRE(planes.set_of_line()[i] == planes.set_of_line()[probe.lines - 1 - i]);
        return planes.sets();
    };
    CHECK(sets(linear_array{}, 5) == 1);
    CHECK(sets(phased_array{}, 1) == 1);
    CHECK(sets(phased_array{}, 5) > 30);
    CHECK(sets(convex_array{}, 5) > 10);
}

TEST_CASE("on every line of a sector tissue has its level, and so has a round plate around the probe") {
    using namespace elevation_sectors_test;
    constexpr medium scatterers{.density = 1000, .sound_speed = 1540, .backscatter = 1},
        silent{.density = 1000, .sound_speed = 1540}, dense{.density = 1200, .sound_speed = 1540};
    const phased_array probe{};
    const auto seen = [&](const scene& body, std::uint32_t seed) {
        return convolve(exec::par_unseq,
                        trace(exec::par_unseq, body, probe, pose{}, physical<>{.scattering = {.seed = seed}},
                              {.depth = image_depth, .samples = 1536, .planes = 5}, straight_lines{.directions = 1}),
                        pulse{}, probe);
    };
    const scene tissue = scene{scatterers}.build(exec::par);
    double level[4] = {}; // of a quarter of the lines each
    constexpr std::uint32_t seeds = 24;
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
        const iq_lines lines = seen(tissue, seed);
        for (std::uint32_t i = 0; i < lines.count; ++i)
            for (std::uint32_t k = 200; k < 1400; ++k)
                level[i / 32] += static_cast<double>(dot(lines(i, k), lines(i, k))) / (32.0 * 1200 * seeds);
    }
    for (const double one : level) {
        MESSAGE("tissue: ", decibels(std::sqrt(one)) + 55, " dB from its level");
        CHECK(std::fabs(decibels(std::sqrt(one)) + 55) < 0.3);
    }
    scene plate{silent};
    plate.add(make_cylinder({0, -200_mm, 0}, {0, 200_mm, 0}, 90_mm, 720), silent);
    plate.add(make_box({-400_mm, -190_mm, -400_mm}, {400_mm, 190_mm, 400_mm}), dense, {.priority = -1});
    plate.build(exec::par);
    const iq_lines echo = seen(plate, 1);
    float weakest = 1, strongest = 0;
    for (std::uint32_t i = 2; i + 2 < echo.count; ++i) {
        float largest = 0;
        for (std::uint32_t k = 1100; k < 1200; ++k) largest = std::max(largest, length(echo(i, k)));
        weakest = std::min(weakest, largest);
        strongest = std::max(strongest, largest);
    }
    MESSAGE("round plate: ", weakest, " to ", strongest, " on all lines");
    CHECK(decibels(static_cast<double>(strongest / weakest)) < 1);
}
