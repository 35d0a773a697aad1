#include <insonify/acoustics/tissue.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/tracing/read/label.hpp>
#include "../slab.hpp"
#include "solids.hpp"
#include <doctest/doctest.h>
#include <limits>
#include <set>

using namespace insonify;

namespace label_test {
namespace {

// Nested, overlapping, of different priorities, placed and turned, one twice in the same place, one of water in water.
solids::world world_of_solids() {
    const pose turned = look_at({4_mm, 1_mm, 22_mm}, {6_mm, 3_mm, 30_mm}, {1, 0, 0.3F});
    return {.background = tissue::water,
            .all = {solids::box({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.007}, tissue::fat),
                    solids::box({-0.04, -0.04, 0.005}, {0.04, 0.04, 0.05}, tissue::muscle),
                    solids::sphere({-0.008, 0.001, 0.02}, 0.006, tissue::vessel_wall),
                    solids::sphere({-0.008, 0.001, 0.02}, 0.005, tissue::blood),
                    solids::box({-0.004, -0.006, -0.005}, {0.005, 0.006, 0.006}, tissue::bone, {.at = turned}),
                    solids::sphere({0.0, 0.0, 0.04}, 0.009, tissue::liver, {.priority = 1}),
                    solids::sphere({0.002, 0.0, 0.04}, 0.004, tissue::bone),
                    solids::sphere({0.012, 0.0, 0.045}, 0.006, tissue::steel, {.priority = 2}),
                    solids::box({-0.02, -0.02, 0.032}, {-0.012, 0.02, 0.036}, tissue::nerve),
                    solids::box({-0.02, -0.02, 0.032}, {-0.012, 0.02, 0.036}, tissue::tendon),
                    solids::sphere({0.0, 0.0, 0.06}, 0.004, tissue::water)}};
}

// Every sample of every third line against the formulas.
template <class Probe>
void check_labels(const solids::world& formulas, const scene& body, const Probe& probe, const pose& at) {
    for (const auto grid : {label_settings::depth_grid::geometric, label_settings::depth_grid::displayed}) {
        const label_settings settings{.depth = 70_mm, .samples = 701, .grid = grid};
        const label_lines labels = label(exec::par, body, probe, at, settings);
        std::size_t compared = 0, doubtful = 0, wrong = 0;
        std::set<label_id> met;
        for (std::uint32_t line = 0; line < probe.lines; line += 3) {
            const solids::walk walk{formulas, detail::world_beam(probe, at, static_cast<float>(line)), 0.0701, 5};
            for (std::uint32_t k = 0; k < labels.samples; ++k) {
                const double depth = (k + 0.5) / 701 * 0.07;
                const std::size_t i =
                    grid == label_settings::depth_grid::displayed ? walk.at_displayed(depth) : walk.at_geometric(depth);
                ++compared;
                if (walk.in_doubt(i, 12)) {
                    ++doubtful;
                    continue;
                }
                met.insert(labels(line, k));
                if (labels(line, k) != walk.solid[i]) ++wrong;
            }
        }
        MESSAGE(compared, " samples, ", doubtful, " too near to a surface, ", met.size(), " labels met");
        CHECK(wrong == 0);
        CHECK(doubtful < compared / 50);
        CHECK(met.size() >= 9);
    }
}

// Displayed depth at which an object begins on the middle line.
float first_of(const label_lines& labels, object_id id) {
    const std::uint32_t line = labels.count / 2;
    std::uint32_t k = 0;
    while (k < labels.samples && labels(line, k) != static_cast<label_id>(id)) ++k;
    return static_cast<float>(k) * labels.depth / static_cast<float>(labels.samples);
}

} // namespace
} // namespace label_test

TEST_CASE("a label is the id of the object that a sample lies in, and background_label outside all") {
    scene body{tissue::muscle};
    const object_id bone = body.add(make_sphere({0, 0, 30_mm}, 10_mm, 5), tissue::bone);
    body.build(exec::par);
    const label_lines truth =
        label(exec::par, body, linear_array{.lines = 3, .width = 1_mm}, pose{}, {.depth = 60_mm, .samples = 60});
    CHECK(truth.count == 3);
    CHECK(truth.samples == 60);
    CHECK(truth.depth == 60_mm);
    CHECK(truth.values.size() == 180);
    for (std::uint32_t k = 0; k < 60; ++k)
        CHECK(truth(1, k) == (k < 20 || k >= 40 ? background_label : static_cast<label_id>(bone)));
}

TEST_CASE("labels are those of spheres and boxes as formulas, nested, overlapping and placed, on both grids") {
    const solids::world formulas = label_test::world_of_solids();
    const scene body = formulas.scene();
    label_test::check_labels(formulas, body, linear_array{.lines = 61, .width = 38_mm}, pose{});
    label_test::check_labels(formulas, body, convex_array{.lines = 61, .radius = 40_mm, .field_of_view = 70_deg},
                             look_at({3_mm, -2_mm, -1_mm}, {1_mm, 1_mm, 30_mm}, {1, 0.2F, 0}));
    label_test::check_labels(formulas, body, phased_array{.lines = 61, .field_of_view = 80_deg},
                             look_at({-2_mm, 1_mm, 20_mm}, {0, 0, 50_mm}, {1, 0.1F, 0})); // the face inside objects
}

TEST_CASE("of objects in one place the one of highest priority is the label, then the smaller, then the later") {
    scene body{tissue::water};
    const object_id first = body.add(make_box({-5_mm, -5_mm, 10_mm}, {5_mm, 5_mm, 20_mm}), tissue::fat);
    const object_id second = body.add(make_box({-5_mm, -5_mm, 10_mm}, {5_mm, 5_mm, 20_mm}), tissue::muscle);
    const object_id small_one = body.add(make_box({-4_mm, -4_mm, 14_mm}, {4_mm, 4_mm, 16_mm}), tissue::blood);
    const object_id urgent =
        body.add(make_box({-6_mm, -6_mm, 18_mm}, {6_mm, 6_mm, 30_mm}), tissue::bone, {.priority = 1});
    body.build(exec::par);
    const linear_array probe{.lines = 1, .width = 1_mm};
    const auto at = [&](std::uint32_t k) {
        return label(exec::seq, body, probe, pose{}, {.depth = 40_mm, .samples = 40})(0, k);
    };
    CHECK(at(12) == static_cast<label_id>(second));
    CHECK(at(15) == static_cast<label_id>(small_one));
    CHECK(at(19) == static_cast<label_id>(urgent));
    CHECK(at(29) == static_cast<label_id>(urgent));
    CHECK(at(30) == background_label);
    body.remove(second); // ids are kept
    body.build(exec::par);
    CHECK(at(12) == static_cast<label_id>(first));
    CHECK(at(19) == static_cast<label_id>(urgent));
}

TEST_CASE("no sample between touching objects is background") {
    scene body{tissue::water};
    body.add(make_box({-5_mm, -5_mm, 10_mm}, {5_mm, 5_mm, 20_mm}), tissue::fat);
    body.add(make_box({-5_mm, -5_mm, 0}, {5_mm, 5_mm, 10_mm}), tissue::muscle, {.at = {.translation = {0, 0, 20_mm}}});
    body.build(exec::par);
    const label_lines labels =
        label(exec::par, body, linear_array{.lines = 9, .width = 8_mm}, pose{}, {.depth = 40_mm, .samples = 80000});
    for (std::uint32_t line = 0; line < labels.count; ++line)
        for (std::uint32_t k = 20002; k < 59998; ++k) REQUIRE(labels(line, k) == (k < 40000 ? 0U : 1U));
}

TEST_CASE("on the displayed grid a plate at z stands at z c0 / c") { // V8
    struct {
        float speed, depth, displayed;
    } const rows[] = {{1455, 20_mm, 21.168_mm},  {1580, 20_mm, 19.494_mm}, {1450, 100_mm, 106.2_mm},
                      {1400, 50_mm, 55.0_mm},    {3500, 10_mm, 4.4_mm},    {1540, 30_mm, 30_mm},
                      {5740, 200_mm, 53.658_mm}, {343, 10_mm, 44.898_mm}};
    for (const auto& row : rows) {
        scene body{medium{.density = 1000, .sound_speed = row.speed}};
        const object_id plate = body.add(slab({0, 0, row.depth}, {0, 0, -1}, 100_mm, 10_mm), tissue::water);
        body.build(exec::par);
        const linear_array probe{.lines = 5, .width = 10_mm};
        const label_settings settings{.depth = 120_mm, .samples = 4096, .grid = label_settings::depth_grid::displayed};
        const float found = label_test::first_of(label(exec::par, body, probe, pose{}, settings), plate);
        MESSAGE(row.speed, " m/s: plate at ", (row.depth * 1e3F), " mm displayed at ", (found * 1e3F), " mm, expected ",
                (row.displayed * 1e3F));
        CHECK(std::fabs(found - row.displayed) < 0.05_mm);
        CHECK(std::fabs(found - row.depth * 1540 / row.speed) <= 0.51F * settings.depth / 4096);
    }
}

TEST_CASE("displayed and geometric grid are one where sound has the display's speed") {
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 4), medium{.density = 1100, .sound_speed = 1540});
    body.build(exec::par);
    const linear_array probe{};
    CHECK(label(exec::par, body, probe, pose{},
                {.depth = 60_mm, .samples = 500, .grid = label_settings::depth_grid::displayed}) ==
          label(exec::par, body, probe, pose{}, {.depth = 60_mm, .samples = 500}));
}

TEST_CASE("labels left without a number of samples have two for each deviation of the pulse, a multiple of 64") {
    const scene body = scene{}.build(exec::par);
    const auto samples = [&](float frequency, float depth) {
        return label(exec::par, body, linear_array{.lines = 2, .frequency = frequency}, pose{}, {.depth = depth})
            .samples;
    };
    CHECK(samples(7.5_MHz, 40_mm) == 1344);
    CHECK(samples(5_MHz, 80_mm) == 1792);
    CHECK(samples(100_MHz, max_scan_depth) == 1U << 20U); // bounded
}

TEST_CASE("labels are equal on any number of threads, with and without SIMD") {
    const scene body = label_test::world_of_solids().scene();
    const convex_array probe{.lines = 101, .radius = 40_mm, .field_of_view = 60_deg};
    const label_settings settings{.depth = 60_mm, .samples = 777, .grid = label_settings::depth_grid::displayed};
    const label_lines reference = label(exec::seq, body, probe, pose{}, settings);
    CHECK(label(exec::unseq, body, probe, pose{}, settings) == reference);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U}) {
        CHECK(label(exec::par.threads(threads), body, probe, pose{}, settings) == reference);
        CHECK(label(exec::par_unseq.threads(threads), body, probe, pose{}, settings) == reference);
    }
}

TEST_CASE("what cannot be labelled is refused with a sentence") {
    scene body{tissue::water};
    const auto with = [&](const auto& probe, const pose& at, const label_settings& settings) {
        return label(exec::par, body, probe, at, settings);
    };
    CHECK_THROWS_WITH_AS(with(linear_array{}, pose{}, {}),
                         "scene: call build(policy) after the last add or remove, before tracing or update",
                         usage_error);
    body.build(exec::par);
    CHECK_THROWS_AS(with(linear_array{}, pose{}, {.depth = 0}), usage_error);
    CHECK_THROWS_AS(with(linear_array{}, pose{}, {.depth = -1}), usage_error);
    CHECK_THROWS_AS(with(linear_array{}, pose{}, {.depth = std::numeric_limits<float>::quiet_NaN()}), usage_error);
    CHECK_THROWS_AS(with(linear_array{.lines = 0}, pose{}, {}), usage_error);
    CHECK_THROWS_AS(with(linear_array{}, pose{.rotation = mat3{2}}, {}), geometry_error);
    CHECK_THROWS_AS(with(linear_array{.lines = ~0U}, pose{}, {.samples = ~0U}), usage_error);
}
