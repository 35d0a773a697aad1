#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/read/ground_truth.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "echoes.hpp"

using namespace insonify;

namespace refraction_test {
namespace {

/// The aperture collects every specular echo whole.
struct whole_echo {
    float operator()(float, float, float) const { return 1; }
};

double wide(float x) { return static_cast<double>(x); }

// A plane plate in a medium, tilted by an angle, and an air wall behind it at right angles to the line: level and displayed
// depth of the wall's echo, in double precision. The level is that of the refracted ray, the depth that of the line.
struct oblique_plate {
    medium around{}, inside{};
    double thickness = 3e-3, degrees = 0, front = 20e-3, wall = 40e-3;

    echoes_test::echo expected(double megahertz) const {
        const double i = degrees * 3.14159265358979 / 180, c1 = wide(around.sound_speed), c2 = wide(inside.sound_speed);
        const double t = std::asin(c2 / c1 * std::sin(i));
        const double z1 = wide(around.density) * c1, z2 = wide(inside.density) * c2;
        const double sum = z2 * std::cos(i) + z1 * std::cos(t);
        const double transmitted =
            4 * z1 * z2 * std::cos(i) * std::cos(t) / (sum * sum); // there and back, each surface
        const double through =
            thickness / std::cos(t); // along the refracted ray, which advances by the cosine of its turn
        const double outside = wall - through * std::cos(t - i);
        const double loss =
            2 * (wide(around.attenuation) * std::pow(megahertz, wide(around.attenuation_power)) * outside +
                 wide(inside.attenuation) * std::pow(megahertz, wide(inside.attenuation_power)) * through);
        const medium air = tissue::air;
        const double za = wide(air.density) * wide(air.sound_speed), r = (za - z1) / (za + z1);
        return {transmitted * transmitted * std::fabs(r) * std::pow(10.0, -loss / 20),
                1540 * ((wall - thickness / std::cos(i)) / c1 + thickness / std::cos(i) / c2)};
    }

    scene body() const {
        const auto tilt = static_cast<float>(degrees * 3.14159265358979 / 180);
        const auto at = static_cast<float>(front);
        scene made{around};
        made.add(make_box({-80_mm, -60_mm, 0}, {80_mm, 60_mm, static_cast<float>(thickness)}), inside,
                 {.at = look_at({0, 0, at}, {std::sin(tilt), 0, at + std::cos(tilt)},
                                {std::cos(tilt), 0, -std::sin(tilt)})});
        made.add(make_box({-90_mm, -60_mm, static_cast<float>(wall)}, {90_mm, 60_mm, 90_mm}), tissue::air);
        made.build(exec::par);
        return made;
    }
};

medium quiet(medium m) {
    m.backscatter = m.roughness = 0;
    return m;
}

} // namespace
} // namespace refraction_test

TEST_CASE("behind an oblique plate, straight lines have the level of the refracted ray") {
    using namespace refraction_test;
    const medium muscle = quiet(tissue::muscle), bone = quiet(tissue::bone);
    const medium silicone{.density = 1070, .sound_speed = 1000, .attenuation = 100}; // slower than its surroundings
    const auto model = physical<>{.bandwidth = pulse_bandwidth::narrow}.with_specular(whole_echo{});
    const linear_array one_line{.lines = 1, .width = 1_mm, .frequency = 2.5_MHz};
    const oblique_plate plates[] = {{muscle, bone, 3e-3, 0},     {muscle, bone, 3e-3, 10}, {muscle, bone, 3e-3, 20},
                                    {muscle, bone, 3e-3, 24},    {muscle, bone, 1e-3, 26}, {muscle, silicone, 5e-3, 20},
                                    {muscle, silicone, 5e-3, 40}};
    for (const oblique_plate& plate : plates) {
        const scene body = plate.body();
        const auto found = echoes_test::echoes_of(
            trace(exec::par, body, one_line, pose{}, model, {.depth = 60_mm, .samples = 6000}), 0);
        REQUIRE(found.size() == 3);
        const echoes_test::echo expected = plate.expected(2.5);
        MESSAGE(plate.inside.sound_speed, " m/s, ", plate.degrees, " degrees: ", found[2].decibels(), " dB at ",
                found[2].depth * 1e3, " mm (expected ", expected.decibels(), " dB at ", expected.depth * 1e3, " mm)");
        CHECK(std::fabs(found[2].decibels() - expected.decibels()) < 0.05);
        CHECK(std::fabs(found[2].depth - expected.depth) < 10e-6);

        const ground_truth_lines truth =
            ground_truth(exec::par, body, one_line, pose{}, model,
                         {.depth = 60_mm, .samples = 6000, .grid = label_settings::depth_grid::displayed});
        const auto before_wall = static_cast<std::uint32_t>((expected.depth - 20e-6) / 10e-6);
        CHECK(truth.label(0, before_wall) == background_label); // the muscle behind the plate
        CHECK(truth.label(0, before_wall + 4) == 1);
        CHECK(20 * std::log10(wide(truth.transmitted(0, before_wall))) ==
              doctest::Approx(found[2].decibels()).epsilon(2e-3).scale(1e-30));
    }
}

TEST_CASE("through parallel oblique layers, every surface has the level of the refracted ray") {
    using namespace refraction_test;
    // Gel, muscle, bone, fat, all tilted by 20 degrees: thickness over the cosine of each layer's angle of refraction.
    const medium gel{.density = 1020, .sound_speed = 1540, .attenuation = 20};
    const medium media[] = {gel, quiet(tissue::muscle), quiet(tissue::bone), quiet(tissue::fat), quiet(tissue::muscle)};
    const double tilt = 20 * 3.14159265358979 / 180, thickness[] = {5e-3, 10e-3, 3e-3, 30e-3};
    const auto lean = static_cast<float>(tilt);
    scene body{media[0]};
    double along = thickness[0] / std::cos(tilt);
    for (std::size_t i = 1; i < 5; ++i) {
        const auto at = static_cast<float>(along);
        body.add(make_box({-200_mm, -100_mm, 0}, {200_mm, 100_mm, 150_mm}), media[i],
                 {.priority = static_cast<int>(i),
                  .at = look_at({0, 0, at}, {std::sin(lean), 0, at + std::cos(lean)},
                                {std::cos(lean), 0, -std::sin(lean)})});
        if (i < 4) along += thickness[i] / std::cos(tilt);
    }
    body.build(exec::par);
    const auto found = echoes_test::echoes_of(
        trace(exec::par, body, linear_array{.lines = 1, .width = 1_mm, .frequency = 2.5_MHz}, pose{},
              physical<>{.bandwidth = pulse_bandwidth::narrow}
                  .with_specular(whole_echo{})
                  .with_scattering(no_scatterers{}),
              {.depth = 70_mm, .samples = 7000}),
        0);
    REQUIRE(found.size() == 4);
    const double invariant = std::sin(tilt) / wide(media[0].sound_speed);
    const auto cosine = [&](std::size_t i) {
        return std::sqrt(1 - std::pow(invariant * wide(media[i].sound_speed), 2));
    };
    double amplitude = 1, loss = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        loss +=
            2 * wide(media[i].attenuation) * std::pow(2.5, wide(media[i].attenuation_power)) * thickness[i] / cosine(i);
        const double z1 = wide(media[i].density) * wide(media[i].sound_speed) / cosine(i),
                     z2 = wide(media[i + 1].density) * wide(media[i + 1].sound_speed) / cosine(i + 1);
        const double r = (z2 - z1) / (z2 + z1);
        const double expected = 20 * std::log10(amplitude * std::fabs(r)) - loss;
        MESSAGE("surface ", i, ": ", found[i].decibels(), " dB (expected ", expected, ")");
        CHECK(std::fabs(found[i].decibels() - expected) < 0.05);
        amplitude *= 1 - r * r;
    }
}

TEST_CASE("where the ray enters a layer after the line, what arrives does not grow with depth") {
    using namespace refraction_test;
    medium strong = quiet(tissue::muscle); // attenuates more than what is before it
    strong.attenuation = 500;
    // A wedge of bone, whose front leans by 15 degrees and whose back by `lean`.
    for (const float lean : {-20_deg, -10_deg, 10_deg, 20_deg}) {
        scene body{tissue::gel};
        const auto add = [&](float depth, float angle, const medium& inside, int priority) {
            body.add(make_box({-200_mm, -100_mm, 0}, {200_mm, 100_mm, 150_mm}), inside,
                     {.priority = priority,
                      .at = look_at({0, 0, depth}, {std::sin(angle), 0, depth + std::cos(angle)},
                                    {std::cos(angle), 0, -std::sin(angle)})});
        };
        add(10_mm, 15_deg, quiet(tissue::bone), 1);
        add(20_mm, lean, strong, 2);
        add(30_mm, 0, tissue::gel, 3);
        body.build(exec::par);
        const ground_truth_lines truth =
            ground_truth(exec::par, body, linear_array{.lines = 1, .width = 1_mm, .frequency = 5_MHz}, pose{},
                         {.depth = 50_mm, .samples = 3000});
        float largest = 0;
        for (std::uint32_t k = 0; k + 1 < 3000; ++k)
            largest = std::max(largest, truth.transmitted(0, k + 1) / truth.transmitted(0, k));
        MESSAGE("back at ", lean / 1_deg, " degrees: from one sample to the next at most ", largest,
                " times (expected 1)");
        CHECK(largest < 1.0001F);
    }
}
