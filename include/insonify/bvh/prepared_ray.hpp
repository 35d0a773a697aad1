#ifndef INSONIFY_BVH_PREPARED_RAY_HPP
#define INSONIFY_BVH_PREPARED_RAY_HPP

#include <insonify/bvh/node.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <insonify/geometry/triangle.hpp>

namespace insonify::inline INSONIFY_ABI {

/// False for NaN; reads the bits, so that it holds under -ffast-math too.
INSONIFY_FN INSONIFY_INLINE bool is_number(float value) {
    return (__builtin_bit_cast(std::uint32_t, value) & 0x7FFFFFFFU) <= 0x7F800000U;
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
    ray source{};
    float inverse[4] = {}; ///< 1 / direction, finite; the fourth of these and of what follows is not used
    float entry[4] = {-FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};
    float exit[4] = {FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX};
    std::uint32_t entry_row[4] = {}; ///< of a node's bounds: the side that the ray meets first ...
    std::uint32_t exit_row[4] = {};  ///< ... and last
    sheared_ray sheared{};
    /// A ray that is not meets nothing. One that is has a finite origin and direction, numbers for limits, and moves.
    bool legal = false;

    /// @param reach  no coordinate of a box is further from 0
    INSONIFY_FN INSONIFY_INLINE void prepare(const ray& r, float reach) {
        using axes = lanes<4>;
        const axes given = each_lane<4>([&](int axis) { return axis < 3 ? r.direction[axis] : 0.0F; });
        const axes origin = each_lane<4>([&](int axis) { return axis < 3 ? r.origin[axis] : 0.0F; });
        const axes none(0.0F), wild = floats_of<4>(not_finite<4>(given) | not_finite<4>(origin));
        legal = bits_of(wild < none) == 0 && is_number(r.min_distance) && is_number(r.max_distance);
        if (!legal) return;
        const auto moves = axes(1e-30F) < absolute(given); // less is too little to be divided by
        legal = bits_of(moves) != 0;
        if (!legal) return;
        const axes along = select(moves, given, none), size = absolute(along), longest(greatest(size));
        const axes from = absolute(origin);
        source = r;
        source.direction = {along[0], along[1], along[2]};
        // Not 1 instead of 0: clang inverts constants by itself, and then divides by 0 all the same.
        const axes swift = select(moves, insonify::inverse(select(moves, along, longest)), axes(1e30F));
        const axes begin = -origin * swift;
        const axes room = absolute(swift) * (axes(5e-7F) * (from + axes(reach)) + axes(1e-20F));
        // Not where it is so far away that an axis tells nothing, nor where the huge inverse is not huge enough: further
        // than `extent / longest` is no hit.
        const axes extent(sum(from) + reach);
        const auto tells = absolute(begin) + room < axes(1e36F) && (moves || extent <= room * longest);
        const axes middle = select(tells, begin, none), apart = select(tells, room, axes(FLT_MAX)); // finite, both
        store(select(tells, swift, none), inverse);
        store(middle - apart, entry);
        store(middle + apart, exit);
        const auto upper_first = bit_lanes<4>{} - (raw_bits<4>(swift) >> 31); // all bits of an axis, or none
        constexpr auto first_row = tree_node<Width>::row(0, 0), next_row = tree_node<Width>::row(0, 1);
        constexpr auto upper_row = tree_node<Width>::row(1, 0);
        const auto met_first = steps_of_bits<4>(first_row, next_row) + (upper_first & upper_row);
        store_bits<4>(met_first, entry_row);
        store_bits<4>(steps_of_bits<4>(upper_row, 2 * next_row) - met_first, exit_row);
        sheared = sheared_ray{source};
    }
};

/// Where the ray enters the boxes of a node's children, with a bit in `met`, that it meets within its limits; FLT_MAX for
/// the others.
template <int Width>
struct box_entries {
    lanes<Width> distance{};
    std::uint32_t met = 0;
};

/// Slab test of all children at once. Conservative: rounding never loses a box.
/// @param max_distance  FLT_MAX at most
template <int Width>
INSONIFY_FN INSONIFY_INLINE box_entries<Width> enter(const tree_node<Width>& node, const prepared_ray<Width>& r,
                                                     float max_distance) {
    using floats = lanes<Width>;
    floats in(r.source.min_distance), out(max_distance);
    for (int axis = 0; axis < 3; ++axis) {
        const floats inverse(r.inverse[axis]), entry(r.entry[axis]), exit(r.exit[axis]);
        in = greater(multiply_add(load<Width>(node.sides + r.entry_row[axis]), inverse, entry), in);
        out = lesser(multiply_add(load<Width>(node.sides + r.exit_row[axis]), inverse, exit), out);
    }
    const auto met = in <= out;
    return {select(met, in, floats(FLT_MAX)), bits_of(met)};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
