#ifndef INSONIFY_BVH_LEAF_TRIANGLES_HPP
#define INSONIFY_BVH_LEAF_TRIANGLES_HPP

#include <insonify/bvh/leaf.hpp>
#include <bit>

namespace insonify::inline INSONIFY_ABI {

template <class Range>
concept triangle_range = primitive_range<Range> && std::same_as<range_primitive_t<Range>, triangle>;

/// A leaf of triangles: their corners side by side for SIMD, so that a ray meets all of them at once.
template <triangle_range Range, int Width>
struct alignas(sizeof(float) * Width) leaf<Range, Width> {
    float corner[3][3][Width] = {}; ///< [corner][axis][triangle]
    std::uint32_t usable = 0;       ///< a bit for each triangle that is there and finite

    aabb fill(const Range& range, const std::uint32_t* slots) {
        aabb whole;
        usable = 0;
        for (int i = 0; i < Width && slots[i] != no_primitive; ++i) {
            const triangle t = range[slots[i]];
            const aabb box = bounds(t);
            if (box.empty()) continue;
            whole = merged(whole, box);
            usable |= 1U << static_cast<unsigned>(i);
            for (int axis = 0; axis < 3; ++axis) {
                corner[0][axis][i] = t.a[axis];
                corner[1][axis][i] = t.b[axis];
                corner[2][axis][i] = t.c[axis];
            }
        }
        return whole;
    }

    /// The watertight test of triangle.hpp, in floats. Where their rounding leaves the side of an edge in doubt (the
    /// ray passes within a few units in the last place of it), that triangle is asked again, exactly.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void intersect_all(const prepared_ray& r, const float& max_distance, const Range&,
                                   const std::uint32_t* slots, Visit&& visit) const {
        using floats = lanes<Width>;
        const sheared_ray& shear = r.sheared;
        const floats origin_x(shear.origin[shear.x]), origin_y(shear.origin[shear.y]), origin_z(shear.origin[shear.z]);
        const floats minus_shear_x(-shear.shear.x), minus_shear_y(-shear.shear.y);
        floats x[3], y[3], z[3];
        for (int c = 0; c < 3; ++c) {
            z[c] = load<Width>(corner[c][shear.z]) - origin_z;
            x[c] = multiply_add(minus_shear_x, z[c], load<Width>(corner[c][shear.x]) - origin_x);
            y[c] = multiply_add(minus_shear_y, z[c], load<Width>(corner[c][shear.y]) - origin_y);
        }
        const floats u = x[1] * y[2] - y[1] * x[2], v = x[2] * y[0] - y[2] * x[0], w = x[0] * y[1] - y[0] * x[1];

        // Each product is at most |x| |y|: four roundings of half a unit each, doubled for safety; and underflow.
        const floats reach_x = greater(greater(absolute(x[0]), absolute(x[1])), absolute(x[2]));
        const floats reach_y = greater(greater(absolute(y[0]), absolute(y[1])), absolute(y[2]));
        const floats doubt = reach_x * reach_y * floats(5e-7F) + floats(4 * FLT_MIN);
        const floats lowest = lesser(lesser(u, v), w), highest = greater(greater(u, v), w);
        const std::uint32_t candidates = usable & ~bits_of(lowest < -doubt && doubt < highest);
        if (candidates == 0) return;
        const std::uint32_t certain = bits_of(doubt < lowest || highest < -doubt);

        float distance[Width];
        const floats share = floats(shear.shear.z) / (u + v + w);
        store(u * share * z[0] + v * share * z[1] + w * share * z[2], distance);
        for (std::uint32_t left = candidates; left != 0; left &= left - 1) {
            const std::uint32_t i = lowest_bit(left);
            const float found = (certain >> i & 1U) != 0 ? distance[i] : intersect(shear, corners(i)).distance;
            if (found >= r.source.min_distance && found <= max_distance && found < FLT_MAX)
                visit(hit{.distance = found, .primitive = slots[i]});
        }
    }

    INSONIFY_FN triangle corners(std::uint32_t i) const {
        return {{corner[0][0][i], corner[0][1][i], corner[0][2][i]},
                {corner[1][0][i], corner[1][1][i], corner[1][2][i]},
                {corner[2][0][i], corner[2][1][i], corner[2][2][i]}};
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
