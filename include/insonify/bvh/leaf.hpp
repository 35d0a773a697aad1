#ifndef INSONIFY_BVH_LEAF_HPP
#define INSONIFY_BVH_LEAF_HPP

#include <insonify/bvh/build_box.hpp>
#include <insonify/bvh/concepts.hpp>
#include <insonify/bvh/prepared_ray.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What a tree keeps of its primitives for a leaf: which of them can be hit. For the rest the range is asked.
///
/// Triangles have their own: leaf_triangles.hpp.
template <class Range, int Width>
struct leaf {
    std::uint32_t primitive[Width]; ///< `no_primitive` where none is, or its bounds are not finite

    /// Takes over the primitives' present shape; returns the box around them.
    aabb fill(const Range& range, const std::uint32_t* slots) {
        aabb whole;
        for (int i = 0; i < Width; ++i) {
            primitive[i] = no_primitive;
            if (slots[i] == no_primitive) continue;
            const aabb box = bounds(range[slots[i]]);
            if (!is_finite(box)) continue;
            primitive[i] = slots[i];
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
                                   Visit&& visit) const {
        for (const std::uint32_t one : primitive) {
            if (one == no_primitive) continue;
            hit found = intersect(r.source, range[one]);
            if (!(found.distance >= r.source.min_distance && found.distance <= max_distance && found)) continue;
            found.primitive = one;
            visit(found);
        }
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
