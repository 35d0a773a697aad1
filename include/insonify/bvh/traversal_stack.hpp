#ifndef INSONIFY_BVH_TRAVERSAL_STACK_HPP
#define INSONIFY_BVH_TRAVERSAL_STACK_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/node.hpp>
#include <insonify/execution/pack.hpp>

/// The traversal stack of child references, in two orders. Which children are hit is unpredictable, so neither order
/// branches on it.
///
///     start()               the root is next
///     descend(node, ...)    one of the children that were hit, at least one, is next; the others are pushed
///     pop(limit)            the top of the stack is next; false if the stack is empty
namespace insonify::inline INSONIFY_ABI::detail {

/// Capacity: each level pops one reference and pushes at most Width, and `detail::pack_lanes` always writes Width.
template <int Width>
inline constexpr std::uint32_t max_stack = max_levels<Width>*(Width - 1) + 1;

/// Front to back, and skips references that begin beyond the limit: for closest hits.
template <int Width>
struct nearest_first {
    std::uint32_t next = 0;
    std::uint32_t size = 0;
    std::uint32_t references[max_stack<Width>];
    std::uint32_t distances[max_stack<Width>]; // at which each reference begins, as bits

    INSONIFY_FN INSONIFY_INLINE void start() { next = size = 0; }

    /// @param distance  at which the ray enters each child; FLT_MAX for those it misses
    /// @param met       a bit for each child that is hit
    INSONIFY_FN INSONIFY_INLINE void descend(const tree_node<Width>& node, const lanes<Width>& distance,
                                             std::uint32_t met) {
        const std::uint32_t tied = met & bits_of(distance == lanes<Width>(reduce_min(distance)));
        const std::uint32_t nearest =
            lowest_bit(tied | 1U << (Width - 1)); // never out of range, whatever the numbers are
        next = node.child[nearest];
        met &= ~(1U << nearest);
        detail::pack_lanes<Width>(raw_bits<Width>(distance), met, distances + size);
        size += detail::pack_lanes<Width>(load_bits<Width>(node.child), met, references + size);
    }

    INSONIFY_FN INSONIFY_INLINE bool pop(float limit) {
        do {
            if (size == 0) return false;
            next = references[--size];
        } while (entry() > limit);
        return true;
    }

    /// The distance at which `next` begins, after `pop`.
    INSONIFY_FN INSONIFY_INLINE float entry() const { return __builtin_bit_cast(float, distances[size]); }
};

/// In no order: for any hit, and for all hits.
template <int Width>
struct any_order {
    std::uint32_t next = 0;
    std::uint32_t size = 0;
    std::uint32_t references[max_stack<Width>];

    INSONIFY_FN INSONIFY_INLINE void start() { next = size = 0; }

    /// @param met  a bit for each child that is hit
    INSONIFY_FN INSONIFY_INLINE void descend(const tree_node<Width>& node, const lanes<Width>&, std::uint32_t met) {
        size += detail::pack_lanes<Width>(load_bits<Width>(node.child), met, references + size);
        next = references[--size];
    }

    INSONIFY_FN INSONIFY_INLINE bool pop(float) {
        if (size == 0) return false;
        next = references[--size];
        return true;
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
