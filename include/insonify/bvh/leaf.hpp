#ifndef INSONIFY_BVH_LEAF_HPP
#define INSONIFY_BVH_LEAF_HPP

#include <insonify/bvh/build_box.hpp>
#include <insonify/bvh/concepts.hpp>
#include <insonify/bvh/prepared_ray.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What a tree keeps for a leaf beside the indices of its primitives: which can be hit. For the rest the range is asked.
///
/// Triangles have their own: leaf_triangles.hpp.
template <class Range, int Width>
struct leaf {
    std::uint32_t usable = 0; ///< a bit for each primitive that is there and has finite bounds

    /// Takes over the primitives' present shape; returns the box around them.
    aabb fill(const Range& range, const std::uint32_t* slots) {
        aabb whole;
        usable = 0;
        for (int i = 0; i < Width && slots[i] != no_primitive; ++i) {
            const aabb box = bounds(range[slots[i]]);
            if (!is_finite(box)) continue;
            usable |= 1U << static_cast<unsigned>(i);
            whole = merged(whole, box);
        }
        return whole;
    }

    /// The box of a primitive as builders take it; empty where it is not finite.
    static build_box box(const Range& range, std::size_t i) {
        const aabb found = bounds(range[i]);
        return is_finite(found) ? build_box{found} : build_box::none();
    }

    /// Calls visit(hit) for every primitive met between the ray's min_distance and max_distance, which visit may move.
    INSONIFY_VISITS
    template <class Visit>
    INSONIFY_FN void intersect_all(const prepared_ray<Width>& r, const float& max_distance, const Range& range,
                                   const std::uint32_t* slots, Visit&& visit) const {
        for (std::uint32_t left = usable; left != 0; left &= left - 1) {
            const std::uint32_t slot = slots[lowest_bit(left)];
            hit found = intersect(r.source, range[slot]);
            if (!(found.distance >= r.source.min_distance && found.distance <= max_distance && found)) continue;
            found.primitive = slot;
            visit(found);
        }
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
