#ifndef INSONIFY_BVH_TRAVERSE_PACKET_HPP
#define INSONIFY_BVH_TRAVERSE_PACKET_HPP

#include <insonify/bvh/ray_packet.hpp>
#include <insonify/bvh/traverse.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A packet of rays on its way through a tree, a node or a leaf at each step: see `tree_walk`.
template <class Range, int Width>
struct packet_walk {
    using tree_view = bvh_view<Range, Width>;
    using floats = lanes<Width>;

    ray_packet<Width> rays;
    std::uint32_t best[ray_packet<Width>::most_rays]; ///< what each ray has met, `no_primitive` before: see the steps
    nearest_first<Width> way;

    /// Takes rays from the first of `count` on. @return how many go together: 0 for none
    std::size_t start(const tree_view& tree, const ray* first, std::size_t count) {
        const std::size_t taken = tree.nodes.empty() ? 0 : rays.prepare(first, count, tree.reach, tree.leaf_size);
        for (std::size_t k = 0; k < taken; ++k) best[k] = no_primitive;
        way.start();
        return taken;
    }

    /// Calls visit(group, its first ray, primitive, distance) for every triangle that one of a group's rays may meet, with
    /// the distances of these rays, FLT_MAX for those that miss it, their limits not yet looked at. Nodes are taken nearest
    /// first; visit returns 0 where it has lowered none. @return false at the end of the way
    template <class Visit>
    INSONIFY_INLINE bool step(const tree_view& tree, const Visit& visit) {
        if ((way.next & leaf_bit) == 0) {
            const tree_node<Width>& node = tree.nodes[way.next];
            floats entry;
            if (const std::uint32_t met = enter(node, rays, entry); met != 0) {
                way.go_down(node, entry, met);
                tree.prefetch(way.next);
                return true;
            }
        } else if (way.next != no_child) {
            tree.leaves[way.next ^ leaf_bit].intersect_packet(rays, visit);
        }
        if (!way.go_back(rays.end - rays.begin)) return false;
        tree.prefetch(way.next);
        return true;
    }

    /// A step towards the nearest hit of each ray, which ends up in `best` and the ray's limit; as
    /// `tree_walk::step_closest` finds it.
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

    /// How far along each ray of a group the nearest hit lies, FLT_MAX where there is none.
    floats nearest(std::size_t g) const {
        const auto met = floats(0.0F) <= floats_of<Width>(load_bits<Width>(best + g * Width));
        return select(met, load<Width>(rays.of[g].limit), floats(FLT_MAX));
    }

    /// A step towards any hit of each ray, which ends up in `best`.
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

    /// A step along all hits: visit(ray of the packet, hit), in no order.
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
    // For those of a group's rays that have met it.
    INSONIFY_INLINE void take(const lane_mask<Width>& met, std::uint32_t primitive, std::uint32_t first) {
        std::uint32_t* const held = best + first;
        store_bits<Width>(select_bits<Width>(met, bit_lanes<Width>{} + primitive, load_bits<Width>(held)), held);
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
