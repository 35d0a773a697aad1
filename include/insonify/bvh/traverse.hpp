#ifndef INSONIFY_BVH_TRAVERSE_HPP
#define INSONIFY_BVH_TRAVERSE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/leaf.hpp>
#include <insonify/geometry/mesh.hpp>
#include <cstdint>

/// The traversal stack of child references. Which children are hit is unpredictable, so nothing branches on it.
///
///     start()               the root is next
///     descend(node, ...)    one of the children that were hit, at least one, is next; the others are pushed
///     pop(limit)            the top of the stack is next; false if the stack is empty
namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// Capacity: each level pops one reference and pushes at most Width, and `pack_lanes` always writes Width.
template <int Width>
inline constexpr std::uint32_t max_stack = max_levels<Width>*(Width - 1) + 1;

/// Front to back; skips references that begin beyond the limit.
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
        const std::uint32_t nearest = lowest_bit(tied | 1U << (Width - 1)); // never out of range, even for NaN
        next = node.child[nearest];
        met &= ~(1U << nearest);
        pack_lanes<Width>(raw_bits<Width>(distance), met, distances + size);
        size += pack_lanes<Width>(load_bits<Width>(node.child), met, references + size);
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

template <primitive_range Range, int Width>
struct ray_traversal;

} // namespace detail

/// A BVH as traversal reads it, on the host or a device: pointers to its arrays. Trivially copyable, owns nothing.
template <primitive_range Range, int Width = simd_width>
struct bvh_view {
    view<const tree_node<Width>> nodes{};            ///< the root first; none: an empty tree
    view<const detail::leaf<Range, Width>> leaves{}; ///< of `Width` primitives
    Range range{};                                   ///< the primitives
    float max_abs_coordinate = 0;                    ///< of all boxes: bounds the rounding of slab tests
    float leaf_size = 0;                             ///< metres: the edge of a square of the mean half area of leaves
    aabb box{};                                      ///< around all primitives

    /// Prefetches the node or leaf of a child reference. Computes the address without a branch on the kind of child,
    /// which would mispredict. Nothing is read, so `no_child` is allowed.
    INSONIFY_FN INSONIFY_INLINE void prefetch(std::uint32_t child) const {
        constexpr std::size_t of_node = sizeof(tree_node<Width>), of_leaf = sizeof(detail::leaf<Range, Width>);
        constexpr std::size_t of_either = of_node < of_leaf ? of_node : of_leaf, line_size = 64; // of cache
        const std::size_t is_leaf = (child & leaf_bit) != 0, is_larger = of_node < of_leaf ? is_leaf : 1 - is_leaf;
        const std::size_t apart =
            reinterpret_cast<std::uintptr_t>(leaves.first) - reinterpret_cast<std::uintptr_t>(nodes.first);
        const std::size_t place = is_leaf * apart + (child & ~leaf_bit) * (of_node + is_leaf * (of_leaf - of_node));
        const char* const what = reinterpret_cast<const char*>(nodes.first) + static_cast<std::ptrdiff_t>(place);
        for (std::size_t line = 0; line < of_node || line < of_leaf; line += line_size)
            detail::prefetch(what + (line < of_either ? line : is_larger * line));
    }

    /// The closest hit; ties go to the lowest primitive.
    INSONIFY_FN hit closest(const ray& r) const {
        hit best;
        detail::ray_traversal<Range, Width> traversal;
        for (bool more = traversal.start(*this, r); more;) more = traversal.step_closest(*this, best);
        return best;
    }

    /// Whether anything is hit.
    INSONIFY_FN bool any(const ray& r) const {
        bool met = false;
        detail::ray_traversal<Range, Width> traversal;
        for (bool more = traversal.start(*this, r); more && !met;)
            more = traversal.step(*this, [&](const hit&) { met = true; });
        return met;
    }

    /// Calls visit(hit) for every hit, in no order, once per primitive.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each_hit(const ray& r, Visit&& visit) const {
        detail::ray_traversal<Range, Width> traversal;
        for (bool more = traversal.start(*this, r); more;) more = traversal.step(*this, visit);
    }

    /// Calls visit(primitive) for every primitive whose bounds overlap a box.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each_overlap(const aabb& region, Visit&& visit) const {
        if (nodes.empty()) return;
        std::uint32_t stack[detail::max_stack<Width>];
        std::uint32_t size = 0;
        stack[size++] = 0;
        while (size > 0) {
            const std::uint32_t node = stack[--size];
            for (int i = 0; i < Width; ++i) {
                const std::uint32_t child = nodes[node].child[i];
                if (child == no_child || !overlaps(region, nodes[node].box(i))) continue;
                if ((child & leaf_bit) == 0) {
                    stack[size++] = child;
                    continue;
                }
                for (const std::uint32_t primitive : leaves[child ^ leaf_bit].primitive)
                    if (primitive != no_primitive && overlaps(region, bounds(range[primitive]))) visit(primitive);
            }
        }
    }
};

namespace detail {

/// The traversal of one ray, one node or leaf per step. Each step prefetches the memory of the next, so interleaved
/// traversals hide the latency.
template <primitive_range Range, int Width>
struct ray_traversal {
    using tree_view = bvh_view<Range, Width>;

    prepared_ray<Width> r{};
    float limit = 0; ///< hits beyond it do not count; a visitor may lower it
    nearest_first<Width> stack;

    /// @return false where nothing can be hit
    INSONIFY_FN INSONIFY_INLINE bool start(const tree_view& tree, const ray& source) {
        r.prepare(source, tree.max_abs_coordinate);
        const bool endless = __builtin_bit_cast(std::uint32_t, source.max_distance) == 0x7F800000U; // read as bits, for
        limit = endless ? FLT_MAX : source.max_distance; // under -ffast-math there is no infinity, and a NaN would trap
        stack.start();
        return r.valid && !tree.nodes.empty();
    }

    /// Calls visit(hit) for hits between the ray's limits, in no order. @return false when the traversal is finished
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN INSONIFY_INLINE bool step(const tree_view& tree, Visit&& visit) {
        if ((stack.next & leaf_bit) == 0) {
            const tree_node<Width>& node = tree.nodes[stack.next];
            lanes<Width> entry;
            if (const std::uint32_t met = enter(node, r, limit, entry); met != 0) {
                stack.descend(node, entry, met);
                tree.prefetch(stack.next);
                return true;
            }
        } else if (stack.next != no_child) {
            tree.leaves[stack.next ^ leaf_bit].intersect_all(r, limit, tree.range, visit);
        }
        if (!stack.pop(limit)) return false;
        tree.prefetch(stack.next);
        return true;
    }

    /// One step of the search for the closest hit; ties go to the lowest primitive.
    INSONIFY_FN INSONIFY_INLINE bool step_closest(const tree_view& tree, hit& best) {
        return step(tree, [&](const hit& found) {
            if (!nearer(found, best)) return;
            best = found;
            limit = found.distance;
        });
    }
};

/// The point of a mesh that is nearest to another point.
struct nearest_point {
    float distance_squared = FLT_MAX; ///< m^2
    std::uint32_t primitive = ~0U;    ///< face; ~0 where there is none
    vec3 point{0, 0, 0};              ///< on the face
};

/// Squared distance from a point to a box; 0 inside.
INSONIFY_FN inline float distance_squared(const aabb& box, vec3 p) {
    const vec3 outside = p - min(max(p, box.lower), box.upper);
    return dot(outside, outside);
}

/// Searches a tree of triangles by branch and bound for the face nearest to p; of equally near ones the lowest.
template <int Width>
INSONIFY_FN nearest_point find_nearest(const bvh_view<mesh_view, Width>& tree, vec3 p) {
    nearest_point best;
    if (tree.nodes.empty()) return best;
    std::uint32_t stack[max_stack<Width>], count = 0;
    float bound[max_stack<Width>];
    stack[count] = 0;
    bound[count++] = 0;
    while (count > 0) {
        const std::uint32_t code = stack[--count];
        if (bound[count] > best.distance_squared) continue;
        if ((code & leaf_bit) != 0) {
            for (const std::uint32_t face : tree.leaves[code ^ leaf_bit].primitive) {
                if (face == no_primitive) continue;
                const vec3 on = nearest_on(tree.range[face], p);
                const float squared = dot(p - on, p - on);
                if (squared < best.distance_squared || (squared == best.distance_squared && face < best.primitive))
                    best = {squared, face, on};
            }
            continue;
        }
        const std::uint32_t first = count;
        for (int i = 0; i < Width; ++i) {
            const std::uint32_t child = tree.nodes[code].child[i];
            const float squared = child == no_child ? FLT_MAX : distance_squared(tree.nodes[code].box(i), p);
            if (child == no_child || squared > best.distance_squared) continue;
            std::uint32_t place = count++; // sorted, so that the nearest child is visited next
            for (; place > first && bound[place - 1] < squared; --place) {
                bound[place] = bound[place - 1];
                stack[place] = stack[place - 1];
            }
            bound[place] = squared;
            stack[place] = child;
        }
    }
    return best;
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
