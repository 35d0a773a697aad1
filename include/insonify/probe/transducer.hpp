#ifndef INSONIFY_PROBE_TRANSDUCER_HPP
#define INSONIFY_PROBE_TRANSDUCER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/geometry/ray.hpp>
#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>

/// Range checks of settings. Where a value is plausible in another unit the error suggests that unit: "probe: width is
/// 38 m: did you mean 38_mm?". The limits admit all ultrasound, from the testing of concrete to acoustic microscopy.
namespace insonify::inline INSONIFY_ABI {

inline constexpr float max_scan_depth = 10;   ///< of lines, metres
inline constexpr float max_aperture = 1;      ///< of the face of a probe, metres
inline constexpr float min_frequency = 1e3F;  ///< hertz
inline constexpr float max_frequency = 1e10F; ///< hertz

/// @param setting  name of the setting
/// @throws usage_error  for a value outside 1e-9 to 1e12, whose square overflows or underflows, or NaN
inline void check_positive(float value, const char* setting) {
    if (!is_finite(value) || !(value >= 1e-9F && value <= 1e12F))
        throw usage_error{detail::joined(
            {"probe: ", setting, " is ", detail::number_text(value), "; it must be a number from 1e-9 to 1e12"})};
}

/// @param setting  name of the setting
/// @param max      metres
/// @param owner    start of the sentence: who has the setting
/// @throws usage_error  for a length outside 1 nm to `max`, or NaN
inline void check_length(float metres, const char* setting, float max = max_aperture, const char* owner = "probe") {
    if (is_finite(metres) && metres >= 1e-9F && metres <= max) return;
    const std::string text = detail::number_text(metres);
    if (is_finite(metres) && metres > max && 1e-3F * metres <= max)
        throw usage_error{detail::joined({owner, ": ", setting, " is ", text, " m: did you mean ", text, "_mm?"})};
    throw usage_error{detail::joined(
        {owner, ": ", setting, " is ", text, " m; it must be from 1 nm to ", detail::number_text(max), " m"})};
}

/// @throws usage_error  for a depth outside 1 nm to `max_scan_depth`, or NaN
inline void check_depth(float metres, const char* owner) { check_length(metres, "depth", max_scan_depth, owner); }

/// @throws usage_error  for a frequency outside `min_frequency` to `max_frequency`, or NaN
inline void check_frequency(float hertz, const char* owner = "probe") {
    if (is_finite(hertz) && hertz >= min_frequency && hertz <= max_frequency) return;
    const std::string text = detail::number_text(hertz);
    if (is_finite(hertz) && hertz < min_frequency && 1e6F * hertz >= min_frequency)
        throw usage_error{detail::joined({owner, ": frequency is ", text, " Hz: did you mean ", text, "_MHz?"})};
    throw usage_error{detail::joined({owner, ": frequency is ", text, " Hz; it must be from 1 kHz to 10 GHz"})};
}

/// @param max  radians
/// @throws usage_error  for an angle outside 1e-9 rad to `max`, or NaN
inline void check_angle(float radians, const char* setting, float max, const char* owner) {
    if (is_finite(radians) && radians >= 1e-9F && radians <= max) return;
    const float degrees = 180 / pi * max;
    const std::string text = detail::number_text(radians);
    if (is_finite(radians) && radians > max && radians <= degrees)
        throw usage_error{detail::joined({owner, ": ", setting, " is ", text, " rad: did you mean ", text, "_deg?"})};
    throw usage_error{detail::joined({owner, ": ", setting, " is ", text, " rad; it must be from 1e-9 rad to ",
                                      detail::number_text(degrees), "_deg"})};
}

/// A probe: scan lines in the slice plane y = 0 of the probe frame.
///
/// Probe frame: x lateral, y elevation, z depth; the face is at z = 0 in the centre of the array.
/// - `std::uint32_t lines`, `float frequency` (hertz): data members.
/// - `ray beam(float line) const`: starts at the face, with a direction of length 1. Line i of N is at the fraction
///   (i + 1/2) / N - 1/2 of the aperture or field of view. `line` may be fractional; the field of view extends from
///   -1/2 to N - 1/2.
/// - `vec2 locate(vec2 point) const`: the inverse, from {x, z} in metres to {line, depth along the line in metres},
///   also outside the field of view.
/// - `void check() const`: throws usage_error for settings out of range.
/// Mark `beam` and `locate` INSONIFY_FN to use them on a device. With an == of its own, a probe's tables are computed
/// once, not for every frame.
template <class Probe>
concept transducer = requires(const Probe& probe, float line, vec2 point) {
    { probe.lines } -> std::same_as<const std::uint32_t&>;
    { probe.frequency } -> std::same_as<const float&>;
    { probe.beam(line) } -> std::same_as<ray>;
    { probe.locate(point) } -> std::same_as<vec2>;
    probe.check();
};

/// Position of a (fractional) line as a fraction of the aperture or field of view, -1/2 to 1/2.
INSONIFY_FN constexpr float aperture_fraction(float line, std::uint32_t lines) {
    return (line + 0.5F) / static_cast<float>(lines) - 0.5F;
}
/// The (fractional) line at a fraction of the aperture or field of view.
INSONIFY_FN constexpr float line_at_fraction(float fraction, std::uint32_t lines) {
    return (fraction + 0.5F) * static_cast<float>(lines) - 0.5F;
}

/// True for a field of view of 360 degrees, where the last line is next to the first.
template <transducer Probe>
INSONIFY_FN bool is_full_circle(const Probe& probe) {
    if (probe.lines < 2) return false;
    const ray begin = probe.beam(-0.5F), end = probe.beam(static_cast<float>(probe.lines) - 0.5F);
    return length(end.direction - begin.direction) < 1e-4F &&
           length(end.origin - begin.origin) <= 1e-4F * length(begin.origin);
}

/// Fractional bandwidth of a probe at -6 dB: its `bandwidth`; that of a pulse of 2.5 cycles for a probe without that member.
template <transducer Probe>
INSONIFY_FN constexpr float fractional_bandwidth(const Probe& probe) {
    if constexpr (requires { probe.bandwidth; })
        return probe.bandwidth;
    else
        return 0.644F;
}

/// Checks `lines`, `frequency` and, where the probe has them, `fnumber`, `focus`, `elevation_height`, `elevation_focus`,
/// `bandwidth` and `side_lobes`.
/// @throws usage_error  naming a setting that is out of range
template <class Array>
void check_array(const Array& array) {
    if (array.lines == 0) throw usage_error{"probe: lines is 0; it must be at least 1"};
    check_frequency(array.frequency);
    if constexpr (requires { array.fnumber; }) check_positive(array.fnumber, "fnumber");
    if constexpr (requires { array.focus; })
        if (array.focus != 0) check_length(array.focus, "focus", max_scan_depth); // 0: half the depth of the picture
    if constexpr (requires { array.elevation_height; }) check_length(array.elevation_height, "elevation_height");
    if constexpr (requires { array.elevation_focus; })
        check_length(array.elevation_focus, "elevation_focus", max_scan_depth);
    if constexpr (requires { array.bandwidth; }) check_positive(array.bandwidth, "bandwidth");
    if constexpr (requires { array.side_lobes; })
        if (!(array.side_lobes >= 0 && array.side_lobes <= 0.2F))
            throw usage_error{"probe: side_lobes is " + detail::number_text(array.side_lobes) +
                              "; it must be an amplitude of 0 (none) to 0.2, and 0.047 (-26.5 dB) is that of a "
                              "rectangular aperture"};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
