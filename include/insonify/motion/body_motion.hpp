#ifndef INSONIFY_MOTION_BODY_MOTION_HPP
#define INSONIFY_MOTION_BODY_MOTION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/geometry/centre_line.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Inverse of a map that displaces all points along one direction and does not fold over: along a line in that
/// direction the displacement falls by less than one to one, so that there is one solution, which is bracketed.
/// @param displacement  displacement(moved): of the point `now` - `moved` * `direction`, metres
/// @param direction     of length 1
/// @param max           upper bound of the displacement, metres
/// @return              the point that the map takes to `now`, to within 0.1 um (and rounding)
template <class Displacement>
vec3 rest_along(const Displacement& displacement, vec3 now, vec3 direction, float max) {
    const float tolerance = 1e-7F + 2.5e-7F * length(now);
    float low = -max, high = max, last = 0, error_before = displacement(0.0F), moved = error_before;
    for (int i = 0; i < 40 && std::fabs(error_before) > tolerance; ++i) {
        const float error = displacement(moved) - moved;
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

/// Maps for `scene::deform`: how bodies move by themselves, and with a needle. Times are seconds; the same second gives
/// the same deformation.
namespace insonify::inline INSONIFY_ABI {

/// A vessel that pulses: its wall moves outwards in systole, quickly, and back in diastole, slowly. Tissue around it
/// keeps its volume, so that its motion falls off with one over the distance; its content is stretched evenly.
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
    vec3 operator()(vec3 rest) const { return widened(rest, radius, radius + amplitude * wave()); }
    /// The inverse.
    vec3 rest_of(vec3 now) const { return widened(now, radius + amplitude * wave(), radius); }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(from) || !is_finite(to) || !(length(to - from) > 0) || !(radius > 0) ||
            !(std::fabs(amplitude) < radius) || !is_finite(rate) || !is_finite(time))
            throw usage_error{"pulsation: `from` and `to` must be different points, `radius` above 0 and more than "
                              "`amplitude`, `rate` and `time` finite"};
    }

    friend bool operator==(const pulsation&, const pulsation&) = default;

  private:
    // Where a point goes as the radius of the vessel changes.
    vec3 widened(vec3 point, float before, float after) const {
        if (after == before) return point;
        const vec3 axis = normalize(to - from);
        const vec3 away = point - from - dot(point - from, axis) * axis;
        const float squared = dot(away, away), added = after * after - before * before;
        const float factor = squared < before * before ? after / before : std::sqrt(1 + added / squared);
        return point + (factor - 1) * away;
    }
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
    vec3 operator()(vec3 rest) const { return rest + amplitude * wave() * fraction_at(rest) * normalize(direction); }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        const vec3 along = normalize(direction);
        const float peak = amplitude * wave();
        return detail::rest_along([&](float moved) { return peak * fraction_at(now - moved * along); }, now, along,
                                  std::fabs(amplitude));
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(direction) || !(length(direction) > 0) || !is_finite(centre) ||
            !(std::fabs(amplitude) < extent) || !is_finite(rate) || !is_finite(time))
            throw usage_error{"breathing: `direction` must not be 0, `extent` more than `amplitude`, `rate` and `time` "
                              "finite"};
    }

    friend bool operator==(const breathing&, const breathing&) = default;

  private:
    float fraction_at(vec3 rest) const {
        const vec3 away = (rest - centre) / extent;
        return std::exp(-0.5F * dot(away, away));
    }
};

/// Tissue along the shaft of a needle that moves with it: by `drag` at the shaft, and by a Gaussian of the distance.
///
/// The needle itself is an object of higher priority than the tissue: it opens no gap, and tissue closes behind it.
/// While the needle moves, `drag` follows its motion up to the distance at which tissue slips, a millimetre or so.
struct needle_drag {
    vec3 entry{0, 0, 0};    ///< where the needle enters the tissue, in the world, metres
    vec3 tip{0, 0, 20e-3F}; ///< in the world, metres
    float drag = 0.5e-3F;   ///< displacement at the shaft towards the tip, metres; below 0: of a needle drawn back
    float extent = 3e-3F;   ///< distance at which the displacement is 0.61, metres; more than `drag`

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const { return rest + drag_at(rest) * normalize(tip - entry); }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        const vec3 along = normalize(tip - entry);
        return detail::rest_along([&](float moved) { return drag_at(now - moved * along); }, now, along,
                                  std::fabs(drag));
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(entry) || !is_finite(tip) || !(length(tip - entry) > 0) || !(std::fabs(drag) < extent))
            throw usage_error{"needle_drag: `entry` and `tip` must be different points, and `extent` more than `drag`"};
    }

    friend bool operator==(const needle_drag&, const needle_drag&) = default;

  private:
    float drag_at(vec3 rest) const {
        const vec3 shaft = tip - entry;
        const float along = clamp(dot(rest - entry, shaft) / dot(shaft, shaft), 0, 1);
        const vec3 away = (rest - entry - along * shaft) / extent;
        return drag * std::exp(-0.5F * dot(away, away));
    }
};

/// A vessel that collapses where the pressure around it exceeds that of its blood: a map for `scene::deform`. Veins
/// close at a few mmHg; arteries, whose pressure is ten times that, do not.
///
/// The lumen, a circle of a radius R at rest, becomes an ellipse of the same width. Its height and its area are those
/// at rest times
///
///     opening = max((1 + (outside - inside) / stiffness)^(-2/3), residual),
///
/// and 1 where `outside` is below `inside`. Tissue above and below follows the point of the wall that lies between it
/// and the axis, by exp(-z^2 / (2 above^2)), where z is its distance from there along `direction`; tissue beside the
/// lumen, at a distance x from where its width ends, by exp(-x^2 / (2 beside^2)) of that. All move along `direction`,
/// by at most (1 - opening) R. The map does not fold over: the determinant of its derivative is at least `opening`.
/// Source: Shapiro 1977, J. Biomech. Eng. 99, 126: area of thin-walled tubes that are nearly closed.
struct collapse {
    vec3 from{0, 0, 0};      ///< a point of the vessel's axis, in the world, metres
    vec3 to{0, 1, 0};        ///< another one; the axis goes on beyond both
    vec3 direction{0, 0, 1}; ///< in which it is flattened, of any length above 0; its part across the axis counts
    float radius = 4.5e-3F;  ///< of the lumen at rest, metres
    float outside = 0;       ///< pressure of the tissue around the vessel, Pa: see `_mmHg`
    float inside = 1070;     ///< pressure of its blood, Pa: 8 mmHg, a vein of the leg in a patient who lies
    float stiffness = 40;    ///< of its wall against bending, Pa: E h^3 / (12 (1 - nu^2) R^3) of its thickness h
    float residual = 0.06F;  ///< opening at which the walls touch, above 0 to 1
    float beside = 1.5e-3F;  ///< distance beside the wall at which the displacement is 0.61, metres
    float above = 4e-3F;     ///< the same above and below its wall, metres

    /// Height of the lumen over that at rest.
    float opening() const {
        const float excess = max(outside - inside, 0) / stiffness, root = std::cbrt(1 + excess);
        return max(1 / (root * root), residual);
    }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const float closed = 1 - opening();
        if (closed == 0) return rest;
        const vec3 axis = normalize(to - from), up = normalize(direction - dot(direction, axis) * axis);
        const vec3 away = rest - from - dot(rest - from, axis) * axis;
        const float height = dot(away, up), distance = length(away);
        if (distance <= radius) return rest - closed * height * up;
        const float to_wall = radius / distance, z = (1 - to_wall) * height / above;
        const float x = max(std::fabs(dot(away, cross(axis, up))) - radius, 0) / beside;
        return rest - closed * to_wall * height * std::exp(-0.5F * (x * x + z * z)) * up;
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        const vec3 axis = normalize(to - from), up = normalize(direction - dot(direction, axis) * axis);
        const auto displacement = [&](float moved) {
            const vec3 rest = now - moved * up;
            return dot((*this)(rest)-rest, up);
        };
        return detail::rest_along(displacement, now, up, radius);
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(from) || !is_finite(to) || !is_finite(direction) ||
            !(length(cross(to - from, direction)) > 1e-3F * length(to - from) * length(direction)))
            throw usage_error{"collapse: `from` and `to` must be different points, and `direction` not along the axis"};
        if (!(radius > 0) || !(beside > 0) || !(above > 0) || !(stiffness > 0) || !is_finite(outside) ||
            !is_finite(inside) || !(residual > 0 && residual <= 1))
            throw usage_error{"collapse: `radius`, `beside`, `above` and `stiffness` must be above 0, the pressures "
                              "finite, and `residual` above 0 to 1"};
    }

    friend bool operator==(const collapse&, const collapse&) = default;
};

/// A map of a straight vessel, `pulsation` or `collapse`, along one that bends, tapers and has elliptical sections.
///
///     body.deform(exec::par, bent{centre_line{sections}, pulsation{.time = t}});
///
/// Across each place of the line, lengths are scaled so that the section becomes the circle of the straight vessel: an
/// amplitude of a tenth of its radius is a tenth of the radius everywhere. Points stay in the plane across the line.
///
/// Around the centre of a bend, where the nearest place of the line jumps, so does the displacement: to both sides it
/// is that of the straight vessel at the distance of the bend's radius. For a pulsation of 0.4 mm of a radius of 4 mm
/// that is 0.08 mm in a bend of 20 mm, and 0.2 mm in one of 8 mm; keep bends much wider than `collapse::above` and
/// `beside`.
template <class Map>
struct bent {
    centre_line line{}; ///< at rest, in the world
    Map vessel{};       ///< its `from` and `to` do not count

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        return moved(rest, [](const Map& straight, vec3 point) { return straight(point); });
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const {
        return moved(now, [](const Map& straight, vec3 point) { return straight.rest_of(point); });
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (line.empty()) throw usage_error{"bent: `line` is empty; give the sections of the vessel"};
        Map straight = along_z();
        if constexpr (requires { straight.direction; })
            if (is_finite(vessel.direction) && vessel.direction != vec3{0, 0, 0}) straight.direction = {1, 0, 0};
        straight.check();
    }

    friend bool operator==(const bent&, const bent&) = default;

  private:
    Map along_z() const {
        Map straight = vessel;
        straight.from = {0, 0, 0};
        straight.to = {0, 0, 1};
        return straight;
    }

    template <class Move>
    vec3 moved(vec3 point, const Move& move) const {
        const line_place here = line.place(point);
        const vec2 scale = vessel.radius / here.radii;
        const auto across = [&](vec3 v) { return vec2{dot(v, here.first_axis), dot(v, here.second_axis)}; };
        Map straight = along_z();
        if constexpr (requires { straight.direction; }) {
            const vec2 direction = across(vessel.direction);
            const bool is_across = length(direction) > 1e-3F * length(vessel.direction);
            straight.direction = {is_across ? scale * direction : vec2{0, 1}, 0}; // along the line: any is as good
        }
        const vec2 before = scale * across(point - here.centre);
        const vec2 change = (vec2{move(straight, vec3{before, 0})} - before) / scale;
        return point + change.x * here.first_axis + change.y * here.second_axis;
    }
};
/// Deduces the map.
template <class Map>
bent(centre_line, Map) -> bent<Map>;

/// Displacements on a regular grid, as image registration gives them: a map for `scene::deform`. Trilinear between the
/// nodes; beyond the grid as at its border.
struct displacement_grid {
    vec3 origin{0, 0, 0};              ///< the first node, in the world, metres
    vec3 spacing{1e-3F, 1e-3F, 1e-3F}; ///< of the nodes along x, y and z, metres
    uvec3 size{2, 2, 2};               ///< number of nodes along x, y and z, at least 2 each
    std::vector<vec3> displacements{}; ///< from rest to now of each node at rest, metres; x changes first, z last

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 place = (rest - origin) / spacing;
        return rest + detail::interpolated(displacements.data(), size, min(max(place, vec3{0}), vec3{size - 1U}));
    }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        if (!is_finite(origin) || !is_finite(spacing) || !(spacing.x > 0 && spacing.y > 0 && spacing.z > 0))
            throw usage_error{"displacement_grid: `origin` and `spacing` must be finite, and the spacing above 0"};
        if (size.x < 2 || size.y < 2 || size.z < 2 || displacements.size() != std::size_t{size.x} * size.y * size.z)
            throw usage_error{"displacement_grid: `displacements` must have size.x * size.y * size.z values, and at "
                              "least 2 nodes along each axis"};
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
