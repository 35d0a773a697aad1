#include <insonify/signal/envelope.hpp>
#include <cmath>
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

} // namespace

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
