#ifndef INSONIFY_PROBE_TRANSDUCER_HPP
#define INSONIFY_PROBE_TRANSDUCER_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/memo.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/ray.hpp>
#include <cmath>
#include <concepts>
#include <cstdint>

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
        throw usage_error{"probe: ", setting, " is ", value, "; it must be a number from 1e-9 to 1e12"};
}

/// @param setting  name of the setting
/// @param max      metres
/// @param owner    start of the sentence: who has the setting
/// @throws usage_error  for a length outside 1 nm to `max`, or NaN
inline void check_length(float metres, const char* setting, float max = max_aperture, const char* owner = "probe") {
    constexpr float rounding = 1e-6F; // 20 * 1_mm is more than 0.02F
    if (is_finite(metres) && metres >= 1e-9F && metres <= (1 + rounding) * max) return;
    if (is_finite(metres) && metres > max && 1e-3F * metres <= max)
        throw usage_error{owner, ": ", setting, " is ", metres, " m: did you mean ", metres, "_mm?"};
    throw usage_error{owner, ": ", setting, " is ", metres, " m; it must be from 1 nm to ", max, " m"};
}

/// @throws usage_error  for a depth outside 1 nm to `max_scan_depth`, or NaN
inline void check_depth(float metres, const char* owner) { check_length(metres, "depth", max_scan_depth, owner); }

/// @throws usage_error  for a frequency outside `min_frequency` to `max_frequency`, or NaN
inline void check_frequency(float hertz, const char* owner = "probe") {
    if (is_finite(hertz) && hertz >= min_frequency && hertz <= max_frequency) return;
    if (is_finite(hertz) && hertz < min_frequency && 1e6F * hertz >= min_frequency)
        throw usage_error{owner, ": frequency is ", hertz, " Hz: did you mean ", hertz, "_MHz?"};
    throw usage_error{owner, ": frequency is ", hertz, " Hz; it must be from 1 kHz to 10 GHz"};
}

/// @param max  radians
/// @throws usage_error  for an angle outside 1e-9 rad to `max`, or NaN
inline void check_angle(float radians, const char* setting, float max, const char* owner) {
    if (is_finite(radians) && radians >= 1e-9F && radians <= max) return;
    const float degrees = 180 / pi * max;
    if (is_finite(radians) && radians > max && radians <= degrees)
        throw usage_error{owner, ": ", setting, " is ", radians, " rad: did you mean ", radians, "_deg?"};
    throw usage_error{owner, ": ", setting, " is ", radians, " rad; it must be from 1e-9 rad to ", degrees, "_deg"};
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
/// A probe needs an == of its own for what a `scanner` keeps from frame to frame beside echoes: the map of its
/// pixels, the
/// automatic gain of the first frame, persistence and compounding.
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

namespace detail {

/// Lines that diverge from an apex, which lies `radius` behind the face.
struct sector {
    std::uint32_t lines = 1;
    float radius = 0;        ///< radius of the face, metres
    float field_of_view = 1; ///< angle between the ends of the sector, radians
    float face = 1;          ///< z of the origin of the probe from the apex, in radii: 1 on the face, 0 in the apex

    /// From (R sin t, 0, R cos t - R) towards (sin t, 0, cos t).
    INSONIFY_FN ray beam(float line) const {
        const float angle = aperture_fraction(line, lines) * field_of_view;
        const vec3 direction{std::sin(angle), 0, std::cos(angle)};
        return {.origin = radius * (direction - vec3{0, 0, face}), .direction = direction};
    }
    INSONIFY_FN vec2 locate(vec2 point) const {
        const float along = point.y + face * radius;
        const float from_apex = std::sqrt(point.x * point.x + along * along);
        return {line_at_fraction(std::atan2(point.x, along) / field_of_view, lines), from_apex - radius};
    }
};

/// The settings of a probe: those that it states, and for those that it lacks the values here.
struct stated_settings {
    std::uint32_t lines = 0;
    float frequency = 0;            ///< hertz
    float fnumber = 2;              ///< see `beam_model`, as those that follow
    float aperture = FLT_MAX;       ///< metres
    float focus = 0;                ///< metres; 0: half the depth of the picture
    float elevation_height = 5e-3F; ///< metres
    float elevation_focus = 20e-3F; ///< metres
    float side_lobes = 0;           ///< amplitude
    float bandwidth = 0.644F;       ///< fractional, at -6 dB: that of a pulse of 2.5 cycles

    stated_settings() = default;
    template <class Array>
    INSONIFY_FN explicit constexpr stated_settings(const Array& array)
        : lines{array.lines}, frequency{array.frequency} {
        if constexpr (requires { array.fnumber; }) fnumber = array.fnumber;
        if constexpr (requires { array.aperture(); }) aperture = array.aperture();
        if constexpr (requires { array.focus; }) focus = array.focus;
        if constexpr (requires { array.elevation_height; }) elevation_height = array.elevation_height;
        if constexpr (requires { array.elevation_focus; }) elevation_focus = array.elevation_focus;
        if constexpr (requires { array.side_lobes; }) side_lobes = array.side_lobes;
        if constexpr (requires { array.bandwidth; }) bandwidth = array.bandwidth;
    }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        if (lines == 0) throw usage_error{"probe: lines is 0; it must be at least 1"};
        check_frequency(frequency);
        check_positive(fnumber, "fnumber");
        if (focus != 0) check_length(focus, "focus", max_scan_depth);
        check_length(elevation_height, "elevation_height");
        check_length(elevation_focus, "elevation_focus", max_scan_depth);
        check_positive(bandwidth, "bandwidth");
        if (!(side_lobes >= 0 && side_lobes <= 0.2F))
            throw usage_error{"probe: side_lobes is ", side_lobes,
                              "; it must be an amplitude of 0 (none) to 0.2, and 0.047 (-26.5 dB) is that of a "
                              "rectangular aperture"};
    }

    friend bool operator==(const stated_settings&, const stated_settings&) = default;
};

} // namespace detail

/// True for a field of view of 360 degrees, where the last line is next to the first.
template <transducer Probe>
INSONIFY_FN bool is_full_circle(const Probe& probe) {
    if (probe.lines < 2) return false;
    const ray begin = probe.beam(-0.5F), end = probe.beam(static_cast<float>(probe.lines) - 0.5F);
    return length(end.direction - begin.direction) < 1e-4F &&
           length(end.origin - begin.origin) <= 1e-4F * length(begin.origin);
}

/// Fractional bandwidth of a probe at -6 dB: its `bandwidth`; that of a pulse of 2.5 cycles for a probe without that
/// member.
template <transducer Probe>
INSONIFY_FN constexpr float fractional_bandwidth(const Probe& probe) {
    return detail::stated_settings{probe}.bandwidth;
}

/// Checks `lines`, `frequency` and, where the probe has them, `fnumber`, `focus`, `elevation_height`,
/// `elevation_focus`, `bandwidth` and `side_lobes`.
/// @throws usage_error  naming a setting that is out of range
template <class Array>
void check_array(const Array& array) {
    detail::stated_settings{array}.check();
}

/// A probe whose lines are all turned in the slice plane by one angle, each about its origin on the face: one look of a
/// compounded image. The lines of a linear array fill a parallelogram.
///
/// The probe must have parallel lines, or lines that diverge from one point behind its face, as all probes of the
/// library have. A line at an angle sees the face foreshortened: `fnumber` and `aperture` are those of the steered
/// line, F / cos(angle) and width * cos(angle). Depth is measured along the lines.
template <transducer Probe>
struct steered : Probe {
    float steering = 0; ///< angle of every line to that of the probe, radians; positive towards +x

    /// @param radians  -45_deg to 45_deg
    explicit steered(const Probe& probe, float radians = 0)
        : Probe{probe}, steering{radians}, sine_{std::sin(radians)}, cosine_{std::cos(radians)} {
        if constexpr (requires { this->fnumber; }) this->fnumber /= cosine_;
        if (probe.lines == 0) return; // `check` refuses it
        // Two lines that are neither the same nor opposite, also in a full circle.
        const ray first = probe.beam(-0.5F), second = probe.beam(0.25F * static_cast<float>(probe.lines) - 0.5F);
        const vec2 from{first.origin.x, first.origin.z}, to{second.origin.x, second.origin.z};
        const vec2 down{first.direction.x, first.direction.z}, other{second.direction.x, second.direction.z};
        const float turn = down.x * other.y - down.y * other.x;
        if (std::fabs(turn) < 1e-6F) return; // parallel
        diverging_ = true;
        const float to_apex = ((to.x - from.x) * other.y - (to.y - from.y) * other.x) / turn;
        apex_ = from + to_apex * down;
        radius_ = std::fabs(to_apex);
    }

    /// The line as a ray in the probe frame.
    INSONIFY_FN ray beam(float line) const {
        ray turned = Probe::beam(line);
        turned.direction = rotated(turned.direction, sine_, cosine_);
        return turned;
    }
    /// The direction along which a line sees the grid of scatterers: that of the line without steering, or of the line
    /// turned back by 10 degrees where it is steered further. So looks of a compounded image see the same scatterers;
    /// at larger angles to the grid their level would fall.
    INSONIFY_FN vec3 scatterer_axis(float line) const {
        const float rest = steering - clamp(steering, -10_deg, 10_deg);
        return rotated(Probe::beam(line).direction, std::sin(rest), std::cos(rest));
    }
    /// From {x, z} to {line, depth along it}.
    INSONIFY_FN vec2 locate(vec2 point) const {
        if (steering == 0) return Probe::locate(point);
        if (!diverging_) { // the face is plane, and a line reaches the depth z after z / cos(angle)
            const vec2 straight = Probe::locate(point);
            const float back = straight.y * sine_ / cosine_;
            const vec3 along = Probe::beam(straight.x).direction; // {along.z, -along.x} runs along the face
            return {Probe::locate(point - back * vec2{along.z, -along.x}).x, straight.y / cosine_};
        }
        // A line leaves the face, a circle of radius R, at `steering` to its radius. At the distance d from the apex
        // its angle to the radius is asin(R sine / d), so it has turned about the apex by the difference.
        const vec2 from_apex = point - apex_;
        const float distance = length(from_apex), offset = radius_ * sine_;
        const float along = std::sqrt(max(distance * distance - offset * offset, 0));
        const float sine = (sine_ * along - cosine_ * offset) / max(distance, 1e-9F),
                    cosine = (cosine_ * along + sine_ * offset) / max(distance, 1e-9F);
        const vec2 origin{cosine * from_apex.x - sine * from_apex.y, sine * from_apex.x + cosine * from_apex.y};
        return {Probe::locate(apex_ + (1 + radius_ / max(distance, 1e-9F)) * origin).x, along - radius_ * cosine_};
    }

    /// The largest active aperture, seen from a steered line, metres.
    INSONIFY_FN float aperture() const requires requires(const Probe& probe) { probe.aperture(); }
    { return Probe::aperture() * cosine_; }

    /// @throws usage_error  naming a setting that is out of range
    void check() const {
        if (!(std::fabs(steering) <= 45_deg)) // first: the F-number depends on it
            throw usage_error{"steered: the angle is ", steering * 180 / pi, "_deg; it must be from -45_deg to 45_deg"};
        Probe::check();
    }

    friend bool operator==(const steered&, const steered&) requires detail::comparable<Probe>
    = default;

  private:
    // In the slice plane, towards +x.
    INSONIFY_FN static vec3 rotated(vec3 along, float sine, float cosine) {
        return {cosine * along.x + sine * along.z, along.y, cosine * along.z - sine * along.x};
    }

    float sine_ = 0, cosine_ = 1;
    bool diverging_ = false;
    vec2 apex_{0, 0};  // of the lines of the probe, {x, z}
    float radius_ = 0; // of the face, metres
};

/// A probe with another number of lines, usually more: the same face, field of view and beam with finer lateral
/// sampling. Or some neighbouring ones of these lines: see `section`.
template <transducer Probe>
struct refined : Probe {
    std::uint32_t lines = 1; ///< hides the member of the probe: about `rays` times as many
    float rays = 1;          ///< lines for each line of the probe, need not be whole
    float first_line = 0;    ///< number of line 0 among all of them

    /// @param rays_per_line  above 0; the number of lines is rounded
    refined(const Probe& probe, float rays_per_line)
        : Probe{probe}, lines{static_cast<std::uint32_t>(std::lround(static_cast<float>(probe.lines) * rays_per_line))},
          rays{static_cast<float>(lines) / static_cast<float>(probe.lines)} {}

    /// The lines from `begin` to before `end`.
    refined section(std::uint32_t begin, std::uint32_t end) const {
        refined some = *this;
        some.lines = end - begin;
        some.first_line += static_cast<float>(begin);
        return some;
    }

    /// The line as a ray in the probe frame.
    INSONIFY_FN ray beam(float line) const { return Probe::beam(coarse(line)); }
    /// Of a probe that is `steered`: see there.
    INSONIFY_FN vec3 scatterer_axis(float line) const requires requires(const Probe& probe) {
        probe.scatterer_axis(0.0F);
    }
    { return Probe::scatterer_axis(coarse(line)); }
    /// From {x, z} to {line, depth along it}.
    INSONIFY_FN vec2 locate(vec2 point) const {
        const vec2 place = Probe::locate(point);
        return {(place.x + 0.5F) * rays - 0.5F - first_line, place.y};
    }

    friend bool operator==(const refined&, const refined&) requires detail::comparable<Probe>
    = default;

  private:
    INSONIFY_FN float coarse(float line) const { return (first_line + line + 0.5F) / rays - 0.5F; }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
