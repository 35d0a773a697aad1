#ifndef INSONIFY_PROBE_LINE_GRID_HPP
#define INSONIFY_PROBE_LINE_GRID_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Values along the scan lines of a probe: `count` lines of `samples` values each.
///
/// Sample k of a line is at depth (k + 1/2) / samples * depth.
template <class Value>
struct line_grid {
    std::uint32_t count = 0;     ///< number of lines
    std::uint32_t samples = 0;   ///< depth samples of each line
    float depth = 0;             ///< from the face to the end of the last sample, metres
    std::vector<Value> values{}; ///< line after line

    line_grid() = default;
    /// All values are `Value{}`, which is zero.
    line_grid(std::uint32_t lines, std::uint32_t samples_per_line, float end_depth)
        : count{lines}, samples{samples_per_line}, depth{end_depth},
          values(static_cast<std::size_t>(lines) * samples_per_line) {}

    /// Changes the shape and reuses the memory; old values are left unchanged.
    void reshape(std::uint32_t lines, std::uint32_t samples_per_line, float end_depth) {
        count = lines;
        samples = samples_per_line;
        depth = end_depth;
        values.resize(static_cast<std::size_t>(lines) * samples_per_line);
    }

    /// One value; indices are not checked.
    Value& operator()(std::uint32_t line, std::uint32_t sample) {
        return values[static_cast<std::size_t>(line) * samples + sample];
    }
    /// The same.
    const Value& operator()(std::uint32_t line, std::uint32_t sample) const {
        return values[static_cast<std::size_t>(line) * samples + sample];
    }

    friend bool operator==(const line_grid&, const line_grid&) = default;
};

namespace detail {

/// @throws usage_error  for echoes that are not those of a probe with so many lines
template <class Value>
void check_echoes(const line_grid<Value>& echoes, std::uint32_t lines, const char* caller) {
    if (echoes.count != lines || echoes.samples == 0 || echoes.values.size() != std::size_t{lines} * echoes.samples)
        throw usage_error{caller, ": the echoes must have as many lines as the probe, and a value for every sample"};
}

} // namespace detail

/// The object at a sample: its `object_id` as a number.
using label_id = std::uint32_t;

/// The label outside all objects, and of pixels outside the field of view.
inline constexpr label_id background_label = ~0U;

using scan_lines = line_grid<float>;     ///< real values: intensity, envelope, or brightness after `log_compress`
using iq_lines = line_grid<vec2>;        ///< complex baseband values: x in phase, y in quadrature
using label_lines = line_grid<label_id>; ///< the object at each sample

/// Depth and sampling of the scan lines.
struct acquisition {
    float depth = 0.08F;       ///< metres, at most 10
    std::uint32_t samples = 0; ///< depth samples of each line; 0: chosen by the model
    std::uint32_t planes = 1;  ///< 1, 3, 5 or 7 elevation planes, which sample the slice thickness
    std::uint32_t frame = 0;   ///< number of the frame: speckle of flowing media (`medium::flowing`) depends on it
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
