#ifndef INSONIFY_SCENE_PRESSED_FACE_HPP
#define INSONIFY_SCENE_PRESSED_FACE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/scene/indentation.hpp>
#include <array>
#include <cmath>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// A face of a probe, flat or curved, pressed into skin of any shape: what `press` finds, and a map for `scene::deform`. Like
/// `indentation`, with a depth that differs from point to point of the face.
struct pressed_face {
    static constexpr std::size_t columns = 33; ///< along x, from edge to edge
    static constexpr std::size_t rows = 5;     ///< along y, from edge to edge

    pose at{};                                            ///< probe to world
    float left = -20e-3F;                                 ///< edge of the face along x, metres
    float right = 20e-3F;                                 ///< the other one
    float elevation = 8e-3F;                              ///< its size along y, metres
    std::array<float, columns> height{};                  ///< z of the face at each column, metres
    std::array<std::array<float, columns>, rows> depth{}; ///< of the face below the skin at rest, along z, metres
    float decay = 20e-3F;                                 ///< see `indentation`
    float recovery = 8e-3F;                               ///< see `indentation`

    /// Position of a point of the face as a number of columns.
    float column(float x) const {
        const float width = right - left;
        return width > 0 ? clamp((x - left) / width, 0, 1) * (columns - 1) : 0;
    }
    /// The column that is nearest to a point of the face.
    std::size_t nearest_column(float x) const { return static_cast<std::size_t>(std::lround(column(x))); }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 local = at.local_point(rest);
        const float x = column(local.x), y = clamp(local.y / elevation + 0.5F, 0, 1) * (rows - 1);
        const auto i = static_cast<std::size_t>(min(x, columns - 2)), k = static_cast<std::size_t>(min(y, rows - 2));
        const float part = x - static_cast<float>(i), upper = y - static_cast<float>(k);
        const auto mixed = [part, i](const std::array<float, columns>& values) {
            return values[i] + part * (values[i + 1] - values[i]);
        };
        const float here = mixed(depth[k]) + upper * (mixed(depth[k + 1]) - mixed(depth[k]));
        const vec2 beside{max(max(left - local.x, local.x - right), 0), max(std::fabs(local.y) - 0.5F * elevation, 0)};
        const float at_skin = here * detail::beside_face(length(beside), recovery);
        return rest + at.direction({0, 0, detail::sunk(at_skin, local.z - mixed(height) + here, decay)});
    }
    /// The inverse.
    vec3 rest_of(vec3 now) const { return detail::rest_along(*this, now, at.direction({0, 0, 1}), decay); }

    /// @throws usage_error  if a setting is out of range
    void check() const {
        bool valid = is_rigid(at) && is_finite(left) && is_finite(right) && elevation > 0 && decay > 0 && recovery > 0;
        for (const float z : height) valid = valid && is_finite(z);
        for (const std::array<float, columns>& row : depth)
            for (const float one : row) valid = valid && one >= 0 && one < decay;
        if (!valid)
            throw usage_error{
                "pressed_face: `depth` must be at least 0 and less than `decay` at each point of the face, `left`, "
                "`right` and `height` finite, `elevation` and `recovery` above 0, and `at` a rigid pose"};
    }

    friend bool operator==(const pressed_face&, const pressed_face&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
