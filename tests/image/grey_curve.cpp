#include <insonify/image/grey_map.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

TEST_CASE("grey_map: reject and shoulder keep black, white and the order of levels") {
    for (const grey_map& map : {grey_map{.reject = 0.35F}, grey_map{.shoulder = 0.7F},
                                grey_map{.gamma = 0.8F, .contrast = 0.3F, .reject = 0.2F, .shoulder = 0.85F}}) {
        CHECK(map(0) == 0);
        CHECK(map(1) == doctest::Approx(1).scale(1e-30));
        float before = 0;
        for (int i = 1; i <= 1000; ++i) {
            const float grey = map(static_cast<float>(i) / 1000);
            REQUIRE(grey > before);
            before = grey;
        }
    }
}

TEST_CASE("grey_map: below `reject` nearly flat, above `shoulder` half as steep, bent softly between") {
    const auto slope = [](const grey_map& map, float g) { return (map(g + 0.005F) - map(g - 0.005F)) / 0.01F; };
    // Far from the bends b has the slopes 0 and 1, and 1 and 1/2; near-hyperbolas have 1/2 and 3/4 at the bend.
    const grey_map toe{.reject = 0.5F, .softness = 0.02F}, knee{.shoulder = 0.5F, .softness = 0.02F};
    const float steep = slope(toe, 0.8F), full = slope(knee, 0.2F);
    MESSAGE("slopes over the full one: ", slope(toe, 0.2F) / steep, ", expected 0; ", slope(toe, 0.5F) / steep,
            ", expected 0.5; ", slope(knee, 0.8F) / full, ", expected 0.5; ", slope(knee, 0.5F) / full,
            ", expected 0.75");
    CHECK(std::fabs(slope(toe, 0.2F) / steep) < 0.01F);
    CHECK(slope(toe, 0.5F) / steep == doctest::Approx(0.5).scale(1e-30).epsilon(0.02));
    CHECK(slope(knee, 0.8F) / full == doctest::Approx(0.5).scale(1e-30).epsilon(0.02));
    CHECK(slope(knee, 0.5F) / full == doctest::Approx(0.75).scale(1e-30).epsilon(0.02));
    CHECK(steep == doctest::Approx(2).scale(1e-30).epsilon(0.01)); // from 0 at 0.5 to 1 at 1
}

TEST_CASE("grey_map: the brightness along lines is mapped as pixels are") {
    const grey_map map{.gamma = 1.2F, .contrast = 0.5F, .reject = 0.2F};
    scan_lines lines{5, 1000, 0.04F};
    for (std::size_t i = 0; i < lines.values.size(); ++i) lines.values[i] = static_cast<float>(i % 101) / 100;
    const scan_lines mapped = map_grey(exec::par, lines, map);
    CHECK(mapped.count == 5);
    for (std::size_t i = 0; i < lines.values.size(); ++i) REQUIRE(mapped.values[i] == map(lines.values[i]));
}

TEST_CASE("grey_map: bends out of range are refused") {
    const float not_a_number = std::numeric_limits<float>::quiet_NaN();
    for (const float bad : {-0.1F, 1.0F, not_a_number})
        CHECK_THROWS_AS(map_grey(exec::seq, image{}, {.reject = bad}), usage_error);
    for (const float bad : {0.0F, 1.1F, not_a_number}) {
        CHECK_THROWS_AS(map_grey(exec::seq, image{}, {.shoulder = bad}), usage_error);
        CHECK_THROWS_AS(map_grey(exec::seq, image{}, {.softness = bad}), usage_error);
    }
}
