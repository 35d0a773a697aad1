#include <insonify/core/math.hpp>
#include <cfloat>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

TEST_CASE("finite numbers are told from infinities and NaN by their bits") {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float finite : {0.0F, -0.0F, 1e-45F, FLT_MAX, -FLT_MAX}) CHECK(is_finite(finite));
    for (const float wild : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_FALSE(is_finite(wild));
        CHECK_FALSE(is_finite(vec3{0, wild, 0}));
    }
    CHECK(is_finite(vec3{1, 2, 3}));
}

TEST_CASE("multiply_add rounds once where the machine has the instruction, and twice elsewhere") {
    const float a = 1 + 0x1p-12F; // a * a = 1 + 2^-11 + 2^-24: the last term needs more than 24 bits
    const float once = 0x1p-24F, twice = 0;
    CHECK(multiply_add(a, a, -(1 + 0x1p-11F)) == (has_fma ? once : twice));
}

TEST_CASE("clamped keeps a value within its limits") {
    CHECK(clamped(-1, 0, 2) == 0);
    CHECK(clamped(1, 0, 2) == 1);
    CHECK(clamped(3, 0, 2) == 2);
    CHECK(lesser(vec3{1, 5, 3}, vec3{4, 2, 6}) == vec3{1, 2, 3});
    CHECK(greater(vec3{1, 5, 3}, vec3{4, 2, 6}) == vec3{4, 5, 6});
    CHECK(absolute(vec3{-1, 2, -3}) == vec3{1, 2, 3});
}
