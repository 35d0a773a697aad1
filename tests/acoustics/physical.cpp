#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/acoustics/physical.hpp>
#include "emitted_echoes.hpp"
#include <array>
#include <doctest/doctest.h>

using namespace insonify;

namespace physical_law_test {
namespace {

constexpr double pi_exact = 3.14159265358979;

} // namespace
} // namespace physical_law_test

static_assert(acoustic_model<physical<>>);

TEST_CASE("physical: specular echoes have reflection, transmission and attenuation in closed form") {
    using namespace physical_law_test;
    const emitted found = emit(physical<>{}, {layers, media, 5_MHz}, 60_mm);
    REQUIRE(found.surfaces.size() == 3);
    CHECK(found.rough.empty());
    CHECK(found.speckle.empty()); // anechoic
    const medium* const order[] = {&media[0], &media[1], &media[0], &media[2]};
    const double thickness[] = {10e-3, 4e-3, 6e-3};
    double shown = 0, decibels = 0, transmitted = 1;
    for (std::size_t i = 0; i < 3; ++i) {
        shown += thickness[i] * 1540 / wide(order[i]->sound_speed);
        decibels += loss(*order[i], thickness[i], 5);
        const double r = reflection(*order[i], *order[i + 1]);
        CHECK(wide(found.surfaces[i].depth) == doctest::Approx(shown).epsilon(1e-6).scale(1e-30));
        CHECK(wide(found.surfaces[i].amplitude) ==
              doctest::Approx(transmitted * r * level(-decibels)).epsilon(1e-4).scale(1e-30));
        CHECK(found.surfaces[i].slope == vec2{0, 0});
        transmitted *= 1 - r * r;
    }
}

TEST_CASE("physical: an oblique surface has Fresnel's reflection, the specular law and a slope") {
    using namespace physical_law_test;
    constexpr float angle_x = 0.06F, angle_y = -0.03F;
    const double cosine = 1 / std::sqrt(1 + std::pow(std::tan(0.06), 2) + std::pow(std::tan(0.03), 2));
    const std::array<layer, 2> oblique{layer{0, 20_mm, 0}, layer{.begin = 20_mm,
                                                                 .end = 60_mm,
                                                                 .medium = 2,
                                                                 .cosine = static_cast<float>(cosine),
                                                                 .slope = {std::tan(angle_x), std::tan(angle_y)}}};
    const std::array<float, 2> fnumbers{1.5F, 3};
    const traced_line line{.layers = oblique,
                           .media = media,
                           .frequency = 5_MHz,
                           .aperture = {.fnumbers = fnumbers, .spacing = 15_mm, .elevation_fnumber = 5}};
    const double shown = 20e-3 * 1540 / 1455; // 21.2 mm: F/3 in the slice plane
    const double r = wide(fresnel{}.pressure_reflection(media[0], media[2], static_cast<float>(cosine)));
    const specular_return aperture{.lobe = specular_return::lobe_shape::aperture};
    const double collected = (1 - 0.06 / std::atan(1.0 / 6)) * (1 - 0.03 / std::atan(1.0 / 10));
    const double attenuation = level(-loss(media[0], 20e-3, 5));

    const emitted found = emit(physical<>{.specular = aperture}, line, 60_mm);
    REQUIRE(found.surfaces.size() == 1);
    CHECK(wide(found.surfaces[0].amplitude) == doctest::Approx(r * collected * attenuation).epsilon(1e-4).scale(1e-30));
    CHECK(wide(found.surfaces[0].depth) == doctest::Approx(shown).epsilon(1e-6).scale(1e-30));
    CHECK(wide(found.surfaces[0].slope.x) == doctest::Approx(std::tan(0.06) * 1540 / 1455).scale(1e-30));
    CHECK(wide(found.surfaces[0].slope.y) == doctest::Approx(-std::tan(0.03) * 1540 / 1455).scale(1e-30));

    const emitted normal = emit(physical<>{.angle = angle::normal}, line, 60_mm);
    REQUIRE(normal.surfaces.size() == 1);
    CHECK(wide(normal.surfaces[0].amplitude) ==
          doctest::Approx(reflection(media[0], media[2]) * attenuation).epsilon(1e-4).scale(1e-30));
    CHECK(normal.surfaces[0].slope == vec2{0, 0});

    const emitted uniform = emit(physical<>{.timing = timing::uniform}, line, 60_mm);
    REQUIRE(uniform.surfaces.size() == 1);
    CHECK(uniform.surfaces[0].depth == doctest::Approx(20_mm).scale(1e-30));
    CHECK(wide(uniform.surfaces[0].slope.x) == doctest::Approx(std::tan(0.06)).scale(1e-30));
}

TEST_CASE("physical: a rough surface has a weakened specular echo and a diffuse one of the calibrated level") {
    using namespace physical_law_test;
    std::array<medium, 2> rough{medium{.density = 1000, .sound_speed = 1540},
                                medium{.density = 2000, .sound_speed = 3000, .roughness = 30_um}};
    const std::array<layer, 2> two{layer{0, 20_mm, 0}, layer{20_mm, 30_mm, 1, 7}};
    const double r = reflection(rough[0], rough[1]), k = 2 * pi_exact * 5e6 / 1540;
    const double phase = 2 * k * 30e-6;
    const traced_line line{.layers = two, .media = rough, .frequency = 5_MHz, .aperture = {.elevation_fnumber = 4}};
    const emitted found = emit(physical<>{}, line, 30_mm);
    REQUIRE(found.surfaces.size() == 1);
    REQUIRE(found.rough.size() == 1);
    CHECK(wide(found.surfaces[0].amplitude) ==
          doctest::Approx(r * std::exp(-phase * phase / 2)).epsilon(1e-4).scale(1e-30));
    CHECK(wide(found.rough[0].amplitude) ==
          doctest::Approx(r * std::sqrt((1 - std::exp(-phase * phase)) * 0.166 / (2 * 4))).epsilon(1e-4).scale(1e-30));
    CHECK(found.rough[0].depth == doctest::Approx(20_mm).scale(1e-30));

    double power = 0, product = 0; // of the random field at two depths
    constexpr int lines = 2000;
    for (int i = 0; i < lines; ++i) {
        traced_line aside = line;
        aside.frame.origin = {0.7_mm * static_cast<float>(i), 0, 0};
        const rough_echo one = emit(physical<>{}, aside, 30_mm).rough.at(0);
        power += wide(dot(one.value, one.value)) / lines;
        product += wide(dot(one.value, one.deeper)) / lines;
    }
    CHECK(power == doctest::Approx(1).epsilon(0.08).scale(1e-30)); // 3.5 standard errors
    CHECK(std::fabs(product) < 0.08);

    rough[1].roughness = 0;
    CHECK(emit(physical<>{}, line, 30_mm).rough.empty());
}

TEST_CASE("physical: speckle has the level of the medium's backscatter, after transmission and attenuation") {
    using namespace physical_law_test;
    const std::array<medium, 2> tissue{
        medium{.density = 1000, .sound_speed = 1500, .attenuation = 50, .backscatter = 0.5F},
        medium{.density = 1200, .sound_speed = 1600, .attenuation = 30, .backscatter = 2}};
    const std::array<layer, 2> two{layer{0, 10_mm, 0}, layer{10_mm, 40_mm, 1, 1}};
    const double r = reflection(tissue[0], tissue[1]), sigma = 0.1e-3, spacing = 1.25 * sigma;
    double power[2] = {}, count[2] = {}, worst_end = 0;
    for (int i = 0; i < 400; ++i) {
        const emitted found = emit(physical<>{.bandwidth = pulse_bandwidth::narrow},
                                   {.layers = two,
                                    .media = tissue,
                                    .frequency = 5_MHz,
                                    .frame = {.origin = {0.9_mm * static_cast<float>(i), 0, 0}},
                                    .pulse_sigma = static_cast<float>(sigma)},
                                   30_mm);
        const double border = 10e-3 * 1540 / 1500;
        double first[2] = {1e9, 1e9}, last[2] = {};
        for (const speckle_run& run : found.speckle) {
            const scatterer_echoes& e = run.echoes;
            // Slots reach across the border: a run of a single one there may belong to either layer.
            const double middle = wide(e.depth) + 0.5 * wide(e.step) * (e.count - 1.0);
            const std::size_t which = middle < border ? 0 : 1;
            const double stretch = 1540 / wide(tissue[which].sound_speed);
            const auto decibels = [&](double shown) {
                return which == 0 ? loss(tissue[0], shown / stretch, 5)
                                  : loss(tissue[0], 10e-3, 5) + loss(tissue[1], (shown - border) / stretch, 5);
            };
            const double end = wide(e.depth) + wide(e.step) * e.count;
            const double gain = which == 0 ? 1 : 1 - r * r;
            const double pulse_gain = std::sqrt(std::sqrt(pi_exact) * sigma / wide(e.step));
            const double base = gain * wide(tissue[which].backscatter) * level(-55) / pulse_gain;
            if (std::fabs(middle - border) > wide(e.step)) {
                CHECK(wide(e.first_level) ==
                      doctest::Approx(base * level(-decibels(wide(e.depth)))).epsilon(2e-3).scale(1e-30));
                CHECK(wide(e.last_level) == doctest::Approx(base * level(-decibels(end))).epsilon(2e-3).scale(1e-30));
            }
            power[which] += run.inner;
            count[which] += e.count - 2.0;
            first[which] = std::min(first[which], wide(e.depth) / spacing);
            last[which] = std::max(last[which], (end - wide(e.step)) / spacing);
        }
        // Each layer is full: its first and last scatterer lie within half a spacing of its surfaces.
        for (const double apart : {first[0], last[0] - border / spacing, first[1] - border / spacing})
            worst_end = std::max(worst_end, std::fabs(apart));
        CHECK(last[1] >= 30e-3 / spacing - 0.5); // to the displayed depth
        CHECK(last[1] < 30e-3 / spacing + 2);
    }
    for (const std::size_t which : {0U, 1U})
        CHECK(power[which] / count[which] == doctest::Approx(1).epsilon(0.02).scale(1e-30));
    MESSAGE("first and last scatterers within ", worst_end, " spacings of the surfaces");
    CHECK(worst_end < 0.51);
}

TEST_CASE("physical: the mean power of speckle is that of the tissue, in layers thinner than the spacing too") {
    using namespace physical_law_test;
    const std::array<medium, 2> tissue{medium{.density = 1000, .sound_speed = 1540},
                                       medium{.density = 1000, .sound_speed = 1540, .backscatter = 1}};
    constexpr double sigma = 0.1e-3;
    constexpr int lines = 4000;
    for (const double thickness : {0.02e-3, 0.1e-3, 0.3e-3, 1e-3}) {
        double power = 0;
        for (int i = 0; i < lines; ++i) {
            const float begin = 10_mm + 0.0131_mm * static_cast<float>(i % 97);
            const std::array<layer, 3> thin{layer{0, begin, 0},
                                            layer{begin, begin + static_cast<float>(thickness), 1, 1},
                                            layer{begin + static_cast<float>(thickness), 40_mm, 0}};
            const emitted found = emit(physical<>{},
                                       {.layers = thin,
                                        .media = tissue,
                                        .frequency = 5_MHz,
                                        .frame = {.origin = {0.9_mm * static_cast<float>(i), 0, 0}},
                                        .pulse_sigma = static_cast<float>(sigma)},
                                       30_mm);
            for (const speckle_run& run : found.speckle) power += run.power * std::pow(wide(run.echoes.first_level), 2);
        }
        // The pulse sums power over sqrt(pi) sigma.
        const double expected = lines * std::pow(level(-55), 2) * thickness / (std::sqrt(pi_exact) * sigma);
        MESSAGE("layer of ", 1e3 * thickness, " mm: power ", power / expected, " of that of the tissue");
        CHECK(power == doctest::Approx(expected).epsilon(0.06).scale(1e-30));
    }
}

TEST_CASE("physical: layers that begin beyond the displayed depth are skipped; equal media have no interface") {
    using namespace physical_law_test;
    CHECK(emit(physical<>{}, {layers, media, 5_MHz}, 10_mm).surfaces.size() == 1); // surfaces at 10.6, 14.5 and 20.8 mm
    CHECK(emit(physical<>{}, {layers, media, 5_MHz}, 12_mm).surfaces.size() == 2);
    CHECK(emit(physical<>{}, {layers, media, 5_MHz}, 15_mm).surfaces.size() == 3);
    const std::array<layer, 2> same{layer{0, 10_mm, 1}, layer{10_mm, 20_mm, 1, 1}};
    CHECK(emit(physical<>{}, {same, media, 5_MHz}, 20_mm).surfaces.empty());
}
