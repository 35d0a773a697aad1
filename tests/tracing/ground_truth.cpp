#include <insonify/acoustics/tissue.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/read/ground_truth.hpp>
#include "../slab.hpp"
#include "ground_truth_scenes.hpp"
#include "solids.hpp"
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace ground_truth_test {
namespace {

// The samples of a line that hold a surface.
std::vector<std::uint32_t> surfaces_of(const ground_truth_lines& truth, std::uint32_t line) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t k = 0; k < truth.surface.samples; ++k)
        if (truth.surface(line, k) != background_label) found.push_back(k);
    return found;
}

} // namespace
} // namespace ground_truth_test

TEST_CASE("a tilted plate has its angle as incidence, and lets 1 - R through") { // V3
    using namespace ground_truth_test;
    const medium before{.density = 1065, .sound_speed = 1580}, after{.density = 1910, .sound_speed = 3500};
    struct {
        float angle, reflected;
    } const rows[] = {{0, 0.3574F}, {10_deg, 0.3822F}, {20_deg, 0.4933F}, {25_deg, 0.6759F}, {30_deg, 1.0F}};
    for (const auto& row : rows)
        for (const float azimuth : {0.0F, 0.7F, 1.5707963F, 4.0F}) { // within the slice plane, out of it, both
            const vec3 normal{std::sin(row.angle) * std::cos(azimuth), std::sin(row.angle) * std::sin(azimuth),
                              -std::cos(row.angle)};
            scene body{before};
            const object_id plate = body.add(slab({0, 0, 40_mm}, normal, 200_mm, 30_mm), after);
            body.build(exec::par);
            const ground_truth_lines truth =
                ground_truth(exec::par, body, middle_line(5_MHz), pose{}, {.depth = 60_mm, .samples = 600});
            const std::uint32_t k = surfaces_of(truth, 0).at(0);
            CHECK((k == 399 || k == 400));
            CHECK(truth.surface(0, k) == static_cast<label_id>(plate));
            CHECK(std::fabs(truth.incidence(0, k) - row.angle) < 2e-6F);
            CHECK(truth.transmitted(0, 398) == 1);
            CHECK(std::fabs(truth.transmitted(0, 410) - (1 - row.reflected)) < 1e-4F);
            for (std::uint32_t i = 0; i < 600; ++i)
                if (i != k) REQUIRE(truth.incidence(0, i) == 0);
        }
}

TEST_CASE("the beam meets a sphere at asin(b / a), b being how far its middle is off") {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 7), tissue::liver);
    body.build(exec::par);
    const linear_array probe{.lines = 39, .width = 19.5_mm};
    const ground_truth_lines truth = ground_truth(exec::par, body, probe, pose{}, {.depth = 60_mm, .samples = 1000});
    for (std::uint32_t line = 0; line < probe.lines; ++line) {
        const auto found = ground_truth_test::surfaces_of(truth, line);
        REQUIRE(found.size() == 2);
        const double off = (static_cast<double>(line) - 19) * 0.5e-3, half = std::sqrt(1e-4 - off * off);
        for (const std::uint32_t k : found) // a facet is up to 0.4 degrees off its sphere
            CHECK(std::fabs(static_cast<double>(truth.incidence(line, k)) - std::asin(std::fabs(off) / 0.01)) < 0.01);
        CHECK(std::fabs(found[0] - (0.03 - half) / 6e-5) <= 1.5);
        CHECK(std::fabs(found[1] - (0.03 + half) / 6e-5) <= 1.5);
    }
}

TEST_CASE("a surface is of the object that gives the medium where two meet, entered or left") {
    scene body{tissue::water};
    const auto in_order = [&](float from, float to, const medium& inside, int priority = 0) {
        return static_cast<label_id>(
            body.add(make_box({-to, -to, from}, {to, to, to}), inside, {.priority = priority}));
    };
    const label_id muscle = in_order(5.03_mm, 50.03_mm, tissue::muscle);
    const label_id wall = in_order(10.03_mm, 20.03_mm, tissue::vessel_wall);
    const label_id blood = in_order(12.03_mm, 18.03_mm, tissue::blood);
    const label_id bone = in_order(30.03_mm, 35.03_mm, tissue::bone);
    const label_id fat = in_order(35.03_mm, 40.03_mm, tissue::fat);     // touches the bone; larger
    const label_id same = in_order(42.03_mm, 45.03_mm, tissue::muscle); // invisible
    const label_id urgent = in_order(48.03_mm, 55.03_mm, tissue::steel, 1);
    CHECK(same != urgent);
    body.build(exec::par);
    struct {
        float depth;
        label_id id;
    } const rows[] = {{5.03_mm, muscle}, {10.03_mm, wall}, {12.03_mm, blood}, {18.03_mm, blood},  {20.03_mm, wall},
                      {30.03_mm, bone},  {35.03_mm, bone}, {40.03_mm, fat},   {48.03_mm, urgent}, {55.03_mm, urgent}};
    const ground_truth_lines truth =
        ground_truth(exec::par, body, ground_truth_test::middle_line(5_MHz), pose{}, {.depth = 60_mm, .samples = 600});
    const auto found = ground_truth_test::surfaces_of(truth, 0);
    REQUIRE(found.size() == std::size(rows));
    for (std::size_t i = 0; i < found.size(); ++i) {
        CHECK(found[i] == static_cast<std::uint32_t>(rows[i].depth / 0.1_mm));
        CHECK(truth.surface(0, found[i]) == rows[i].id);
    }
}

TEST_CASE("of several surfaces in one sample the first is reported, and all weaken what goes on") {
    const medium metal{.density = 7900, .sound_speed = 5740};
    scene body{tissue::water}; // a film in sample 200, and a block that begins there too
    const object_id film = body.add(make_box({-9_mm, -9_mm, 20.02_mm}, {9_mm, 9_mm, 20.05_mm}), metal);
    body.add(make_box({-9_mm, -9_mm, 20.08_mm}, {9_mm, 9_mm, 30.05_mm}), metal);
    body.build(exec::par);
    const ground_truth_lines truth = ground_truth(exec::par, body, ground_truth_test::middle_line(5_MHz), pose{},
                                                  physical<>{.bandwidth = pulse_bandwidth::narrow},
                                                  {.depth = 40_mm, .samples = 400}); // the loss of a single frequency
    CHECK(ground_truth_test::surfaces_of(truth, 0) == std::vector<std::uint32_t>{200, 300});
    CHECK(truth.surface(0, 200) == static_cast<label_id>(film));
    const double water_db = 2 * 0.00217 * 25 * 1.995; // there and back, to sample 199
    CHECK(ground_truth_test::decibels(truth.transmitted(0, 199)) ==
          doctest::Approx(-water_db).epsilon(1e-4).scale(1e-30));
    const double z1 = 998.0 * 1482, z2 = 7900.0 * 5740, t = 4 * z1 * z2 / ((z1 + z2) * (z1 + z2));
    CHECK(truth.transmitted(0, 202) / truth.transmitted(0, 199) ==
          doctest::Approx(t * t * t).epsilon(1e-3).scale(1e-30));
}

TEST_CASE("a ball of water in water has labels but no surface, and casts no shadow") {
    scene body{tissue::water};
    const object_id ball = body.add(make_sphere({0, 0, 30_mm}, 10_mm, 4), tissue::water);
    body.build(exec::par);
    const scene nothing = scene{tissue::water}.build(exec::par);
    const linear_array probe{.lines = 33, .width = 30_mm};
    const label_settings settings{.depth = 60_mm, .samples = 300, .grid = label_settings::depth_grid::displayed};
    const ground_truth_lines truth = ground_truth(exec::par, body, probe, pose{}, settings);
    const ground_truth_lines empty = ground_truth(exec::par, nothing, probe, pose{}, settings);
    CHECK(truth.label(16, 150) == static_cast<label_id>(ball));
    CHECK(truth.surface == empty.surface);
    CHECK(truth.incidence == empty.incidence);
    CHECK(truth.medium == empty.medium);
    for (std::size_t i = 0; i < truth.transmitted.values.size(); ++i)
        REQUIRE(truth.transmitted.values[i] == doctest::Approx(empty.transmitted.values[i]).epsilon(1e-6).scale(1e-30));
}

TEST_CASE("depth is geometric on both grids: 20 mm of fat, 10 mm of bone, then muscle") {
    scene body{tissue::muscle};
    body.add(make_box({-50_mm, -50_mm, -5_mm}, {50_mm, 50_mm, 20_mm}), tissue::fat);
    body.add(make_box({-50_mm, -50_mm, 20_mm}, {50_mm, 50_mm, 30_mm}), tissue::bone);
    body.build(exec::par);
    label_settings settings{.depth = 40_mm, .samples = 1000};
    const ground_truth_lines geometric =
        ground_truth(exec::par, body, ground_truth_test::middle_line(2_MHz), pose{}, settings);
    settings.grid = label_settings::depth_grid::displayed;
    const ground_truth_lines displayed =
        ground_truth(exec::par, body, ground_truth_test::middle_line(2_MHz), pose{}, settings);
    for (std::uint32_t k = 0; k < 1000; ++k) {
        const double z = (k + 0.5) * 40e-6;
        const double fat_end = 0.02 * 1540 / 1455, bone_end = fat_end + 0.01 * 1540 / 3500;
        const double expected = z < fat_end    ? z * 1455 / 1540
                                : z < bone_end ? 0.02 + (z - fat_end) * 3500 / 1540
                                               : 0.03 + (z - bone_end) * 1580 / 1540;
        REQUIRE(static_cast<double>(geometric.depth(0, k)) == doctest::Approx(z).epsilon(1e-5).scale(1e-30));
        REQUIRE(static_cast<double>(displayed.depth(0, k)) == doctest::Approx(expected).epsilon(1e-5).scale(1e-30));
        // What arrives is a matter of where, not of where it is displayed.
        const auto same_place = static_cast<std::uint32_t>(expected / 40e-6);
        if (same_place < 1000 && displayed.medium(0, k) == geometric.medium(0, same_place))
            REQUIRE(displayed.transmitted(0, k) ==
                    doctest::Approx(geometric.transmitted(0, same_place)).epsilon(0.05).scale(1e-30));
    }
}

TEST_CASE("label is that of `label`, medium that of the object, attenuation that of a walk in steps of 1 um") {
    // Of one impedance and speed, so that attenuation alone acts.
    const auto medium_with = [](float attenuation, float power) {
        return medium{.density = 1000, .sound_speed = 1500, .attenuation = attenuation, .attenuation_power = power};
    };
    const medium outside = medium_with(0.2_dB_per_cm, 2), middle = medium_with(1_dB_per_cm, 1);
    const solids::world formulas{.background = outside,
                                 .all = {solids::box({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.007}, outside),
                                         solids::sphere({0, 0, 0.03}, 0.01, middle),
                                         solids::sphere({0.002, 0, 0.03}, 0.004, medium_with(0.15_dB_per_cm, 1.2F))}};
    const scene body = formulas.scene();
    const convex_array probe{.lines = 41, .radius = 30_mm, .field_of_view = 40_deg, .frequency = 4_MHz};
    for (const auto grid : {label_settings::depth_grid::geometric, label_settings::depth_grid::displayed}) {
        const label_settings settings{.depth = 50_mm, .samples = 500, .grid = grid};
        const ground_truth_lines truth =
            ground_truth(exec::par, body, probe, pose{}, physical<>{.bandwidth = pulse_bandwidth::narrow}, settings);
        CHECK(truth.label == label(exec::par, body, probe, pose{}, settings));
        for (std::uint32_t line = 0; line < probe.lines; line += 4) {
            const solids::walk walk{formulas, detail::world_beam(probe, pose{}, static_cast<float>(line)), 0.051, 4};
            for (std::uint32_t k = 0; k < 500; ++k) {
                REQUIRE(body.media()[truth.medium(line, k)] == formulas.medium_of(truth.label(line, k)));
                const double depth = (k + 0.5) * 1e-4;
                const std::size_t i =
                    grid == label_settings::depth_grid::displayed ? walk.at_displayed(depth) : walk.at_geometric(depth);
                REQUIRE(std::fabs(ground_truth_test::decibels(truth.transmitted(line, k)) + walk.lost[i]) < 0.02);
            }
        }
    }
}

TEST_CASE("every sample of every map is a number, whatever the media") {
    scene body{tissue::air};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 3), medium{.density = 1e-3F, .sound_speed = 10, .attenuation = 1e6F});
    body.add(make_sphere({0, 0, 30_mm}, 5_mm, 3), medium{.density = 1e5F, .sound_speed = 1e5F});
    body.build(exec::par);
    for (const auto grid : {label_settings::depth_grid::geometric, label_settings::depth_grid::displayed}) {
        const ground_truth_lines truth =
            ground_truth(exec::par, body, linear_array{}, pose{}, {.depth = 60_mm, .samples = 400, .grid = grid});
        for (std::size_t i = 0; i < truth.depth.values.size(); ++i) {
            REQUIRE(truth.transmitted.values[i] >= 0);
            REQUIRE(truth.transmitted.values[i] <= 1);
            REQUIRE(truth.depth.values[i] > 0);
            REQUIRE(is_finite(truth.depth.values[i]));
            REQUIRE(truth.incidence.values[i] >= 0);
            REQUIRE(truth.incidence.values[i] <= 1.5708F);
            REQUIRE(truth.medium.values[i] < 3);
        }
    }
}

TEST_CASE("ground truth is equal on any number of threads, and refuses what `label` refuses") {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 4), tissue::bone);
    body.add(make_sphere({-15_mm, 0, 25_mm}, 4_mm, 4), tissue::blood);
    const linear_array probe{.lines = 101};
    const label_settings settings{.depth = 60_mm, .samples = 333, .grid = label_settings::depth_grid::displayed};
    CHECK_THROWS_AS(ground_truth(exec::par, body, probe, pose{}, settings), usage_error);
    body.build(exec::par);
    CHECK_THROWS_AS(ground_truth(exec::par, body, probe, pose{}, {.depth = -1}), usage_error);
    CHECK_THROWS_AS(ground_truth(exec::par, body, probe, pose{.rotation = mat3{2}}, settings), geometry_error);
    const ground_truth_lines reference = ground_truth(exec::seq, body, probe, pose{}, settings);
    for (const auto* map : {&reference.label, &reference.medium, &reference.surface})
        CHECK((map->count == 101 && map->samples == 333 && map->depth == 60_mm && map->values.size() == 101 * 333));
    for (const auto* map : {&reference.incidence, &reference.transmitted, &reference.depth})
        CHECK((map->count == 101 && map->samples == 333 && map->depth == 60_mm && map->values.size() == 101 * 333));
    CHECK(ground_truth(exec::unseq, body, probe, pose{}, settings) == reference);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U}) {
        CHECK(ground_truth(exec::par.threads(threads), body, probe, pose{}, settings) == reference);
        CHECK(ground_truth(exec::par_unseq.threads(threads), body, probe, pose{}, settings) == reference);
    }
}
