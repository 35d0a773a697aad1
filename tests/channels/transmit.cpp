#include <insonify/channels/transmit.hpp>
#include <insonify/core/units.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

TEST_CASE("transmits: delays make the wave front that they state") {
    const element_array array{.elements = 32};
    const auto first_fires_at_0 = [](const transmit& one) {
        return *std::min_element(one.delays.begin(), one.delays.end()) == 0;
    };
    const std::vector<transmit> plane = plane_waves(array, 3, 20_deg);
    REQUIRE(plane.size() == 3);
    CHECK(plane[0].angle == doctest::Approx(-10 * pi / 180).scale(1e-30));
    CHECK(plane[1].angle == 0);
    for (const transmit& one : plane) {
        CHECK(first_fires_at_0(one));
        const float expected = std::fabs(std::sin(one.angle)) * 31 * array.pitch / 1540;
        CHECK(*std::max_element(one.delays.begin(), one.delays.end()) == doctest::Approx(expected).scale(1e-9));
    }
    CHECK(plane[2].delays.back() > plane[2].delays.front()); // towards x: the elements on the left fire first

    const std::vector<vec3> foci{{1_mm, 0, 20_mm}};
    const transmit narrow = focused(array, foci, 4)[0], whole = focused(array, foci)[0];
    CHECK(std::count(narrow.weights.begin(), narrow.weights.end(), 1.0F) ==
          doctest::Approx(5.0 / 0.3).scale(1e-30).epsilon(0.1));
    CHECK(whole.weights.empty());
    for (std::uint32_t i = 1; i < array.elements; ++i) // all waves arrive at once
        CHECK(whole.delays[i] + length(foci[0] - array.element(i).origin) / 1540 ==
              doctest::Approx(whole.delays[0] + length(foci[0] - array.element(0).origin) / 1540).scale(1e-30));

    const std::vector<vec3> sources{{0, 0, -5_mm}};
    const transmit spread = diverging_waves(array, sources)[0];
    CHECK(first_fires_at_0(spread));
    CHECK(spread.delays[0] == doctest::Approx((std::hypot(15.5F * 0.3e-3F, 5e-3F) - std::hypot(0.15e-3F, 5e-3F)) / 1540)
                                  .scale(1e-30)
                                  .epsilon(1e-3));

    const std::vector<transmit> each = full_synthetic_aperture(array);
    REQUIRE(each.size() == 32);
    CHECK(each[7].weights[7] == 1);
    CHECK(std::count(each[7].weights.begin(), each[7].weights.end(), 0.0F) == 31);
}

TEST_CASE("transmits and arrays: what is out of range is named") {
    const element_array array{};
    const std::vector<vec3> in_front{{0, 0, 1_mm}}, behind{{0, 0, -1_mm}};
    CHECK_THROWS_AS(plane_waves(array, 0, 0.1F), usage_error);
    CHECK_THROWS_AS(plane_waves(array, 3, 20), usage_error);
    CHECK_THROWS_AS(diverging_waves(array, in_front), usage_error);
    CHECK_THROWS_AS(focused(array, behind), usage_error);
    CHECK_THROWS_AS(focused(array, in_front, -1), usage_error);
    CHECK_THROWS_AS((convex_element_array{.elements = 400}.check()), usage_error);
    CHECK_THROWS_AS((element_array{.sound_speed = 1.54F}.check()), usage_error);
    CHECK_THROWS_AS((element_array{.bandwidth = 0}.check()), usage_error);
    CHECK_THROWS_AS((element_array{.pitch = 3}.check()), usage_error);
    CHECK_THROWS_AS((element_array{.fnumber = 0}.check()), usage_error);
    for (const element_array& one : {presets::l11_5v_elements, presets::l12_3v_elements, presets::p4_2v_elements})
        CHECK_NOTHROW(one.check());
    CHECK_NOTHROW(presets::c5_2v_elements.check());
    static_assert(element_transducer<element_array> && element_transducer<convex_element_array>);
}
