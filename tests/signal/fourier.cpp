#include <insonify/core/random.hpp>
#include <insonify/signal/fourier.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace fourier_test {
namespace {

using number = std::complex<double>;

std::vector<number> of_lane(const std::vector<detail::complex_block>& values, std::size_t lane) {
    std::vector<number> numbers;
    for (const detail::complex_block& one : values)
        numbers.emplace_back(static_cast<double>(one.x[lane]), static_cast<double>(one.y[lane]));
    return numbers;
}

} // namespace

TEST_CASE("fourier: as the sum that defines it, and back") {
    for (const std::size_t size : {1U, 2U, 3U, 8U, 12U, 18U, 64U, 72U, 96U}) {
        const detail::fourier transform{size};
        std::vector<detail::complex_block> values(size), room(size);
        for (std::size_t i = 0; i < size; ++i)
            for (std::size_t lane = 0; lane < detail::complex_batch::width; ++lane) {
                const vec2 value = hash_normal(lane, i);
                values[i].x[lane] = value.x;
                values[i].y[lane] = value.y;
            }
        const std::vector<detail::complex_block> before = values;
        transform.forward(values, room);
        const std::vector<detail::complex_block> spectra = values;
        transform.inverse(values, room);
        for (std::size_t lane = 0; lane < detail::complex_batch::width; ++lane) {
            const std::vector<number> x = of_lane(before, lane), spectrum = of_lane(spectra, lane),
                                      back = of_lane(values, lane);
            double worst = 0;
            for (std::size_t n = 0; n < size; ++n) {
                number sum = 0;
                for (std::size_t k = 0; k < size; ++k)
                    sum += x[k] * std::polar(1.0, -2 * std::acos(-1.0) * static_cast<double>(k * n % size) /
                                                      static_cast<double>(size));
                worst = std::max(worst, std::abs(sum - spectrum[n]));
                worst = std::max(worst, std::abs(x[n] - back[n] / static_cast<double>(size)));
            }
            CHECK(worst < 2e-6 * std::sqrt(2 * static_cast<double>(size)));
        }
    }
}

TEST_CASE("transform_length: the shortest even 2^k 3^m, m at most 2, that holds the values") {
    CHECK(detail::transform_length(0) == 2);
    CHECK(detail::transform_length(5) == 6);
    CHECK(detail::transform_length(64) == 64);
    CHECK(detail::transform_length(65) == 72);
    CHECK(detail::transform_length(1000) == 1024);
    CHECK(detail::transform_length(1025) == 1152);
}

} // namespace fourier_test
