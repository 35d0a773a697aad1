#ifndef INSONIFY_BVH_TRAVERSE_HPP
#define INSONIFY_BVH_TRAVERSE_HPP

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/bvh/traversal_stack.hpp>
#include <insonify/core/view.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

template <primitive_range Range, int Width, class Order>
struct tree_walk;

/// A tree as traversal sees it, on the host or a device: pointers to its arrays. Trivially copyable, owns nothing.
template <primitive_range Range, int Width = simd_width>
struct bvh_view {
    view<const tree_node<Width>> nodes{};
    view<const leaf<Range, Width>> leaves{};
    Range range{};
    float reach = 0;     ///< no coordinate of a box is further from 0
    float leaf_size = 0; ///< metres: the mean of leaves, as squares

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

    /// The nearest hit; of equally near ones the lowest primitive.
    INSONIFY_FN hit closest(const ray& r) const {
        hit best;
        tree_walk<Range, Width, nearest_first<Width>> walk;
        for (bool more = walk.start(*this, r); more;) more = walk.step_closest(*this, best);
        return best;
    }

    /// Whether anything is hit.
    INSONIFY_FN bool any(const ray& r) const {
        bool met = false;
        tree_walk<Range, Width, any_order<Width>> walk;
        for (bool more = walk.start(*this, r); more && !met;) more = walk.step(*this, [&](const hit&) { met = true; });
        return met;
    }

    /// Calls visit(hit) for every hit, in no order, each primitive once.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each_hit(const ray& r, Visit&& visit) const {
        tree_walk<Range, Width, any_order<Width>> walk;
        for (bool more = walk.start(*this, r); more;) more = walk.step(*this, visit);
    }

    /// Calls visit(primitive) for every primitive whose bounds overlap the shape: an `aabb` or a `plane`.
    template <class Shape, class Visit>
    INSONIFY_FN void for_each_overlap(const Shape& shape, Visit&& visit) const {
        if (nodes.empty()) return;
        std::uint32_t stack[most_waiting<Width>];
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
/// @tparam Order  `nearest_first` where the limit comes nearer on the way, otherwise `any_order`: see traversal_stack.hpp
template <primitive_range Range, int Width, class Order>
struct tree_walk {
    using tree_view = bvh_view<Range, Width>;

    prepared_ray<Width> r{};
    float limit = 0; ///< what a hit must not be beyond; a visitor may lower it
    Order way;

    /// @return false where there is nothing to meet
    INSONIFY_FN INSONIFY_INLINE bool start(const tree_view& tree, const ray& source) {
        r.prepare(source, tree.reach);
        const bool endless = __builtin_bit_cast(std::uint32_t, source.max_distance) == 0x7F800000U; // read as bits, for
        limit = endless ? FLT_MAX : source.max_distance; // under -ffast-math there is no infinity, and a NaN would trap
        way.start();
        return r.legal && !tree.nodes.empty();
    }

    /// Calls visit(hit) for what is met between the ray's limits, in no order. @return false at the end of the way
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN INSONIFY_INLINE bool step(const tree_view& tree, Visit&& visit) {
        if ((way.next & leaf_bit) == 0) {
            const tree_node<Width>& node = tree.nodes[way.next];
            const box_entries<Width> boxes = enter(node, r, limit);
            if (boxes.met != 0) {
                way.go_down(node, boxes.distance, boxes.met);
                tree.prefetch(way.next);
                return true;
            }
        } else if (way.next != no_child) {
            tree.leaves[way.next ^ leaf_bit].intersect_all(r, limit, tree.range, visit);
        }
        if (!way.go_back(limit)) return false;
        tree.prefetch(way.next);
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
