#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace poiseuille_test {
namespace {

const object_id vessel{3};
const poiseuille stream{.object = vessel,
                        .from = {-10_mm, 2_mm, 20_mm},
                        .to = {30_mm, 2_mm, 50_mm}, // along {0.8, 0, 0.6}
                        .radius = 4_mm,
                        .peak_velocity = 0.5_m_per_s,
                        .waveform = {.heart_rate = 1.2_Hz, .resistive_index = 0.7F, .delay = 0.3F}};

} // namespace

TEST_CASE("pulsatile: the resistive index and the mean are those of the samples over a beat") {
    for (const float index : {0.0F, 0.7F, 1.3F}) {
        const pulsatile waveform{.heart_rate = 1.2_Hz, .resistive_index = index, .systole = 0.12F, .delay = 0.1F};
        double largest = -10, smallest = 10, sum = 0;
        constexpr int count = 10000;
        for (int i = 0; i < count; ++i) {
            const auto now = static_cast<double>(waveform(0.1F + (static_cast<float>(i) + 0.5F) / (1.2F * count)));
            largest = std::max(largest, now);
            smallest = std::min(smallest, now);
            sum += now / count;
        }
        MESSAGE("resistive index ", (largest - smallest) / largest, ", expected ", index, "; mean ", sum, " and ",
                waveform.mean());
        CHECK(largest == doctest::Approx(1).scale(1e-30).epsilon(1e-4));
        CHECK((largest - smallest) / largest == doctest::Approx(static_cast<double>(index)).scale(1e-30).epsilon(1e-3));
        CHECK(sum == doctest::Approx(static_cast<double>(waveform.mean())).scale(1e-30).epsilon(1e-3));
        CHECK(waveform(0.4F) == doctest::Approx(waveform(0.4F + 5 / 1.2F)).scale(1e-30).epsilon(1e-4)); // periodic
    }
    CHECK(pulsatile{}(7.0F) == 1);
}

TEST_CASE(
    "poiseuille: a parabola along the axis, zero at the wall, outside and in other objects; its flow by integration") {
    const vec3 along{0.8F, 0, 0.6F}, across{0, 1, 0}, on_axis{6_mm, 2_mm, 32_mm};
    const float systole = 0.3F + 0.15F / 1.2F;
    double flow = 0;
    constexpr int rings = 400;
    for (int i = 0; i < rings; ++i) {
        const float r = 4_mm * (static_cast<float>(i) + 0.5F) / rings;
        const vec3 v = stream(vessel, on_axis + r * across, systole);
        CHECK(length(v - 0.5F * (1 - r * r / 16e-6F) * along) < 1e-4F);
        flow += static_cast<double>(2 * pi * r * 4_mm / rings * dot(v, along));
    }
    MESSAGE("volume flow ", flow * 1e6, " ml/s, expected ", stream.volume_flow(systole) * 1e6F);
    CHECK(flow == doctest::Approx(static_cast<double>(stream.volume_flow(systole))).epsilon(1e-3).scale(1e-30));
    CHECK(stream(vessel, on_axis + 4.001F * 1_mm * across, systole) == vec3{0, 0, 0});
    CHECK(stream(object_id{4}, on_axis, systole) == vec3{0, 0, 0});
    CHECK(dot(stream(vessel, on_axis, 0.3F), along) ==
          doctest::Approx(0.15).scale(1e-30).epsilon(0.01)); // the end of diastole
}

TEST_CASE("velocity samples: linear between samples of space and time, zero outside, periodic") {
    velocity_samples grid{.object = vessel,
                          .lower = {-1_mm, -1_mm, 0},
                          .spacing = {1_mm, 0.5_mm, 2_mm},
                          .size = {3, 5, 4},
                          .steps = 2,
                          .interval = 0.1F};
    const auto velocity = [](vec3 p, float t) {
        return vec3{p.x * 100, 1 + p.y * 50 - p.z * 20, p.x * p.z * 1e4F} * (1 + t);
    };
    for (std::uint32_t t = 0; t < 2; ++t)
        for (std::uint32_t z = 0; z < 4; ++z)
            for (std::uint32_t y = 0; y < 5; ++y)
                for (std::uint32_t x = 0; x < 3; ++x)
                    grid.velocities.push_back(
                        velocity(grid.lower + grid.spacing * vec3{uvec3{x, y, z}}, static_cast<float>(t)));
    grid.check();
    const vec3 point{0.3_mm, 0.7_mm, 3.3_mm};
    CHECK(length(grid(vessel, point, 0) - velocity(point, 0)) < 1e-5F);
    CHECK(length(grid(vessel, point, 0.025F) - velocity(point, 0.25F)) < 1e-5F);
    CHECK(length(grid(vessel, point, 0.15F) - velocity(point, 0.5F)) < 1e-5F); // on the way back to the first
    CHECK(length(grid(vessel, point, -0.175F) - velocity(point, 0.25F)) < 1e-5F);
    CHECK(length(grid(vessel, {1_mm, 1_mm, 6_mm}, 0) - velocity({1_mm, 1_mm, 6_mm}, 0)) < 1e-5F); // the last corner
    CHECK(grid(vessel, {1.01_mm, 0, 0}, 0) == vec3{0, 0, 0});
    CHECK(grid(object_id{1}, point, 0) == vec3{0, 0, 0});
}

TEST_CASE("velocity fields: settings out of range are refused") {
    CHECK_THROWS_AS((poiseuille{.radius = 4_mm}).check(), usage_error);
    poiseuille wrong = stream;
    wrong.radius = 0;
    CHECK_THROWS_WITH(wrong.check(), "poiseuille: `radius` must be a finite number of metres above 0, such as 4_mm");
    wrong = stream;
    wrong.peak_velocity = 400;
    CHECK_THROWS_AS(wrong.check(), usage_error);
    wrong = stream;
    wrong.waveform.heart_rate = 72;
    CHECK_THROWS_WITH(wrong.check(), "pulsatile: `heart_rate` is 72 Hz; it must be 0 (steady flow) to 20 beats per "
                                     "second, such as 1.2_Hz");
    wrong.waveform = {.resistive_index = -1};
    CHECK_THROWS_AS(wrong.check(), usage_error);
    wrong.waveform = {.systole = 0.5F};
    CHECK_THROWS_AS(wrong.check(), usage_error);
    velocity_samples grid{.size = {2, 2, 2}};
    CHECK_THROWS_WITH(grid.check(), "velocity_samples: `size` and `steps` need 8 velocities, not 0");
    grid.velocities.resize(8);
    CHECK_NOTHROW(grid.check());
    grid.spacing.x = 0;
    CHECK_THROWS_AS(grid.check(), usage_error);
    grid.spacing.x = 1;
    grid.velocities[3].y = std::nanf("");
    CHECK_THROWS_AS(grid.check(), usage_error);
    grid.velocities.resize(16);
    grid.steps = 2;
    CHECK_THROWS_AS(grid.check(), usage_error);
    grid.size = {1, 2, 2};
    CHECK_THROWS_AS(grid.check(), usage_error);
}

} // namespace poiseuille_test

TEST_CASE("tube_flow: branches take what a taper leaves no room for") {
    const object_id blood{3};
    const std::vector<tube_section> taper{{{0, 0, 0}, {4_mm, 4_mm}}, {{0, 0, 40_mm}, {2_mm, 2_mm}}};
    for (const float branches : {0.0F, 0.5F, 1.0F}) {
        const tube_flow flow{.object = blood, .line = taper, .peak_velocity = 0.5F, .side_branches = branches};
        flow.check();
        CHECK(flow(blood, {0, 0, 0}, 0).z == doctest::Approx(0.5).scale(1e-30));
        // A quarter of the area.
        CHECK(flow(blood, {0, 0, 40_mm}, 0).z ==
              doctest::Approx(0.5 * std::pow(4, 1 - branches)).scale(1e-30).epsilon(1e-4));
    }
    CHECK_THROWS_AS(tube_flow({.object = blood, .line = taper, .side_branches = 1.5F}).check(), usage_error);
}

TEST_CASE("tube_flow: on a straight line it is the law of poiseuille") {
    const centre_line line{{{{0, 0, 10_mm}, vec2{3_mm}}, {{20_mm, 0, 30_mm}, vec2{3_mm}}}};
    const tube_flow bent{.object = object_id{3}, .line = line, .peak_velocity = 0.4F, .waveform = {.heart_rate = 1.2F}};
    const poiseuille straight{.object = object_id{3},
                              .from = {0, 0, 10_mm},
                              .to = {20_mm, 0, 30_mm},
                              .radius = 3_mm,
                              .peak_velocity = 0.4F,
                              .waveform = {.heart_rate = 1.2F}};
    CHECK(bent.volume_flow(0.3F) == doctest::Approx(straight.volume_flow(0.3F)).scale(1e-30));
    for (std::uint64_t i = 0; i < 200; ++i) {
        const vec3 point = vec3{20_mm, 8_mm, 30_mm} *
                           (vec3{hash_uniform(1, i), hash_uniform(2, i), hash_uniform(3, i)} - vec3{0, 0.5F, -0.2F});
        const float time = hash_uniform(4, i);
        CHECK(length(bent(object_id{3}, point, time) - straight(object_id{3}, point, time)) < 2e-6F);
        CHECK(bent(object_id{2}, point, time) == vec3{0, 0, 0});
    }
}

TEST_CASE("tube_flow: every section of a tube that bends and narrows has the same volume flow") {
    std::vector<tube_section> sections;
    for (int i = 0; i <= 16; ++i) {
        const float angle = 0.1F * static_cast<float>(i);
        sections.push_back({.centre = 40_mm * vec3{std::cos(angle), 0, std::sin(angle)},
                            .radii = vec2{4_mm, 3_mm} * (1 - 0.02F * static_cast<float>(i))});
    }
    const tube_flow flow{.line = centre_line{sections, {0, 1, 0}}, .peak_velocity = 0.5F};
    for (const float angle : {0.0F, 0.33F, 0.8F, 1.55F}) {
        const vec3 outwards{std::cos(angle), 0, std::sin(angle)}, along{-std::sin(angle), 0, std::cos(angle)};
        double sum = 0;
        constexpr float step = 0.1_mm;
        for (int u = -60; u <= 60; ++u)
            for (int v = -60; v <= 60; ++v) {
                const vec3 point =
                    (40_mm + step * static_cast<float>(u)) * outwards + vec3{0, step * static_cast<float>(v), 0};
                sum += static_cast<double>(dot(flow(object_id{}, point, 0), along) * step * step);
            }
        CHECK(sum == doctest::Approx(flow.volume_flow(0)).scale(1e-30).epsilon(0.01));
    }
    CHECK_THROWS_AS(tube_flow{}.check(), usage_error);
    CHECK_THROWS_AS((tube_flow{.line = flow.line, .peak_velocity = 1000}).check(), usage_error);
}
