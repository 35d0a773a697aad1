#ifndef INSONIFY_PROBE_TRANSDUCER_HPP
#define INSONIFY_PROBE_TRANSDUCER_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/geometry/ray.hpp>
#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>

namespace insonify::inline INSONIFY_ABI {

/// Anything that sends lines into the body; all of them in the slice plane y = 0 of the probe's frame.
///
/// The frame: x lateral, y elevation, z depth, the face at z = 0 in the middle of the array.
/// - `std::uint32_t lines`, `float frequency` (hertz): members;
/// - `ray beam(float line) const`: from the face, in a direction of length 1. Line i of N stands at (i + 1/2) / N - 1/2
///   of the aperture or field of view; `line` may lie between two, and the field ends at -1/2 and N - 1/2;
/// - `vec2 locate(vec2 point) const`, its inverse: from {x, z} in metres to {line, depth along the beam in metres}, also
///   outside the field;
/// - `void check() const`: throws usage_error where the settings make no sense.
/// `beam` and `locate` are marked INSONIFY_FN where they shall run on a device.
template <class Probe>
concept transducer = requires(const Probe& probe, float line, vec2 point) {
    { probe.lines } -> std::same_as<const std::uint32_t&>;
    { probe.frequency } -> std::same_as<const float&>;
    { probe.beam(line) } -> std::same_as<ray>;
    { probe.locate(point) } -> std::same_as<vec2>;
    probe.check();
};

/// Where a (fractional) line stands, as a share of the aperture or field of view: -1/2 to 1/2. And back.
INSONIFY_FN constexpr float share_of_line(float line, std::uint32_t lines) {
    return (line + 0.5F) / static_cast<float>(lines) - 0.5F;
}
/// The line that stands at a share: the inverse.
INSONIFY_FN constexpr float line_of_share(float share, std::uint32_t lines) {
    return (share + 0.5F) * static_cast<float>(lines) - 0.5F;
}

/// True where the field ends where it began: the last line is the neighbour of the first.
template <transducer Probe>
INSONIFY_FN bool is_full_circle(const Probe& probe) {
    if (probe.lines < 2) return false;
    const ray begin = probe.beam(-0.5F), end = probe.beam(static_cast<float>(probe.lines) - 0.5F);
    return length(end.direction - begin.direction) < 1e-4F &&
           length(end.origin - begin.origin) <= 1e-4F * length(begin.origin);
}

/// @throws usage_error  naming the setting, where its value is not above 0, or so small or large that squares overflow
INSONIFY_LAZY void check_positive(float value, const char* setting) {
    if (!is_finite(value) || !(value >= 1e-9F && value <= 1e12F))
        throw usage_error{std::string{"probe: `"} + setting + "` must be a number above 0, between 1e-9 and 1e12"};
}

/// Checks what every array has: lines, frequency, fnumber, focus, elevation_height, elevation_focus and, if there,
/// bandwidth.
/// @throws usage_error  naming the setting that makes no sense
template <class Array>
void check_array(const Array& array) {
    if (array.lines == 0) throw usage_error{"probe: `lines` must be at least 1"};
    check_positive(array.frequency, "frequency");
    check_positive(array.fnumber, "fnumber");
    if (array.focus != 0) check_positive(array.focus, "focus"); // 0: half the depth of the picture
    check_positive(array.elevation_height, "elevation_height");
    check_positive(array.elevation_focus, "elevation_focus");
    if constexpr (requires { array.bandwidth; }) check_positive(array.bandwidth, "bandwidth");
}

} // namespace insonify::inline INSONIFY_ABI
#endif
