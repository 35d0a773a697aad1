#include <insonify/signal/envelope.hpp>
#include <algorithm>
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

void check_bursts(std::size_t n) {
    const detail::hilbert_transform transform{n};
    CHECK(transform.size() >= n + n / 4);
    std::vector<detail::complex_batch> values(transform.size()), room(transform.size());
    constexpr int width = detail::complex_batch::width;
    for (std::size_t i = 0; i < n; ++i)
        values[i] = {each_lane<width>([&](int lane) { return static_cast<float>(lane * burst(i, n, 0.22, 0.1)); }),
                     lanes<width>(static_cast<float>(3 * burst(i, n, 0.31, 0)))};
    transform.apply(values, room);
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
        detail::complex_block at;
        at.store_from(values[i]);
        for (int lane = 0; lane < width; ++lane) {
            worst = std::max(worst, std::fabs(static_cast<double>(at.x[lane]) - lane * burst(i, n, 0.22, 0.35)));
            worst = std::max(worst, std::fabs(static_cast<double>(at.y[lane]) - 3 * burst(i, n, 0.31, 0.25)));
        }
    }
    CHECK(worst < 1e-6 * std::max(10, width));
}

} // namespace

TEST_CASE("hilbert_transform: shifts bursts by -90 degrees, two at a time in each lane") {
    for (const std::size_t n : {200U, 256U, 1000U, 4096U}) check_bursts(n);
}

TEST_CASE("hilbert_transform: zeros and single samples are legal") {
    for (const std::size_t n : {0U, 1U, 2U, 3U}) {
        const detail::hilbert_transform transform{n};
        std::vector<detail::complex_batch> values(transform.size()), room(transform.size());
        transform.apply(values, room);
        for (const detail::complex_batch& one : values) CHECK(reduce_max(abs(one.x) + abs(one.y)) == 0);
    }
}

} // namespace hilbert_test
