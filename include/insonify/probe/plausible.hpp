#ifndef INSONIFY_PROBE_PLAUSIBLE_HPP
#define INSONIFY_PROBE_PLAUSIBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/text.hpp>
#include <string>

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

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
