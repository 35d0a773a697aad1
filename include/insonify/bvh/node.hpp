#ifndef INSONIFY_BVH_NODE_HPP
#define INSONIFY_BVH_NODE_HPP

#include <insonify/execution/simd.hpp>
#include <insonify/geometry/aabb.hpp>
#include <bit>
#include <cstdint>
#include <vector>

/// A tree in three arrays: who is whose child (`topology`), the bounds of the children (`node_bounds`), and what the
/// leaves hold (see leaf.hpp). The first is made by a builder and stays; the other two follow moving primitives.
///
///     node 0:  [ node 1 | leaf 0 | node 2 | leaf 1 | - | - | - | - ]        Width = 8 children
///     slots:   leaf 0: 5 0 7 - - - - -   leaf 1: 3 4 - ...                  Width primitives to a leaf
namespace insonify::inline INSONIFY_ABI {

/// Marks an empty slot of a leaf.
inline constexpr std::uint32_t no_primitive = ~0U;

/// A child's code: the index of a node, or this bit and the index of a leaf, or `no_child`.
inline constexpr std::uint32_t leaf_bit = 0x80000000U;
inline constexpr std::uint32_t no_child = ~0U;

/// No tree is deeper, whatever the primitives: builders halve by number once a node stands this far down ...
inline constexpr std::uint32_t free_levels = 24;

/// ... which ends within as many more levels as 2^32 primitives take.
template <int Width>
inline constexpr std::uint32_t
    most_levels = free_levels + 33 / static_cast<std::uint32_t>(std::bit_width(static_cast<unsigned>(Width)) - 1);

template <int Width>
struct node_children {
    std::uint32_t child[Width];
};

/// Boxes of a node's children, side by side for SIMD: [lower, upper][axis][child]. Children precede no parent.
template <int Width>
struct alignas(sizeof(float) * Width) node_bounds {
    float side[2][3][Width];

    INSONIFY_FN aabb box(int child) const {
        return {{side[0][0][child], side[0][1][child], side[0][2][child]},
                {side[1][0][child], side[1][1][child], side[1][2][child]}};
    }
    INSONIFY_FN void set_box(int child, const aabb& b) {
        for (int axis = 0; axis < 3; ++axis) {
            side[0][axis][child] = b.lower[axis];
            side[1][axis][child] = b.upper[axis];
        }
    }
    INSONIFY_FN aabb all() const {
        aabb whole;
        for (int child = 0; child < Width; ++child) whole = merged(whole, box(child));
        return whole;
    }
};

/// What a builder makes. Node 0 is the root; a child's index is above its parent's. No nodes: an empty tree.
template <int Width>
struct topology {
    std::vector<node_children<Width>> nodes{};
    std::vector<std::uint32_t> slots{}; ///< leaf b holds primitives slots[b * Width] onwards, `no_primitive` after them
    std::uint32_t levels = 0;           ///< of nodes on the longest way down, at most `most_levels`

    std::size_t leaves() const { return slots.size() / Width; }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
