#ifndef INSONIFY_BVH_TRAVERSAL_STACK_HPP
#define INSONIFY_BVH_TRAVERSAL_STACK_HPP

#include <insonify/bvh/node.hpp>
#include <insonify/execution/pack.hpp>

/// Where a walk through a tree goes next, and what waits until then, as children's codes; in two orders, for two kinds of
/// questions:
///
///     start()               to the root
///     go_down(node, ...)    to one of the node's children that are met, of which there is one at least
///     go_back(limit)        to what has waited; false where nothing does, which is the end of the way
namespace insonify::inline INSONIFY_ABI {

/// Each level takes one from what waits and adds at most Width.
template <int Width>
inline constexpr std::uint32_t most_waiting = most_levels<Width>*(Width - 1) + 1;

/// To the nearest first, and back to nothing that begins beyond the limit: for the nearest hit.
template <int Width>
struct nearest_first {
    std::uint32_t next = 0;
    std::uint32_t waiting = 0;
    std::int64_t stack[most_waiting<Width>];

    INSONIFY_FN INSONIFY_INLINE void start() { next = waiting = 0; }

    /// @param distance  where each child begins  @param met  a bit for each
    INSONIFY_FN INSONIFY_INLINE void go_down(const tree_node<Width>& node, const lanes<Width>& distance,
                                             std::uint32_t met) {
        const std::uint32_t first = lowest_bit(met);
        next = node.child[first];
        if ((met &= met - 1) == 0) return;
        alignas(sizeof(float) * Width) float distances[Width];
        store(distance, distances);
        std::int64_t nearest = key_of(distances[first], next);
        do {
            const std::uint32_t i = lowest_bit(met);
            const std::int64_t key = key_of(distances[i], node.child[i]);
            stack[waiting++] = key < nearest ? nearest : key;
            nearest = key < nearest ? key : nearest;
        } while ((met &= met - 1) != 0);
        next = static_cast<std::uint32_t>(nearest);
    }

    INSONIFY_FN INSONIFY_INLINE bool go_back(float limit) {
        do {
            if (waiting == 0) return false;
            next = static_cast<std::uint32_t>(stack[--waiting]);
        } while (distance_of(stack[waiting]) > limit);
        return true;
    }

  private:
    // A distance in the upper half, so that keys order as distances do (but among negative ones, where the order does not
    // matter), and a child's code in the lower.
    INSONIFY_FN static std::int64_t key_of(float distance, std::uint32_t child) {
        return static_cast<std::int64_t>(std::uint64_t{__builtin_bit_cast(std::uint32_t, distance)} << 32U | child);
    }
    INSONIFY_FN static float distance_of(std::int64_t key) {
        return __builtin_bit_cast(float, static_cast<std::uint32_t>(static_cast<std::uint64_t>(key) >> 32U));
    }
};

/// As they come, without a branch, since no one foresees what a ray meets: for whether anything is hit, and for all that
/// is.
template <int Width>
struct any_order {
    std::uint32_t next = 0;
    std::uint32_t waiting = 0;
    std::uint32_t
        stack[most_waiting<Width>]; // with room for all of the last node's children, which `pack_lanes` writes

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
