#include <insonify/acoustics/medium.hpp>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

namespace medium_test {
static_assert(medium{.density = 1700, .sound_speed = 1000}.impedance() == 1.7e6F);
static_assert(medium{} == medium{} && medium{} != medium{.roughness = 1_um});

TEST_CASE("medium: specular, anechoic and lossless by default") {
    const medium own{.density = 1000, .sound_speed = 1500};
    CHECK(own.attenuation == 0);
    CHECK(own.attenuation_power == 1);
    CHECK(own.backscatter == 0);
    CHECK(own.roughness == 0);
}

TEST_CASE("medium: equality compares every member") {
    const medium own{};
    CHECK(own != medium{.density = 999});
    CHECK(own != medium{.sound_speed = 1500});
    CHECK(own != medium{.attenuation = 1});
    CHECK(own != medium{.attenuation_power = 2});
    CHECK(own != medium{.backscatter = 1});
}

TEST_CASE("medium: displayed depth is stretched by c0 / c, at most a million times") {
    CHECK(displayed_stretch({.sound_speed = 1540}) == 1);
    CHECK(displayed_stretch({.sound_speed = 770}) == 2);
    CHECK(displayed_stretch({.sound_speed = 3080}) == 0.5F);
    CHECK(displayed_stretch({.sound_speed = 1e-20F}) == 1e6F);
    CHECK(displayed_stretch({.sound_speed = 1e-45F}) == 1e6F);
}

TEST_CASE("medium: valid if density and speed are above 0 and nothing is negative, infinite or NaN") {
    CHECK(is_valid(medium{}));
    CHECK(is_valid(medium{.density = 1.2F, .sound_speed = 343}));
    const float infinite = std::numeric_limits<float>::infinity();
    for (const float bad : {-1.0F, infinite, -infinite, std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_FALSE(is_valid(medium{.density = bad}));
        CHECK_FALSE(is_valid(medium{.sound_speed = bad}));
        CHECK_FALSE(is_valid(medium{.attenuation = bad}));
        CHECK_FALSE(is_valid(medium{.attenuation_power = bad}));
        CHECK_FALSE(is_valid(medium{.backscatter = bad}));
        CHECK_FALSE(is_valid(medium{.roughness = bad}));
    }
    CHECK_FALSE(is_valid(medium{.density = 0}));
    CHECK_FALSE(is_valid(medium{.sound_speed = 0}));
    CHECK(is_valid(medium{.density = 1e9F, .sound_speed = 0.9e9F}));
    CHECK_FALSE(is_valid(medium{.density = 1e9F, .sound_speed = 1.1e9F})); // its impedance
    CHECK(is_valid(medium{.density = 1e-9F, .sound_speed = 1.1e-9F}));
    CHECK_FALSE(is_valid(medium{.density = 1e-9F, .sound_speed = 0.9e-9F}));
    CHECK_FALSE(is_valid(medium{.density = 1e19F, .sound_speed = 1e-9F}));
    CHECK_FALSE(is_valid(medium{.density = 1e9F, .sound_speed = 1e-19F}));
}

} // namespace medium_test
