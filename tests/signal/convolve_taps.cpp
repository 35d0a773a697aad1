#include <insonify/core/random.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

TEST_CASE("taps: a filter is the sum of weights times samples, for any number of taps and samples") {
    std::vector<vec2> from(300);
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = hash_normal(7, i);
    for (const std::size_t number : {0U, 1U, 3U, 4U, 5U, 9U})
        for (const std::size_t count : {0U, 1U, 31U, 32U, 33U, 100U}) {
            std::vector<detail::tap> taps(number);
            for (std::size_t i = 0; i < number; ++i)
                taps[i] = {.weight = hash_normal(8, i).x,
                           .offset = static_cast<std::ptrdiff_t>(hash_uniform(9, i) * 100) - 50};
            std::vector<vec2> one(count + 1, vec2{5, 5}), many(count + 1, vec2{5, 5});
            detail::sum_taps<1>({taps.data(), number}, from.data() + 60, one.data(), count);
            detail::sum_taps<simd_width>({taps.data(), number}, from.data() + 60, many.data(), count);
            for (std::size_t i = 0; i < count; ++i) {
                double x = 0, y = 0;
                for (const detail::tap& t : taps) {
                    const vec2 sample = from[static_cast<std::size_t>(60 + static_cast<std::ptrdiff_t>(i) + t.offset)];
                    x += static_cast<double>(t.weight) * static_cast<double>(sample.x);
                    y += static_cast<double>(t.weight) * static_cast<double>(sample.y);
                }
                for (const vec2 sum : {one[i], many[i]}) {
                    REQUIRE(std::fabs(static_cast<double>(sum.x) - x) < 1e-5);
                    REQUIRE(std::fabs(static_cast<double>(sum.y) - y) < 1e-5);
                }
            }
            CHECK(one[count] == vec2{5, 5}); // memory beyond the results is unchanged
            CHECK(many[count] == vec2{5, 5});
        }
}
