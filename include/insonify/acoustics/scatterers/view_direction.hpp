#ifndef INSONIFY_ACOUSTICS_SCATTERERS_VIEW_DIRECTION_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_VIEW_DIRECTION_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/random.hpp>

/// The grid of a `cell_field` is fine along the viewing direction and coarse across it. Grids exist for a lattice of
/// directions; each line uses, slab by slab, a random one of the four around its own. Thus speckle persists while a
/// probe turns a little, and decorrelates gradually as it turns further.
namespace insonify::inline INSONIFY_ABI::detail {

/// Lattice directions lie on the six faces of a cube, an eighth of half an edge apart: 7 degrees in the middle of a
/// face.
inline constexpr float view_steps = 8;

/// Probability that two lines at this angle, radians, choose the same direction in a slab. Exact in the middle of a
/// face; an upper bound towards the edges of the cube, where directions are closer.
INSONIFY_FN inline float same_view_probability(float angle) { return max(0, 1 - view_steps * std::fabs(angle)); }

/// One of the four lattice directions around `towards`, chosen with bilinear weights: its mean is `towards`.
/// @param towards  not 0
/// @param bits     32 random bits
/// @return         whole numbers from -view_steps to view_steps; for the opposite direction, the opposite
INSONIFY_FN inline vec3 lattice_direction(vec3 towards, std::uint32_t bits) {
    const vec3 size = abs(towards);
    const float scale = view_steps / max(max(size.x, size.y), size.z);
    const auto rounded = [&](float coordinate, std::uint32_t random) { // the largest is a whole number already
        const float fraction = (static_cast<float>(random & 0x3FFU) + 0.5F) * 0x1p-10F;
        return std::copysign(std::floor(std::fabs(coordinate) * scale + fraction), coordinate);
    };
    return {rounded(towards.x, bits), rounded(towards.y, bits >> 10U), rounded(towards.z, bits >> 20U)};
}

/// A number for each lattice direction.
INSONIFY_FN inline std::uint32_t lattice_index(vec3 direction) {
    const auto digit = [](float coordinate) {
        return static_cast<std::uint32_t>(static_cast<std::int32_t>(coordinate) + 64);
    };
    return (digit(direction.x) << 16U) + (digit(direction.y) << 8U) + digit(direction.z);
}

/// Parallel oblique slabs that fill space; the view direction is chosen once for each.
struct view_slabs {
    static constexpr float thickness = 2e-3F; ///< metres

    /// Position of a point in slabs; its floor is the index of the slab.
    INSONIFY_FN static float position(vec3 point) { return dot(point, vec3{0.48F, 0.6F, 0.64F}) / thickness; }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
