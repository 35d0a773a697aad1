#ifndef INSONIFY_BVH_NODE_HPP
#define INSONIFY_BVH_NODE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/large_array.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/geometry/triangle.hpp>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

/// A BVH is three arrays: nodes, with child references from the builder and boxes from the last refit; slots, which
/// list the primitives of each leaf; and leaves, with the data that rays are intersected with (see leaf.hpp).
///
///     node 0:  [ node 1 | leaf 0 | node 2 | leaf 1 | - | - | - | - ]        Width = 8 children
///     slots:   leaf 0: 0 5 7 - - - - -   leaf 1: 3 4 - ...                  Width primitives per leaf
namespace insonify::inline INSONIFY_ABI {

/// Marks an empty slot of a leaf.
inline constexpr std::uint32_t no_primitive = ~0U;

/// A child reference is the index of a node, or this bit and the index of a leaf, or `no_child`.
inline constexpr std::uint32_t leaf_bit = 0x80000000U;
/// Marks a child that does not exist.
inline constexpr std::uint32_t no_child = ~0U;

namespace detail {

template <int Width>
inline constexpr auto width_bits = static_cast<std::uint32_t>(std::countr_zero(static_cast<unsigned>(Width)));

/// Bounds the depth for any input: median split below this depth ...
inline constexpr std::uint32_t free_levels = 24;

/// ... which takes at most this many levels in all, for 2^32 primitives.
template <int Width>
inline constexpr std::uint32_t max_levels = free_levels + 33 / width_bits<Width>;

/// Sums of half surface areas, in square metres.
struct box_areas {
    double nodes = 0;
    double leaves = 0;
};

} // namespace detail

/// Boxes and references of the children. 256 bytes at width 8: four cache lines.
template <int Width>
struct alignas(64) tree_node {
    static_assert(Width == 4 || Width == 8, "a tree has 4 or 8 children per node");
    float sides[6 * Width];     ///< rows of lower x, y, z, then of upper x, y, z
    std::uint32_t child[Width]; ///< references

    /// The index in `sides` where the row of a side begins. @param upper  0 or 1
    INSONIFY_FN static constexpr std::uint32_t row(std::uint32_t upper, std::uint32_t axis) {
        return (3 * upper + axis) * Width;
    }
    /// The box of child i.
    /// @{
    INSONIFY_FN aabb box(int i) const {
        const float* const side = sides + i;
        return {{side[row(0, 0)], side[row(0, 1)], side[row(0, 2)]},
                {side[row(1, 0)], side[row(1, 1)], side[row(1, 2)]}};
    }
    INSONIFY_FN void set_box(int i, const aabb& b) {
        float* const side = sides + i;
        side[row(0, 0)] = b.lower.x;
        side[row(0, 1)] = b.lower.y;
        side[row(0, 2)] = b.lower.z;
        side[row(1, 0)] = b.upper.x;
        side[row(1, 1)] = b.upper.y;
        side[row(1, 2)] = b.upper.z;
    }
    /// @}
};

/// The output of a builder. Node 0 is the root, children come after their parent; no nodes: an empty tree.
template <int Width>
struct topology {
    /// Consecutive nodes that form a complete subtree: parts can be processed in parallel.
    struct part {
        std::uint32_t begin = 0;      ///< the first node
        std::uint32_t end = 0;        ///< the node after the last one
        std::uint32_t first_leaf = 0; ///< leaves are consecutive as well
        std::uint32_t leaf_end = 0;   ///< the leaf after the last one
        detail::box_areas areas{};    ///< of its boxes: scratch of `refit`, which therefore does not allocate
    };
    detail::large_array<tree_node<Width>> nodes{}; ///< the root first
    detail::large_array<std::uint32_t> slots{};    ///< of leaf b from b * Width on; `no_primitive` where empty
    detail::large_array<part> parts{};             ///< nodes before the first part are ancestors of all
    std::uint32_t levels = 0;                      ///< nodes on the longest path from the root, at most `max_levels`

    /// The number of leaves.
    std::size_t leaves() const { return slots.size() / Width; }
};

/// A primitive has `bounds(p)` and `intersect(ray, p)`, found by argument-dependent lookup.
///
/// `intersect` returns at most one hit and may ignore the ray's limits: the BVH discards hits outside them, and sets
/// `hit::primitive`. Primitives whose bounds are empty or not finite are never hit.
template <class Primitive>
concept primitive = requires(const Primitive& p, const ray& r) {
    { bounds(p) } -> std::convertible_to<aabb>;
    { intersect(r, p) } -> std::convertible_to<hit>;
};

/// The element type of a range.
template <class Range>
using range_primitive_t = std::remove_cvref_t<decltype(std::declval<const Range&>()[std::size_t{}])>;

/// A copyable view of primitives with `size()` and `[]`, such as `view<T>` and `mesh_view`.
template <class Range>
concept primitive_range = std::is_copy_constructible_v<Range> && std::is_copy_assignable_v<Range> &&
    primitive<range_primitive_t<Range>> && requires(const Range& range) {
    { range.size() } -> std::convertible_to<std::size_t>;
};

namespace detail {

/// A ray with the constants of its box and triangle tests.
///
/// It crosses the side of a box at coordinate s at the distance s * inverse + entry (or + exit). These differ by the
/// rounding error, so that the slab test is conservative (Ize 2013, "Robust BVH ray traversal"). Along an axis with a
/// direction component of 0 the inverse is huge: the ray enters every box whose sides it lies between or on, since only
/// the triangle test decides which triangle owns an edge that two boxes share.
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

/// Slab test of all children. Conservative: rounding never loses a box.
/// @param max_distance  FLT_MAX at most
/// @param entry         where the ray enters them; FLT_MAX for those it misses
/// @return a bit for each child that is hit
template <int Width>
INSONIFY_FN INSONIFY_INLINE std::uint32_t enter(const tree_node<Width>& node, const prepared_ray<Width>& r,
                                                float max_distance, lanes<Width>& entry) {
    using floats = lanes<Width>;
    floats in(r.source.min_distance), out(max_distance);
    for (int axis = 0; axis < 3; ++axis) {
        const floats inverse(r.inverse[axis]);
        in = max(multiply_add(load<Width>(node.sides + r.entry_row[axis]), inverse, floats(r.entry[axis])), in);
        out = min(multiply_add(load<Width>(node.sides + r.exit_row[axis]), inverse, floats(r.exit[axis])), out);
    }
    const auto met = in <= out;
    entry = select(met, in, floats(FLT_MAX));
    return bits_of(met);
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
