#include <insonify/acoustics/tissue.hpp>
#include <insonify/image/image.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <doctest/doctest.h>

#include "../tracing/reference.hpp"

using namespace insonify;

namespace pixels_test {
namespace {

vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

pose random_pose(std::uint64_t seed, vec3 centre) {
    const vec3 z = random_point(seed, 0), x = random_point(seed, 1);
    return look_at(centre, centre + z, x);
}

medium random_medium(std::uint64_t seed) {
    return {.density = 900 + 1100 * hash_uniform(seed, 0),
            .sound_speed = 1400 + 2500 * hash_uniform(seed, 1),
            .attenuation = 300 * hash_uniform(seed, 2)};
}

// Balls, boxes and cylinders in random poses round a point 30 mm deep: they nest, overlap, and hold the probe.
scene random_scene(std::uint64_t seed) {
    scene body{random_medium(seed)};
    const auto objects = 2 + hash_bits(seed, 1) % 6;
    for (std::uint64_t i = 0; i < objects; ++i) {
        const std::uint64_t own = hash_bits(seed, 100 + i);
        const float size = 4_mm + 20_mm * hash_uniform(own, 0);
        const vec3 centre = vec3{0, 0, 30_mm} + 25_mm * random_point(own, 3);
        mesh surface = own % 3 == 0 ? make_sphere({0, 0, 0}, size, 2)
                       : own % 3 == 1
                           ? make_box(-vec3{size, 0.7F * size, 0.5F * size}, {size, 0.7F * size, 0.5F * size}, 1)
                           : make_cylinder({0, 0, -size}, {0, 0, size}, 0.6F * size, 20);
        body.add(std::move(surface), random_medium(own),
                 {.priority = static_cast<int>(own % 5 % 3), .at = random_pose(own, centre)});
    }
    body.add(make_sphere({0, 0, 0}, 12_mm, 2), random_medium(seed + 1)); // the probe stands in it
    body.build(exec::par);
    return body;
}

} // namespace
} // namespace pixels_test

TEST_CASE("beams and pixels agree with brute force in double precision on 24 random scenes") {
    constexpr std::uint64_t first_seed = 2011;
    MESSAGE("first seed ", first_seed);
    const law2011 model{};
    const acquisition scan{.depth = 60_mm, .samples = 500};
    const auto compare = [&](const scene& body, const auto& probe, const pose& at) {
        const scan_lines scalar = trace(exec::seq, body, probe, at, model, scan);
        const scan_lines simd = trace(exec::par_unseq, body, probe, at, model, scan);
        const scan_lines pixels = trace_pixels(exec::par, body, probe, at, model, scan);
        double worst = 0;
        int doubtful = 0;
        for (std::uint32_t i = 0; i < probe.lines; ++i) {
            const reference::line line = reference::trace(body, detail::world_beam(probe, at, static_cast<float>(i)));
            for (std::uint32_t k = 0; k < scan.samples; ++k) {
                const double depth = (k + 0.5) / scan.samples * static_cast<double>(scan.depth);
                if (reference::in_doubt(line, depth, static_cast<double>(model.reflection_length))) {
                    ++doubtful;
                    continue;
                }
                const double expected = reference::intensity(line, depth, static_cast<double>(probe.frequency) * 1e-6,
                                                             static_cast<double>(model.reflection_length));
                for (const scan_lines* found : {&scalar, &simd, &pixels})
                    worst = std::max(worst, std::fabs(static_cast<double>((*found)(i, k)) - expected) / expected);
            }
        }
        CHECK(worst < 2e-3);
        CHECK(doubtful < 0.02 * probe.lines * scan.samples);
        return worst;
    };
    double worst = 0;
    for (std::uint64_t seed = first_seed; seed < first_seed + 24; ++seed) {
        const scene body = pixels_test::random_scene(seed);
        const vec3 at_face = 4_mm * pixels_test::random_point(seed, 7);
        const pose at = look_at(at_face, {0, 0, 30_mm}, pixels_test::random_point(seed, 8));
        CAPTURE(seed);
        switch (seed % 3) {
        case 0:
            worst = std::max(worst, compare(body, linear_array{.lines = 24, .width = 30_mm, .frequency = 2_MHz}, at));
            break;
        case 1:
            worst = std::max(
                worst,
                compare(body, convex_array{.lines = 24, .radius = 20_mm, .field_of_view = 70_deg, .frequency = 2_MHz},
                        at));
            break;
        default:
            worst = std::max(
                worst,
                compare(body, phased_array{.lines = 24, .width = 10_mm, .field_of_view = 90_deg, .frequency = 2_MHz},
                        at));
            break;
        }
    }
    MESSAGE("worst relative difference ", worst, ", allowed 0.002");
}

TEST_CASE("a camera sees the slice where its rays meet it") {
    // A ball in water, seen from the side by both cameras: its outline is where it is.
    scene body{tissue::water};
    body.add(make_sphere({5_mm, 0, 20_mm}, 6_mm, 4), medium{.density = 998, .sound_speed = 1482, .attenuation = 500});
    body.build(exec::par);
    const linear_array probe{.lines = 128, .width = 40_mm, .frequency = 5_MHz};
    const pose side = look_at({0, 100_mm, 20_mm}, {0, 0, 20_mm}, {1, 0, 0});
    const orthographic_camera parallel{.at = side, .extent = {60_mm, 60_mm}, .size = {120, 120}};
    const perspective_camera central{.at = side, .field_of_view = 2 * std::atan(0.3F), .size = {120, 120}};
    const law2011 model{};
    const image a = trace_pixels(exec::par, body, probe, pose{}, model, {.depth = 40_mm}, parallel);
    const image b = trace_pixels(exec::par_unseq, body, probe, pose{}, model, {.depth = 40_mm}, central);
    REQUIRE(a.size == uvec2{120, 120});
    double difference = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        difference += static_cast<double>(std::fabs(a.pixels[i] - b.pixels[i]));
    CHECK(difference / static_cast<double>(a.pixels.size()) < 1e-3); // 100 mm away, 60 mm wide: the same scale
    const auto pixel = [](float x, float z) {
        return uvec2{static_cast<std::uint32_t>(60 + x / 0.5_mm),
                     static_cast<std::uint32_t>(60 + (z - 20_mm) / 0.5_mm)};
    };
    const auto grey = [&](float x, float z) { return a(pixel(x, z).x, pixel(x, z).y); };
    CHECK(grey(-10_mm, 20_mm) > 0.9F);                   // water
    CHECK(grey(5_mm, 25_mm) < 0.6F * grey(5_mm, 15_mm)); // attenuated within the ball
    CHECK(grey(5_mm, 35_mm) < 0.1F);                     // its shadow
    CHECK(grey(-25_mm, 20_mm) == 0);                     // beside the probe's field
    CHECK(grey(0, 45_mm) == 0);                          // below its depth
    const image same = trace_pixels(exec::seq, body, probe, pose{}, model, {.depth = 40_mm}, parallel);
    CHECK(same == a);
    const orthographic_camera from_behind{.at = look_at({0, -100_mm, 20_mm}, {0, -200_mm, 20_mm}, {1, 0, 0})};
    for (const float p : trace_pixels(exec::par, body, probe, pose{}, model, {.depth = 40_mm}, from_behind).pixels)
        REQUIRE(p == 0);
}

TEST_CASE("cameras refuse settings out of range") {
    const scene body = scene{}.build(exec::seq);
    const auto see = [&](const auto& camera) {
        trace_pixels(exec::seq, body, linear_array{}, pose{}, law2011{}, {}, camera);
    };
    CHECK_THROWS_AS(see(orthographic_camera{.size = {0, 5}}), usage_error);
    CHECK_THROWS_AS(see(orthographic_camera{.size = {1U << 20U, 1U << 20U}}), usage_error);
    CHECK_THROWS_WITH_AS(see(orthographic_camera{.size = {16385, 1}}),
                         "camera: size 16385x1 exceeds 16384 pixels a side; ask for fewer", usage_error);
    CHECK_THROWS_AS(see(orthographic_camera{.extent = {0, 1}}), usage_error);
    CHECK_THROWS_AS(see(orthographic_camera{.at = {.rotation = mat3{0}}}), geometry_error);
    CHECK_THROWS_AS(see(perspective_camera{.field_of_view = 4}), usage_error);
}
