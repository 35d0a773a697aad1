#include <insonify/image/grey_map.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

TEST_CASE("grey_map: the default is the identity") {
    for (const float grey : {0.0F, 0.1F, 0.5F, 1.0F}) CHECK(grey_map{}(grey) == grey);
    CHECK(grey_map{}(-1) == 0);
    CHECK(grey_map{}(2) == 1);
}

TEST_CASE("grey_map: curves increase from black to white") {
    for (const grey_map& map : {grey_map{.gamma = 0.4F}, grey_map{.gamma = 2.2F}, grey_map{.contrast = 1},
                                grey_map{.gamma = 0.8F, .contrast = 0.5F}}) {
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

TEST_CASE("grey_map: a power law, and an S-curve that preserves middle grey") {
    CHECK(grey_map{.gamma = 2}(0.3F) == doctest::Approx(0.09).scale(1e-30));
    CHECK(grey_map{.gamma = 0.5F}(0.25F) == doctest::Approx(0.5).scale(1e-30));
    CHECK(grey_map{.contrast = 0.7F}(0.5F) == doctest::Approx(0.5).scale(1e-30));
    CHECK(grey_map{.contrast = 1}(0.25F) == doctest::Approx(0.15625).scale(1e-30)); // 3/16 - 2/64
    CHECK(grey_map{.contrast = 1}(0.75F) == doctest::Approx(0.84375).scale(1e-30));
}

TEST_CASE("grey_map: every pixel of an image is mapped") {
    image picture{{70, 80}};
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = static_cast<float>(i % 101) / 100;
    const image mapped = map_grey(exec::par, picture, {.gamma = 2});
    CHECK(mapped.size == picture.size);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
        REQUIRE(mapped.pixels[i] == doctest::Approx(picture.pixels[i] * picture.pixels[i]).scale(1e-30));
}

TEST_CASE("grey_map: settings out of range are refused") {
    const float not_a_number = std::numeric_limits<float>::quiet_NaN();
    for (const float bad : {0.0F, -1.0F, std::numeric_limits<float>::infinity(), not_a_number})
        CHECK_THROWS_AS(map_grey(exec::seq, image{}, {.gamma = bad}), usage_error);
    for (const float bad : {-0.1F, 1.1F, not_a_number})
        CHECK_THROWS_AS(map_grey(exec::seq, image{}, {.contrast = bad}), usage_error);
}
