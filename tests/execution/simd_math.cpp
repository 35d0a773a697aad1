#include <insonify/execution/simd.hpp>
#include <algorithm>
#include <doctest/doctest.h>
#include <limits>

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

TEST_CASE("logarithms are right to 3e-7, those of powers of two exact, and clamped where floats end") {
    constexpr int n = simd_width;
    float x[n] = {}, result[n];
    const auto logarithm = [&](float value) {
        for (float& lane : x) lane = value;
        store(logarithm_of_two<n>(load<n>(x)), result);
        return result[n - 1];
    };
    double worst = 0;
    for (double exponent = -126; exponent < 128; exponent += 0.00173) {
        const auto value = static_cast<float>(std::exp2(exponent));
        const double expected = std::log2(static_cast<double>(value));
        const double error = std::fabs(static_cast<double>(logarithm(value)) - expected);
        worst = std::max(worst, error / std::max(1.0, std::fabs(expected)));
    }
    for (double near_one = 0.5; near_one < 2; near_one += 1.7e-5) {
        const auto value = static_cast<float>(near_one);
        worst =
            std::max(worst, std::fabs(static_cast<double>(logarithm(value)) - std::log2(static_cast<double>(value))));
    }
    MESSAGE("worst error ", worst);
    CHECK(worst < 3e-7);
    for (int exponent = -126; exponent < 128; ++exponent)
        CHECK(logarithm(std::ldexp(1.0F, exponent)) == static_cast<float>(exponent));
    for (const float small : {0.0F, -1.0F, 1e-40F}) CHECK(logarithm(small) == -126);
    CHECK(logarithm(std::numeric_limits<float>::infinity()) == 128);
}

TEST_CASE("a range is taken in whole registers, then one by one, each float once") {
    constexpr int n = simd_width;
    for (std::size_t end = 3; end < 3 + 3 * n; ++end) {
        std::size_t next = 3, single = 0;
        detail::in_registers<n>(3, end, [&](std::size_t i, auto width) {
            CHECK(i == next);
            next += width;
            single += width == 1;
        });
        CHECK(next == end);
        CHECK(single == (n == 1 ? end - 3 : (end - 3) % n));
    }
}

TEST_CASE("cosines and sines of lanes of turns are right to 2e-7") {
    double worst = 0;
    for (double turns = -0.5; turns <= 0.5; turns += 1e-4) {
        const detail::turned_lanes<4> found{lanes<4>(static_cast<float>(turns))};
        const double angle = 2 * std::acos(-1.0) * static_cast<double>(static_cast<float>(turns));
        float x[4], y[4];
        store(found.x, x);
        store(found.y, y);
        worst = std::max({worst, std::fabs(static_cast<double>(x[3]) - std::cos(angle)),
                          std::fabs(static_cast<double>(y[3]) - std::sin(angle))});
    }
    MESSAGE("worst error ", worst);
    CHECK(worst < 2e-7);
}
