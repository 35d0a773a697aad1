#include <insonify/acoustics/scatterers/cell_field.hpp>
#include <doctest/doctest.h>
#include <set>

using namespace insonify;

namespace cell_field_directions_test {
namespace {
vec3 view_direction_of(vec3 towards, std::uint32_t bits) { return normalize(detail::lattice_direction(towards, bits)); }
} // namespace

TEST_CASE("view_direction: one of four neighbouring directions, whose mean is the given one") {
    for (const vec3 towards : {vec3{0.05F, -0.4F, 1}, vec3{-1, 0.02F, 0.7F}, vec3{0.3F, 2, -1.9F}}) {
        std::set<std::int64_t> different;
        vec3 mean{0, 0, 0}; // of the points on the side of the cube
        constexpr std::uint32_t draws = 20000;
        const float highest = max(max(std::fabs(towards.x), std::fabs(towards.y)), std::fabs(towards.z));
        for (std::uint32_t i = 0; i < draws; ++i) {
            const vec3 view = view_direction_of(towards, mix_bits(i));
            CHECK(length(view) == doctest::Approx(1).scale(1e-30));
            const float largest = max(max(std::fabs(view.x), std::fabs(view.y)), std::fabs(view.z));
            mean += view / largest * (1.0F / draws);
            for (int axis = 0; axis < 3; ++axis)
                CHECK(std::fabs(view[axis] / largest - towards[axis] / highest) < 1.001F / detail::view_steps);
            different.insert(std::lround(view.x * 1e4F) * 1000003 + std::lround(view.y * 1e4F));
        }
        CHECK(different.size() == 4);
        CHECK(length(mean - towards / highest) < 2e-3F);
    }
}

TEST_CASE("view_direction: a lattice direction is returned unchanged, for all random bits") {
    for (const vec3 towards : {vec3{0, 0, 1}, vec3{0, -1, 0}, vec3{1e-9F, -1e-9F, 1}, vec3{1, 0.5F, -0.25F}})
        for (std::uint32_t i = 0; i < 1000; ++i)
            CHECK(length(view_direction_of(towards, mix_bits(i)) - normalize(towards)) < 1e-6F);
}

TEST_CASE("view_direction: continuous across the edges of the cube") {
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const vec3 before = view_direction_of({0.9999999F, 0.25F, 1}, mix_bits(i)),
                   after = view_direction_of({1, 0.25F, 0.9999999F}, mix_bits(i));
        CHECK(length(before - after) < 1e-6F);
    }
}

TEST_CASE("view_direction: two lines agree with the stated probability, and slabs are 2 mm thick") {
    for (const float turn : {0.2F, 1.0F, 4.0F}) {
        const float radians = turn * pi / 180;
        int agreed = 0;
        constexpr int draws = 40000;
        for (int i = 0; i < draws; ++i) {
            const float start = 0.1F * hash_uniform(5, static_cast<std::uint64_t>(i));
            const std::uint32_t bits = mix_bits(static_cast<std::uint32_t>(i));
            const vec3 a = view_direction_of({std::tan(start), 0, 1}, bits),
                       b = view_direction_of({std::tan(start + radians), 0, 1}, bits);
            agreed += length(a - b) < 1e-6F ? 1 : 0;
        }
        CHECK(std::fabs(static_cast<float>(agreed) / draws - detail::same_view_probability(radians)) < 0.02F);
    }
    CHECK(detail::same_view_probability(0) == 1);
    CHECK(detail::same_view_probability(1) == 0);
    const vec3 across = 2e-3F * vec3{0.48F, 0.6F, 0.64F};
    CHECK(detail::slab_position(across) - detail::slab_position({0, 0, 0}) == doctest::Approx(1).scale(1e-30));
}

} // namespace cell_field_directions_test
