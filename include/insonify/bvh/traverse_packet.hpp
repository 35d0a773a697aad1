#ifndef INSONIFY_BVH_TRAVERSE_PACKET_HPP
#define INSONIFY_BVH_TRAVERSE_PACKET_HPP

#include <insonify/bvh/ray_packet.hpp>
#include <insonify/bvh/traverse.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Shows a packet every triangle that one of its rays may meet: visit(packet, primitive, distance) gets the distances
/// of all rays, FLT_MAX for those that miss it, their limits not yet looked at. Nodes are taken nearest first; where
/// visit returns true, it has lowered limits.
template <class Range, int Width, class Visit>
void search_packet(const bvh_view<Range, Width>& tree, ray_packet<Width>& p, const Visit& visit) {
    using tree_view = bvh_view<Range, Width>;
    if (tree.nodes.empty()) return;
    std::int64_t stack[tree_view::stack_size];
    std::uint32_t waiting = 0;
    std::uint32_t next = 0;
    for (;;) {
        if ((next & leaf_bit) == 0) {
            lanes<Width> entry;
            if (std::uint32_t left = enter(tree.nodes[next], p, entry); left != 0) {
                const std::uint32_t* const child = tree.nodes[next].child;
                next = child[lowest_bit(left)];
                if ((left & (left - 1)) == 0) continue;
                alignas(sizeof(float) * Width) float distance[Width];
                store(entry, distance);
                std::int64_t nearest = tree_view::key_of(distance[lowest_bit(left)], next);
                tree.prefetch(next);
                while ((left &= left - 1) != 0) {
                    const std::uint32_t i = lowest_bit(left);
                    const std::int64_t key = tree_view::key_of(distance[i], child[i]);
                    tree.prefetch(child[i]);
                    stack[waiting++] = key < nearest ? nearest : key;
                    nearest = key < nearest ? key : nearest;
                }
                next = static_cast<std::uint32_t>(nearest);
                continue;
            }
        } else if (next != no_child) {
            const std::uint32_t index = next ^ leaf_bit;
            if (tree.leaves[index].intersect_packet(p, tree.slots.first + std::size_t{index} * Width, visit) &&
                !p.shorten())
                return;
        }
        do {
            if (waiting == 0) return;
            next = static_cast<std::uint32_t>(stack[--waiting]);
        } while (tree_view::distance_of(stack[waiting]) > p.end - p.begin);
    }
}

/// The nearest hit of each ray, as `bvh_view::closest` finds it.
template <class Range, int Width>
void closest(const bvh_view<Range, Width>& tree, ray_packet<Width>& p, hit* hits) {
    using floats = lanes<Width>;
    std::uint32_t best[Width];
    for (std::uint32_t& b : best) b = no_primitive;
    search_packet(tree, p, [&](ray_packet<Width>& rays, std::uint32_t primitive, const floats& distance) {
        const floats limit = load<Width>(rays.limit);
        const auto within = load<Width>(rays.min_distance) <= distance && distance < floats(FLT_MAX);
        const auto nearer = within && distance < limit;
        for (std::uint32_t left = bits_of(within && distance == limit); left != 0; left &= left - 1) {
            std::uint32_t& held = best[lowest_bit(left)];
            if (primitive < held) held = primitive;
        }
        std::uint32_t left = bits_of(nearer);
        if (left == 0) return false;
        store(select(nearer, distance, limit), rays.limit);
        for (; left != 0; left &= left - 1) best[lowest_bit(left)] = primitive;
        return true;
    });
    for (int i = 0; i < Width; ++i) hits[i] = best[i] == no_primitive ? hit{} : hit{p.limit[i], best[i]};
}

/// Whether each ray hits anything, 1 or 0.
template <class Range, int Width>
void any(const bvh_view<Range, Width>& tree, ray_packet<Width>& p, std::uint8_t* met) {
    using floats = lanes<Width>;
    std::uint32_t all_met = 0;
    search_packet(tree, p, [&](ray_packet<Width>& rays, std::uint32_t, const floats& distance) {
        const floats limit = load<Width>(rays.limit);
        const auto within =
            load<Width>(rays.min_distance) <= distance && distance < floats(FLT_MAX) && distance <= limit;
        const std::uint32_t found = bits_of(within);
        all_met |= found;
        if (found == 0) return false;
        store(select(within, floats(-1.0F), limit), rays.limit);
        return true;
    });
    for (unsigned i = 0; i < Width; ++i) met[i] = static_cast<std::uint8_t>(all_met >> i & 1U);
}

/// Every hit of each ray, nearest first; replaces what `hits` held.
template <class Range, int Width>
void all(const bvh_view<Range, Width>& tree, ray_packet<Width>& p, std::vector<hit>* hits) {
    using floats = lanes<Width>;
    for (int i = 0; i < Width; ++i) hits[i].clear();
    search_packet(tree, p, [&](ray_packet<Width>& rays, std::uint32_t primitive, const floats& distance) {
        const auto within = load<Width>(rays.min_distance) <= distance && distance < floats(FLT_MAX) &&
                            distance <= load<Width>(rays.limit);
        alignas(sizeof(floats)) float found[Width];
        store(distance, found);
        for (std::uint32_t left = bits_of(within); left != 0; left &= left - 1)
            hits[lowest_bit(left)].push_back({found[lowest_bit(left)], primitive});
        return false;
    });
    for (int i = 0; i < Width; ++i) std::sort(hits[i].begin(), hits[i].end(), nearer);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
