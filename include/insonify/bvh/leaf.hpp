#ifndef INSONIFY_BVH_LEAF_HPP
#define INSONIFY_BVH_LEAF_HPP

#include <insonify/bvh/concepts.hpp>
#include <insonify/bvh/prepared_ray.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What a tree keeps for a leaf beside the indices of its primitives: nothing, the range is asked.
///
/// Triangles have their own: leaf_triangles.hpp.
template <class Range, int Width>
struct leaf {
    /// Takes over the primitives' present shape; returns the box around them.
    aabb fill(const Range& range, const std::uint32_t* slots) {
        aabb whole;
        for (int i = 0; i < Width && slots[i] != no_primitive; ++i) {
            const aabb box = bounds(range[slots[i]]);
            if (is_finite(box)) whole = merged(whole, box);
        }
        return whole;
    }

    /// The boxes of consecutive primitives, Width at most; empty ones for those that are not finite or not there.
    static box_rows<Width> boxes(const Range& range, std::size_t first, std::size_t count) {
        box_rows<Width> rows;
        for (int i = 0; i < Width; ++i) {
            const std::size_t place = static_cast<std::size_t>(i);
            const aabb box = place < count ? bounds(range[first + place]) : aabb{};
            rows.set_box(i, is_finite(box) ? box : aabb{});
        }
        return rows;
    }

    /// Calls visit(hit) for every primitive met between the ray's min_distance and max_distance, which visit may move.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void intersect_all(const prepared_ray<Width>& r, const float& max_distance, const Range& range,
                                   const std::uint32_t* slots, Visit&& visit) const {
        for (int i = 0; i < Width && slots[i] != no_primitive; ++i) {
            hit found = intersect(r.source, range[slots[i]]);
            if (!(found.distance >= r.source.min_distance && found.distance <= max_distance && found)) continue;
            found.primitive = slots[i];
            visit(found);
        }
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
