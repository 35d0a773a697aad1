#ifndef INSONIFY_ACOUSTICS_VIEW_DIRECTION_HPP
#define INSONIFY_ACOUSTICS_VIEW_DIRECTION_HPP

#include <insonify/core/random.hpp>

/// Scatterers are laid out for the direction that they are looked at from, along it finely and across it coarsely. There
/// are layouts for some directions only, and a line takes one of those around its own: so the texture stays while a probe
/// is turned a little, and turns into another one bit by bit.
namespace insonify::inline INSONIFY_ABI {

/// Directions on the six sides of a cube, an eighth of half an edge apart: 7 degrees in the middle of a side.
inline constexpr float view_steps = 8;

/// How alike the choices of two lines are whose directions lie so many radians apart: they agree with this probability in
/// the middle of a side; towards the edges of the cube, where the directions lie closer, less often.
INSONIFY_FN inline float same_view(float radians) { return greater(0, 1 - view_steps * std::fabs(radians)); }

/// One of the four directions of the lattice around `towards`, the nearer the likelier.
/// @param towards  not 0
/// @param chance   32 random bits
/// @return         length 1
INSONIFY_FN inline vec3 view_direction(vec3 towards, std::uint32_t chance) {
    const vec3 size = absolute(towards);
    const int main = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    const int next = (main + 1) % 3, last = (main + 2) % 3;
    const auto rounded = [&](int axis, std::uint32_t bits) {
        return std::floor(view_steps * towards[axis] / size[main] + (static_cast<float>(bits) + 0.5F) * 0x1p-16F);
    };
    vec3 chosen{};
    chosen[main] = std::copysign(view_steps, towards[main]);
    chosen[next] = rounded(next, chance & 0xFFFFU);
    chosen[last] = rounded(last, chance >> 16U);
    return normalize(chosen);
}

/// Space in oblique slabs, each of which makes its own choice.
struct view_slabs {
    static constexpr float thickness = 2e-3F;

    /// Where a point stands, in slabs; its floor is the number of the slab.
    INSONIFY_FN static float place(vec3 point) { return dot(point, vec3{0.48F, 0.6F, 0.64F}) / thickness; }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
