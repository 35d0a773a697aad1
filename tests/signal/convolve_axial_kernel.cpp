#include <insonify/core/random.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

TEST_CASE("axial_kernel: a Gaussian with peak 1 and zero padding, each result at the centre of its samples") {
    for (const std::size_t decimation : {1U, 2U, 3U, 4U})
        for (const std::size_t samples : {12U, 24U, 300U})
            for (const float sigma : {1.0F, 4.3F, 20.0F}) {
                detail::axial_kernel kernel;
                kernel.set(samples, {.sigma = sigma}, decimation);
                const std::size_t count = samples / decimation;
                std::vector<vec2> line(samples), layout(kernel.layout_size()), results(count), wide(count);
                for (std::size_t i = 0; i < samples; ++i) line[i] = hash_normal(samples, i);
                kernel.lay_out(line.data(), layout.data());
                kernel.apply<1>(layout.data(), results.data());
                kernel.apply<simd_width>(layout.data(), wide.data());
                for (std::size_t k = 0; k < count; ++k) {
                    const double middle = (static_cast<double>(k) + 0.5) * static_cast<double>(decimation) - 0.5;
                    double x = 0, y = 0;
                    for (std::size_t i = 0; i < samples; ++i) {
                        const double sigmas = (static_cast<double>(i) - middle) / static_cast<double>(sigma);
                        const double weight = std::exp(-sigmas * sigmas / 2);
                        x += weight * static_cast<double>(line[i].x);
                        y += weight * static_cast<double>(line[i].y);
                    }
                    for (const vec2 result : {results[k], wide[k]}) { // the kernel is truncated at 4 sigma: 3.4e-4
                        REQUIRE(std::fabs(static_cast<double>(result.x) - x) < 5e-3);
                        REQUIRE(std::fabs(static_cast<double>(result.y) - y) < 5e-3);
                    }
                }
            }
}

TEST_CASE("axial_kernel: the impulse response is the Gaussian") {
    for (const std::size_t decimation : {1U, 2U, 3U}) {
        constexpr float sigma = 5;
        detail::axial_kernel kernel;
        kernel.set(120, {.sigma = sigma}, decimation);
        std::vector<vec2> line(120), layout(kernel.layout_size()), results(120 / decimation);
        line[61] = {1, -2};
        kernel.lay_out(line.data(), layout.data());
        kernel.apply<simd_width>(layout.data(), results.data());
        for (std::size_t k = 0; k < results.size(); ++k) {
            const double sigmas = ((static_cast<double>(k) + 0.5) * static_cast<double>(decimation) - 61.5) / 5;
            const double expected = std::fabs(sigmas) <= 4 ? std::exp(-sigmas * sigmas / 2) : 0;
            CHECK(std::fabs(static_cast<double>(results[k].x) - expected) < 1e-6);
            CHECK(std::fabs(static_cast<double>(results[k].y) + 2 * expected) < 1e-6);
        }
    }
}

TEST_CASE("axial_kernel: the ring-down follows an echo, and what is before it stays") {
    for (const std::size_t decimation : {1U, 2U}) {
        constexpr float sigma = 4;
        constexpr std::size_t samples = 240, echo = 100;
        const auto response = [&](float ring_down) {
            detail::axial_kernel kernel;
            kernel.set(samples, {.sigma = sigma, .ring_down = ring_down}, decimation);
            std::vector<vec2> line(samples), layout(kernel.layout_size()), results(samples / decimation);
            line[echo] = {1, 0};
            kernel.lay_out(line.data(), layout.data());
            kernel.apply<simd_width>(layout.data(), results.data());
            return results;
        };
        const std::vector<vec2> plain = response(0), ringing = response(0.2F);
        const std::size_t last_before = echo / decimation - 1,
                          behind = (echo + static_cast<std::size_t>(3 * sigma)) / decimation;
        for (std::size_t k = 0; k <= last_before; ++k) CHECK(ringing[k] == plain[k]);
        CHECK(ringing[behind].x > 0.2F * std::exp(-3 / 2.5F) * 0.9F); // three standard deviations deeper
        CHECK(ringing[samples / decimation - 1].x == 0);
    }
}
