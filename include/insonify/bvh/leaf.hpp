#ifndef INSONIFY_BVH_LEAF_HPP
#define INSONIFY_BVH_LEAF_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/build_box.hpp>
#include <insonify/bvh/concepts.hpp>
#include <insonify/bvh/prepared_ray.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <algorithm>
#include <cstddef>

namespace insonify::inline INSONIFY_ABI::detail {

/// The number of primitives from which faces and corners are prefetched. Smaller meshes, up to some 2 MB, are cached
/// (bench/bvh.cpp refits a small mesh and a large one).
inline constexpr std::size_t prefetch_threshold = std::size_t{1} << 17U;

/// One point of each of four primitives, as structure of arrays.
struct four_points {
    lanes<4> x, y, z;

    INSONIFY_FN INSONIFY_INLINE four_points(const lanes<4>& xs, const lanes<4>& ys, const lanes<4>& zs)
        : x{xs}, y{ys}, z{zs} {}
    INSONIFY_FN INSONIFY_INLINE four_points(const vec3& a, const vec3& b, const vec3& c, const vec3& d)
        : x{of(a.x, b.x, c.x, d.x)}, y{of(a.y, b.y, c.y, d.y)}, z{of(a.z, b.z, c.z, d.z)} {}

    /// Negative where a coordinate is not finite.
    INSONIFY_FN INSONIFY_INLINE bit_lanes<4> wild() const {
        return not_finite<4>(x) | not_finite<4>(y) | not_finite<4>(z);
    }

    template <int Width>
    INSONIFY_FN INSONIFY_INLINE void put(float (&rows)[3][Width], int first) const {
        store(x, rows[0] + first);
        store(y, rows[1] + first);
        store(z, rows[2] + first);
    }

  private:
    INSONIFY_FN INSONIFY_INLINE static lanes<4> of(float a, float b, float c, float d) {
        return each_lane<4>([&](int i) { return i < 2 ? (i == 0 ? a : b) : (i == 2 ? c : d); });
    }
};

/// The half centres of the boxes of four primitives, as structure of arrays.
struct four_centres {
    lanes<4> at[3];    ///< by axis
    bit_lanes<4> wild; ///< negative where a box is empty or not finite, and left out
};

/// A leaf holds the indices of its primitives and reads them from the range. Triangles are stored in the leaf itself: see
/// leaf_triangles.hpp.
template <class Range, int Width>
struct leaf {
    std::uint32_t primitive[Width]; ///< `no_primitive` in empty slots, and where bounds are not finite

    /// Reads the primitives from the range. @return their box
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

    /// The box of a primitive; empty where it is not finite.
    static build_box box(const Range& range, std::size_t i) {
        const aabb found = bounds(range[i]);
        return is_finite(found) ? build_box{found} : build_box::none();
    }

    /// The half centres of four primitives from `first` on; lanes beyond `last` repeat it.
    static four_centres centres(const Range& range, std::size_t first, std::size_t last) {
        vec3 at[4];
        bit_lanes<4> wild{};
        for (int i = 0; i < 4; ++i) {
            const build_box one = box(range, std::min(first + static_cast<std::size_t>(i), last));
            float place[4];
            store(one.half_centre(), place);
            at[i] = {place[0], place[1], place[2]};
            wild[i] = std::uint32_t{one.empty()} << 31U;
        }
        const four_points all{at[0], at[1], at[2], at[3]};
        return {{all.x, all.y, all.z}, wild};
    }

    /// Calls visit(hit) for every hit between min_distance and max_distance, which visit may lower.
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

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
