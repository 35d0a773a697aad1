#include <insonify/acoustics/physical.hpp>
#include "emitted_echoes.hpp"
#include <array>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

TEST_CASE("physical: the samples are those that an echo_line writes of the emitted echoes") {
    using namespace physical_law_test;
    std::array<medium, 3> echoic = media;
    for (medium& m : echoic) m.backscatter = 1, m.roughness = 10_um;
    const traced_line line{layers, echoic, 5_MHz};
    std::vector<vec2> written(1200, vec2{0, 0}), added(1200, vec2{0, 0});
    physical<>{}(exec::seq, line, 25_um, written);
    physical<>{}.emit(line, echo_line{added, 25_um, 5_MHz});
    CHECK(written == added);
    CHECK(length(written[423]) > 0);
}

TEST_CASE(
    "physical: a shadow floor is a lower bound of speckle relative to the attenuation of the soft tissue around") {
    using namespace physical_law_test;
    std::array<medium, 3> echoic = media;
    echoic[2].backscatter = 1;
    const emitted bare = emit(physical<>{}, {layers, echoic, 15_MHz}, 60_mm);
    REQUIRE(!bare.speckle.empty());
    // Bone, the last layer, counts as the tissue before it.
    const double bone_shown = 16e-3 * 1540 / 1455 + 4e-3 * 1540 / 1580;
    const double in_bone = (wide(bare.speckle.front().echoes.depth) - bone_shown) * 3500 / 1540;
    const double tissue = loss(media[0], 16e-3 + in_bone, 15) + loss(media[1], 4e-3, 15);
    double raised = 0;
    for (const float floor_db : {-60.0F, -20.0F, 0.0F}) {
        const emitted found = emit(physical<>{.shadow_floor_db = floor_db}, {layers, echoic, 15_MHz}, 60_mm);
        const double from = wide(bare.speckle.front().echoes.first_level),
                     to = wide(found.speckle.front().echoes.first_level);
        raised = to / from;
        // The level without loss is that of a transparent stack.
        std::array<medium, 3> clear = echoic;
        for (medium& m : clear) m.attenuation = 0, m.density = 1000 * 1500 / m.sound_speed;
        const double unshadowed =
            wide(emit(physical<>{}, {layers, clear, 15_MHz}, 60_mm).speckle.front().echoes.first_level);
        const double floor = unshadowed * level(wide(floor_db) - tissue);
        CHECK(to == doctest::Approx(std::fmax(from, floor)).epsilon(1e-3).scale(1e-30));
        REQUIRE(found.surfaces.size() == bare.surfaces.size());
        for (std::size_t i = 0; i < bare.surfaces.size(); ++i)
            CHECK(found.surfaces[i].amplitude == bare.surfaces[i].amplitude);
    }
    CHECK(raised > 1.1); // the last is a floor
}

TEST_CASE("physical: a broadband pulse loses the decibels of `attenuated`") {
    using namespace physical_law_test;
    const std::array<layer, 2> two{layer{0, 30_mm, 0}, layer{30_mm, 60_mm, 2}};
    const double narrow = loss(media[0], 30e-3, 5), beta = narrow / (8.685889638 * 5e6);
    const double bandwidth = 0.6, sigma = bandwidth * 5e6 / 2.3548;
    const double broad = 8.685889638 * (beta * 5e6 - beta * beta * sigma * sigma / 2);
    const emitted found = emit(physical<>{.bandwidth = pulse_bandwidth::broad},
                               {.layers = two,
                                .media = media,
                                .frequency = 5_MHz,
                                .pulse_sigma = static_cast<float>(0.1874 * 1540 / (bandwidth * 5e6))},
                               60_mm);
    REQUIRE(found.surfaces.size() == 1);
    CHECK(wide(found.surfaces[0].amplitude) ==
          doctest::Approx(reflection(media[0], media[2]) * level(-broad)).epsilon(1e-3).scale(1e-30));
}

TEST_CASE("physical: at_interface is the response of the boundary, loss that of the attenuation law") {
    using namespace physical_law_test;
    struct half {
        response operator()(const incidence& at) const { return {.reflected = at.cosine / 2, .transmitted = 0.25F}; }
    };
    struct constant_loss {
        float operator()(const medium& m, float frequency) const { return m.attenuation + frequency; }
    };
    const incidence oblique{media[0], media[1], 0.8F, 5_MHz};
    CHECK(physical<>{}.at_interface(oblique).reflected == fresnel{}.pressure_reflection(media[0], media[1], 0.8F));
    CHECK(physical<>{}.at_interface(oblique).transmitted == fresnel{}.energy_transmission(media[0], media[1], 0.8F));
    CHECK(physical<half>{}.at_interface(oblique).reflected == 0.4F);
    CHECK(physical<half>{}.at_interface(oblique).transmitted == 0.25F);
    CHECK(physical<half>{.angle = angle::normal}.at_interface(oblique).reflected == 0.5F);

    CHECK(physical<>{}.loss({.attenuation = 50}, 5_MHz) == doctest::Approx(500).scale(1e-30));
    CHECK(physical<>{}.loss({.attenuation = 0.2F, .attenuation_power = 2}, 3_MHz) == doctest::Approx(3.6).scale(1e-30));
    CHECK(physical<>{}.with_attenuation(constant_loss{}).loss({.attenuation = 2}, 3) == 5);
}

TEST_CASE("physical: default samples and the depth to trace") {
    using namespace physical_law_test;
    // Two per standard deviation 0.1874 * 1540 / (0.644 * 7.5e6) = 59.75 um: 1339 samples in 40 mm, rounded up to 1344.
    CHECK(physical<>{}.samples(40_mm, 7.5_MHz) == 1344);
    CHECK(physical<>{}.max_depth(40_mm, media) == doctest::Approx(40e-3 * 3500 / 1540 + 1e-3).scale(1e-30));
    CHECK(physical<>{.timing = timing::uniform}.max_depth(40_mm, media) == doctest::Approx(41_mm).scale(1e-30));
    CHECK(physical<>{}.covariance(0.1_mm, 0.02F) == gaussian_field{}.covariance(0.1_mm, 0.02F));
    CHECK(physical<fresnel, no_scatterers>{}.covariance(0, 0) == 0);
    CHECK(physical<fresnel, no_scatterers>{}.surface_covariance(0, 0) == 1);
}
