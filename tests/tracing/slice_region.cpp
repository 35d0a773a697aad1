// Covers tracing/find/slice_cut.hpp.
#include <insonify/core/random.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <doctest/doctest.h>
#include <glm/glm.hpp>
#include <vector>

using namespace insonify;

namespace slice_region_test {

using namespace insonify::detail;

TEST_CASE("the level of a point has a bit for each slice below it, and one in a slice lies below it") {
    const detail::elevation_plane planes[] = {{0}, {-2_mm}, {2_mm}, {1_mm}};
    const slice_frame frame{pose{}, planes};
    const std::vector<vec3> points{{0, -3_mm, 0},  {0, -2_mm, 0},  {0, -1_mm, 0}, {0, 0, 0},
                                   {0, 0.5_mm, 0}, {0, 1.5_mm, 0}, {0, 9_mm, 0}};
    std::vector<std::uint8_t> levels(points.size());
    find_levels(frame, points, levels.data());
    CHECK(levels == std::vector<std::uint8_t>{0, 0, 0b10, 0b10, 0b11, 0b1011, 0b1111});

    const detail::elevation_plane crossing[] = {{1_mm, -0.1F}, {-1_mm, 0.1F}}; // at 10 mm
    const std::vector<vec3> between{{0, 0, 0}, {0, 0, 20_mm}, {0, 2_mm, 9_mm}};
    levels.resize(between.size());
    find_levels({pose{}, crossing}, between, levels.data());
    CHECK(levels == std::vector<std::uint8_t>{0b10, 0b01, 0b11});
}

TEST_CASE("slices seen from a placed object are where they are in the world") {
    const pose at = look_at({3_mm, 1_mm, 4_mm}, {10_mm, -5_mm, 9_mm}, {1, 2, 3});
    const pose object = look_at({-30_mm, 12_mm, 44_mm}, {1_mm, 5_mm, -9_mm}, {0, 1, 0});
    const detail::elevation_plane planes[] = {{}, {1_mm, 0.1F}};
    const slice_frame world{at, planes}, local = world.local(object);
    for (std::uint64_t i = 0; i < 100; ++i) {
        const vec3 p = 50_mm * vec3{hash_uniform(1, 3 * i), hash_uniform(1, 3 * i + 1), hash_uniform(1, 3 * i + 2)};
        for (const std::uint32_t slice : {0U, 1U})
            CHECK(std::fabs(local.height_of(slice, object.local_point(p)) - world.height_of(slice, p)) < 1e-7F);
        CHECK(length(local.place_of(object.local_point(p)) - world.place_of(p)) < 1e-7F);
        const vec3 of_probe = at.local_point(p);
        CHECK(std::fabs(world.height_of(0, p) - of_probe.y) < 1e-7F);
        CHECK(std::fabs(world.height_of(1, p) - world.height[1] - (of_probe.y - planes[1].height(of_probe.z))) < 1e-7F);
    }
}

TEST_CASE("a box that a line of a slice goes through overlaps the region, one far from all of them does not") {
    const detail::elevation_plane planes[] = {{-1_mm, 0.04F}, {0.5_mm, -0.02F}};
    std::size_t inside = 0, outside = 0;
    const auto check = [&](const auto& probe) {
        detail::line_fan fan;
        REQUIRE(fan.assign(probe));
        const pose at = look_at({3_mm, 1_mm, 4_mm}, {10_mm, -5_mm, 9_mm}, {1, 2, 3});
        const slice_region endless{slice_frame{at, planes, fan.upright()}, fan}, near_part = endless.within(50_mm, fan);
        for (std::uint64_t i = 0; i < 4000; ++i) {
            const std::uint64_t own = hash_bits(probe.lines, i);
            const ray beam = probe.beam(static_cast<float>(own % probe.lines));
            const float depth = 100_mm * hash_uniform(own, 1), size = 1e-6F + 2_mm * hash_uniform(own, 2);
            const vec3 aside{0, planes[own % 2].height(beam.at(depth).z), 0};
            const vec3 p = at.point(beam.at(depth) + aside),
                       shift{size * hash_uniform(own, 3), size * hash_uniform(own, 4), 0};
            const aabb around{p - shift, p - shift + vec3{size, size, 0}};
            REQUIRE(overlaps(endless, around));
            if (depth <= 50_mm) REQUIRE(overlaps(near_part, around));
            ++inside;
            const float step = 10_mm + 50_mm * hash_uniform(own, 5);
            for (const vec3 away : {vec3{0, step, 0}, vec3{0, -step, 0}}) {
                const vec3 q = at.point(beam.at(depth) + away);
                CHECK_FALSE(overlaps(endless, aabb{q - vec3{size}, q + vec3{size}}));
                ++outside;
            }
        }
        const auto beside = [&](vec3 q) { return aabb{at.point(q) - vec3{1_mm}, at.point(q) + vec3{1_mm}}; };
        CHECK(overlaps(endless, beside({0, 0, 20_mm})));
        CHECK_FALSE(overlaps(endless, beside({-60_mm, 0, 20_mm})));
        CHECK_FALSE(overlaps(endless, beside({60_mm, 0, 20_mm})));
        CHECK_FALSE(overlaps(endless, beside({0, 0, -40_mm})));
        CHECK(overlaps(endless, beside({0, 0, 90_mm})));
        CHECK_FALSE(overlaps(near_part, beside({0, 0, 90_mm})));
        CHECK_FALSE(overlaps(endless, aabb{}));
    };
    check(linear_array{.lines = 64, .width = 30_mm});
    check(convex_array{.lines = 64, .radius = 20_mm, .field_of_view = 60_deg});
    CHECK(inside == 8000);
    CHECK(outside == 16000);
}

} // namespace slice_region_test
