#ifndef INSONIFY_MOTION_PRESSED_FACE_HPP
#define INSONIFY_MOTION_PRESSED_FACE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/motion/indentation.hpp>
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
    /// Where a row and a column are: x and y of the probe, metres.
    vec2 place(std::size_t row, std::size_t column) const {
        return {left + (right - left) * static_cast<float>(column) / (columns - 1),
                elevation * (static_cast<float>(row) / (rows - 1) - 0.5F)};
    }
    /// z of the face, metres, at x and y of the probe: linear between the columns, and on from the outer ones.
    float surface_at(vec2 place) const { return mixed(height, cell_of(place)); }
    /// Its depth below the skin at rest, likewise.
    float depth_at(vec2 place) const {
        const cell at_place = cell_of(place);
        const float lower = mixed(depth[at_place.row], at_place), upper = mixed(depth[at_place.row + 1], at_place);
        return lower + at_place.upper * (upper - lower);
    }
    /// The column that is nearest to a point of the face.
    std::size_t nearest_column(float x) const { return static_cast<std::size_t>(std::lround(column(x))); }

    /// Where a point at rest is now.
    vec3 operator()(vec3 rest) const {
        const vec3 local = at.local_point(rest);
        const vec2 place{clamp(local.x, left, right), clamp(local.y, -0.5F * elevation, 0.5F * elevation)};
        const float here = depth_at(place);
        const vec2 beside{max(max(left - local.x, local.x - right), 0), max(std::fabs(local.y) - 0.5F * elevation, 0)};
        const float at_skin = here * detail::beside_face(length(beside), recovery);
        return rest + at.direction({0, 0, detail::sunk(at_skin, local.z - surface_at(place) + here, decay)});
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

  private:
    struct cell {
        std::size_t column, row;
        float part, upper; // within it; beyond 0 to 1 outside of the face
    };
    cell cell_of(vec2 place) const {
        const float width = right - left, x = width > 0 ? (place.x - left) / width * (columns - 1) : 0,
                    y = (place.y / elevation + 0.5F) * (rows - 1);
        const auto i = static_cast<std::size_t>(clamp(x, 0, columns - 2)),
                   k = static_cast<std::size_t>(clamp(y, 0, rows - 2));
        return {i, k, x - static_cast<float>(i), y - static_cast<float>(k)};
    }
    static float mixed(const std::array<float, columns>& values, const cell& at) {
        return values[at.column] + at.part * (values[at.column + 1] - values[at.column]);
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
