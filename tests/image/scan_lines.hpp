#ifndef INSONIFY_TESTS_IMAGE_SCAN_LINES_HPP
#define INSONIFY_TESTS_IMAGE_SCAN_LINES_HPP

#include <insonify/core/units.hpp>
#include <insonify/image/scan_convert.hpp>
#include <algorithm>

/// Scan lines and probes of the tests of scan conversion.
namespace scan_convert_test {

using namespace insonify;

/// A user's own probe: parallel lines, all steered by 20 degrees.
struct steered_array {
    std::uint32_t lines = 200;
    float frequency = 5_MHz;
    float width = 40_mm;
    ray beam(float line) const {
        return {.origin = {aperture_fraction(line, lines) * width, 0, 0}, .direction = {0.34202014F, 0, 0.93969262F}};
    }
    vec2 locate(vec2 point) const {
        const float depth = point.y / 0.93969262F;
        return {line_at_fraction((point.x - depth * 0.34202014F) / width, lines), depth};
    }
    void check() const {}
};

inline scan_lines filled(std::uint32_t count, std::uint32_t samples, float depth, float value) {
    scan_lines lines{count, samples, depth};
    std::fill(lines.values.begin(), lines.values.end(), value);
    return lines;
}

} // namespace scan_convert_test

#endif
