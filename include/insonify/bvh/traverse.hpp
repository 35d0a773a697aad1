#ifndef INSONIFY_BVH_TRAVERSE_HPP
#define INSONIFY_BVH_TRAVERSE_HPP

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/core/view.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

template <primitive_range Range, int Width>
struct tree_walk;

/// A tree as traversal sees it, on the host or a device: pointers to its arrays. Trivially copyable, owns nothing.
template <primitive_range Range, int Width = simd_width>
struct bvh_view {
    view<const tree_node<Width>> nodes{};
    view<const leaf<Range, Width>> leaves{};
    Range range{};
    float reach = 0;     ///< no coordinate of a box is further from 0
    float leaf_size = 0; ///< metres: the mean of leaves, as squares

    /// Each node pops one entry and pushes at most Width.
    static constexpr std::uint32_t stack_size = most_levels<Width> * (Width - 1) + 1;

    /// Asks for what a child's code stands for, long before it is looked at. Whether that is a leaf is a factor here, since
    /// a branch no one could foresee. What lies there is not read, so `no_child` may ask as well.
    INSONIFY_FN INSONIFY_INLINE void prefetch(std::uint32_t child) const {
        constexpr std::size_t of_node = sizeof(tree_node<Width>), of_leaf = sizeof(leaf<Range, Width>);
        constexpr std::size_t of_either = of_node < of_leaf ? of_node : of_leaf, line_size = 64; // of cache
        const std::size_t is_leaf = (child & leaf_bit) != 0, is_larger = of_node < of_leaf ? is_leaf : 1 - is_leaf;
        const std::size_t apart =
            reinterpret_cast<std::uintptr_t>(leaves.first) - reinterpret_cast<std::uintptr_t>(nodes.first);
        const std::size_t place = is_leaf * apart + (child & ~leaf_bit) * (of_node + is_leaf * (of_leaf - of_node));
        const char* const what = reinterpret_cast<const char*>(nodes.first) + static_cast<std::ptrdiff_t>(place);
        for (std::size_t line = 0; line < of_node || line < of_leaf; line += line_size)
            insonify::prefetch(what + (line < of_either ? line : is_larger * line));
    }

    /// What waits: its distance in the upper half, so that keys order as distances do (but among negative ones, where
    /// the order does not matter), and the child's code in the lower.
    INSONIFY_FN static std::int64_t key_of(float distance, std::uint32_t child) {
        return static_cast<std::int64_t>(std::uint64_t{__builtin_bit_cast(std::uint32_t, distance)} << 32U | child);
    }
    INSONIFY_FN static float distance_of(std::int64_t key) {
        return __builtin_bit_cast(float, static_cast<std::uint32_t>(static_cast<std::uint64_t>(key) >> 32U));
    }

    /// The nearest hit; of equally near ones the lowest primitive.
    INSONIFY_FN hit closest(const ray& r) const {
        hit best;
        tree_walk<Range, Width> walk;
        for (bool more = walk.start(*this, r); more;) more = walk.step_closest(*this, best);
        return best;
    }

    /// Whether anything is hit.
    INSONIFY_FN bool any(const ray& r) const {
        bool met = false;
        tree_walk<Range, Width> walk;
        for (bool more = walk.start(*this, r); more && !met;) more = walk.step(*this, [&](const hit&) { met = true; });
        return met;
    }

    /// Calls visit(hit) for every hit, in no order, each primitive once.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each_hit(const ray& r, Visit&& visit) const {
        tree_walk<Range, Width> walk;
        for (bool more = walk.start(*this, r); more;) more = walk.step(*this, visit);
    }

    /// Calls visit(primitive) for every primitive whose bounds overlap the shape: an `aabb` or a `plane`.
    template <class Shape, class Visit>
    INSONIFY_FN void for_each_overlap(const Shape& shape, Visit&& visit) const {
        if (nodes.empty()) return;
        std::uint32_t stack[stack_size];
        std::uint32_t waiting = 0;
        stack[waiting++] = 0;
        while (waiting > 0) {
            const std::uint32_t node = stack[--waiting];
            for (int i = 0; i < Width; ++i) {
                const std::uint32_t child = nodes[node].child[i];
                if (child == no_child || !overlaps(shape, nodes[node].box(i))) continue;
                if ((child & leaf_bit) == 0) {
                    stack[waiting++] = child;
                    continue;
                }
                for (const std::uint32_t primitive : leaves[child ^ leaf_bit].primitive)
                    if (primitive != no_primitive && overlaps(shape, bounds(range[primitive]))) visit(primitive);
            }
        }
    }
};

/// One ray on its way through a tree, a node or a leaf at each step. Between two steps the memory that the next one
/// needs is on its way too, so several rays that take turns wait less than one after the other.
template <primitive_range Range, int Width>
struct tree_walk {
    using tree_view = bvh_view<Range, Width>;

    prepared_ray<Width> r{};
    float limit = 0;           ///< what a hit must not be beyond; a visitor may lower it
    std::uint32_t next = 0;    ///< the child's code that the next step looks at
    std::uint32_t waiting = 0; ///< so many on the stack
    std::int64_t stack[tree_view::stack_size];

    /// @return false where there is nothing to meet
    INSONIFY_FN INSONIFY_INLINE bool start(const tree_view& tree, const ray& source) {
        r.prepare(source, tree.reach);
        limit = source.max_distance;
        next = 0;
        waiting = 0;
        return r.legal && !tree.nodes.empty();
    }

    /// Calls visit(hit) for what is met between the ray's limits, in no order. Children are taken nearest first, so that
    /// a visitor that lowers the limit to its best hit skips the rest. @return false at the end of the way
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN INSONIFY_INLINE bool step(const tree_view& tree, Visit&& visit) {
        if ((next & leaf_bit) == 0) {
            const tree_node<Width>& node = tree.nodes[next];
            const box_entries<Width> boxes = enter(node, r, limit);
            if (std::uint32_t left = boxes.met; left != 0) {
                const std::uint32_t first = lowest_bit(left);
                next = node.child[first];
                if ((left &= left - 1) == 0) {
                    tree.prefetch(next);
                    return true;
                }
                alignas(sizeof(float) * Width) float distance[Width];
                store(boxes.distance, distance);
                std::int64_t nearest = tree_view::key_of(distance[first], next);
                do {
                    const std::uint32_t i = lowest_bit(left);
                    const std::int64_t key = tree_view::key_of(distance[i], node.child[i]);
                    stack[waiting++] = key < nearest ? nearest : key;
                    nearest = key < nearest ? key : nearest;
                } while ((left &= left - 1) != 0);
                next = static_cast<std::uint32_t>(nearest);
                tree.prefetch(next);
                return true;
            }
        } else if (next != no_child) {
            const std::size_t index = next ^ leaf_bit;
            tree.leaves[index].intersect_all(r, limit, tree.range, visit);
        }
        do {
            if (waiting == 0) return false;
            next = static_cast<std::uint32_t>(stack[--waiting]);
        } while (tree_view::distance_of(stack[waiting]) > limit);
        tree.prefetch(next);
        return true;
    }

    /// A step towards the nearest hit; of equally near ones the lowest primitive.
    INSONIFY_FN INSONIFY_INLINE bool step_closest(const tree_view& tree, hit& best) {
        return step(tree, [&](const hit& found) {
            if (!nearer(found, best)) return;
            best = found;
            limit = found.distance;
        });
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
