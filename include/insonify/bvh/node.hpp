#ifndef INSONIFY_BVH_NODE_HPP
#define INSONIFY_BVH_NODE_HPP

#include <insonify/bvh/large_array.hpp>
#include <insonify/geometry/aabb.hpp>
#include <bit>
#include <cstdint>

/// A tree in three arrays: the nodes (whose children are whose, made by a builder, and the boxes around them, which
/// follow moving primitives), the slots, which say whose primitives are whose, and the leaves, which hold what rays ask
/// for, the indices of usable primitives among it (see leaf.hpp).
///
///     node 0:  [ node 1 | leaf 0 | node 2 | leaf 1 | - | - | - | - ]        Width = 8 children
///     slots:   leaf 0: 0 5 7 - - - - -   leaf 1: 3 4 - ...                  Width primitives to a leaf
namespace insonify::inline INSONIFY_ABI {

/// Marks an empty slot of a leaf.
inline constexpr std::uint32_t no_primitive = ~0U;

/// A child's code: the index of a node, or this bit and the index of a leaf, or `no_child`.
inline constexpr std::uint32_t leaf_bit = 0x80000000U;
inline constexpr std::uint32_t no_child = ~0U;

/// The logarithm of a width, to base 2.
template <int Width>
inline constexpr auto width_bits = static_cast<std::uint32_t>(std::countr_zero(static_cast<unsigned>(Width)));

/// No tree is deeper, whatever the primitives: builders halve by number once a node stands this far down ...
inline constexpr std::uint32_t free_levels = 24;

/// ... which ends within as many more levels as 2^32 primitives take.
template <int Width>
inline constexpr std::uint32_t most_levels = free_levels + 33 / width_bits<Width>;

/// Boxes side by side for SIMD: three rows of lower sides, x, y, z, then three of upper ones.
template <int Width>
struct box_rows {
    float sides[6 * Width];

    /// Where the row of a side begins in `sides`. @param upper  0 or 1
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

/// The boxes of the children, and their codes. 256 bytes at a width of 8: four lines of cache.
template <int Width>
struct alignas(64) tree_node : box_rows<Width> {
    static_assert(std::has_single_bit(static_cast<unsigned>(Width)), "the width of a tree must be a power of two");
    std::uint32_t child[Width];
};

/// Sums of the halved surfaces of boxes, square metres.
struct box_areas {
    double nodes = 0;
    double leaves = 0;
};

/// What a builder makes. Node 0 is the root; a child's index is above its parent's. No nodes: an empty tree.
template <int Width>
struct topology {
    /// Consecutive nodes that make a whole tree by themselves: parts may be worked on at the same time.
    struct part {
        std::uint32_t begin = 0;
        std::uint32_t end = 0;
        std::uint32_t first_leaf = 0; ///< its leaves are consecutive as well
        std::uint32_t leaf_end = 0;
        box_areas areas{}; ///< of its boxes, written by `refit`; here so that it allocates nothing
    };
    large_array<tree_node<Width>> nodes{};
    large_array<std::uint32_t> slots{}; ///< leaf b holds primitives slots[b * Width] onwards, `no_primitive` after them
    large_array<part> parts{};          ///< the nodes before the first one are above them all
    std::uint32_t levels = 0;           ///< of nodes on the longest way down, at most `most_levels`

    std::size_t leaves() const { return slots.size() / Width; }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
