#ifndef INSONIFY_BVH_PREPARED_RAY_HPP
#define INSONIFY_BVH_PREPARED_RAY_HPP

#include <insonify/bvh/node.hpp>
#include <insonify/geometry/triangle.hpp>

namespace insonify::inline INSONIFY_ABI {

/// False for NaN; reads the bits, so that it holds under -ffast-math too.
INSONIFY_FN INSONIFY_INLINE bool is_number(float value) {
    return (__builtin_bit_cast(std::uint32_t, value) & 0x7FFFFFFFU) <= 0x7F800000U;
}

/// A direction without what is too little to be divided by.
INSONIFY_FN INSONIFY_INLINE vec3 settled(vec3 direction) {
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::fabs(direction[axis]) > 1e-30F)) direction[axis] = 0;
    return direction;
}

/// Whether a ray may meet anything: it is finite but for its limits, which are numbers, and has a direction.
INSONIFY_FN INSONIFY_INLINE bool is_legal(const ray& r) {
    return is_finite(r.origin) && is_finite(r.direction) && is_number(r.min_distance) && is_number(r.max_distance) &&
           settled(r.direction) != vec3{0, 0, 0};
}

/// A ray with what every box and triangle asks of it worked out once.
///
/// It meets the side of a box that stands at s along an axis at the distance s * inverse + entry (or + exit). `entry`
/// and `exit` are apart by what rounding may add up to, so that no box is lost (Ize 2013, "Robust BVH ray traversal").
/// Along an axis across which the ray does not move, it passes every box whose sides it stands between or on: a ray in
/// the plane that two boxes share must meet both, for the triangle test alone knows whose the edge between them is.
/// So there the inverse is huge.
template <int Width>
struct prepared_ray {
    /// What a box is asked along one axis.
    struct slab {
        float inverse = 0; ///< 1 / direction, finite
        float entry = -FLT_MAX;
        float exit = FLT_MAX;
        std::uint32_t entry_row = 0; ///< of a node's bounds: the side that the ray meets first ...
        std::uint32_t exit_row = 0;  ///< ... and last
    };
    ray source{};
    slab slabs[3]{};
    sheared_ray sheared{};
    bool legal = false; ///< a ray that is not meets nothing

    /// @param reach  no coordinate of a box is further from 0
    INSONIFY_FN INSONIFY_INLINE void prepare(const ray& r, float reach) {
        source = r;
        legal = is_legal(r);
        if (!legal) return;
        source.direction = settled(r.direction);
        const vec3 along = source.direction;
        const vec3 from = absolute(r.origin), size = absolute(along);
        const float extent = from.x + from.y + from.z + reach, longest = greater(size.x, greater(size.y, size.z));
        slabs[0] = slab_of(0, r.origin.x, along.x, reach, extent, longest);
        slabs[1] = slab_of(1, r.origin.y, along.y, reach, extent, longest);
        slabs[2] = slab_of(2, r.origin.z, along.z, reach, extent, longest);
        sheared = sheared_ray{source};
    }

  private:
    // `extent / longest` is further than any hit.
    INSONIFY_FN INSONIFY_INLINE static slab slab_of(std::uint32_t axis, float origin, float along, float reach,
                                                    float extent, float longest) {
        const bool moves = along != 0;
        slab s;
        const std::uint32_t backwards = along < 0 ? 1 : 0;
        s.entry_row = tree_node<Width>::row(backwards, axis);
        s.exit_row = tree_node<Width>::row(1 - backwards, axis);
        const float inverse = moves ? 1 / along : 1e30F;
        const float begin = -origin * inverse;
        const float room = std::fabs(inverse) * (5e-7F * (std::fabs(origin) + reach) + 1e-20F);
        if (!(std::fabs(begin) + room < 1e36F)) return s;    // so far away that this axis tells nothing
        if (!moves && !(room * longest >= extent)) return s; // nor here, where the huge inverse is not huge enough
        s.inverse = inverse;
        s.entry = begin - room;
        s.exit = begin + room;
        return s;
    }
};

/// Where the ray enters the boxes of a node's children; `met` has a bit for each box that it meets within its limits.
template <int Width>
struct box_entries {
    lanes<Width> distance{};
    std::uint32_t met = 0;
};

/// Slab test of all children at once. Conservative: rounding never loses a box.
template <int Width>
INSONIFY_FN INSONIFY_INLINE box_entries<Width> enter(const tree_node<Width>& node, const prepared_ray<Width>& r,
                                                     float max_distance) {
    using floats = lanes<Width>;
    floats in(r.source.min_distance), out(max_distance);
    for (int axis = 0; axis < 3; ++axis) {
        const auto& slab = r.slabs[axis];
        const floats inverse(slab.inverse), entry(slab.entry), exit(slab.exit);
        in = greater(multiply_add(load<Width>(node.sides + slab.entry_row), inverse, entry), in);
        out = lesser(multiply_add(load<Width>(node.sides + slab.exit_row), inverse, exit), out);
    }
    return {in, bits_of(in <= out)};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
