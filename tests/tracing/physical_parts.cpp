#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/trace.hpp>
#include "echoes.hpp"
#include "physical_scenes.hpp"
#include <doctest/doctest.h>

using namespace insonify;

namespace physical_test {
namespace {

struct everything {
    float operator()(float, float, float) const { return 1; }
};

struct polished {
    float coherent(const incidence&) const { return 1; }
    float diffuse(const incidence&) const { return 0; }
};

struct lossless {
    float operator()(const medium&, float) const { return 0; }
};

} // namespace
} // namespace physical_test

TEST_CASE("every part of the model can be a user's own, and works in it") {
    scene body{medium{.density = 1000, .sound_speed = 1540, .attenuation = 50}};
    body.add(physical_test::slab(20_mm, 40_mm),
             medium{.density = 1500, .sound_speed = 1540, .attenuation = 50, .roughness = 30_um},
             {.at = look_at({0, 0, 0}, {0.05F, 0, 1}, {1, 0, 0})});
    body.build(exec::seq);
    const acquisition scan{.depth = 30_mm, .samples = 1200};
    const linear_array probe{.lines = 1, .width = 20_mm, .frequency = 5_MHz};
    const auto first = [&](const auto& model) {
        return echoes_test::echoes_of(trace(exec::seq, body, probe, pose{}, model, scan), 0).at(0).amplitude;
    };
    const auto plain = physical<>{.bandwidth = pulse_bandwidth::narrow}
                           .with_specular(physical_test::everything{})
                           .with_roughness(physical_test::polished{})
                           .with_attenuation(physical_test::lossless{})
                           .with_scattering(no_scatterers{})
                           .with_boundary(fresnel{});
    CHECK(first(plain) ==
          doctest::Approx(0.2).epsilon(1e-3).scale(1e-30)); // (1500 - 1000) / 2500, and nothing taken from it
    CHECK(first(plain.with_attenuation(power_law{})) < 0.2 * std::pow(10, -9.9 / 20)); // 2 x 0.5 x 5 x 2 cm = 10 dB
    CHECK(first(plain.with_roughness(kirchhoff{})) < 0.19);
    const float tilted = std::atan(0.05F); // 2.9 degrees, F/2, 20 mm deep
    CHECK(first(plain.with_specular(specular_return{})) ==
          doctest::Approx(0.2F * specular_return{}(tilted, 2, 20_mm * 5_MHz / 1540)).epsilon(2e-3).scale(1e-30));
    CHECK(echoes_test::echoes_of(trace(exec::seq, body, probe, pose{}, plain, scan, paths{}), 0).at(0).amplitude ==
          doctest::Approx(0.2).epsilon(1e-3).scale(1e-30));
}

TEST_CASE("a field of a user's may emit single scatterers, and settings out of range are refused") {
    const scene body = scene{tissue::muscle}.build(exec::seq);
    const linear_array probe{.lines = 3};
    const acquisition scan{.depth = 20_mm, .samples = 800};
    const auto model = physical{}.with_scattering(physical_test::one_scatterer{});
    const iq_lines lines = trace(exec::par, body, probe, pose{}, model, scan);
    CHECK(echoes_test::echoes_of(lines, 1).size() == 1);
    CHECK_THROWS_AS(trace(exec::seq, body, probe, pose{}, physical<>{.scattering = {.cell = 0}}, scan), usage_error);
    CHECK_THROWS_AS(trace(exec::seq, body, probe, pose{}, physical<>{.texture_db = NAN}, scan), usage_error);
    CHECK_THROWS_AS(trace(exec::seq, body, probe, pose{}, physical<>{.shadow_floor_db = 3}, scan), usage_error);
}

TEST_CASE("a model changes its law, its texture and its options, and keeps the rest") {
    struct mirror {
        response operator()(const incidence&) const { return {.reflected = 0.5F, .transmitted = 0.25F}; }
    };
    scene body{medium{.density = 1000, .sound_speed = 1540, .backscatter = 1}};
    body.add(make_box({-50_mm, -50_mm, 0}, {50_mm, 50_mm, 20_mm}), medium{.density = 1200, .sound_speed = 1540},
             {.at = look_at({0, 0, 20_mm}, {0.3F, 0, 1.02F}, {1, 0, -0.3F})});
    body.build(exec::par);
    const acquisition scan{.depth = 40_mm, .samples = 4000};
    const auto first_echo = [&](const auto& model) {
        return physical_test::echoes_of(trace(exec::par, body, physical_test::probe(5_MHz), pose{}, model, scan), 8)
            .front()
            .amplitude;
    };
    const physical<> base{.angle = angle::normal, .texture_db = -300};
    const auto silent = base.with_scattering(no_scatterers{});
    CHECK(silent.angle == angle::normal);
    CHECK(first_echo(silent) ==
          doctest::Approx(1.0 / 11).scale(1e-30)); // (1.2 - 1) / (1.2 + 1), as at normal incidence
    CHECK(first_echo(silent.with_boundary(mirror{})) == doctest::Approx(0.5).scale(1e-30));
    CHECK(trace(exec::par, body, physical_test::probe(5_MHz), pose{}, silent.with_boundary(fresnel{}), scan) ==
          trace(exec::par, body, physical_test::probe(5_MHz), pose{}, silent, scan));
    const physical<fresnel, no_scatterers> oblique{.specular = {.lobe = specular_return::lobe_shape::aperture}};
    CHECK(trace(exec::par, body, physical_test::probe(5_MHz), pose{}, oblique, scan).values ==
          std::vector<vec2>(16 * 4000, vec2{0, 0})); // 17 degrees off: beside the aperture
    const physical<fresnel, no_scatterers> broad{.bandwidth = pulse_bandwidth::broad},
        narrow{.bandwidth = pulse_bandwidth::narrow};
    scene lossy{medium{.density = 1000, .sound_speed = 1540, .attenuation = 50}};
    lossy.add(physical_test::slab(40_mm, 60_mm), tissue::air);
    lossy.build(exec::par);
    const auto level = [&](const auto& model) {
        return physical_test::echoes_of(trace(exec::par, lossy, physical_test::probe(5_MHz), pose{}, model,
                                              {.depth = 45_mm, .samples = 4500}),
                                        8)
            .front()
            .decibels();
    };
    CHECK(level(narrow) == doctest::Approx(-20).epsilon(1e-3).scale(1e-30));
    CHECK(level(broad) > -18.5 - 0.4); // B = 0.644 for 2.5 cycles: a little less than the 18.5 dB of B = 0.6
    CHECK(level(broad) < -18.0);
    CHECK(level(physical<fresnel, no_scatterers>{}) == level(broad)); // the default
}
