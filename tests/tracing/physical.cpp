#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include "echoes.hpp"
#include "physical_scenes.hpp"
#include <doctest/doctest.h>

using namespace insonify;

static_assert(acoustic_model<physical<>> && acoustic_model<physical<fresnel, no_scatterers>>);

TEST_CASE("the paper's base scene, physically: bone echoes at the level and the depth of its closed form") { // V22
    struct {
        float frequency, top, bottom;
    } const rows[] = {{2.5_MHz, -13.848F, -68.465F}, {5_MHz, -23.848F, -128.465F}, {7.5_MHz, -33.848F, -188.465F}};
    for (const auto& row : rows) {
        scene body{physical_test::of_impedance(1.70_MRayl, 1580, 1_dB_per_cm)};
        body.add(physical_test::slab(20_mm, 40_mm), physical_test::of_impedance(7.80_MRayl, 4080, 5_dB_per_cm));
        body.build(exec::par);
        const acquisition scan{.depth = 40_mm, .samples = 4000};
        const auto found = physical_test::echoes_of(
            trace(exec::par, body, physical_test::probe(row.frequency), pose{}, physical_test::carrier_alone, scan), 7);
        REQUIRE(found.size() == 2);
        MESSAGE("V22 at ", row.frequency / 1e6F, " MHz: ", found[0].decibels(), " dB at ", found[0].depth * 1e3,
                " mm, ", found[1].decibels(), " dB at ", found[1].depth * 1e3, " mm; expected ", row.top, ", 19.494, ",
                row.bottom, ", 27.043");
        CHECK(std::fabs(found[0].decibels() - static_cast<double>(row.top)) < 0.01);
        CHECK(std::fabs(found[1].decibels() - static_cast<double>(row.bottom)) < 0.01);
        CHECK(std::fabs(found[0].depth - 19.494e-3) < 0.5 * 10e-6);
        CHECK(std::fabs(found[1].depth - 27.043e-3) < 0.5 * 10e-6);
    }
}

TEST_CASE("the second echo of layered media is that of a wave simulation, to 0.05 dB") { // V23
    struct {
        float frequency, second;
    } const rows[] = {{1.5_MHz, -7.566F}, {2.5_MHz, -9.739F}, {3.5_MHz, -11.957F}};
    for (const auto& row : rows) {
        scene body{medium{.density = 998, .sound_speed = 1482}};
        body.add(physical_test::slab(10_mm, 20_mm),
                 medium{.density = 1065, .sound_speed = 1580, .attenuation = 100, .attenuation_power = 1.05F});
        body.add(physical_test::slab(20_mm, 50_mm), medium{.density = 1910, .sound_speed = 3500});
        body.build(exec::par);
        const auto found =
            physical_test::echoes_of(trace(exec::par, body, physical_test::probe(row.frequency), pose{},
                                           physical_test::carrier_alone, {.depth = 24_mm, .samples = 2400}),
                                     3);
        REQUIRE(found.size() == 2);
        MESSAGE("V23: ", found[1].decibels(), " dB, expected ", row.second);
        CHECK(std::fabs(found[1].decibels() - static_cast<double>(row.second)) < 0.05);
    }
}

TEST_CASE("a plate is displayed where its travel time puts it") { // V8
    for (const float speed : {1455.0F, 1482.0F, 1540.0F, 1580.0F, 1400.0F}) {
        scene body{medium{.density = 1000, .sound_speed = speed}};
        body.add(physical_test::slab(30_mm, 70_mm), tissue::bone);
        body.build(exec::par);
        const acquisition scan{.depth = 36_mm, .samples = 1800};
        const auto found = physical_test::echoes_of(
            trace(exec::par, body, physical_test::probe(5_MHz), pose{}, physical<>{}, scan), 0);
        REQUIRE(found.size() == 1);
        CHECK(std::fabs(found[0].depth - 30e-3 * 1540 / static_cast<double>(speed)) < 10e-6);
        const auto by_distance = physical_test::echoes_of(
            trace(exec::par, body, physical_test::probe(5_MHz), pose{}, physical<>{.timing = timing::uniform}, scan),
            0);
        REQUIRE(by_distance.size() == 1);
        CHECK(by_distance[0].depth == doctest::Approx(30e-3).epsilon(1e-5).scale(1e-30));
    }
}

TEST_CASE("water in water has no echo at all, at any angle, whatever law a user brings") {
    struct shouts {
        response operator()(const incidence&) const { return {.reflected = 1, .transmitted = 0}; }
    };
    scene body{tissue::water};
    body.add(make_sphere({0, 0, 20_mm}, 8_mm, 4), tissue::water);
    body.build(exec::par);
    const acquisition scan{.depth = 40_mm, .samples = 1024, .planes = 5};
    for (const vec2 value : trace(exec::par, body, linear_array{}, pose{}, physical<>{}, scan).values)
        REQUIRE(value == vec2{0, 0});
    for (const vec2 value : trace(exec::par, body, linear_array{}, pose{}, physical<shouts>{}, scan).values)
        REQUIRE(value == vec2{0, 0});
}

TEST_CASE("a user's medium that equals a shipped one echoes as it does") {
    const medium own{tissue::liver};
    scene shipped{tissue::fat}, users{tissue::fat};
    shipped.add(make_sphere({0, 0, 20_mm}, 8_mm, 4), tissue::liver);
    users.add(make_sphere({0, 0, 20_mm}, 8_mm, 4), own);
    shipped.build(exec::par);
    users.build(exec::par);
    const acquisition scan{.depth = 40_mm, .samples = 1024};
    CHECK(trace(exec::par, shipped, linear_array{}, pose{}, physical<>{}, scan) ==
          trace(exec::par, users, linear_array{}, pose{}, physical<>{}, scan));
}

TEST_CASE("skin, liver, vessel, liver and out again: each echo has the size of its own pair of media") {
    scene body{tissue::gel};
    body.add(physical_test::slab(5_mm, 50_mm), tissue::skin);
    body.add(physical_test::slab(10_mm, 45_mm), tissue::liver);
    body.add(physical_test::slab(20_mm, 25_mm), tissue::blood);
    body.build(exec::par);
    const auto silent = physical<>{}.with_scattering(no_scatterers{});
    const auto found = physical_test::echoes_of(
        trace(exec::par, body, physical_test::probe(5_MHz), pose{}, silent, {.depth = 55_mm, .samples = 5500}), 8);
    REQUIRE(found.size() == 6);
    const medium order[] = {tissue::gel,   tissue::skin, tissue::liver, tissue::blood,
                            tissue::liver, tissue::skin, tissue::gel};
    const float thickness[] = {5_mm, 5_mm, 10_mm, 5_mm, 20_mm, 5_mm};
    double through = 1, decibels = 0, shown = 0;
    for (std::size_t i = 0; i < 6; ++i) {
        const double z1 = static_cast<double>(order[i].impedance()), z2 = static_cast<double>(order[i + 1].impedance());
        const double d = static_cast<double>(thickness[i]);
        decibels += 2 * static_cast<double>(order[i].attenuation) *
                    std::pow(5.0, static_cast<double>(order[i].attenuation_power)) * d;
        shown += d * 1540 / static_cast<double>(order[i].sound_speed);
        const double r = (z2 - z1) / (z2 + z1);
        const double h = static_cast<double>(std::max(order[i].roughness, order[i + 1].roughness));
        const double k = 2 * 3.14159265358979 * 5e6 / static_cast<double>(order[i].sound_speed);
        CHECK(found[i].depth == doctest::Approx(shown).epsilon(1e-3).scale(1e-30));
        const double coherent = std::fabs(r) * through * std::exp(-2 * k * k * h * h) * std::pow(10, -decibels / 20);
        // The diffuse echo stands at the same place: at most its own size away.
        const double diffuse =
            std::sqrt(r * r * (1 - std::exp(-4 * k * k * h * h))) * through * std::pow(10, -decibels / 20);
        CHECK(std::fabs(found[i].amplitude - coherent) <= 2 * diffuse + 1e-3 * coherent);
        through *= 1 - r * r;
    }
}

TEST_CASE("no echo is larger than the sound that was sent, whatever the media") {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const auto random_medium = [&](std::uint64_t i) {
            return medium{.density = 1 + 8000 * hash_uniform(seed, 3 * i),
                          .sound_speed = 300 + 5000 * hash_uniform(seed, 3 * i + 1),
                          .attenuation = 100 * hash_uniform(seed, 3 * i + 2)};
        };
        scene body{random_medium(0)};
        for (std::uint64_t i = 1; i < 6; ++i)
            body.add(make_sphere({20_mm * (hash_uniform(seed, 40 + i) - 0.5F), 0, 40_mm * hash_uniform(seed, 50 + i)},
                                 3_mm + 10_mm * hash_uniform(seed, 60 + i), 3),
                     random_medium(i));
        body.build(exec::par);
        const iq_lines lines =
            trace(exec::par, body, linear_array{.lines = 32}, pose{}, physical<>{}, {.depth = 60_mm, .samples = 3000});
        for (const vec2 v : lines.values) {
            REQUIRE(is_finite(v.x));
            REQUIRE(is_finite(v.y));
            REQUIRE(glm::length(v) < 4); // several echoes may fall into one sample
        }
    }
}

TEST_CASE("physical echoes are bit-equal on any number of threads, and the same each time") {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 20_mm}, 6_mm, 4), tissue::bone);
    body.add(make_sphere({-10_mm, 0, 15_mm}, 4_mm, 4), tissue::blood);
    body.build(exec::par);
    const acquisition scan{.depth = 40_mm, .samples = 1500, .planes = 5};
    const iq_lines reference = trace(exec::seq, body, linear_array{}, pose{}, physical<>{}, scan);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U}) {
        CHECK(trace(exec::par.threads(threads), body, linear_array{}, pose{}, physical<>{}, scan) == reference);
        CHECK(trace(exec::par_unseq.threads(threads), body, linear_array{}, pose{}, physical<>{}, scan) ==
              trace(exec::unseq, body, linear_array{}, pose{}, physical<>{}, scan));
    }
    CHECK_THROWS_AS(trace(exec::par, body, linear_array{}, pose{}, physical<>{}, {.depth = 40_mm, .planes = 2}),
                    usage_error);
    CHECK_THROWS_AS(trace(exec::par, body, linear_array{}, pose{}, physical<>{}, {.depth = 40_mm, .planes = 9}),
                    usage_error);
}
