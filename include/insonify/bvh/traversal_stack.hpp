#ifndef INSONIFY_BVH_TRAVERSAL_STACK_HPP
#define INSONIFY_BVH_TRAVERSAL_STACK_HPP

#include <insonify/bvh/node.hpp>
#include <insonify/execution/pack.hpp>

/// Where a walk through a tree goes next, and what waits until then, as children's codes; in two orders, for two kinds of
/// questions, both without branches on which children are met, since no one foresees that:
///
///     start()               to the root
///     go_down(node, ...)    to one of the node's children that are met, of which there is one at least
///     go_back(limit)        to what has waited; false where nothing does, which is the end of the way
namespace insonify::inline INSONIFY_ABI {

/// Each level takes one from what waits and adds at most Width; `pack_lanes` writes as many in any case.
template <int Width>
inline constexpr std::uint32_t most_waiting = most_levels<Width>*(Width - 1) + 1;

/// To the nearest first, and back to nothing that begins beyond the limit: for the nearest hit.
template <int Width>
struct nearest_first {
    std::uint32_t next = 0;
    std::uint32_t waiting = 0;
    std::uint32_t stack[most_waiting<Width>];
    std::uint32_t begins[most_waiting<Width>]; // of each, the bits of its distance

    INSONIFY_FN INSONIFY_INLINE void start() { next = waiting = 0; }

    /// @param distance  where each child begins: FLT_MAX at most, and that for those that are not met
    /// @param met       a bit for each
    INSONIFY_FN INSONIFY_INLINE void go_down(const tree_node<Width>& node, const lanes<Width>& distance,
                                             std::uint32_t met) {
        const std::uint32_t tied = met & bits_of(distance == lanes<Width>(least(distance)));
        const std::uint32_t nearest = lowest_bit(tied | 1U << (Width - 1)); // no lane beyond, whatever the numbers
        next = node.child[nearest];
        met &= ~(1U << nearest);
        pack_lanes<Width>(raw_bits<Width>(distance), met, begins + waiting);
        waiting += pack_lanes<Width>(load_bits<Width>(node.child), met, stack + waiting);
    }

    INSONIFY_FN INSONIFY_INLINE bool go_back(float limit) {
        do {
            if (waiting == 0) return false;
            next = stack[--waiting];
        } while (__builtin_bit_cast(float, begins[waiting]) > limit);
        return true;
    }
};

/// As they come: for whether anything is hit, and for all that is.
template <int Width>
struct any_order {
    std::uint32_t next = 0;
    std::uint32_t waiting = 0;
    std::uint32_t stack[most_waiting<Width>];

    INSONIFY_FN INSONIFY_INLINE void start() { next = waiting = 0; }

    /// @param met  a bit for each child
    INSONIFY_FN INSONIFY_INLINE void go_down(const tree_node<Width>& node, const lanes<Width>&, std::uint32_t met) {
        waiting += pack_lanes<Width>(load_bits<Width>(node.child), met, stack + waiting);
        next = stack[--waiting];
    }

    INSONIFY_FN INSONIFY_INLINE bool go_back(float) {
        if (waiting == 0) return false;
        next = stack[--waiting];
        return true;
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
