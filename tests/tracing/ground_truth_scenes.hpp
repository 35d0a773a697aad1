#ifndef INSONIFY_TESTS_TRACING_GROUND_TRUTH_SCENES_HPP
#define INSONIFY_TESTS_TRACING_GROUND_TRUTH_SCENES_HPP

#include <insonify/core/units.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/read/ground_truth.hpp>
#include <cmath>

/// Media and scenes of the tests of ground truth.
namespace ground_truth_test {

using namespace insonify;

inline constexpr linear_array middle_line(float frequency) {
    return {.lines = 1, .width = 1_mm, .frequency = frequency};
}

inline double decibels(float amplitude) { return 20 * std::log10(static_cast<double>(amplitude)); }

} // namespace ground_truth_test

#endif
