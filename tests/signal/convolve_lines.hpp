#ifndef INSONIFY_TESTS_SIGNAL_CONVOLVE_LINES_HPP
#define INSONIFY_TESTS_SIGNAL_CONVOLVE_LINES_HPP

#include <insonify/core/random.hpp>
#include <insonify/probe/line_grid.hpp>
#include <cmath>
#include <vector>

/// Lines to convolve, and what is measured on them.
namespace convolve_test {

using namespace insonify;

inline const pulse six_tenths{.cycles = 1.61F / 0.6F}; // fractional bandwidth 0.6

inline iq_lines white_noise(std::uint32_t lines, std::uint32_t samples, float depth, std::uint64_t seed) {
    iq_lines noise{lines, samples, depth};
    for (std::size_t i = 0; i < noise.values.size(); ++i) noise.values[i] = hash_normal(seed, i);
    return noise;
}

/// Full width at half maximum, in steps, with linear interpolation.
inline double half_width(const std::vector<double>& values) {
    std::size_t peak = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i] > values[peak]) peak = i;
    const double half = values[peak] / 2;
    std::size_t right = peak, left = peak;
    while (values[right] > half) ++right;
    while (values[left] > half) --left;
    return static_cast<double>(right) - (half - values[right]) / (values[right - 1] - values[right]) -
           static_cast<double>(left) - (half - values[left]) / (values[left + 1] - values[left]);
}

inline double decibels(double ratio) { return 20 * std::log10(ratio); }

} // namespace convolve_test

#endif
