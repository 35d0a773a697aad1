#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;

/// Fibres that are a function of the point.
namespace fibre_directions_test {
namespace {

/// Fibres on circles about an axis along y, 40 mm above the face: at 25 mm beside it they run down at 20 degrees or so.
struct arcs {
    vec3 centre{0, 0, -40_mm};
    vec3 operator()(vec3 p) const {
        const vec3 from = p - centre;
        return {from.z, 0, -from.x};
    }
};
/// Fibres that fan out from a line along y, as those of a pennate muscle do.
struct fan {
    vec3 operator()(vec3 p) const { return p - vec3{-90_mm, p.y, 20_mm}; }
};

mesh block() { return make_box({-40_mm, -15_mm, -2_mm}, {40_mm, 15_mm, 42_mm}); }

/// @param number  bodies of different numbers have different sheets
scene muscle(const fibre_directions& fibres, int number = 0) {
    scene body{medium{.density = 1075, .sound_speed = 1580, .attenuation = 100}};
    for (int i = 0; i < number; ++i) body.remove(body.add(block(), tissue::muscle)); // ids are never reused
    body.add(block(), tissue::muscle, {.fibres = fibres});
    return std::move(body).build(exec::par);
}

fibre_chart chart_of(const scene& body) { return body.view_for_rays(exec::par).structures[1].chart; }

/// Gradients of the coordinates along a direction.
vec3 along(const fibre_chart& chart, vec3 p, vec3 direction) {
    const vec3 step = 0.5_mm * normalize(direction);
    return (chart(p + step) - chart(p - step)) / 1_mm;
}

/// The largest angle between the fibres and a sheet of the coordinates, in the middle of the block, radians.
double worst_angle(const fibre_chart& chart, const auto& fibres) {
    double worst = 0;
    for (float x = -25_mm; x <= 25_mm; x += 2.5_mm)
        for (float y = -8_mm; y <= 8_mm; y += 4_mm)
            for (float z = 4_mm; z <= 36_mm; z += 2_mm) {
                const vec3 p{x, y, z}, along_fibres = along(chart, p, fibres(p));
                worst =
                    std::max(worst, static_cast<double>(std::hypot(along_fibres.y, along_fibres.z) / along_fibres.x));
            }
    return std::atan(worst);
}

/// Orientation of the echoes in a window, by its structure tensor: positive where they run down to the right; radians. The
/// gradient is that of decibels, smoothed alike in both directions.
double orientation(const scene& body, vec2 from, vec2 to) {
    const linear_array probe{.lines = 256, .width = 60_mm, .frequency = 9_MHz, .focus = 20_mm};
    constexpr double step = 0.15e-3, smooth = 0.5e-3;
    const int columns = static_cast<int>(static_cast<double>(to.x - from.x) / step),
              rows = static_cast<int>(static_cast<double>(to.y - from.y) / step);
    double xx = 0, xz = 0, zz = 0;
    for (int slice = -4; slice <= 4; ++slice) {
        const scan_lines seen =
            envelope(exec::par_unseq, convolve(exec::par_unseq,
                                               trace(exec::par_unseq, body, probe,
                                                     {.translation = {0, static_cast<float>(slice) * 2_mm, 0}},
                                                     physical<>{}, {.depth = 40_mm, .samples = 2048}),
                                               pulse{}, probe));
        const auto level = [&](double x, double z) { // mean of decibels over a square
            double sum = 0, count = 0;
            for (double dx = -smooth; dx <= smooth; dx += step)
                for (double dz = -smooth; dz <= smooth; dz += step, ++count) {
                    const auto line =
                        static_cast<std::uint32_t>(std::lround(probe.locate({static_cast<float>(x + dx), 20_mm}).x));
                    const auto sample = static_cast<std::uint32_t>((z + dz) * 1540 / 1580 / 40e-3 * 2048);
                    sum += std::log10(static_cast<double>(seen(line, sample)) + 1e-9);
                }
            return sum / count;
        };
        std::vector<double> grid(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
        const auto at = [&](int i, int k) -> double& {
            return grid[static_cast<std::size_t>(i) + static_cast<std::size_t>(k) * static_cast<std::size_t>(columns)];
        };
        for (int k = 0; k < rows; ++k)
            for (int i = 0; i < columns; ++i)
                at(i, k) = level(static_cast<double>(from.x) + i * step, static_cast<double>(from.y) + k * step);
        for (int k = 1; k + 1 < rows; ++k)
            for (int i = 1; i + 1 < columns; ++i) {
                const double x = at(i + 1, k) - at(i - 1, k), z = at(i, k + 1) - at(i, k - 1);
                xx += x * x, xz += x * z, zz += z * z;
            }
    }
    return 0.5 * std::atan2(-2 * xz, zz - xx); // of the direction across the gradient
}

} // namespace
} // namespace fibre_directions_test

TEST_CASE("fibres that are a function: in the coordinates of the structure they run along x") {
    using namespace fibre_directions_test;
    const auto check = [](const std::string& what, const auto& fibres, double highest) {
        const double worst = worst_angle(chart_of(muscle(fibres)), fibres) * 180 / 3.14159265358979;
        MESSAGE(what, ": fibres leave the sheets by at most ", worst, " degrees, expected 0");
        CHECK(worst < highest);
    };
    check("arcs", arcs{}, 1);
    check("a fan", fan{}, 1.5);
    check(
        "straight",
        [](vec3) {
            return vec3{1, 0, 0.2F};
        },
        0.1);
    CHECK(chart_of(muscle({1, 0, 0})).empty());
}

TEST_CASE("the echoes of a curved muscle follow its fibres") {
    using namespace fibre_directions_test;
    const auto degrees = [](double angle) { return angle * 180 / 3.14159265358979; };
    const arcs fibres{};
    const scene body = muscle(fibres);
    for (const float x : {-22_mm, -11_mm, 0.0F, 11_mm, 22_mm}) {
        const vec2 from{x - 5_mm, 14_mm}, to{x + 5_mm, 26_mm};
        const vec3 there = fibres({x, 0, 20_mm});
        const double expected = std::atan(static_cast<double>(there.z / there.x)), found = orientation(body, from, to);
        MESSAGE("at ", x * 1e3F, " mm: echoes run at ", degrees(found), " degrees, the fibres at ", degrees(expected));
        CHECK(std::fabs(degrees(found - expected)) < 5);
    }
}

TEST_CASE("the echoes of a pennate muscle flatten towards its surface, whichever way it is pennate") {
    using namespace fibre_directions_test;
    constexpr double degree = 3.14159265358979 / 180, pennation = 20 * degree;
    const auto pennate = [](double angle, float insertion) {
        medium m = tissue::muscle;
        m.structure.wave = 0;
        m.structure.sheath = {.thickness = 0.1_mm, .level_db = -60, .insertion = insertion};
        scene body{medium{.density = 1075, .sound_speed = 1580, .attenuation = 100}};
        body.add(make_box({-60_mm, -25_mm, 5_mm}, {60_mm, 25_mm, 60_mm}), m,
                 {.fibres = {static_cast<float>(std::cos(angle)), 0, static_cast<float>(std::sin(angle))}});
        return std::move(body).build(exec::par);
    };
    for (const double sign : {1.0, -1.0}) {
        const scene curved = pennate(sign * pennation, 70_mm);
        const double deepest = 0.5 * 70e-3 * std::sin(pennation);
        for (const double depth : {3e-3, 8e-3, 20e-3}) { // of the middle of a window
            const float z = static_cast<float>(depth) + 5_mm;
            const vec2 from{-18_mm, z - 2_mm}, to{18_mm, z + 2_mm};
            // Straight fibres of the angle there: the beam is wider than the pulse is long, which flattens all echoes.
            const double angle = sign * std::atan(std::tan(pennation) * std::sqrt(std::fmin(depth / deepest, 1)));
            const double found = orientation(curved, from, to) / degree,
                         expected = orientation(pennate(angle, 0), from, to) / degree;
            MESSAGE(depth * 1e3, " mm below the surface, where fibres run at ", angle / degree, " degrees: echoes at ",
                    found, " degrees, with straight fibres at ", expected);
            CHECK(std::fabs(found - expected) < 4); // sheets follow chords
        }
    }
}

TEST_CASE("curved fibres: the mean power stays, threads and SIMD agree, tissue that deforms keeps its fibres, scenes "
          "are copied") {
    using namespace fibre_directions_test;
    const linear_array probe{.lines = 128, .width = 50_mm, .frequency = 7.5_MHz};
    const acquisition scan{.depth = 40_mm, .samples = 1408};
    const auto seen = [&](const auto& policy, const scene& body, const auto& model) {
        return trace(policy, body, probe, pose{}, model, scan);
    };
    const auto difference = [](const iq_lines& a, const iq_lines& b) {
        float largest = 0, worst = 0;
        for (std::size_t i = 0; i < a.values.size(); ++i) {
            largest = std::max(largest, length(a.values[i]));
            worst = std::max(worst, length(a.values[i] - b.values[i]));
        }
        return worst / largest;
    };
    const scene body = muscle(arcs{});
    const iq_lines curved = seen(exec::par.threads(1), body, physical{});
    CHECK(seen(exec::par.threads(3), body, physical{}) == curved);
    CHECK(difference(curved, seen(exec::par_unseq, body, physical{})) < 1e-3F);
    const scene copy = scene{body};
    CHECK(seen(exec::par, copy, physical{}) == curved);

    const auto power = [&](const fibre_directions& fibres) {
        double sum = 0;
        for (int slice = 0; slice < 33; ++slice) { // each with sheets of its own
            const scene with = muscle(fibres, slice / 5);
            const physical<> model{.scattering = {.seed = 1 + static_cast<std::uint32_t>(slice)}};
            const pose at{.translation = {0, static_cast<float>(slice % 5 - 2) * 5_mm, 0}};
            for (const vec2 value : trace(exec::par_unseq, with, probe, at, model, scan).values)
                sum += static_cast<double>(dot(value, value));
        }
        return sum;
    };
    // Near the face, where echoes are strongest, the fan is tilted as straight fibres at atan(20 / 90) are.
    const double changed = 10 * std::log10(power(fan{}) / power({-90, 0, 20}));
    MESSAGE("mean power of a fan against straight fibres at 12.5 degrees: ", changed, " dB, expected 0");
    CHECK(std::fabs(changed) < 1);

    // Tissue that has moved by 3 mm, seen by a probe that moved with it.
    scene moved{body};
    moved.deform(exec::par, [](vec3 rest) { return rest + vec3{3_mm, 0, 0}; });
    const iq_lines shifted = trace(exec::par, moved, probe, {.translation = {3_mm, 0, 0}}, physical{}, scan);
    const auto middle = [&](const iq_lines& lines) { // away from the sides of the block
        iq_lines part{lines.count - 64, lines.samples, lines.depth};
        for (std::uint32_t i = 0; i < part.count; ++i)
            for (std::uint32_t k = 0; k < lines.samples; ++k) part(i, k) = lines(i + 32, k);
        return part;
    };
    double same = 0, a = 0, b = 0;
    const iq_lines still = middle(curved), back = middle(shifted);
    for (std::size_t i = 0; i < still.values.size(); ++i) {
        same += static_cast<double>(dot(still.values[i], back.values[i]));
        a += static_cast<double>(dot(still.values[i], still.values[i]));
        b += static_cast<double>(dot(back.values[i], back.values[i]));
    }
    MESSAGE("tissue that has moved, seen by a probe that moved with it: correlation ", same / std::sqrt(a * b),
            ", expected 1");
    CHECK(same / std::sqrt(a * b) > 0.9);
}

TEST_CASE("fibres that end on a sheath: threads and SIMD agree, tissue that deforms keeps them, also at the tip of a "
          "muscle") {
    using namespace fibre_directions_test;
    scene body{tissue::deep_fat};
    mesh ellipsoid = make_sphere({0, 0, 0}, 1, 5);
    for (vec3& p : ellipsoid.positions) p = p * vec3{30_mm, 12_mm, 9_mm} + vec3{0, 0, 20_mm};
    body.add(std::move(ellipsoid), tissue::muscle, {.fibres = {1, 0, 0.3F}});
    body.build(exec::par);
    const linear_array probe{.lines = 128, .width = 64_mm, .frequency = 7.5_MHz};
    const acquisition scan{.depth = 40_mm, .samples = 1408};
    const auto seen = [&](const auto& policy, const scene& of, float x) {
        return trace(policy, of, probe, {.translation = {x, 0, 0}}, physical{}, scan);
    };
    const auto difference = [](const iq_lines& a, const iq_lines& b) { // rms, relative
        double power = 0, other = 0;
        for (std::size_t i = 0; i < a.values.size(); ++i) {
            const vec2 between = a.values[i] - b.values[i];
            power += static_cast<double>(dot(a.values[i], a.values[i]));
            other += static_cast<double>(dot(between, between));
        }
        return std::sqrt(other / power);
    };
    const iq_lines still = seen(exec::seq, body, 0);
    for (const vec2 value : still.values) REQUIRE((is_finite(value.x) && is_finite(value.y)));
    CHECK(seen(exec::par.threads(3), body, 0) == still);
    CHECK(difference(still, seen(exec::par_unseq, body, 0)) < 1e-2);
    scene moved{body};
    moved.deform(exec::par, [](vec3 rest) { return rest + vec3{3_mm, 0, 0}; });
    CHECK(difference(still, seen(exec::seq, moved, 3_mm)) < 0.1);
}

TEST_CASE("a function of fibres without a direction is refused, when the scene is built") {
    using namespace fibre_directions_test;
    scene body{tissue::fat};
    const object_id id = body.add(block(), tissue::muscle, {.fibres = [](vec3 p) { return vec3{p.x, 0, 0} * 0.0F; }});
    CHECK_THROWS_AS(body.build(exec::seq), geometry_error);
    body.remove(id);
    body.add(block(), tissue::muscle, {.fibres = [](vec3 p) { return vec3{p.x < 0 ? -INFINITY : INFINITY, 0, 0}; }});
    CHECK_THROWS_AS(body.build(exec::seq), geometry_error);
}

TEST_CASE("the layers of a limb run around it where they are parallel to its surface") {
    using namespace fibre_directions_test;
    scene body{tissue::water};
    body.add(make_cylinder({0, -60_mm, 0}, {0, 60_mm, 0}, 30_mm, 96, 48), tissue::fat, {.layer_normal = own_surface{}});
    body.build(exec::par);
    const fibre_chart chart = chart_of(body);
    double worst = 0, thinnest = 2, thickest = 0;
    for (float turn = 0; turn < 2 * pi; turn += 0.1F)
        for (float r = 18_mm; r < 30_mm; r += 2_mm)
            for (float y = -30_mm; y <= 30_mm; y += 10_mm) {
                const vec3 out{std::cos(turn), 0, std::sin(turn)}, p = r * out + vec3{0, y, 0};
                const vec3 z_slope{along(chart, p, {1, 0, 0}).z, along(chart, p, {0, 1, 0}).z,
                                   along(chart, p, {0, 0, 1}).z};
                worst = std::max(worst, static_cast<double>(length(cross(normalize(z_slope), out))));
                thinnest = std::min(thinnest, static_cast<double>(length(z_slope)));
                thickest = std::max(thickest, static_cast<double>(length(z_slope)));
                CHECK(std::fabs(along(chart, p, {0, 1, 0}).z) < 0.1F);
            }
    MESSAGE("layers leave the surface by at most ", std::asin(worst) * 57.2958, " degrees, are ", thinnest, " to ",
            thickest, " as thick as in flat tissue");
    CHECK(std::asin(worst) * 57.2958 < 8);
    CHECK(thinnest > 0.8);
    CHECK(thickest < 1.2);
}

TEST_CASE("the normal of layers is a direction or a function; fibres come first where they are not across it") {
    using namespace fibre_directions_test;
    const auto axes = [](const object_settings& settings) {
        scene body{tissue::water};
        body.add(block(), tissue::muscle, settings);
        return std::move(body).build(exec::par).view_for_rays(exec::par).structures[1].axes;
    };
    const auto is_along = [](vec3 a, vec3 b) { return std::fabs(dot(a, normalize(b))) > 0.9999F; };
    const mat3 flattest = axes({}), turned = axes({.layer_normal = {0, 0, 5}}),
               both = axes({.fibres = {1, 0, 1}, .layer_normal = {0, 0, 1}});
    CHECK(is_along(flattest[2], {0, 1, 0}));
    CHECK(is_along(turned[2], {0, 0, 1}));
    CHECK(is_along(turned[0], {1, 0, 0}));
    CHECK(is_along(both[0], {1, 0, 1}));
    CHECK(is_along(both[2], {-1, 0, 1}));

    scene body{tissue::water};
    body.add(block(), tissue::fat, {.layer_normal = [](vec3 p) { return vec3{0.02F * p.x / 1_mm, 0, 1}; }});
    body.build(exec::par);
    const fibre_chart chart = chart_of(body);
    const vec3 p{20_mm, 0, 20_mm},
        slope{along(chart, p, {1, 0, 0}).z, along(chart, p, {0, 1, 0}).z, along(chart, p, {0, 0, 1}).z};
    CHECK(dot(normalize(slope), normalize(vec3{0.4F, 0, 1})) > 0.995F);

    scene bad{tissue::water};
    CHECK_THROWS_AS(bad.add(block(), tissue::fat, {.layer_normal = {NAN, 0, 1}}), geometry_error);
    bad.add(block(), tissue::fat, {.name = "fat", .layer_normal = [](vec3) { return vec3{0, 0, 0}; }});
    CHECK_THROWS_AS(bad.build(exec::seq), geometry_error);
}
