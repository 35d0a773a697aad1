#include <insonify/execution/policy.hpp>
#include <insonify/signal/fourier.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace analytic_test {
namespace {

/// A burst at the centre of n samples, with `cycles` per sample and its phase shifted by -`turns` cycles.
double burst(std::size_t i, std::size_t n, double cycles, double turns) {
    const double from_middle = static_cast<double>(i) - static_cast<double>(n) / 2;
    const double sigmas = from_middle / (static_cast<double>(n) / 14);
    return std::exp(-sigmas * sigmas / 2) * std::cos(2 * std::acos(-1.0) * (cycles * from_middle - turns));
}

/// Of more signals than two blocks hold: each burst has a level of its own.
constexpr std::size_t signals = 4 * detail::complex_batch::width + 3;
double level(std::size_t signal) { return 0.1 * static_cast<double>(signal + 1); }

std::vector<float> bursts(std::size_t n) {
    std::vector<float> all;
    for (std::size_t signal = 0; signal < signals; ++signal)
        for (std::size_t i = 0; i < n; ++i)
            all.push_back(static_cast<float>(level(signal) * burst(i, n, signal % 2 == 0 ? 0.22 : 0.31, 0.1)));
    return all;
}

template <class Policy>
std::vector<vec2> analytic(const Policy& policy, const std::vector<float>& all, std::size_t samples) {
    std::vector<vec2> found(all.size());
    detail::for_each_analytic(policy, all, samples, [&](std::size_t signal, std::size_t k, vec2 value) {
        found[signal * samples + k] = value;
    });
    return found;
}

} // namespace

TEST_CASE("for_each_analytic: the imaginary part is the burst shifted by -90 degrees, the real part the burst itself") {
    for (const std::size_t n : {200U, 256U, 1000U, 4096U}) {
        const std::vector<float> all = bursts(n);
        const std::vector<vec2> found = analytic(exec::par, all, n);
        double worst = 0;
        std::size_t changed = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const std::size_t signal = i / n;
            const double shifted = level(signal) * burst(i % n, n, signal % 2 == 0 ? 0.22 : 0.31, 0.35);
            changed += found[i].x == all[i] ? 0 : 1;
            worst = std::max(worst, std::fabs(static_cast<double>(found[i].y) - shifted));
        }
        CHECK(changed == 0);
        CHECK(worst < 2e-6 * level(signals));
    }
}

TEST_CASE("for_each_analytic: the end of a signal does not reach its beginning") {
    std::vector<float> all(256, 0.0F);
    all.back() = 1;
    // Of an impulse, 2 / (pi n) at every other distance n: 255, or 65 the other way round, behind a quarter of zeros.
    const std::vector<vec2> found = analytic(exec::seq, all, 256);
    for (std::size_t k = 0; k < 8; ++k) CHECK(std::fabs(found[k].y) < 0.015F);
}

TEST_CASE("for_each_analytic: every policy gives the same to the bit") {
    const std::vector<float> all = bursts(300);
    const std::vector<vec2> expected = analytic(exec::seq, all, 300), other = analytic(exec::par_unseq, all, 300);
    CHECK(std::memcmp(expected.data(), other.data(), expected.size() * sizeof(vec2)) == 0);
}

TEST_CASE("for_each_analytic: none, zeros and single samples are legal") {
    CHECK(analytic(exec::par, {}, 0).empty());
    for (const std::size_t n : {1U, 2U, 3U})
        for (const vec2 value : analytic(exec::par, std::vector<float>(n), n)) CHECK(value == vec2{0, 0});
}

} // namespace analytic_test
