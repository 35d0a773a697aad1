#ifndef INSONIFY_BVH_BUILD_BOX_HPP
#define INSONIFY_BVH_BUILD_BOX_HPP

#include <insonify/execution/simd.hpp>
#include <insonify/geometry/aabb.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Half the centre of a box: it sorts as the centre does, and two of them never lie infinitely far apart.
template <class = void>
INSONIFY_INLINE lanes<4> half_centre(const lanes<4>& lower, const lanes<4>& upper) {
    return multiply_add(lanes<4>(0.25F), lower, lanes<4>(0.25F) * upper);
}

/// The box of a primitive as builders move it about: [-lower, -, upper, -], so that the union of two is one maximum.
struct alignas(32) build_box {
    float row[8];

    build_box() = default; ///< not set, since arrays of them are written later, by many threads
    explicit build_box(const aabb& box)
        : row{-box.lower.x, -box.lower.y, -box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, 0} {}
    template <class = void>
    INSONIFY_INLINE build_box(const lanes<4>& minus_lower, const lanes<4>& upper) {
        store(minus_lower, row);
        store(upper, row + 4);
    }

    /// The spare lanes carry the primitive's index along, in two halves that are exact as floats.
    void name(std::uint32_t primitive) {
        row[3] = static_cast<float>(primitive >> 16U);
        row[7] = static_cast<float>(primitive & 0xFFFFU);
    }
    std::uint32_t primitive() const {
        return static_cast<std::uint32_t>(row[3]) << 16U | static_cast<std::uint32_t>(row[7]);
    }
    /// Holds nothing, and adds nothing.
    INSONIFY_LAZY static build_box none() { return {lanes<4>(-FLT_MAX), lanes<4>(-FLT_MAX)}; }
    bool empty() const { return row[4] < -row[0]; }

    template <class = void>
    INSONIFY_INLINE void add(const build_box& other) {
        for (int k = 0; k < 8; k += simd_width)
            store(greater(load<simd_width>(row + k), load<simd_width>(other.row + k)), row + k);
    }
    template <class = void>
    INSONIFY_INLINE lanes<4> minus_lower() const {
        return load<4>(row);
    }
    template <class = void>
    INSONIFY_INLINE lanes<4> upper() const {
        return load<4>(row + 4);
    }

    template <class = void>
    INSONIFY_INLINE lanes<4> half_centre() const {
        return insonify::half_centre(-minus_lower(), upper());
    }
    float half_area() const { // 0 of an empty one
        const float x = greater(row[4] + row[0], 0), y = greater(row[5] + row[1], 0), z = greater(row[6] + row[2], 0);
        return x * y + y * z + z * x;
    }
};

/// Where the halved centres of a group lie, at most.
struct centre_range {
    float begin[4] = {FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX};
    float end[4] = {-FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};

    template <class = void>
    INSONIFY_INLINE void add(const lanes<4>& first, const lanes<4>& last) {
        store(lesser(load<4>(begin), first), begin);
        store(greater(load<4>(end), last), end);
    }
    float widest() const { return greater(end[0] - begin[0], greater(end[1] - begin[1], end[2] - begin[2])); }
    bool holds(const centre_range& other) const {
        bool held = true;
        for (int k = 0; k < 3; ++k) held = held && begin[k] <= other.begin[k] && other.end[k] <= end[k];
        return held;
    }
    /// By a share of the widest side, to each side.
    template <class = void>
    INSONIFY_INLINE centre_range widened(float share) const {
        const lanes<4> more(share * widest());
        centre_range wider;
        wider.add(load<4>(begin) - more, load<4>(end) + more);
        return wider;
    }
    /// A centre lies within its box.
    template <class = void>
    INSONIFY_INLINE centre_range within(const build_box& box) const {
        centre_range both;
        store(greater(load<4>(begin), lanes<4>(-0.5F) * box.minus_lower()), both.begin);
        store(lesser(load<4>(end), lanes<4>(0.5F) * box.upper()), both.end);
        return both;
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
