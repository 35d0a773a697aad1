#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/ground_truth.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>

#include "echoes.hpp"

// A model's own laws, in what is drawn, in what is true of it and in where paths go.

using namespace insonify;

namespace laws_test {
namespace {

// Transmits the same, whatever the media and the angle.
struct constant_law {
    float transmitted = 0.8F;
    response operator()(const incidence&) const { return {.reflected = 0.25F, .transmitted = transmitted}; }
    friend bool operator==(const constant_law&, const constant_law&) = default;
};
// dB/m there and back, whatever the frequency.
struct constant_loss {
    float operator()(const medium& m, float) const { return 3 * m.attenuation; }
    friend bool operator==(const constant_loss&, const constant_loss&) = default;
};
// Turns what goes on by a share of its direction, to the side.
struct turning_law : constant_law {
    float aside = 0.2F;
    vec3 refracted(vec3 direction, vec3, const medium&, const medium&) const {
        return normalize(direction + vec3{aside, 0, 0});
    }
    friend bool operator==(const turning_law&, const turning_law&) = default;
};
// Sound takes any law's echo: nothing is lost to the aperture.
struct everything {
    float operator()(float, float, float) const { return 1; }
    friend bool operator==(const everything&, const everything&) = default;
};

constexpr linear_array one_line{.lines = 1, .width = 1_mm, .frequency = 5_MHz};

// Slabs from 10 to 20 mm and from 30 to 40 mm, at right angles to the beam or tilted.
constexpr medium outside{.density = 1000, .sound_speed = 1540, .attenuation = 20, .backscatter = 1};
constexpr medium inside{.density = 1500, .sound_speed = 1540, .attenuation = 60, .backscatter = 1};
scene slabs(float tilt = 0) {
    scene body{outside};
    for (const float z : {10_mm, 30_mm}) {
        const vec3 at{0, 0, z};
        body.add(
            make_box({-90_mm, -90_mm, 0}, {90_mm, 90_mm, 10_mm * std::cos(tilt)}), inside,
            {.at = look_at(at, at + vec3{std::sin(tilt), 0, std::cos(tilt)}, {std::cos(tilt), 0, -std::sin(tilt)})});
    }
    body.build(exec::par);
    return body;
}

// Interfaces above, and metres of each medium.
struct way {
    int surfaces = 0;
    double out = 0, in = 0;
    explicit way(double z) {
        for (const double surface : {10e-3, 20e-3, 30e-3, 40e-3}) surfaces += z > surface;
        in = std::clamp(z - 10e-3, 0.0, 10e-3) + std::clamp(z - 30e-3, 0.0, 10e-3);
        out = z - in;
    }
};

// The largest relative error of `transmitted` against expected(way), over all samples that are not on a surface.
template <class Model, class Expected>
double worst_error(const scene& body, const Model& model, const Expected& expected) {
    const ground_truth_lines truth =
        ground_truth(exec::par, body, one_line, pose{}, model, {.depth = 50_mm, .samples = 500});
    double worst = 0;
    for (std::uint32_t k = 0; k < 500; ++k) {
        const double z = (k + 0.5) * 1e-4;
        worst = std::max(worst, std::fabs(static_cast<double>(truth.transmitted(0, k)) / expected(way{z}) - 1));
    }
    return worst;
}

double decay(double decibels) { return std::pow(10, -decibels / 20); }

} // namespace
} // namespace laws_test

TEST_CASE("transmitted is the product of a user's own law over the surfaces above, times his own attenuation") {
    using namespace laws_test;
    const scene body = slabs();
    const physical<> carrier{.bandwidth = pulse_bandwidth::narrow}; // the closed form is that of a single frequency
    const auto expected = [](double fraction) {
        return [=](const way& w) { return std::pow(fraction, w.surfaces) * decay(2 * 5 * (20 * w.out + 60 * w.in)); };
    };
    for (const float fraction : {1.0F, 0.8F, 0.3F})
        CHECK(worst_error(body, carrier.with_boundary(constant_law{fraction}),
                          expected(static_cast<double>(fraction))) < 1e-4);
    CHECK(worst_error(body, carrier.with_boundary(constant_law{0.8F}).with_attenuation(constant_loss{}),
                      [](const way& w) { return std::pow(0.8, w.surfaces) * decay(3 * (20 * w.out + 60 * w.in)); }) <
          1e-4);
    CHECK(worst_error(slabs(30_deg), carrier.with_boundary(constant_law{0.8F}), expected(0.8)) < 1e-4);
    const double fresnel_fraction = 1 - 0.04; // r = 0.5 / 2.5
    CHECK(worst_error(body, carrier, expected(fresnel_fraction)) < 1e-4);
}

TEST_CASE("under law2011 transmitted is its I_a I_t: one way or two, linear in the frequency or by the power law") {
    using namespace laws_test;
    const scene body = slabs();
    const auto expected = [](double ways) {
        return [=](const way& w) { return std::pow(0.96, w.surfaces) * decay(ways * 5 * (20 * w.out + 60 * w.in)); };
    };
    CHECK(worst_error(body, law2011{}, expected(1)) < 1e-4);
    CHECK(worst_error(body, law2011{.travel = law2011::travel::two_way}, expected(2)) < 1e-4);
    // And it is what law2011 draws, where no bright band lies.
    const ground_truth_lines truth =
        ground_truth(exec::par, body, one_line, pose{}, law2011{}, {.depth = 50_mm, .samples = 500});
    const scan_lines drawn = trace(exec::par, body, one_line, pose{}, law2011{}, {.depth = 50_mm, .samples = 500});
    for (std::uint32_t k = 0; k < 500; ++k)
        if (k % 100 < 89 || k > 400)
            REQUIRE(drawn(0, k) == doctest::Approx(truth.transmitted(0, k)).epsilon(1e-4).scale(1e-30));
}

TEST_CASE("with angle::normal transmitted is that of normal incidence, however the surface is tilted") {
    using namespace laws_test;
    const medium slow{.density = 1000, .sound_speed = 1500}, fast{.density = 1000, .sound_speed = 2000};
    scene body{slow};
    const float tilt = 30_deg;
    body.add(make_box({-90_mm, -90_mm, 0}, {90_mm, 90_mm, 90_mm}), fast,
             {.at = look_at({0, 0, 10_mm}, {std::sin(tilt), 0, 10_mm + std::cos(tilt)},
                            {std::cos(tilt), 0, -std::sin(tilt)})});
    body.build(exec::par);
    const auto behind = [&](const auto& model) {
        return static_cast<double>(
            ground_truth(exec::par, body, one_line, pose{}, model, {.depth = 20_mm, .samples = 200})
                .transmitted(0, 150));
    };
    // T = 4 Z1 Z2 cos i cos t / (Z2 cos i + Z1 cos t)^2, sin t = 4/3 sin i; at normal incidence 48/49.
    const double cos_i = std::cos(static_cast<double>(tilt)), cos_t = std::sqrt(1 - 16.0 / 9 * (1 - cos_i * cos_i));
    const double sum = 2.0 * cos_i + 1.5 * cos_t;
    CHECK(behind(physical{}) ==
          doctest::Approx(4 * 1.5 * 2.0 * cos_i * cos_t / (sum * sum)).epsilon(1e-5).scale(1e-30));
    CHECK(behind(physical<>{.angle = angle::normal}) == doctest::Approx(48.0 / 49).epsilon(1e-6).scale(1e-30));
    CHECK(behind(law2011{}) == doctest::Approx(48.0 / 49).epsilon(1e-6).scale(1e-30));
}

TEST_CASE("the rms of drawn speckle falls along a line as transmitted says, under a user's law and under Fresnel's") {
    using namespace laws_test;
    const scene body = slabs();
    const linear_array probe{.lines = 96, .width = 30_mm, .frequency = 5_MHz};
    constexpr std::uint32_t samples = 1280;
    const auto compare = [&](const auto& plain) {
        const ground_truth_lines truth =
            ground_truth(exec::par, body, probe, pose{}, plain,
                         {.depth = 50_mm, .samples = samples, .grid = label_settings::depth_grid::displayed});
        std::vector<double> power(samples);
        constexpr int seeds = 12;
        for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
            auto model = plain;
            model.scattering.seed = seed;
            const iq_lines lines =
                convolve(exec::par_unseq,
                         trace(exec::par_unseq, body, probe, pose{}, model, {.depth = 50_mm, .samples = samples}),
                         pulse{}, probe);
            for (std::uint32_t i = 0; i < probe.lines; ++i)
                for (std::uint32_t k = 0; k < samples; ++k)
                    power[k] += static_cast<double>(dot(lines(i, k), lines(i, k))) / probe.lines / seeds;
        }
        for (const float from : {3_mm, 12_mm, 22_mm, 32_mm, 42_mm}) { // 5 mm windows, 2 mm off the surfaces
            double drawn = 0, expected = 0;
            const auto first = static_cast<std::uint32_t>(from / 50_mm * samples);
            for (std::uint32_t k = first; k < first + 128; ++k) {
                drawn += power[k];
                expected += std::pow(static_cast<double>(truth.transmitted(48, k)), 2);
            }
            const double decibels = 10 * std::log10(drawn / expected);
            MESSAGE("from ", (from * 1e3F), " mm: speckle over transmitted ", decibels, " dB, expected -55");
            CHECK(std::fabs(decibels + 55) < 0.5);
        }
    };
    compare(physical{}.with_boundary(constant_law{0.5F}));
    compare(physical{});
}

TEST_CASE("paths bend as a user's law says: each surface turns them once more") {
    using namespace laws_test;
    const auto model =
        physical{}.with_boundary(turning_law{}).with_specular(everything{}).with_scattering(no_scatterers{});
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.add(make_box({-90_mm, -90_mm, 10_mm}, {90_mm, 90_mm, 20_mm}), medium{.density = 1500, .sound_speed = 1540});
    body.add(make_box({-90_mm, -90_mm, 30_mm}, {90_mm, 90_mm, 90_mm}), medium{.density = 1500, .sound_speed = 1540});
    body.build(exec::par);
    const acquisition scan{.depth = 50_mm, .samples = 5000};
    const auto found =
        echoes_test::echoes_of(trace(exec::par, body, one_line, pose{}, model, scan, paths{{.bounces = 0}}), 0);
    REQUIRE(found.size() == 3);
    glm::dvec3 along{0, 0, 1};
    double length = 10e-3, amplitude = 0.25;
    for (const auto& echo : found) {
        CHECK(std::fabs(echo.depth - length) < 3e-6);
        CHECK(echo.amplitude == doctest::Approx(amplitude).epsilon(2e-3).scale(1e-30));
        along = glm::normalize(along + glm::dvec3{static_cast<double>(0.2F), 0, 0});
        length += 10e-3 / along.z;
        amplitude *= 0.8;
    }
    CHECK(length > 42e-3); // of 40 mm where nothing bends
}

TEST_CASE("a law that transmits beyond Snell's critical angle lets the path go straight on") {
    using namespace laws_test;
    // 1540 to 3080 m/s: total reflection from 30 degrees on. The plane is tilted by 45, a plate lies 10 mm behind it.
    const medium slow{.density = 1000, .sound_speed = 1540}, fast{.density = 1000, .sound_speed = 3080};
    scene body{slow};
    body.add(make_box({-90_mm, -90_mm, 0}, {90_mm, 90_mm, 90_mm}), fast,
             {.at = look_at({0, 0, 10_mm}, {1, 0, 10_mm + 1}, {1, 0, -1})});
    body.add(make_box({-10_mm, -10_mm, 20_mm}, {2_mm, 10_mm, 22_mm}), medium{.density = 2000, .sound_speed = 3080},
             {.priority = 1});
    body.build(exec::par);
    const auto echoes_of = [&](const auto& model) {
        return echoes_test::echoes_of(trace(exec::par, body, one_line, pose{},
                                            model.with_specular(everything{}).with_scattering(no_scatterers{}),
                                            {.depth = 18_mm, .samples = 1800}, paths{{.bounces = 0}}),
                                      0);
    };
    const auto found = echoes_of(physical{}.with_boundary(constant_law{0.8F}));
    REQUIRE(found.size() == 3); // the plane, and the plate's two sides at 10 + 10/2 and 10 + 12/2 mm
    const double depths[] = {10e-3, 15e-3, 16e-3}, amplitudes[] = {0.25, 0.25 * 0.8, 0.25 * 0.64};
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(std::fabs(found[i].depth - depths[i]) < 6e-6);
        CHECK(found[i].amplitude == doctest::Approx(amplitudes[i]).epsilon(2e-3).scale(1e-30));
    }
    CHECK(echoes_of(physical{}).size() == 1); // Fresnel's law: totally reflected
}
