#include <insonify/core/random.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>

using namespace insonify;

TEST_CASE("random: hash_uniform has the moments of the uniform distribution, and neighbours are uncorrelated") {
    constexpr std::uint64_t count = 1'000'000;
    for (const std::uint64_t seed : {0ULL, 1ULL, 12345678901234ULL}) {
        double mean = 0, square = 0, product = 0;
        float before = 0.5F;
        for (std::uint64_t i = 0; i < count; ++i) {
            const float x = hash_uniform(seed, i);
            REQUIRE(x >= 0);
            REQUIRE(x < 1);
            mean += x;
            square += static_cast<double>(x) * x;
            product += (x - 0.5) * (before - 0.5);
            before = x;
        }
        CHECK(mean / count == doctest::Approx(0.5).scale(1e-30).epsilon(0.003)); // 3.5 standard errors
        CHECK(square / count == doctest::Approx(1.0 / 3).scale(1e-30).epsilon(0.004));
        CHECK(std::fabs(product / count) < 4.0 / 12 / std::sqrt(double{count})); // 4 standard errors
    }
    CHECK(hash_bits(1, 2) != hash_bits(2, 1));
}

TEST_CASE("random: hash_normal has mean 0, variance 1, kurtosis 3, and independent parts") {
    constexpr std::uint64_t count = 500'000;
    double mean = 0, square = 0, fourth = 0, product = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const vec2 x = hash_normal(7, i);
        REQUIRE(is_finite(x.x));
        REQUIRE(is_finite(x.y));
        mean += static_cast<double>(x.x);
        square += static_cast<double>(x.x) * x.x;
        fourth += std::pow(static_cast<double>(x.x), 4);
        product += static_cast<double>(x.x) * x.y;
    }
    CHECK(std::fabs(mean / count) < 0.006);
    CHECK(square / count == doctest::Approx(1).scale(1e-30).epsilon(0.008));
    CHECK(fourth / count == doctest::Approx(3).scale(1e-30).epsilon(0.02));
    CHECK(std::fabs(product / count) < 0.006);
}
