#include <insonify/core/random.hpp>
#include <insonify/signal/envelope.hpp>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace hilbert_test {
namespace {

/// A burst at the centre of n samples, with `cycles` per sample and its phase shifted by -`turns` cycles.
double burst(std::size_t i, std::size_t n, double cycles, double turns) {
    const double from_middle = static_cast<double>(i) - static_cast<double>(n) / 2;
    const double sigmas = from_middle / (static_cast<double>(n) / 14);
    return std::exp(-sigmas * sigmas / 2) * std::cos(2 * std::acos(-1.0) * (cycles * from_middle - turns));
}

template <int Width>
void check_bursts(std::size_t n) {
    const detail::hilbert_transform transform{n};
    CHECK(transform.size() >= n + n / 4);
    std::vector<float> one(transform.size()), other(transform.size());
    for (std::size_t i = 0; i < n; ++i) {
        one[i] = static_cast<float>(burst(i, n, 0.22, 0.1));
        other[i] = static_cast<float>(3 * burst(i, n, 0.31, 0));
    }
    transform.apply<Width>(one.data(), other.data());
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
        worst = std::max(worst, std::fabs(static_cast<double>(one[i]) - burst(i, n, 0.22, 0.35)));
        worst = std::max(worst, std::fabs(static_cast<double>(other[i]) - 3 * burst(i, n, 0.31, 0.25)));
    }
    CHECK(worst < 1e-5);
}

template <int Width>
void check_sums(std::size_t size) {
    std::vector<float> real, imaginary;
    for (std::uint64_t i = 0; i < size; ++i) {
        const vec2 value = hash_normal(3, i);
        real.push_back(value.x);
        imaginary.push_back(value.y);
    }
    const std::vector<float> x = real, y = imaginary;
    const detail::fourier_transform transform{size};
    transform.forward<Width>(real.data(), imaginary.data());
    double worst = 0;
    for (std::size_t n = 0; n < size; ++n) {
        std::complex<double> sum = 0;
        for (std::size_t k = 0; k < size; ++k)
            sum += std::complex<double>{static_cast<double>(x[k]), static_cast<double>(y[k])} *
                   std::polar(1.0, -2 * std::acos(-1.0) * static_cast<double>(k * n) / static_cast<double>(size));
        const std::size_t at = transform.place(n);
        worst = std::max(worst, std::abs(sum - std::complex<double>{static_cast<double>(real[at]),
                                                                    static_cast<double>(imaginary[at])}));
    }
    MESSAGE("largest difference ", worst, ", expected below 1e-5 of a rms of ",
            std::sqrt(2 * static_cast<double>(size)));
    CHECK(worst < 1e-4);
    transform.back<Width>(real.data(), imaginary.data());
    for (std::size_t k = 0; k < size; ++k) {
        CHECK(real[k] / static_cast<float>(size) == doctest::Approx(x[k]).epsilon(1e-5));
        CHECK(imaginary[k] / static_cast<float>(size) == doctest::Approx(y[k]).epsilon(1e-5));
    }
}

} // namespace

TEST_CASE("fourier_transform: as the sum that defines it, and back") {
    for (const std::size_t size : {1U, 2U, 8U, 64U}) {
        check_sums<1>(size);
        check_sums<simd_width>(size);
    }
}

TEST_CASE("hilbert_transform: shifts bursts by -90 degrees, two at a time") {
    for (const std::size_t n : {200U, 256U, 1000U, 4096U}) {
        check_bursts<1>(n);
        check_bursts<simd_width>(n);
    }
}

TEST_CASE("hilbert_transform: zeros and single samples are legal") {
    for (const std::size_t n : {0U, 1U, 2U, 3U}) {
        const detail::hilbert_transform transform{n};
        std::vector<float> one(transform.size()), other(transform.size());
        transform.apply<simd_width>(one.data(), other.data());
        for (const float value : one) CHECK(value == 0);
    }
}

} // namespace hilbert_test
