#include <insonify/core/units.hpp>
#include <cfloat>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace decibels_test {

TEST_CASE("decibels: the amplitude ratio of a level is 10^(level / 20)") {
    static_assert(amplitude_of_decibels(0) == 1.0F && amplitude_of_decibels(20) == 10.0F);
    CHECK(amplitude_of_decibels(0.0F) == 1.0F);
    for (int level = -300; level <= 300; level += 5) {
        const double expected = std::pow(10.0, level / 20.0);
        CHECK(static_cast<double>(amplitude_of_decibels(static_cast<float>(level))) ==
              doctest::Approx(expected).scale(1e-30).epsilon(1e-5));
    }
    CHECK(amplitude_of_decibels(-6.5F) == doctest::Approx(std::pow(10.0, -6.5 / 20)).scale(1e-30).epsilon(1e-6));
}

TEST_CASE("decibels: levels that are not whole are constant expressions, precise to the last bit but one") {
    constexpr float table[] = {amplitude_of_decibels(-6.5F),  amplitude_of_decibels(0.1F),
                               amplitude_of_decibels(-29.7F), amplitude_of_decibels(-0.001F),
                               amplitude_of_decibels(59.9F),  amplitude_of_decibels(-135.3F),
                               amplitude_of_decibels(300.7F), amplitude_of_decibels(-299.3F)};
    constexpr float levels[] = {-6.5F, 0.1F, -29.7F, -0.001F, 59.9F, -135.3F, 300.7F, -299.3F};
    for (int i = 0; i < 8; ++i) {
        const long double expected = std::pow(10.0L, static_cast<long double>(levels[i]) / 20);
        CHECK(std::fabs(table[i] / expected - 1) < 1.2e-7L);
        CHECK(static_cast<double>(amplitude_of_decibels(levels[i])) ==
              doctest::Approx(static_cast<double>(expected)).scale(1e-30).epsilon(1e-5));
    }
    static_assert(amplitude_of_decibels(20.0F) == 10.0F && amplitude_of_decibels(0.0F) == 1.0F);
    static_assert(amplitude_of_decibels(no_level_db) == 0 && amplitude_of_decibels(FLT_MAX) > FLT_MAX);
}

} // namespace decibels_test
