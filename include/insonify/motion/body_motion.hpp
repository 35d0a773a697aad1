#ifndef INSONIFY_MOTION_BODY_MOTION_HPP
#define INSONIFY_MOTION_BODY_MOTION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// Inverse of a map that displaces all points along one direction and does not fold over: along a line in that direction the
/// displacement then falls by less than one to one, so that there is one solution, which is bracketed. Unlike Newton's method in
/// space it needs no derivative, and edges of the map, where its slope jumps, do no harm.
/// @param map        vec3(vec3)
/// @param direction  of length 1
/// @param max        upper bound of the displacement, metres
/// @return           the point that the map takes to `now`, to within 0.1 um (and rounding)
template <class Map>
vec3 rest_along(const Map& map, vec3 now, vec3 direction, float max) {
    const float tolerance = 1e-7F + 2.5e-7F * length(now);
    const auto displacement = [&](vec3 rest) { return dot(map(rest) - rest, direction); };
    float low = -max, high = max, last = 0, error_before = displacement(now), moved = error_before;
    for (int i = 0; i < 40 && error_before != 0; ++i) {
        const float error = displacement(now - moved * direction) - moved;
        if (!(std::fabs(error) > tolerance)) break;
        (error > 0 ? low : high) = moved;
        const float change = error - error_before;
        float next =
            change != 0 ? moved - error * (moved - last) / change : high; // secant; where that is slow, bisection
        if (i >= 8 || !(next > low && next < high)) next = 0.5F * (low + high);
        last = moved;
        error_before = error;
        moved = next;
    }
    return now - moved * direction;
}

} // namespace insonify::inline INSONIFY_ABI::detail

/// Maps for `scene::deform`: how bodies move by themselves, and with a needle. Times are seconds; the same second gives the same
/// deformation.
namespace insonify::inline INSONIFY_ABI {

/// A vessel that pulses: its wall moves outwards in systole, quickly, and back in diastole, slowly. Tissue around it keeps its
/// volume, so that its motion falls off with one over the distance; the content of the vessel is stretched evenly.
struct pulsation {
    vec3 from{0, 0, 0};        ///< a point of the vessel's axis, in the world, metres
    vec3 to{0, 1, 0};          ///< another one; the axis goes on beyond both
    float radius = 3e-3F;      ///< of the vessel at rest, metres
    float amplitude = 0.2e-3F; ///< by which its wall moves outwards, metres
    float rate = 1.2F;         ///< beats per second
    float time = 0;            ///< seconds; whole beats are at rest

    /// How far the wall is, from 0 at rest to 1 in systole.
    float wave() const {
        constexpr float systole = 0.15F; // part of a beat
        const float beats = time * rate, phase = beats - std::floor(beats);
        const float s = phase < systole ? phase / systole : (1 - phase) / (1 - systole);
        return s * s * (3 - 2 * s);
    }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const float now = radius + amplitude * wave();
        if (now == radius) return rest;
        const vec3 axis = normalize(to - from);
        const vec3 away = rest - from - dot(rest - from, axis) * axis;
        const float squared = dot(away, away), added = now * now - radius * radius;
        const float factor = squared < radius * radius ? now / radius : std::sqrt(1 + added / squared);
        return rest + (factor - 1) * away;
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        const float wall = radius + amplitude * wave();
        if (wall == radius) return now;
        const vec3 axis = normalize(to - from);
        const vec3 away = now - from - dot(now - from, axis) * axis;
        const float squared = dot(away, away), added = wall * wall - radius * radius;
        const float factor = squared < wall * wall ? radius / wall : std::sqrt(1 - added / squared);
        return now + (factor - 1) * away;
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(from) || !is_finite(to) || !(length(to - from) > 0) || !(radius > 0) ||
            !(std::fabs(amplitude) < radius) || !is_finite(rate) || !is_finite(time))
            throw usage_error{"pulsation: `from` and `to` must be different points, `radius` above 0 and more than "
                              "`amplitude`, `rate` and `time` finite"};
    }

    friend bool operator==(const pulsation&, const pulsation&) = default;
};

/// Breathing: a region moves back and forth, and rests longer when breathed out.
/// Source: Lujan et al. 1999, Med. Phys. 26, 715: displacement by 1 - cos^(2n)(pi t / period), n = 3.
struct breathing {
    vec3 direction{0, 0, 1};  ///< when breathing in, of any length above 0
    float amplitude = 10e-3F; ///< metres
    vec3 centre{0, 0, 0};     ///< where the motion is largest, in the world, metres
    float extent = 0.15F;     ///< distance from there, metres, at which it is 0.61 (a Gaussian); more than `amplitude`
    float rate = 0.25F;       ///< breaths per second
    float time = 0;           ///< seconds; whole breaths are at rest

    /// How far it is, from 0, breathed out, to 1.
    float wave() const {
        const float breaths = time * rate, cosine = std::cos(pi * (breaths - std::floor(breaths)));
        const float squared = cosine * cosine;
        return 1 - squared * squared * squared;
    }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 away = (rest - centre) / extent;
        return rest + amplitude * wave() * std::exp(-0.5F * dot(away, away)) * normalize(direction);
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const { return detail::rest_along(*this, now, normalize(direction), std::fabs(amplitude)); }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(direction) || !(length(direction) > 0) || !is_finite(centre) ||
            !(std::fabs(amplitude) < extent) || !is_finite(rate) || !is_finite(time))
            throw usage_error{"breathing: `direction` must not be 0, `extent` more than `amplitude`, `rate` and `time` "
                              "finite"};
    }

    friend bool operator==(const breathing&, const breathing&) = default;
};

/// Tissue along the shaft of a needle that moves with it: by `drag` at the shaft, and by a Gaussian of the distance from it.
///
/// The needle itself is an object of higher priority than the tissue: it opens no gap, and tissue closes behind it. While the
/// needle moves, `drag` follows its motion up to the distance at which tissue slips, a millimetre or so.
struct needle_drag {
    vec3 entry{0, 0, 0};    ///< where the needle enters the tissue, in the world, metres
    vec3 tip{0, 0, 20e-3F}; ///< in the world, metres
    float drag = 0.5e-3F;   ///< displacement at the shaft towards the tip, metres; below 0: of a needle drawn back
    float extent = 3e-3F;   ///< distance at which the displacement is 0.61, metres; more than `drag`

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 shaft = tip - entry;
        const float along = clamp(dot(rest - entry, shaft) / dot(shaft, shaft), 0, 1);
        const vec3 away = (rest - entry - along * shaft) / extent;
        return rest + drag * std::exp(-0.5F * dot(away, away)) * normalize(shaft);
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const { return detail::rest_along(*this, now, normalize(tip - entry), std::fabs(drag)); }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(entry) || !is_finite(tip) || !(length(tip - entry) > 0) || !(std::fabs(drag) < extent))
            throw usage_error{"needle_drag: `entry` and `tip` must be different points, and `extent` more than `drag`"};
    }

    friend bool operator==(const needle_drag&, const needle_drag&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
