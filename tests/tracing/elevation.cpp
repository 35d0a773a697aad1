#include <insonify/acoustics/physical.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/signal/kernel/elevation.hpp>
#include <insonify/tracing/trace.hpp>
#include <doctest/doctest.h>

using namespace insonify;
using detail::elevation_planes;

namespace elevation_test {
namespace {

constexpr medium scatterers{.density = 1000, .sound_speed = 1540, .backscatter = 1},
    anechoic{.density = 1000, .sound_speed = 1540}, dense{.density = 1200, .sound_speed = 1540};
const linear_array probe{.frequency = 7.5_MHz};
constexpr float image_depth = 61_mm;
constexpr std::uint32_t samples = 2048;

elevation_planes planes_of(const auto& any_probe, std::uint32_t count) {
    return {beam_of(any_probe, image_depth), count, image_depth, detail::lines_follow_depth(any_probe)};
}
double sigma(float depth) { return static_cast<double>(beam_of(probe, image_depth).elevation_sigma(depth)); }
double above(double deviations) {
    return 0.5 * std::erfc(deviations / std::sqrt(2.0));
} // of a standard normal variable
double decibels(double power) { return 10 * std::log10(std::max(power, 1e-10)); }

iq_lines seen(const scene& body, const auto& any_probe, std::uint32_t planes, std::uint32_t seed = 1) {
    const physical<> model{.scattering = {.seed = seed}};
    const straight_lines alone{.directions = 1};
    return convolve(exec::par_unseq,
                    trace(exec::par_unseq, body, any_probe, pose{}, model,
                          {.depth = image_depth, .samples = samples, .planes = planes}, alone),
                    pulse{}, any_probe);
}
// Mean power of some lines, within a distance of a depth.
double power(const iq_lines& lines, std::uint32_t begin, std::uint32_t end, float depth, float within) {
    double sum = 0, count = 0;
    for (std::uint32_t line = begin; line < end; ++line)
        for (std::uint32_t k = 0; k < lines.samples; ++k) {
            const float z = (static_cast<float>(k) + 0.5F) * lines.depth / static_cast<float>(lines.samples);
            if (std::fabs(z - depth) > within) continue;
            sum += static_cast<double>(dot(lines(line, k), lines(line, k)));
            ++count;
        }
    return sum / count;
}

// All that lies above a height, from a depth on.
scene half_space(float height, float depth, const medium& background, const medium& inside) {
    scene body{background};
    body.add(make_box({-60_mm, height, depth}, {60_mm, 60_mm, 90_mm}), inside);
    body.build(exec::par);
    return body;
}

// What the planes above a height weigh, for random echoes (power) and for coherent ones (amplitude); and the weight of the
// plane whose strip the height lies in, by which a sum over planes may err.
struct staircase {
    double random = 0, coherent = 0, random_step = 0, coherent_step = 0;
};
staircase planes_above(const elevation_planes& planes, double height, float depth) {
    const auto weights = planes.at(depth);
    staircase sum;
    double nearest = 1;
    for (std::uint32_t i = 0; i < planes.count(); ++i) {
        const auto y = static_cast<double>(planes[i].height(depth)), c = static_cast<double>(weights.coherent[i]),
                   p = std::pow(static_cast<double>(weights.random[i]), 2);
        if (y > height) sum.random += p, sum.coherent += c;
        if (std::fabs(y - height) < nearest) {
            nearest = std::fabs(y - height);
            sum.random_step = p;
            sum.coherent_step = c;
        }
    }
    return sum;
}

constexpr float heights[] = {0.25_mm, 0.5_mm, 0.75_mm, 1_mm, 1.5_mm};
constexpr float depths[] = {10_mm, 20_mm, 35_mm, 50_mm};

} // namespace
} // namespace elevation_test

TEST_CASE("tissue that begins above the slice has the level of the beam above it: 10 log10 Phi(-d sqrt(2) / sigma)") {
    using namespace elevation_test;
    constexpr std::uint32_t seeds = 32;
    double full[4] = {};
    const auto measure = [&](float height, double(&level)[4]) {
        const scene body = half_space(height, -9_mm, anechoic, scatterers);
        for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
            const iq_lines lines = seen(body, probe, 5, seed);
            for (int i = 0; i < 4; ++i) level[i] += power(lines, 0, lines.count, depths[i], 1_mm) / seeds;
        }
    };
    measure(-60_mm, full);
    for (const float height : heights) {
        double level[4] = {};
        measure(height, level);
        for (int i = 0; i < 4; ++i) {
            const double found = level[i] / full[i], expected = above(std::sqrt(2.0) * height / sigma(depths[i]));
            const staircase steps = planes_above(planes_of(probe, 5), height, depths[i]);
            MESSAGE((depths[i] * 1e3F), " mm deep, from ", (height * 1e3F), " mm on: ", decibels(found),
                    " dB, expected ", decibels(expected), " (5 planes: ", decibels(steps.random), ")");
            // The sum over planes: what tilts and crossings of planes leave of it within 2 mm of depth.
            CHECK(std::fabs(found - steps.random) < 0.02 + 0.1 * steps.random);
            // Rounds the height to the border of the strip that it lies in, up or down.
            CHECK(std::fabs(found - expected) < 0.03 + steps.random_step);
            if (depths[i] == 35_mm && (height == 0.5_mm || height == 1_mm))
                CHECK(std::fabs(decibels(found) - decibels(expected)) < 0.5);
        }
    }
}

TEST_CASE("a plate that begins above the slice has the amplitude of the beam above it: Phi(-d / sigma)") {
    using namespace elevation_test;
    const auto peak = [](float height, float depth) {
        const iq_lines lines = seen(half_space(height, depth, anechoic, dense), probe, 5);
        float largest = 0;
        for (std::uint32_t k = 0; k < samples; ++k)
            if (std::fabs((static_cast<float>(k) + 0.5F) * image_depth / samples - depth) < 0.5_mm)
                largest = std::max(largest, length(lines(lines.count / 2, k)));
        return static_cast<double>(largest);
    };
    for (const float depth : depths)
        for (const float height : heights) {
            const double found = peak(height, depth) / peak(-60_mm, depth), expected = above(height / sigma(depth));
            const staircase steps = planes_above(planes_of(probe, 5), height, depth);
            MESSAGE((depth * 1e3F), " mm deep, from ", (height * 1e3F), " mm on: ", 2 * decibels(found),
                    " dB, expected ", 2 * decibels(expected), " (5 planes: ", 2 * decibels(steps.coherent), ")");
            CHECK(std::fabs(found - steps.coherent) < 0.01);
            CHECK(std::fabs(found - expected) < 0.01 + steps.coherent_step);
            if (depth == 35_mm && (height == 0.5_mm || height == 1_mm))
                CHECK(2 * std::fabs(decibels(found) - decibels(expected)) < 1);
        }
}

TEST_CASE("a small anechoic sphere is filled by no more than what the beam has beside it, by however many planes") {
    using namespace elevation_test;
    const float rows[] = {29_mm, 35_mm, 50_mm}, radius = 1.5_mm;
    scene cysts{scatterers};
    for (const float depth : rows)
        for (int i = -3; i <= 3; ++i)
            cysts.add(make_sphere({static_cast<float>(i) * 5_mm, 0, depth}, radius, 5), anechoic);
    cysts.build(exec::par);
    const scene none = scene{scatterers}.build(exec::par);
    constexpr std::uint32_t seeds = 48;
    for (const std::uint32_t planes : {1U, 3U, 5U, 7U}) {
        double inside[3] = {}, all[3] = {};
        for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
            const iq_lines lines = seen(cysts, probe, planes, seed), full = seen(none, probe, planes, seed);
            for (int row = 0; row < 3; ++row) {
                all[row] += power(full, 0, full.count, rows[row], 1_mm);
                for (int i = -3; i <= 3; ++i) {
                    const auto line = static_cast<std::uint32_t>(
                        std::lround(probe.locate({static_cast<float>(i) * 5_mm, rows[row]}).x));
                    inside[row] += power(lines, line, line + 1, rows[row], 0.15_mm) / 7;
                }
            }
        }
        for (int row = 0; row < 3; ++row) {
            const double found = inside[row] / all[row], beside = 2 * above(std::sqrt(2.0) * radius / sigma(rows[row]));
            const staircase steps = planes_above(planes_of(probe, planes), radius, rows[row]);
            MESSAGE(planes, " planes, ", (rows[row] * 1e3F), " mm deep: ", decibels(found), " dB, expected ",
                    decibels(beside), " (planes: ", decibels(2 * steps.random), ")");
            // What lies beside the sphere is rounded by the strips of the two planes in which its borders lie.
            CHECK(found < beside + 2 * steps.random_step + 0.03);
            CHECK(std::fabs(found - 2 * steps.random) < 0.005 + 0.3 * steps.random);
            if (rows[row] <= 35_mm) CHECK(decibels(found) < -26);
        }
    }
}

TEST_CASE("tissue has its level at every depth, plates have theirs, in any number of planes, on every probe") {
    using namespace elevation_test;
    const scene tissue = scene{scatterers}.build(exec::par);
    const auto worst_level = [&](const auto& any_probe, std::uint32_t planes) {
        double worst = 0;
        constexpr std::uint32_t seeds = 48;
        double level[11] = {};
        for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
            const iq_lines lines = seen(tissue, any_probe, planes, seed);
            for (int i = 0; i < 11; ++i)
                level[i] += power(lines, 0, lines.count, static_cast<float>(i + 1) * 5_mm, 2.5_mm) / seeds;
        }
        for (const double one : level)
            worst = std::fabs(decibels(one) + 55) > std::fabs(worst) ? decibels(one) + 55 : worst;
        MESSAGE(planes, " planes: tissue within ", worst, " dB of its level");
        return std::fabs(worst);
    };
    for (const std::uint32_t planes : {1U, 3U, 5U, 7U}) CHECK(worst_level(probe, planes) < 0.3);
    for (const std::uint32_t planes : {1U, 5U}) {
        CHECK(worst_level(convex_array{.lines = 128, .radius = 50_mm, .field_of_view = 70_deg, .frequency = 3.5_MHz},
                          planes) < 0.4);
        CHECK(worst_level(radial_array{.lines = 256, .radius = 5_mm, .frequency = 7.5_MHz}, planes) < 0.4);
    }
    for (const float depth : depths) {
        double level[4] = {};
        for (std::uint32_t i = 0; i < 4; ++i) {
            const iq_lines lines = seen(half_space(-60_mm, depth, anechoic, dense), probe, 2 * i + 1);
            level[i] = decibels(power(lines, 90, 100, depth, 0.05_mm));
            CHECK(std::fabs(level[i] - level[0]) < 0.1); // normal incidence on all planes
        }
    }
}

TEST_CASE("a frame in tilted planes is the same by rays and by slices") {
    using namespace elevation_test;
    scene body{scatterers};
    body.add(make_sphere({3_mm, 0.4_mm, 20_mm}, 4_mm, 4), dense);
    body.add(make_cylinder({-9_mm, -20_mm, 10_mm}, {9_mm, 20_mm, 30_mm}, 2_mm, 40), anechoic, {.priority = 1});
    body.add(make_box({-30_mm, 0.3_mm, -5_mm}, {30_mm, 30_mm, 40_mm}), medium{.density = 1100, .sound_speed = 1600});
    body.build(exec::par);
    const auto differing = [&](const auto& any_probe) {
        const acquisition scan{.depth = 50_mm, .samples = 500, .planes = 7};
        const scan_lines slices = trace(exec::par_unseq, body, any_probe, pose{}, law2011{}, scan,
                                        straight_lines{line_search::slices}),
                         rays = trace(exec::par_unseq, body, any_probe, pose{}, law2011{}, scan,
                                      straight_lines{line_search::rays});
        std::size_t apart = 0;
        for (std::size_t i = 0; i < rays.values.size(); ++i)
            apart += std::fabs(slices.values[i] - rays.values[i]) > 1e-5F;
        return static_cast<double>(apart) / static_cast<double>(rays.values.size());
    };
    CHECK(differing(probe) < 1e-3); // lines through vertices and edges
    CHECK(differing(convex_array{.lines = 96, .radius = 40_mm, .field_of_view = 60_deg}) < 1e-3);
    CHECK(differing(phased_array{.lines = 64}) < 1e-3);
    CHECK(differing(radial_array{.lines = 64, .radius = 2_mm}) < 1e-3);
}

TEST_CASE("speckle keeps the correlation of the beam as the probe slides out of the slice: exp(-d^2 / (4 sigma^2))") {
    using namespace elevation_test;
    const scene tissue = scene{scatterers}.build(exec::par);
    for (const std::uint32_t planes : {1U, 5U})
        for (const float slide : {0.3_mm, 0.6_mm, 1_mm}) {
            double product = 0, power = 0;
            for (std::uint32_t seed = 1; seed <= 8; ++seed) {
                const auto slid = [&](float by) {
                    return convolve(exec::par_unseq,
                                    trace(exec::par_unseq, tissue, probe, {.translation = {0, by, 0}},
                                          physical<>{.scattering = {.seed = seed}},
                                          {.depth = image_depth, .samples = samples, .planes = planes}),
                                    pulse{}, probe);
                };
                const iq_lines before = slid(0), after = slid(slide);
                for (std::uint32_t line = 0; line < before.count; ++line)
                    for (std::uint32_t k = 33 * samples / 60; k < 37 * samples / 60; ++k) {
                        product += static_cast<double>(dot(before(line, k), after(line, k)));
                        power += static_cast<double>(dot(before(line, k), before(line, k)));
                    }
            }
            const double expected = std::exp(-std::pow(slide / sigma(35_mm), 2) / 4);
            MESSAGE(planes, " planes, 35 mm deep, slid by ", (slide * 1e3F), " mm: correlation ", (product / power),
                    ", expected ", expected);
            CHECK(std::fabs(product / power / expected - 1) < 0.01);
        }
}
