#ifndef INSONIFY_BVH_TRAVERSE_PACKET_HPP
#define INSONIFY_BVH_TRAVERSE_PACKET_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/ray_packet.hpp>
#include <insonify/bvh/traverse.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// The traversal of a packet, one node or leaf per step: see `ray_traversal`.
template <class Range, int Width>
struct packet_traversal {
    using tree_view = bvh_view<Range, Width>;
    using floats = lanes<Width>;

    ray_packet<Width> rays;
    std::uint32_t best[ray_packet<Width>::max_rays]; ///< the hit primitive of each ray, or `no_primitive`
    nearest_first<Width> stack;

    /// Loads coherent rays from the first of `count` on. @return how many: 0 for none
    std::size_t start(const tree_view& tree, const ray* first, std::size_t count) {
        const std::size_t taken = rays.prepare(first, count, tree.box, tree.max_abs_coordinate, tree.leaf_size);
        for (std::size_t k = 0; k < taken; ++k) best[k] = no_primitive;
        stack.start();
        return taken;
    }

    /// Calls visit(group, index of its first ray, primitive, distances) for every triangle that some ray of a group may hit.
    /// Distances are FLT_MAX for rays that miss; the rays' limits are not applied. visit returns 0 if it lowered no limit.
    /// Traverses front to back. @return false when the traversal is finished
    template <class Visit>
    INSONIFY_INLINE bool step(const tree_view& tree, const Visit& visit) {
        if ((stack.next & leaf_bit) == 0) {
            const tree_node<Width>& node = tree.nodes[stack.next];
            floats entry;
            if (const std::uint32_t met = enter(node, rays, entry); met != 0) {
                stack.descend(node, entry, met);
                tree.prefetch(stack.next);
                return true;
            }
        } else if (stack.next != no_child) {
            tree.leaves[stack.next ^ leaf_bit].intersect_packet(rays, visit);
        }
        if (!stack.pop(rays.end - rays.begin)) return false;
        if ((stack.next & leaf_bit) == 0) rays.narrow(stack.entry());
        tree.prefetch(stack.next);
        return true;
    }

    /// One step of the search for the closest hit of each ray, kept in `best` and the ray's limit. The same hits as
    /// `ray_traversal::step_closest`.
    bool step_closest(const tree_view& tree) {
        return step(tree, [this](auto& group, std::uint32_t first, std::uint32_t primitive, const floats& distance) {
            const floats limit = load<Width>(group.limit);
            const auto within = load<Width>(group.min_distance) <= distance && distance < floats(FLT_MAX);
            const auto nearer = within && distance < limit;
            for (std::uint32_t left = bits_of(within && distance == limit); left != 0; left &= left - 1) {
                std::uint32_t& held = best[first + lowest_bit(left)];
                if (primitive < held) held = primitive;
            }
            store(select(nearer, distance, limit), group.limit);
            take(nearer, primitive, first);
            return bits_of(nearer);
        });
    }

    /// The distances of the closest hits of a group; FLT_MAX for rays without one.
    floats nearest(std::size_t g) const {
        const auto met = floats(0.0F) <= floats_of<Width>(load_bits<Width>(best + g * Width));
        return select(met, load<Width>(rays.of[g].limit), floats(FLT_MAX));
    }

    /// One step of the search for any hit of each ray, kept in `best`.
    bool step_any(const tree_view& tree) {
        return step(tree, [this](auto& group, std::uint32_t first, std::uint32_t primitive, const floats& distance) {
            const floats limit = load<Width>(group.limit);
            const auto met =
                load<Width>(group.min_distance) <= distance && distance < floats(FLT_MAX) && distance <= limit;
            store(select(met, floats(-1.0F), limit), group.limit);
            take(met, primitive, first);
            return bits_of(met);
        });
    }

    /// One step of the search for all hits: calls visit(index of the ray, hit), in no order.
    template <class Visit>
    bool step_all(const tree_view& tree, const Visit& visit) {
        return step(tree, [&](auto& group, std::uint32_t first, std::uint32_t primitive, const floats& distance) {
            alignas(sizeof(floats)) float found[Width];
            store(distance, found);
            for (std::uint32_t left = bits_of(load<Width>(group.min_distance) <= distance &&
                                              distance < floats(FLT_MAX) && distance <= load<Width>(group.limit));
                 left != 0; left &= left - 1)
                visit(first + lowest_bit(left), hit{found[lowest_bit(left)], primitive});
            return 0U;
        });
    }

  private:
    // Records the primitive for the rays of a group that hit it.
    INSONIFY_INLINE void take(const lane_mask<Width>& met, std::uint32_t primitive, std::uint32_t first) {
        std::uint32_t* const held = best + first;
        store_bits<Width>(select_bits<Width>(met, bit_lanes<Width>{} + primitive, load_bits<Width>(held)), held);
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
