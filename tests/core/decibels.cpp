#include <insonify/core/decibels.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace decibels_test {

TEST_CASE("decibels: the amplitude ratio of a level is 10^(level / 20)") {
    static_assert(amplitude_of_decibels(0) == 1.0F && amplitude_of_decibels(20) == 10.0F);
    CHECK(amplitude_of_decibels(0.0F) == 1.0F);
    for (int level = -300; level <= 300; level += 5) {
        const double expected = std::pow(10.0, level / 20.0);
        CHECK(static_cast<double>(amplitude_of_decibels(level)) == doctest::Approx(expected).epsilon(1e-6));
        CHECK(static_cast<double>(amplitude_of_decibels(static_cast<float>(level))) ==
              doctest::Approx(expected).epsilon(1e-5));
    }
    CHECK(amplitude_of_decibels(-6.5F) == doctest::Approx(std::pow(10.0, -6.5 / 20)).epsilon(1e-6));
}

} // namespace decibels_test
