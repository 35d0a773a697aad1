#ifndef INSONIFY_PROBE_STEERED_HPP
#define INSONIFY_PROBE_STEERED_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/memo.hpp>
#include <insonify/core/units.hpp>
#include <insonify/probe/transducer.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// A probe whose lines are all turned in the slice plane by one angle, each about its origin on the face: one look of a
/// compounded image. The lines of a linear array fill a parallelogram.
///
/// The probe must have parallel lines, or lines that diverge from one point behind its face, as all probes of the
/// library have. A line at an angle sees the face foreshortened: `fnumber` and `aperture` are those of the steered line,
/// F / cos(angle) and width * cos(angle). Depth is measured along the lines.
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
    /// turned back by 10 degrees where it is steered further. So looks of a compounded image see the same scatterers; at
    /// larger angles to the grid their level would fall.
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
        // A line leaves the face, a circle of radius R, at `steering` to its radius. At the distance d from the apex its
        // angle to the radius is asin(R sine / d), so it has turned about the apex by the difference.
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
        Probe::check();
        if (!(std::fabs(steering) <= 45_deg))
            throw usage_error{"steered: the angle is " + detail::number_text(steering * 180 / pi) +
                              "_deg; it must be from -45_deg to 45_deg"};
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

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
