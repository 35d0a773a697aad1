#ifndef INSONIFY_BVH_NODE_HPP
#define INSONIFY_BVH_NODE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/large_array.hpp>
#include <insonify/geometry/ray.hpp>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

/// A BVH is three arrays: nodes, with child references from the builder and boxes from the last refit; slots, which list
/// the primitives of each leaf; and leaves, with the data that rays are intersected with (see leaf.hpp).
///
///     node 0:  [ node 1 | leaf 0 | node 2 | leaf 1 | - | - | - | - ]        Width = 8 children
///     slots:   leaf 0: 0 5 7 - - - - -   leaf 1: 3 4 - ...                  Width primitives per leaf
namespace insonify::inline INSONIFY_ABI {

/// Marks an empty slot of a leaf.
inline constexpr std::uint32_t no_primitive = ~0U;

/// A child reference is the index of a node, or this bit and the index of a leaf, or `no_child`.
inline constexpr std::uint32_t leaf_bit = 0x80000000U;
inline constexpr std::uint32_t no_child = ~0U;

/// The binary logarithm of a width.
template <int Width>
inline constexpr auto width_bits = static_cast<std::uint32_t>(std::countr_zero(static_cast<unsigned>(Width)));

/// Bounds the depth for any input: median split below this depth ...
inline constexpr std::uint32_t free_levels = 24;

/// ... which takes at most this many levels in all, for 2^32 primitives.
template <int Width>
inline constexpr std::uint32_t max_levels = free_levels + 33 / width_bits<Width>;

/// Boxes and references of the children. 256 bytes at width 8: four cache lines.
template <int Width>
struct alignas(64) tree_node {
    static_assert(std::has_single_bit(static_cast<unsigned>(Width)), "the width of a tree must be a power of two");
    float sides[6 * Width]; ///< rows of lower x, y, z, then of upper x, y, z
    std::uint32_t child[Width];

    /// The index in `sides` where the row of a side begins. @param upper  0 or 1
    INSONIFY_FN static constexpr std::uint32_t row(std::uint32_t upper, std::uint32_t axis) {
        return (3 * upper + axis) * Width;
    }
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
};

/// Sums of half surface areas, in square metres.
struct box_areas {
    double nodes = 0;
    double leaves = 0;
};

/// The output of a builder. Node 0 is the root, children come after their parent; no nodes: an empty tree.
template <int Width>
struct topology {
    /// Consecutive nodes that form a complete subtree: parts can be processed in parallel.
    struct part {
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
        std::uint32_t first_leaf = 0; ///< leaves are consecutive as well
        std::uint32_t leaf_end = 0;
        box_areas areas{}; ///< of its boxes: scratch of `refit`, which therefore does not allocate
    };
    detail::large_array<tree_node<Width>> nodes{};
    detail::large_array<std::uint32_t>
        slots{};                       ///< leaf b holds primitives slots[b * Width] onwards, `no_primitive` after them
    detail::large_array<part> parts{}; ///< nodes before the first part are ancestors of all
    std::uint32_t levels = 0;          ///< nodes on the longest path from the root, at most `max_levels`

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
///
/// (std::copyable requires more and is slow to compile.)
template <class Range>
concept primitive_range = std::is_copy_constructible_v<Range> && std::is_copy_assignable_v<Range> &&
    primitive<range_primitive_t<Range>> && requires(const Range& range) {
    { range.size() } -> std::convertible_to<std::size_t>;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
