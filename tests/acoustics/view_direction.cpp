#include <insonify/acoustics/view_direction.hpp>
#include <doctest/doctest.h>
#include <set>

using namespace insonify;

TEST_CASE("a view is one of four directions near by, and on average the one that was asked for") {
    for (const vec3 towards : {vec3{0.05F, -0.4F, 1}, vec3{-1, 0.02F, 0.7F}, vec3{0.3F, 2, -1.9F}}) {
        std::set<std::int64_t> different;
        vec3 mean{0, 0, 0}; // of the points on the side of the cube
        constexpr std::uint32_t draws = 20000;
        const float most = greater(greater(std::fabs(towards.x), std::fabs(towards.y)), std::fabs(towards.z));
        for (std::uint32_t i = 0; i < draws; ++i) {
            const vec3 view = view_direction(towards, mix_bits(i));
            CHECK(length(view) == doctest::Approx(1));
            const float largest = greater(greater(std::fabs(view.x), std::fabs(view.y)), std::fabs(view.z));
            mean += view / largest * (1.0F / draws);
            for (int axis = 0; axis < 3; ++axis)
                CHECK(std::fabs(view[axis] / largest - towards[axis] / most) < 1.001F / view_steps);
            different.insert(std::lround(view.x * 1e4F) * 1000003 + std::lround(view.y * 1e4F));
        }
        CHECK(different.size() == 4);
        CHECK(length(mean - towards / most) < 2e-3F);
    }
}

TEST_CASE("a direction of the lattice is its own view, whatever the chance and a rounding") {
    for (const vec3 towards : {vec3{0, 0, 1}, vec3{0, -1, 0}, vec3{1e-9F, -1e-9F, 1}, vec3{1, 0.5F, -0.25F}})
        for (std::uint32_t i = 0; i < 1000; ++i)
            CHECK(length(view_direction(towards, mix_bits(i)) - normalize(towards)) < 1e-6F);
}

TEST_CASE("views go on over the edge of the cube") {
    for (std::uint32_t i = 0; i < 1000; ++i) {
        const vec3 before = view_direction({0.9999999F, 0.25F, 1}, mix_bits(i)),
                   after = view_direction({1, 0.25F, 0.9999999F}, mix_bits(i));
        CHECK(length(before - after) < 1e-6F);
    }
}

TEST_CASE("two lines choose alike as often as stated, and a slab is two millimetres thick") {
    for (const float turn : {0.2F, 1.0F, 4.0F}) {
        const float radians = turn * pi / 180;
        int alike = 0;
        constexpr int draws = 40000;
        for (int i = 0; i < draws; ++i) {
            const float start = 0.1F * hash_uniform(5, static_cast<std::uint64_t>(i));
            const std::uint32_t chance = mix_bits(static_cast<std::uint32_t>(i));
            const vec3 a = view_direction({std::tan(start), 0, 1}, chance),
                       b = view_direction({std::tan(start + radians), 0, 1}, chance);
            alike += length(a - b) < 1e-6F ? 1 : 0;
        }
        CHECK(std::fabs(static_cast<float>(alike) / draws - same_view(radians)) < 0.02F);
    }
    CHECK(same_view(0) == 1);
    CHECK(same_view(1) == 0);
    const vec3 across = 2e-3F * vec3{0.48F, 0.6F, 0.64F};
    CHECK(view_slabs::place(across) - view_slabs::place({0, 0, 0}) == doctest::Approx(1));
}
