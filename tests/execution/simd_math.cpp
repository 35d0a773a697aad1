#include <insonify/execution/simd_math.hpp>
#include <algorithm>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("powers of two are right to 2e-7, whole ones exact, and clamped where floats end") {
    constexpr int n = simd_width;
    float x[n] = {}, result[n];
    double worst = 0;
    for (double exponent = -126; exponent <= 126; exponent += 0.00173) {
        for (float& value : x) value = static_cast<float>(exponent);
        store(power_of_two<n>(load<n>(x)), result);
        const double expected = std::exp2(static_cast<double>(x[0]));
        worst = std::max(worst, std::fabs(static_cast<double>(result[n - 1]) - expected) / expected);
    }
    MESSAGE("worst relative error ", worst);
    CHECK(worst < 2e-7);
    for (int exponent = -126; exponent <= 126; ++exponent) {
        x[0] = static_cast<float>(exponent);
        store(power_of_two<n>(load<n>(x)), result);
        CHECK(result[0] == std::ldexp(1.0F, exponent));
    }
    x[0] = -1000;
    store(power_of_two<n>(load<n>(x)), result);
    CHECK(result[0] == std::ldexp(1.0F, -126));
}
