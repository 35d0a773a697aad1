#ifndef INSONIFY_DOPPLER_VELOCITY_FIELD_HPP
#define INSONIFY_DOPPLER_VELOCITY_FIELD_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/geometry/centre_line.hpp>
#include <insonify/scene/object.hpp>
#include <concepts>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// The background as an object whose tissue moves: see `velocity_field`. Its coordinates are those of the world.
inline constexpr object_id background_object{~0U};

/// The velocity of tissue and blood: a function object
///
///     vec3 operator()(object_id object, vec3 point, float time) const
///
/// of an object (`background_object` for the background), a point in it and a time in seconds. Point, in metres, and
/// velocity, in m/s, are in coordinates of the object. {0, 0, 0} where nothing moves. It is called from many threads.
///
/// Of a body that `scene::deform` deforms, the point is where the tissue was at rest, and the velocity is that at rest:
/// a field describes the body at rest, and follows every deformation. Tissue with the velocity V at rest then moves
/// with F V, where F is the gradient of the deformation, and blood with F V / det F, so that its volume flow through a
/// vessel stays that of the field where the vessel is narrowed.
template <class Field>
concept velocity_field = requires(const Field& field, object_id object, vec3 point, float time) {
    { field(object, point, time) } -> std::convertible_to<vec3>;
};

/// Velocity over the heart beat, relative to its peak.
///
///     w(t) = 1 - RI (1 - s),   s = (x exp(1 - x))^2,   x = phase / systole
///
/// The phase is the fraction of the beat that has passed. w is 1 in systole and 1 - RI at the end of diastole, where
/// RI = (peak systolic - end diastolic velocity) / peak systolic velocity is the resistive index: about 0.6 to 0.8 in
/// carotid and renal arteries, above 1 where the flow reverses in diastole.
/// Source: Pourcelot 1974 for the index; the shape is by convention.
struct pulsatile {
    float heart_rate = 0;         ///< beats per second, such as 1.2_Hz; 0: steady flow
    float resistive_index = 0.7F; ///< 0: steady flow
    float systole = 0.15F;        ///< phase of the peak, 0.05 to 0.2
    float delay = 0;              ///< the first beat begins at this time, seconds

    /// Velocity at a time in seconds over that of the peak.
    float operator()(float time) const {
        if (heart_rate == 0) return 1;
        const float beats = (time - delay) * heart_rate, x = (beats - std::floor(beats)) / systole;
        const float rise = x * std::exp(1 - x);
        return 1 - resistive_index * (1 - rise * rise);
    }
    /// The mean over a beat.
    float mean() const {
        if (heart_rate == 0) return 1;
        // The integral of x^2 exp(2 - 2 x) to x = 1 / systole.
        const float end = 1 / systole;
        const float area = systole * 0.25F * (std::exp(2.0F) - (2 * end * end + 2 * end + 1) * std::exp(2 - 2 * end));
        return 1 - resistive_index * (1 - area);
    }

    /// @throws usage_error  for a setting out of range
    void check() const {
        if (!is_finite(heart_rate) || !(heart_rate >= 0) || !(heart_rate <= 20))
            throw usage_error{"pulsatile: `heart_rate` is ", heart_rate,
                              " Hz; it must be 0 (steady flow) to 20 beats per second, such as 1.2_Hz"};
        if (!(resistive_index >= 0 && resistive_index <= 2))
            throw usage_error{"pulsatile: `resistive_index` must be 0 (steady flow) to 2, such as 0.7"};
        if (!(systole >= 0.05F && systole <= 0.2F) || !is_finite(delay))
            throw usage_error{"pulsatile: `systole` must be a phase of 0.05 to 0.2, and `delay` finite"};
    }

    friend bool operator==(const pulsatile&, const pulsatile&) = default;
};

/// Laminar flow in a straight tube: v = peak_velocity w(t) (1 - r^2 / radius^2) towards `to`; 0 outside the radius.
///
/// Every beat is quasi-steady: the profile stays a parabola, as in small vessels (Womersley number below 3).
/// Source: Hagen-Poiseuille law.
struct poiseuille {
    object_id object{};      ///< whose blood flows
    vec3 from{0, 0, 0};      ///< on the axis, in coordinates of the object, metres
    vec3 to{0, 0, 0};        ///< on the axis; blood flows from `from` to `to`
    float radius = 0;        ///< of the tube, metres
    float peak_velocity = 0; ///< on the axis in systole, m/s; below 0: towards `from`
    pulsatile waveform{};    ///< steady by default

    /// See `velocity_field`.
    vec3 operator()(object_id of, vec3 point, float time) const {
        if (of != object) return {0, 0, 0};
        const vec3 along = normalize(to - from), from_axis = point - from - dot(point - from, along) * along;
        const float fraction = 1 - dot(from_axis, from_axis) / (radius * radius);
        return fraction > 0 ? peak_velocity * waveform(time) * fraction * along : vec3{0, 0, 0};
    }
    /// Volume per second at a time, m^3/s: pi radius^2 / 2 times the velocity on the axis.
    float volume_flow(float time) const { return 0.5F * pi * radius * radius * peak_velocity * waveform(time); }

    /// @throws usage_error  for a setting out of range
    void check() const {
        if (!is_finite(from) || !is_finite(to) || !(length(to - from) > 0))
            throw usage_error{"poiseuille: `from` and `to` must be two different points on the axis of the tube"};
        if (!is_finite(radius) || !(radius > 0))
            throw usage_error{"poiseuille: `radius` must be a finite number of metres above 0, such as 4_mm"};
        if (!is_finite(peak_velocity) || !(std::fabs(peak_velocity) <= 100))
            throw usage_error{"poiseuille: `peak_velocity` must be at most 100 m/s, such as 0.4_m_per_s"};
        waveform.check();
    }

    friend bool operator==(const poiseuille&, const poiseuille&) = default;
};

/// Laminar flow in a tube that bends, tapers, and has elliptical sections: along its line, by
/// v = peak_velocity w(t) (A_0 / A)^(1 - side_branches) (1 - r^2), where r is the distance from the line over that of
/// the wall, A the area of the section and A_0 that of the first one; 0 outside the wall. All sections have the same
/// volume flow, unless branches take some of it.
///
/// The profile across an ellipse is exact for a straight tube; flow that is parallel to the line holds where the tube
/// bends and tapers slowly.
struct tube_flow {
    object_id object{};      ///< whose blood flows
    centre_line line{};      ///< in coordinates of the object; blood flows towards its last section
    float peak_velocity = 0; ///< on the axis of the first section in systole, m/s; below 0: towards it
    pulsatile waveform{};    ///< steady by default
    /// What branches take of the flow, or bring, where the tube tapers: 0: nothing; 1: so much that the velocity is the
    /// same everywhere.
    float side_branches = 0;

    /// See `velocity_field`.
    vec3 operator()(object_id of, vec3 point, float time) const {
        if (of != object) return {0, 0, 0};
        const line_place here = line.place(point);
        const float fraction = 1 - here.squared(point);
        if (!(fraction > 0)) return {0, 0, 0};
        const float narrowed = line.first().area() / here.area();
        const float faster = side_branches == 0 ? narrowed : std::pow(narrowed, 1 - side_branches);
        return peak_velocity * waveform(time) * faster * fraction * here.along;
    }
    /// Volume per second at a time through the first section, m^3/s: half its area times the velocity on its axis.
    float volume_flow(float time) const { return 0.5F * line.first().area() * peak_velocity * waveform(time); }

    /// @throws usage_error  for a setting out of range
    void check() const {
        if (line.empty()) throw usage_error{"tube_flow: `line` is empty; give the sections of the tube"};
        if (!is_finite(peak_velocity) || !(std::fabs(peak_velocity) <= 100))
            throw usage_error{"tube_flow: `peak_velocity` must be at most 100 m/s, such as 0.4_m_per_s"};
        if (!(side_branches >= 0 && side_branches <= 1))
            throw usage_error{"tube_flow: `side_branches` must be 0 (none) to 1 (the velocity is the same everywhere)"};
        waveform.check();
    }

    friend bool operator==(const tube_flow&, const tube_flow&) = default;
};

/// Velocities on a regular grid, as flow solvers give them: linear in space and time between the samples, 0 outside.
///
/// Sample {x, y, z} of time step t is velocities[((t size.z + z) size.y + y) size.x + x] and lies at
/// lower + spacing * {x, y, z}. The time steps repeat.
struct velocity_samples {
    object_id object{};                ///< whose tissue or blood moves
    vec3 lower{0, 0, 0};               ///< of the first sample, in coordinates of the object, metres
    vec3 spacing{1e-3F, 1e-3F, 1e-3F}; ///< metres
    uvec3 size{0, 0, 0};               ///< samples along each axis, at least 2
    std::vector<vec3> velocities{};    ///< m/s
    std::uint32_t steps = 1;           ///< of time
    float interval = 0;                ///< from step to step, seconds; 0 where there is one step

    /// See `velocity_field`.
    vec3 operator()(object_id of, vec3 point, float time) const {
        if (of != object) return {0, 0, 0};
        const vec3 place = (point - lower) / spacing;
        for (int axis = 0; axis < 3; ++axis)
            if (!(place[axis] >= 0 && place[axis] <= static_cast<float>(size[axis] - 1))) return {0, 0, 0};
        if (steps < 2) return at_step(0, place);
        const float whole = static_cast<float>(steps), turns = time / (interval * whole);
        const float step = (turns - std::floor(turns)) * whole;
        const auto before = static_cast<std::uint32_t>(min(step, whole - 1));
        const vec3 first = at_step(before, place);
        return first + (step - static_cast<float>(before)) * (at_step((before + 1) % steps, place) - first);
    }

    /// @throws usage_error  for a setting out of range
    void check() const {
        if (size.x < 2 || size.y < 2 || size.z < 2 || steps < 1)
            throw usage_error{"velocity_samples: `size` must be at least 2 samples along each axis, and `steps` 1"};
        const std::size_t needed = std::size_t{size.x} * size.y * size.z * steps;
        if (velocities.size() != needed)
            throw usage_error{"velocity_samples: `size` and `steps` need ", needed, " velocities, not ",
                              velocities.size()};
        if (!is_finite(lower) || !is_finite(spacing) || !(spacing.x > 0 && spacing.y > 0 && spacing.z > 0))
            throw usage_error{"velocity_samples: `lower` must be finite and `spacing` above 0, such as {1_mm, 1_mm, "
                              "1_mm}"};
        if (steps > 1 && !(is_finite(interval) && interval > 0))
            throw usage_error{"velocity_samples: `interval` must be the seconds between two steps, such as 20_ms"};
        for (const vec3& velocity : velocities)
            if (!is_finite(velocity)) throw usage_error{"velocity_samples: a velocity is not finite"};
    }

  private:
    vec3 at_step(std::uint32_t step, vec3 place) const {
        return detail::interpolated(velocities.data() + std::size_t{step} * size.x * size.y * size.z, size, place);
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
