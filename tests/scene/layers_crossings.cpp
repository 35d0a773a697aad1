#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/layers.hpp>
#include <insonify/scene/scene.hpp>
#include <algorithm>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace crossings_test {
namespace {

struct memory {
    std::vector<crossing> crossings;
    std::vector<std::uint32_t> inside;

    memory(std::size_t max_crossings, std::size_t max_inside) : crossings(max_crossings), inside(max_inside) {}
    line_crossings found() {
        return {.room = view<crossing>{crossings}, .inside = {.ranks = view<std::uint32_t>{inside}}};
    }
};

// Twenty slabs one below the other: 10 mm, 11 mm, ... 49 mm are their surfaces.
scene stacked() {
    scene body{medium{}};
    for (int i = 0; i < 20; ++i) {
        const float z = 10_mm + 2_mm * static_cast<float>(i);
        body.add(make_box({-5_mm, -5_mm, z}, {5_mm, 5_mm, z + 1_mm}), medium{.density = 2});
    }
    body.build(exec::seq);
    return body;
}
// Five boxes, one in the other, that end 10, 11, ... 14 mm below the origin.
scene nested() {
    scene body{medium{}};
    for (int i = 0; i < 5; ++i) {
        const float half = 10_mm + 1_mm * static_cast<float>(i);
        body.add(make_box(-vec3{half}, vec3{half}), medium{.density = 2});
    }
    body.build(exec::seq);
    return body;
}

} // namespace
} // namespace crossings_test

TEST_CASE("crossings sort nearest first, ties by rank and face, as std::sort does") {
    for (const std::uint32_t count : {0U, 1U, 2U, 9U, 10U, 11U, 57U, 302U, 2000U}) {
        std::vector<crossing> expected;
        crossings_test::memory own{count, 1};
        line_crossings found = own.found();
        for (std::uint32_t i = 0; i < count; ++i) { // few distances, so that there are ties
            const crossing one{static_cast<float>(hash_bits(count, 3 * i) % 40),
                               static_cast<std::uint32_t>(hash_bits(count, 3 * i + 1) % 4),
                               static_cast<std::uint32_t>(hash_bits(count, 3 * i + 2) % 1000)};
            found.add(one);
            expected.push_back(one);
        }
        found.sort();
        std::sort(expected.begin(), expected.end());
        CHECK(found.complete());
        CHECK(std::equal(expected.begin(), expected.end(), found.sorted().begin(), found.sorted().end()));
    }
}

TEST_CASE("a line with more crossings than there is room says so; with exactly enough room all are found") {
    const scene body = crossings_test::stacked();
    const scene_view flat = body.view_for_rays(exec::seq);
    const ray line{.origin = {0.3_mm, 0.2_mm, 0}};
    for (const std::uint32_t room : {0U, 1U, 39U, 40U, 41U}) {
        crossings_test::memory own{room, 8};
        line_crossings found = own.found();
        CHECK(find_crossings(flat, line, 60_mm, found) == (room >= 40));
        CHECK(found.complete() == (room >= 40));
        if (room < 40) continue;
        REQUIRE(found.count == 40);
        for (std::uint32_t i = 0; i < 40; ++i)
            CHECK(found.sorted()[i].distance == doctest::Approx(10e-3 + 1e-3 * i).epsilon(1e-6).scale(1e-30));
    }
    crossings_test::memory own{20, 8};
    line_crossings found = own.found();
    CHECK_FALSE(find_crossings(flat, line, 60_mm, found));
    CHECK(find_crossings(flat, line, 29.5_mm, found)); // a former overflow is forgotten; 20 crossings lie above
    CHECK(found.count == 20);
}

TEST_CASE("an origin inside more objects than there is room says so; with exactly enough room all are found") {
    const scene body = crossings_test::nested();
    const scene_view flat = body.view_for_rays(exec::seq);
    for (const std::uint32_t room : {0U, 1U, 4U, 5U, 6U}) {
        crossings_test::memory own{16, room};
        line_crossings found = own.found();
        CHECK(find_crossings(flat, {.origin = {0.3_mm, 0.2_mm, 0}}, 60_mm, found) == (room >= 5));
        CHECK(found.inside.overflow == (room < 5));
        if (room < 5) continue;
        CHECK(found.inside.count == 5);
        CHECK(found.count == 5);
    }
}

TEST_CASE("objects that contain the origin are counted, also where the line ends before it leaves them") {
    const scene body = crossings_test::nested();
    crossings_test::memory own{16, 8};
    line_crossings found = own.found();
    CHECK(find_crossings(body.view_for_rays(exec::seq), {.origin = {0.3_mm, 0.2_mm, 0}}, 5_mm, found));
    CHECK(found.count == 0);
    CHECK(found.inside.count == 5);
}
