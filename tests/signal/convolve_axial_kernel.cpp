#include <insonify/core/random.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace {

template <int Width>
std::vector<vec2> filtered(const std::vector<vec2>& line, float sigma) {
    detail::axial_kernel kernel;
    kernel.set(line.size(), {.sigma = sigma});
    std::vector<vec2> padded(kernel.padded_size(), vec2{0, 0}), results = line;
    kernel.apply<Width>(results.data(), padded.data(), results.data());
    return results;
}

} // namespace

TEST_CASE("axial_kernel: a Gaussian with peak 1 and zero padding") {
    for (const std::size_t samples : {1U, 12U, 24U, 31U, 32U, 33U, 300U})
        for (const float sigma : {1.0F, 4.3F, 20.0F}) {
            std::vector<vec2> line(samples);
            for (std::size_t i = 0; i < samples; ++i) line[i] = hash_normal(samples, i);
            const std::vector<vec2> narrow = filtered<1>(line, sigma), wide = filtered<simd_width>(line, sigma);
            for (std::size_t k = 0; k < samples; ++k) {
                double x = 0, y = 0;
                for (std::size_t i = 0; i < samples; ++i) {
                    const double sigmas =
                        (static_cast<double>(i) - static_cast<double>(k)) / static_cast<double>(sigma);
                    const double weight = std::exp(-sigmas * sigmas / 2);
                    x += weight * static_cast<double>(line[i].x);
                    y += weight * static_cast<double>(line[i].y);
                }
                for (const vec2 result : {narrow[k], wide[k]}) { // the kernel is truncated at 4 sigma: 3.4e-4
                    REQUIRE(std::fabs(static_cast<double>(result.x) - x) < 5e-3);
                    REQUIRE(std::fabs(static_cast<double>(result.y) - y) < 5e-3);
                }
            }
        }
}

TEST_CASE("axial_kernel: the impulse response is the Gaussian") {
    std::vector<vec2> line(120);
    line[61] = {1, -2};
    const std::vector<vec2> results = filtered<simd_width>(line, 5);
    for (std::size_t k = 0; k < results.size(); ++k) {
        const double sigmas = (static_cast<double>(k) - 61) / 5;
        const double expected = std::fabs(sigmas) <= 4 ? std::exp(-sigmas * sigmas / 2) : 0;
        CHECK(std::fabs(static_cast<double>(results[k].x) - expected) < 1e-6);
        CHECK(std::fabs(static_cast<double>(results[k].y) + 2 * expected) < 1e-6);
    }
}
