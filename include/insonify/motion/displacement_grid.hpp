#ifndef INSONIFY_MOTION_DISPLACEMENT_GRID_HPP
#define INSONIFY_MOTION_DISPLACEMENT_GRID_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Displacements on a regular grid, as image registration gives them: a map for `scene::deform`. Trilinear between the nodes;
/// beyond the grid as at its border.
struct displacement_grid {
    vec3 origin{0, 0, 0};              ///< the first node, in the world, metres
    vec3 spacing{1e-3F, 1e-3F, 1e-3F}; ///< of the nodes along x, y and z, metres
    uvec3 size{2, 2, 2};               ///< number of nodes along x, y and z, at least 2 each
    std::vector<vec3> displacements{}; ///< from rest to now of each node at rest, metres; x changes first, z last

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        std::size_t first[3];
        vec3 part;
        for (int axis = 0; axis < 3; ++axis) {
            const float place =
                clamp((rest[axis] - origin[axis]) / spacing[axis], 0, static_cast<float>(size[axis] - 1));
            const auto below = static_cast<std::uint32_t>(place);
            first[axis] = below + 1 < size[axis] ? below : size[axis] - 2;
            part[axis] = place - static_cast<float>(first[axis]);
        }
        vec3 sum{0, 0, 0};
        for (std::size_t corner = 0; corner < 8; ++corner) {
            const std::size_t x = corner & 1U, y = corner >> 1U & 1U, z = corner >> 2U;
            const float weight =
                (x == 1 ? part.x : 1 - part.x) * (y == 1 ? part.y : 1 - part.y) * (z == 1 ? part.z : 1 - part.z);
            sum += weight * displacements[((first[2] + z) * size.y + first[1] + y) * size.x + first[0] + x];
        }
        return rest + sum;
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
