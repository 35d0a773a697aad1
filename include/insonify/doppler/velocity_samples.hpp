#ifndef INSONIFY_DOPPLER_VELOCITY_SAMPLES_HPP
#define INSONIFY_DOPPLER_VELOCITY_SAMPLES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

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
            throw usage_error{detail::joined({"velocity_samples: `size` and `steps` need ", std::to_string(needed),
                                              " velocities, not ", std::to_string(velocities.size())})};
        if (!is_finite(lower) || !is_finite(spacing) || !(spacing.x > 0 && spacing.y > 0 && spacing.z > 0))
            throw usage_error{"velocity_samples: `lower` must be finite and `spacing` above 0, such as {1_mm, 1_mm, "
                              "1_mm}"};
        if (steps > 1 && !(is_finite(interval) && interval > 0))
            throw usage_error{"velocity_samples: `interval` must be the seconds between two steps, such as 20_ms"};
        for (const vec3& velocity : velocities)
            if (!is_finite(velocity)) throw usage_error{"velocity_samples: a velocity is not finite"};
    }

  private:
    // @param place  in samples, inside the grid
    vec3 at_step(std::uint32_t step, vec3 place) const {
        uvec3 cell;
        vec3 weight;
        for (int axis = 0; axis < 3; ++axis) {
            cell[axis] = static_cast<std::uint32_t>(min(place[axis], static_cast<float>(size[axis] - 2)));
            weight[axis] = place[axis] - static_cast<float>(cell[axis]);
        }
        vec3 sum{0, 0, 0};
        for (std::uint32_t corner = 0; corner < 8; ++corner) {
            const std::uint32_t x = corner & 1U, y = corner >> 1U & 1U, z = corner >> 2U;
            const float fraction = (x == 1 ? weight.x : 1 - weight.x) * (y == 1 ? weight.y : 1 - weight.y) *
                                   (z == 1 ? weight.z : 1 - weight.z);
            sum += fraction *
                   velocities[((std::size_t{step} * size.z + cell.z + z) * size.y + cell.y + y) * size.x + cell.x + x];
        }
        return sum;
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
