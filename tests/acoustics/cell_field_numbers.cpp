#include <insonify/acoustics/scatterers/cell_field.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace scatter_numbers_test {
namespace {
struct moments {
    double power = 0, real = 0, imaginary = 0, product = 0, fourth = 0;
};
template <class Numbers>
moments of(const Numbers& numbers, float volume, float stated = 0) {
    constexpr std::uint32_t draws = 400'000;
    moments m;
    for (std::uint32_t i = 0; i < draws; i += simd_width) {
        float real[simd_width], imaginary[simd_width];
        const auto some = numbers.template operator()<simd_width>(steps_of_bits<simd_width>(i, 1), volume, stated);
        store(some.real, real);
        store(some.imaginary, imaginary);
        for (int k = 0; k < simd_width; ++k) {
            const double x = static_cast<double>(real[k]), y = static_cast<double>(imaginary[k]), p = x * x + y * y;
            m.power += p / draws, m.real += x / draws, m.imaginary += y / draws, m.product += x * y / draws;
            m.fourth += p * p / draws;
        }
    }
    return m;
}
} // namespace
} // namespace scatter_numbers_test

TEST_CASE("gaussian_numbers: mean 0, power 1, independent parts; the same on one lane as on many") {
    const auto m = scatter_numbers_test::of(gaussian_numbers{}, 1);
    CHECK(m.power == doctest::Approx(1).epsilon(0.005).scale(1e-30));
    for (const double zero : {m.real, m.imaginary, m.product}) CHECK(std::fabs(zero) < 0.005);
    float one = 0, many[simd_width];
    for (std::uint32_t i = 0; i < 100; ++i) {
        store(gaussian_numbers{}.operator()<1>(steps_of_bits<1>(i, 0), 1, 0).real, &one);
        store(gaussian_numbers{}.operator()<simd_width>(steps_of_bits<simd_width>(i, 0), 1, 0).real, many);
        CHECK(one == many[simd_width - 1]);
    }
}

TEST_CASE("poisson_numbers: power 1, and the fourth moment of the stated density") {
    // The fourth moment of a Poisson number of terms with normal amplitude and random phase is 2 + 3 / mean number.
    for (const float mean : {0.5F, 2.0F, 8.0F}) {
        const auto m = scatter_numbers_test::of(poisson_numbers{.density = mean * 1e9F}, 1e-9F);
        CHECK(m.power == doctest::Approx(1).epsilon(0.02).scale(1e-30));
        CHECK(m.fourth == doctest::Approx(2 + 3 / static_cast<double>(mean)).epsilon(0.05).scale(1e-30));
    }
    for (const float mean : {40.0F, 5000.0F}) { // indistinguishable from Gaussian numbers
        const auto m = scatter_numbers_test::of(poisson_numbers{.density = mean * 1e9F}, 1e-9F);
        CHECK(m.power == doctest::Approx(1).epsilon(0.02).scale(1e-30));
    }
    const auto stated = scatter_numbers_test::of(poisson_numbers{}, 1e-9F, 2e9F);
    CHECK(stated.fourth == doctest::Approx(3.5).epsilon(0.05).scale(1e-30));
    CHECK_THROWS_AS(poisson_numbers{.density = 0}.check(), usage_error);
}
