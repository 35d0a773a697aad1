#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include "physical_scenes.hpp"
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("blocks cast the shadow of their transmission and attenuation") { // V17
    struct {
        float frequency, shadow;
    } const rows[] = {{2.5_MHz, -49.2F}, {5_MHz, -89.2F}, {7.5_MHz, -129.2F}};
    for (const auto& row : rows) {
        // The same reflector below, with the block in its way and without; the block alone attenuates more by 4 dB/cm/MHz.
        const medium around = physical_test::of_impedance(1.70_MRayl, 1540, 1_dB_per_cm);
        const medium bone = physical_test::of_impedance(7.80_MRayl, 1540, 5_dB_per_cm);
        double level[2];
        for (int with = 0; with < 2; ++with) {
            scene body{around};
            if (with == 1) body.add(physical_test::slab(10_mm, 30_mm), bone);
            body.add(physical_test::slab(40_mm, 60_mm), tissue::air);
            body.build(exec::par);
            const auto found =
                physical_test::echoes_of(trace(exec::par, body, physical_test::probe(row.frequency), pose{},
                                               physical_test::carrier_alone, {.depth = 45_mm, .samples = 4500}),
                                         5);
            REQUIRE(found.size() == (with == 1 ? 3 : 1));
            level[with] = found.back().decibels();
        }
        MESSAGE("V17: shadow ", level[1] - level[0], " dB, expected ", row.shadow);
        CHECK(std::fabs(level[1] - level[0] - static_cast<double>(row.shadow)) < 0.1);
    }
}

TEST_CASE("a shadow floor fills shadows with speckle, and raises no echo of a surface") {
    scene body{physical_test::of_impedance(1.70_MRayl, 1540, 1_dB_per_cm)};
    body.add(physical_test::slab(10_mm, 30_mm), physical_test::of_impedance(7.80_MRayl, 1540, 5_dB_per_cm));
    medium behind = tissue::air;
    behind.attenuation = 0;
    behind.backscatter = 1;
    body.add(physical_test::slab(40_mm, 60_mm), behind);
    body.build(exec::par);
    const acquisition scan{.depth = 45_mm, .samples = 4500};
    const auto one = physical<>{}.with_scattering(physical_test::one_scatterer{});
    auto floored = one;
    floored.shadow_floor_db = -20;
    const auto bare =
        physical_test::echoes_of(trace(exec::par, body, physical_test::probe(5_MHz), pose{}, one, scan), 5);
    const auto filled =
        physical_test::echoes_of(trace(exec::par, body, physical_test::probe(5_MHz), pose{}, floored, scan), 5);
    REQUIRE(bare.size() > 3);
    REQUIRE(bare.size() == filled.size());
    for (std::size_t i = 0; i < 3; ++i) // surfaces
        CHECK(filled[i].amplitude == doctest::Approx(bare[i].amplitude).scale(1e-30));
    const double speckle_db = filled.back().decibels() - bare.back().decibels();
    MESSAGE("speckle behind 20 mm of bone is raised by ", speckle_db, " dB");
    CHECK(speckle_db > 60);
}

TEST_CASE("a cyst that attenuates little enhances what lies behind it") { // V16
    const medium around{.density = 1040, .sound_speed = 1540, .attenuation = 70},
        cyst{.density = 1040, .sound_speed = 1540, .attenuation = 5};
    double level[2];
    for (int with = 0; with < 2; ++with) {
        scene body{around};
        if (with == 1) body.add(physical_test::slab(10_mm, 30_mm), cyst);
        body.add(physical_test::slab(40_mm, 60_mm), tissue::air);
        body.build(exec::par);
        level[with] = physical_test::echoes_of(trace(exec::par, body, physical_test::probe(5_MHz), pose{},
                                                     physical_test::carrier_alone, {.depth = 45_mm, .samples = 4500}),
                                               5)
                          .back()
                          .decibels();
    }
    MESSAGE("V16: enhancement ", level[1] - level[0], " dB, expected 13.0");
    CHECK(std::fabs(level[1] - level[0] - 13.0) < 0.5);
}

TEST_CASE("the edges of a shadow follow the lines: constant for parallel ones, growing where they fan out") { // V18
    scene body{medium{.density = 1000, .sound_speed = 1540, .backscatter = 1}};
    body.add(make_box({-10_mm, -30_mm, 20_mm}, {10_mm, 30_mm, 22_mm}), tissue::air);
    body.build(exec::par);
    const auto half_width = [&](const auto& probe, float depth_below, auto along) {
        const iq_lines lines = trace(exec::par, body, probe, pose{}, physical<>{}, {.depth = 90_mm, .samples = 4500},
                                     straight_lines{.directions = 1}); // with a penumbra: see aperture_shading.cpp
        std::uint32_t dark = 0;
        for (std::uint32_t i = 0; i < lines.count; ++i) {
            const float depth = along(probe.beam(static_cast<float>(i)), depth_below);
            const auto k = static_cast<std::uint32_t>(depth / lines.depth * static_cast<float>(lines.samples));
            float energy = 0;
            for (std::uint32_t n = k - 20; n < k + 20; ++n) energy += dot(lines(i, n), lines(i, n));
            dark += energy < 1e-10F ? 1 : 0;
        }
        return dark;
    };
    const auto to_plane = [](const ray& beam, float z) { return (z - beam.origin.z) / beam.direction.z; };
    const linear_array flat{.lines = 400, .width = 40_mm, .frequency = 5_MHz}; // 0.1 mm apart
    for (const float z : {25_mm, 40_mm, 60_mm})
        CHECK(std::fabs(static_cast<float>(half_width(flat, z, to_plane)) * 0.05_mm - 10_mm) <= 0.1_mm);
    struct {
        float radius, expected;
    } const rows[] = {{60_mm, 15.0_mm}, {40_mm, 16.6667_mm}};
    for (const auto& row : rows) {
        const convex_array fan{.lines = 801, .radius = row.radius, .field_of_view = 60_deg, .frequency = 5_MHz};
        const float angle = static_cast<float>(half_width(fan, 60_mm, to_plane)) * 0.5F * 60_deg / 801;
        const float found = std::tan(angle) * (row.radius + 60_mm);
        MESSAGE("V18: half width ", found * 1e3F, " mm, expected ", row.expected * 1e3F);
        CHECK(std::fabs(found - row.expected) < 0.16_mm); // one line
    }
}
