#ifndef INSONIFY_BVH_PREPARED_RAY_HPP
#define INSONIFY_BVH_PREPARED_RAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/node.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/triangle.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// A ray with the constants of its box and triangle tests.
///
/// It crosses the side of a box at coordinate s at the distance s * inverse + entry (or + exit). `entry` and `exit` differ
/// by the accumulated rounding error, so that the slab test is conservative (Ize 2013, "Robust BVH ray traversal"). Along
/// an axis with a direction component of 0 the inverse is huge: the ray then enters every box whose sides it lies between
/// or on. A ray in the plane between two boxes must enter both, since only the triangle test decides which triangle owns
/// their shared edge.
template <int Width>
struct prepared_ray {
    ray source{};
    float inverse[4] = {}; ///< 1 / direction, finite; the fourth lane of each array is unused
    float entry[4] = {-FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};
    float exit[4] = {FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX};
    std::uint32_t entry_row[4] = {}; ///< of a node's sides: the one where the ray enters ...
    std::uint32_t exit_row[4] = {};  ///< ... and where it leaves
    sheared_ray sheared{};
    /// Finite origin, finite direction other than 0, and limits that are not NaN. Other rays miss everything.
    bool valid = false;

    /// @param max_abs_coordinate  of all boxes
    INSONIFY_FN INSONIFY_INLINE void prepare(const ray& r, float max_abs_coordinate) {
        using axes = lanes<4>;
        const axes given = each_lane<4>([&](int axis) { return axis < 3 ? r.direction[axis] : 0.0F; });
        const axes origin = each_lane<4>([&](int axis) { return axis < 3 ? r.origin[axis] : 0.0F; });
        const axes none(0.0F), wild = floats_of<4>(not_finite<4>(given) | not_finite<4>(origin));
        valid = bits_of(wild < none) == 0 && is_number(r.min_distance) && is_number(r.max_distance);
        if (!valid) return;
        const auto moves = axes(1e-30F) < abs(given); // smaller components count as 0
        valid = bits_of(moves) != 0;
        if (!valid) return;
        const axes along = select(moves, given, none), size = abs(along), longest(reduce_max(size));
        const axes from = abs(origin);
        source = r;
        source.direction = {along[0], along[1], along[2]};
        // Divides by `longest` in place of 0, not by a constant 1: clang would fold the select and divide by 0.
        const axes swift = select(moves, insonify::inverse(select(moves, along, longest)), axes(1e30F));
        const axes begin = -origin * swift;
        const axes room = abs(swift) * (axes(5e-7F) * (from + axes(max_abs_coordinate)) + axes(1e-20F));
        // An axis is ignored where distances overflow, or where the huge inverse is too small: hits lie within
        // `extent / longest`.
        const axes extent(sum(from) + max_abs_coordinate);
        const auto tells = abs(begin) + room < axes(1e36F) && (moves || extent <= room * longest);
        const axes middle = select(tells, begin, none), apart = select(tells, room, axes(FLT_MAX)); // both finite
        store(select(tells, swift, none), inverse);
        store(middle - apart, entry);
        store(middle + apart, exit);
        const auto upper_first = bit_lanes<4>{} - (raw_bits<4>(swift) >> 31); // a full mask per axis
        constexpr auto first_row = tree_node<Width>::row(0, 0), next_row = tree_node<Width>::row(0, 1);
        constexpr auto upper_row = tree_node<Width>::row(1, 0);
        const auto met_first = steps_of_bits<4>(first_row, next_row) + (upper_first & upper_row);
        store_bits<4>(met_first, entry_row);
        store_bits<4>(steps_of_bits<4>(upper_row, 2 * next_row) - met_first, exit_row);
        sheared = sheared_ray{source};
    }
};

/// The distances at which a ray enters the boxes of a node's children, FLT_MAX for those it misses, and a bit for each hit.
template <int Width>
struct box_entries {
    lanes<Width> distance{};
    std::uint32_t met = 0;
};

/// Slab test of all children. Conservative: rounding never loses a box.
/// @param max_distance  FLT_MAX at most
template <int Width>
INSONIFY_FN INSONIFY_INLINE box_entries<Width> enter(const tree_node<Width>& node, const prepared_ray<Width>& r,
                                                     float max_distance) {
    using floats = lanes<Width>;
    floats in(r.source.min_distance), out(max_distance);
    for (int axis = 0; axis < 3; ++axis) {
        const floats inverse(r.inverse[axis]), entry(r.entry[axis]), exit(r.exit[axis]);
        in = max(multiply_add(load<Width>(node.sides + r.entry_row[axis]), inverse, entry), in);
        out = min(multiply_add(load<Width>(node.sides + r.exit_row[axis]), inverse, exit), out);
    }
    const auto met = in <= out;
    return {select(met, in, floats(FLT_MAX)), bits_of(met)};
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
