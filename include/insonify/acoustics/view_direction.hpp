#ifndef INSONIFY_ACOUSTICS_VIEW_DIRECTION_HPP
#define INSONIFY_ACOUSTICS_VIEW_DIRECTION_HPP

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
/// @return         length 1
INSONIFY_FN inline vec3 view_direction(vec3 towards, std::uint32_t bits) {
    const vec3 size = abs(towards);
    const int main = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    const int next = (main + 1) % 3, last = (main + 2) % 3;
    const auto rounded = [&](int axis, std::uint32_t random) {
        return std::floor(view_steps * towards[axis] / size[main] + (static_cast<float>(random) + 0.5F) * 0x1p-16F);
    };
    vec3 chosen{};
    chosen[main] = std::copysign(view_steps, towards[main]);
    chosen[next] = rounded(next, bits & 0xFFFFU);
    chosen[last] = rounded(last, bits >> 16U);
    return normalize(chosen);
}

/// Parallel oblique slabs that fill space; the view direction is chosen once for each.
struct view_slabs {
    static constexpr float thickness = 2e-3F; ///< metres

    /// Position of a point in slabs; its floor is the index of the slab.
    INSONIFY_FN static float position(vec3 point) { return dot(point, vec3{0.48F, 0.6F, 0.64F}) / thickness; }
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
