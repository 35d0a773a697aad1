#ifndef INSONIFY_PROBE_LINE_GRID_HPP
#define INSONIFY_PROBE_LINE_GRID_HPP

#include <insonify/core/math.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// What lies along the lines of a probe: `count` lines of `samples` values each, line after line.
///
/// Sample k of a line stands at depth (k + 1/2) / samples * depth.
template <class Value>
struct line_grid {
    std::uint32_t count = 0;     ///< lines
    std::uint32_t samples = 0;   ///< along each line
    float depth = 0;             ///< metres from the face to the end of the last sample
    std::vector<Value> values{}; ///< line after line

    line_grid() = default;
    /// Values as `Value{}` makes them: zeros.
    line_grid(std::uint32_t lines, std::uint32_t samples_per_line, float end_depth)
        : count{lines}, samples{samples_per_line}, depth{end_depth},
          values(static_cast<std::size_t>(lines) * samples_per_line) {}

    /// Another shape in the same memory: values that were there are left where they are.
    void reshape(std::uint32_t lines, std::uint32_t samples_per_line, float end_depth) {
        count = lines;
        samples = samples_per_line;
        depth = end_depth;
        values.resize(static_cast<std::size_t>(lines) * samples_per_line);
    }

    /// One value; neither index is checked.
    /// @{
    Value& operator()(std::uint32_t line, std::uint32_t sample) {
        return values[static_cast<std::size_t>(line) * samples + sample];
    }
    const Value& operator()(std::uint32_t line, std::uint32_t sample) const {
        return values[static_cast<std::size_t>(line) * samples + sample];
    }
    /// @}

    friend bool operator==(const line_grid&, const line_grid&) = default;
};

/// Says which object: its `object_id` as a number.
using label_id = std::uint32_t;

/// The label of what lies in no object, and of pixels outside the field of view.
inline constexpr label_id background_label = ~0U;

using scan_lines = line_grid<float>;     ///< real values: intensity, envelope, or grey after `log_compress`
using iq_lines = line_grid<vec2>;        ///< complex values at baseband: x in phase, y in quadrature
using label_lines = line_grid<label_id>; ///< which object lies there

} // namespace insonify::inline INSONIFY_ABI
#endif
