#ifndef INSONIFY_TESTS_TRACING_ECHOES_HPP
#define INSONIFY_TESTS_TRACING_ECHOES_HPP

#include <insonify/probe/line_grid.hpp>
#include <cmath>
#include <vector>

/// Finds the single echoes of a line before it is convolved: each is divided linearly between two samples.
namespace echoes_test {

struct echo {
    double amplitude, depth; // depth in metres
    double decibels() const { return 20 * std::log10(amplitude); }
};

inline std::vector<echo> echoes_of(const insonify::iq_lines& lines, std::uint32_t line) {
    std::vector<echo> found;
    const double spacing = static_cast<double>(lines.depth) / lines.samples;
    for (std::uint32_t k = 0; k < lines.samples; ++k) {
        const double upper = glm::length(glm::dvec2{lines(line, k)});
        if (upper == 0) continue;
        const double lower = k + 1 < lines.samples ? glm::length(glm::dvec2{lines(line, k + 1)}) : 0;
        found.push_back({upper + lower, (k + 0.5 + lower / (upper + lower)) * spacing});
        ++k;
    }
    return found;
}

} // namespace echoes_test

#endif
