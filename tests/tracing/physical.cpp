#include <insonify/acoustics/physical.hpp>
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/convolve.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/trace.hpp>
#include <doctest/doctest.h>

#include "echoes.hpp"

using namespace insonify;

namespace physical_test {
namespace {

using echoes_test::echo, echoes_test::echoes_of;

mesh slab(float from, float to) { return make_box({-60_mm, -60_mm, from}, {60_mm, 60_mm, to}); }
medium of_impedance(float rayl, float speed, float attenuation) {
    return {.density = rayl / speed, .sound_speed = speed, .attenuation = attenuation};
}
constexpr linear_array probe(float frequency) { return {.lines = 16, .width = 10_mm, .frequency = frequency}; }

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

// One scatterer in the middle of what it is asked for.
struct one_scatterer {
    template <class Emit>
    void scatter(const material_line&, float begin, float end, float, Emit&& emit) const {
        const float real = 1, imaginary = 0;
        emit(scatterer_run{.first = 0.5F * (begin + end), .count = 1, .real = &real, .imaginary = &imaginary});
    }
    float covariance(float, float) const { return 0; }
};

} // namespace
} // namespace physical_test

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
            trace(exec::par, body, physical_test::probe(row.frequency), pose{}, physical<>{}, scan), 7);
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
        const auto found = physical_test::echoes_of(trace(exec::par, body, physical_test::probe(row.frequency), pose{},
                                                          physical<>{}, {.depth = 24_mm, .samples = 2400}),
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
            const auto found = physical_test::echoes_of(trace(exec::par, body, physical_test::probe(row.frequency),
                                                              pose{}, physical<>{}, {.depth = 45_mm, .samples = 4500}),
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
        level[with] = physical_test::echoes_of(trace(exec::par, body, physical_test::probe(5_MHz), pose{}, physical<>{},
                                                     {.depth = 45_mm, .samples = 4500}),
                                               5)
                          .back()
                          .decibels();
    }
    MESSAGE("V16: enhancement ", level[1] - level[0], " dB, expected 13.0");
    CHECK(std::fabs(level[1] - level[0] - 13.0) < 0.5);
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

TEST_CASE("a tilted plate, traced and convolved, fades as a simulated aperture's does") { // V19, the whole way
    // Published for a plate in the focus, 30 mm deep, F/2: decibels against the plate across the beam.
    struct {
        float frequency;
        double level[5]; // at 2, 4, 6, 8 and 10 degrees
    } const rows[] = {{2.5_MHz, {-0.376, -1.714, -4.031, -6.397, -10.26}},
                      {5_MHz, {-0.536, -2.334, -4.245, -6.671, -10.053}},
                      {7.5_MHz, {-0.662, -2.503, -4.359, -6.778, -10.107}}};
    for (const auto& row : rows) {
        const linear_array probe{.lines = 301, .width = 30.1_mm, .frequency = row.frequency, .focus = 30_mm};
        double level[6];
        for (int i = 0; i <= 5; ++i) {
            const float tilt = static_cast<float>(2 * i) * 1_deg;
            const pose turned = look_at({0, 0, 30_mm}, {std::sin(tilt), 0, 30_mm + std::cos(tilt)},
                                        {std::cos(tilt), 0, -std::sin(tilt)});
            scene body{medium{.density = 1000, .sound_speed = 1540}};
            body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 40_mm}), medium{.density = 1200, .sound_speed = 1540},
                     {.at = turned});
            body.build(exec::par);
            const physical<> model{.specular = {.lobe = specular_return::lobe::exact}};
            const acquisition scan{.depth = 40_mm, .samples = 4000};
            const scan_lines seen = envelope(
                exec::par, convolve(exec::par, trace(exec::par, body, probe, pose{}, model, scan), pulse{}, probe));
            float most = 0;
            for (std::uint32_t k = 0; k < seen.samples; ++k) most = std::max(most, seen(150, k));
            level[i] = 20 * std::log10(static_cast<double>(most));
        }
        for (int i = 1; i <= 5; ++i) {
            MESSAGE("V19 at ", row.frequency / 1e6F, " MHz, ", 2 * i, " degrees: ", level[i] - level[0],
                    " dB, simulated ", row.level[i - 1]);
            CHECK(std::fabs(level[i] - level[0] - row.level[i - 1]) < 1);
        }
    }
}

TEST_CASE("a plate that is tilted out of the slice fades by the aperture's height, however many planes there are") {
    const linear_array probe{.lines = 61,
                             .width = 12.2_mm,
                             .frequency = 5_MHz,
                             .focus = 30_mm,
                             .elevation_height = 7.5_mm,
                             .elevation_focus = 30_mm}; // F/4
    const specular_return lobe{.lobe = specular_return::lobe::exact};
    for (const std::uint32_t planes : {1U, 5U, 7U}) {
        double level[4];
        for (int i = 0; i < 4; ++i) {
            const float tilt = static_cast<float>(i) * 1.5_deg;
            const pose turned = look_at({0, 0, 30_mm}, {0, std::sin(tilt), 30_mm + std::cos(tilt)}, {1, 0, 0});
            scene body{medium{.density = 1000, .sound_speed = 1540}};
            body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 40_mm}), medium{.density = 1200, .sound_speed = 1540},
                     {.at = turned});
            body.build(exec::par);
            const acquisition scan{.depth = 40_mm, .samples = 4000, .planes = planes};
            const iq_lines echoes = trace(exec::par, body, probe, pose{}, physical<>{.specular = lobe}, scan);
            const scan_lines seen = envelope(exec::par, convolve(exec::par, echoes, pulse{}, probe));
            float most = 0;
            for (std::uint32_t k = 0; k < seen.samples; ++k) most = std::max(most, seen(30, k));
            level[i] = 20 * std::log10(static_cast<double>(most));
            const double expected = 20 * std::log10(static_cast<double>(lobe(tilt, 4, 30e-3F * 5e6F / 1540)));
            MESSAGE(planes, " planes, ", (1.5 * i), " degrees: ", level[i] - level[0], " dB, expected ", expected);
            if (i > 0 && expected > -12) CHECK(std::fabs(level[i] - level[0] - expected) < 1);
        }
    }
}

TEST_CASE("a rough surface scatters at its calibrated level, at any tilt, with any texture beside it") {
    // RMS sqrt(R (1 - exp(-4 k^2 h^2 cos^2 i)) cos^2 i 0.166 / (F#x F#y)); 200 um leave nothing of the mirror echo.
    const linear_array probe{.lines = 300, .width = 30_mm, .frequency = 5_MHz, .focus = 20_mm}; // F/2, F/4 in elevation
    const medium rough{.density = 1500, .sound_speed = 1540, .roughness = 200_um};
    for (const float degrees : {0.0F, 5.0F, 20.0F})
        for (const float cell : {0.2_mm, 0.5_mm}) {
            const float tilt = degrees * 1_deg;
            double power = 0, count = 0;
            for (std::uint32_t seed = 1; seed <= 12; ++seed) {
                const pose turned = look_at({0, 0, 20_mm}, {std::sin(tilt), 0, 20_mm + std::cos(tilt)},
                                            {std::cos(tilt), 0, -std::sin(tilt)});
                scene body{medium{.density = 1000, .sound_speed = 1540}};
                body.add(make_box({-60_mm, -60_mm, 0}, {60_mm, 60_mm, 60_mm}), rough, {.at = turned});
                body.build(exec::par);
                const physical<> model{.scattering = {.cell = cell}, .seed = seed};
                const iq_lines echoes =
                    trace(exec::par, body, probe, pose{}, model, {.depth = 30_mm, .samples = 3000, .planes = 3});
                const iq_lines seen = convolve(exec::par, echoes, pulse{}, probe);
                for (std::uint32_t line = 30; line < 270; ++line) { // where the line meets the plate
                    const double x = (line + 0.5) / 300 * 30 - 15;
                    const double z = 20 - x * std::tan(static_cast<double>(tilt));
                    const auto k = static_cast<std::uint32_t>(z / 30 * 3000);
                    power += std::pow(static_cast<double>(length(seen(line, k))), 2), count += 1;
                }
            }
            const double r = 0.2, cosine = std::cos(static_cast<double>(tilt)); // (1500 - 1000) / 2500 at any angle
            const double expected = 10 * std::log10(r * r * cosine * cosine * 0.166 / (2 * 4));
            MESSAGE(degrees, " degrees, cells of ", (cell * 1e3F), " mm: ", 10 * std::log10(power / count),
                    " dB, expected ", expected);
            CHECK(std::fabs(10 * std::log10(power / count) - expected) < 1);
        }
}

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
    const auto plain = physical{}
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
    CHECK(echoes_test::echoes_of(trace_paths(exec::seq, body, probe, pose{}, plain, scan), 0).at(0).amplitude ==
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
    CHECK_THROWS_AS(trace(exec::seq, body, probe, pose{}, physical<>{.specular = {.power = -1}}, scan), usage_error);
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
    const physical<fresnel, no_scatterers> oblique{.specular = {.lobe = specular_return::lobe::aperture}};
    CHECK(trace(exec::par, body, physical_test::probe(5_MHz), pose{}, oblique, scan).values ==
          std::vector<vec2>(16 * 4000, vec2{0, 0})); // 17 degrees off: beside the aperture
    const physical<fresnel, no_scatterers> broad{.bandwidth = pulse_bandwidth::broad}, narrow{};
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
}
