#ifndef INSONIFY_BVH_TRAVERSE_HPP
#define INSONIFY_BVH_TRAVERSE_HPP

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/core/view.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A tree as traversal sees it, on the host or a device: pointers to its arrays. Trivially copyable, owns nothing.
template <primitive_range Range, int Width = simd_width>
struct bvh_view {
    view<const node_children<Width>> nodes{};
    view<const node_bounds<Width>> bounds_of{};
    view<const leaf<Range, Width>> leaves{};
    view<const std::uint32_t> slots{};
    Range range{};

    /// Each node pops one entry and pushes at most Width.
    static constexpr std::uint32_t stack_size = most_levels<Width> * (Width - 1) + 1;

    /// Calls visit(hit) for everything met between the ray's limits, in no order; visit may lower `max_distance`.
    ///
    /// Children are taken nearest first, so that a visitor that lowers the limit to its best hit skips the rest.
    /// @tparam Stop  bool(): asked after each leaf, true ends the search
    INSONIFY_VISITS
    template <class Visit, class Stop>
    INSONIFY_FN void search(const ray& source, float& max_distance, Visit&& visit, Stop&& stop) const {
        struct entry {
            float distance;
            std::uint32_t child;
        };
        const prepared_ray r{source};
        if (!r.legal || nodes.empty()) return;
        entry stack[stack_size];
        std::uint32_t waiting = 0;
        stack[waiting++] = {r.source.min_distance, 0};
        while (waiting > 0) {
            const entry next = stack[--waiting];
            if (next.distance > max_distance + 1e-6F * std::fabs(max_distance)) continue;
            if ((next.child & leaf_bit) != 0) {
                const std::uint32_t index = next.child ^ leaf_bit;
                leaves[index].intersect_all(r, max_distance, range, slots.first + std::size_t{index} * Width, visit);
                if (stop()) return;
                continue;
            }
            const box_entries<Width> boxes = enter(bounds_of[next.child], r, max_distance);
            float distance[Width];
            store(boxes.distance, distance);
            const std::uint32_t first_pushed = waiting;
            for (std::uint32_t left = boxes.met; left != 0; left &= left - 1) {
                const std::uint32_t i = lowest_bit(left);
                const std::uint32_t child = nodes[next.child].child[i];
                if (child == no_child) continue;
                std::uint32_t place = waiting++; // insertion sort: farthest below, nearest on top
                for (; place > first_pushed && stack[place - 1].distance < distance[i]; --place)
                    stack[place] = stack[place - 1];
                stack[place] = {distance[i], child};
            }
        }
    }

    /// The nearest hit; of equally near ones the lowest primitive.
    INSONIFY_FN hit closest(const ray& r) const {
        hit best;
        float limit = r.max_distance;
        search(
            r, limit,
            [&](const hit& found) {
                if (!nearer(found, best)) return;
                best = found;
                limit = found.distance;
            },
            [] { return false; });
        return best;
    }

    /// Whether anything is hit.
    INSONIFY_FN bool any(const ray& r) const {
        bool met = false;
        float limit = r.max_distance;
        search(
            r, limit, [&](const hit&) { met = true; }, [&] { return met; });
        return met;
    }

    /// Calls visit(hit) for every hit, in no order, each primitive once.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void for_each_hit(const ray& r, Visit&& visit) const {
        float limit = r.max_distance;
        search(r, limit, visit, [] { return false; });
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
                if (child == no_child || !overlaps(shape, bounds_of[node].box(i))) continue;
                if ((child & leaf_bit) == 0) {
                    stack[waiting++] = child;
                    continue;
                }
                const std::uint32_t* slot = slots.first + std::size_t{child ^ leaf_bit} * Width;
                for (int k = 0; k < Width && slot[k] != no_primitive; ++k) {
                    const aabb box = bounds(range[slot[k]]);
                    if (is_finite(box) && overlaps(shape, box)) visit(slot[k]);
                }
            }
        }
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
