#ifndef INSONIFY_TISSUE_FIBRE_CHART_HPP
#define INSONIFY_TISSUE_FIBRE_CHART_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI {

/// Coordinates in which curved fibres are straight: at the nodes of a grid, linear in between. Trivially copyable; refers to the
/// scene's arrays. Fibres run along x, and layers are flat in z, as in `structure`.
struct fibre_chart {
    view<const vec3> nodes{}; ///< x varies fastest; metres
    uvec3 count{0, 0, 0};     ///< of nodes along each axis, at least 2
    vec3 origin{0, 0, 0};     ///< of the grid, in coordinates of the object
    float spacing = 1;        ///< of the nodes, metres

    /// Whether fibres are straight everywhere.
    INSONIFY_FN bool empty() const { return nodes.empty(); }

    /// The coordinates of a point of the object; metres. Beyond the grid those of its outermost cells go on.
    INSONIFY_FN vec3 operator()(vec3 point) const {
        const vec3 place = (point - origin) / spacing;
        std::size_t first = 0, step[3] = {1, count.x, std::size_t{count.x} * count.y};
        float part[3];
        for (int i = 0; i < 3; ++i) {
            const float below = std::floor(clamp(place[i], 0, static_cast<float>(count[i]) - 2));
            part[i] = place[i] - below;
            first += step[i] * static_cast<std::size_t>(below);
        }
        const auto along_x = [&](std::size_t at) { return nodes[at] + part[0] * (nodes[at + 1] - nodes[at]); };
        const auto in_plane = [&](std::size_t at) {
            const vec3 low = along_x(at);
            return low + part[1] * (along_x(at + step[1]) - low);
        };
        const vec3 low = in_plane(first);
        return low + part[2] * (in_plane(first + step[2]) - low);
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
