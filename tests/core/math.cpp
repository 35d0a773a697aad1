#include <insonify/core/math.hpp>
#include <cfloat>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

TEST_CASE("math: is_finite is false for infinities and NaN") {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float finite : {0.0F, -0.0F, 1e-45F, FLT_MAX, -FLT_MAX}) CHECK(is_finite(finite));
    for (const float value : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_FALSE(is_finite(value));
        CHECK_FALSE(is_finite(vec3{0, value, 0}));
    }
    CHECK(is_finite(vec3{1, 2, 3}));
}

TEST_CASE("math: multiply_add rounds once with fused multiply-add, otherwise twice") {
    const float a = 1 + 0x1p-12F; // a * a = 1 + 2^-11 + 2^-24: the last term needs more than 24 bits
    const float once = 0x1p-24F, twice = 0;
    CHECK(multiply_add(a, a, -(1 + 0x1p-11F)) == (detail::has_fma ? once : twice));
}

TEST_CASE("math: places in a table lie between two of its values, or at its ends") {
    const auto is = [](float place, std::size_t count, std::size_t above, std::size_t below, float part) {
        const detail::table_place found{place, count};
        CHECK(found.above == above);
        CHECK(found.below == below);
        CHECK(found.part == part);
    };
    is(1.25F, 4, 1, 2, 0.25F);
    is(2, 4, 2, 3, 0);
    is(-0.5F, 4, 0, 1, 0);
    is(3, 4, 3, 3, 0);
    is(7.5F, 4, 3, 3, 0);
    is(0.5F, 1, 0, 0, 0);
}

TEST_CASE("math: min, max, clamp and abs") {
    CHECK(clamp(-1, 0, 2) == 0);
    CHECK(clamp(1, 0, 2) == 1);
    CHECK(clamp(3, 0, 2) == 2);
    CHECK(min(vec3{1, 5, 3}, vec3{4, 2, 6}) == vec3{1, 2, 3});
    CHECK(max(vec3{1, 5, 3}, vec3{4, 2, 6}) == vec3{4, 5, 6});
    CHECK(abs(vec3{-1, 2, -3}) == vec3{1, 2, 3});
}
