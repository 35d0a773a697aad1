#ifndef INSONIFY_BVH_BUILD_BOX_HPP
#define INSONIFY_BVH_BUILD_BOX_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd.hpp>
#include <insonify/geometry/aabb.hpp>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI::detail {

/// Half the centre of a box: sorts like the centre, and differences of two do not overflow.
INSONIFY_INLINE lanes<4> half_centre(const lanes<4>& lower, const lanes<4>& upper) {
    return multiply_add(lanes<4>(0.25F), lower, lanes<4>(0.25F) * upper);
}

/// The box of a primitive in builders: [-lower, -, upper, -], so that the union of two is one maximum.
struct alignas(32) build_box {
    float row[8];

    build_box() = default; ///< uninitialised: arrays are filled later, in parallel
    explicit build_box(const aabb& box)
        : row{-box.lower.x, -box.lower.y, -box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, 0} {}
    INSONIFY_INLINE build_box(const lanes<4>& minus_lower, const lanes<4>& upper) {
        store(minus_lower, row);
        store(upper, row + 4);
    }

    /// Stores the index of the primitive in the spare lanes, in two halves that floats represent exactly.
    void name(std::uint32_t primitive) {
        row[3] = static_cast<float>(primitive >> 16U);
        row[7] = static_cast<float>(primitive & 0xFFFFU);
    }
    std::uint32_t primitive() const {
        return static_cast<std::uint32_t>(row[3]) << 16U | static_cast<std::uint32_t>(row[7]);
    }
    /// The empty box.
    static build_box none() { return {lanes<4>(-FLT_MAX), lanes<4>(-FLT_MAX)}; }
    bool empty() const { return row[4] < -row[0]; }

    INSONIFY_INLINE void add(const build_box& other) {
        for (int k = 0; k < 8; k += simd_width)
            store(max(load<simd_width>(row + k), load<simd_width>(other.row + k)), row + k);
    }
    INSONIFY_INLINE lanes<4> minus_lower() const { return load<4>(row); }
    INSONIFY_INLINE lanes<4> upper() const { return load<4>(row + 4); }

    INSONIFY_INLINE lanes<4> half_centre() const { return detail::half_centre(-minus_lower(), upper()); }
    float half_area() const { // 0 for an empty box
        const float x = max(row[4] + row[0], 0), y = max(row[5] + row[1], 0), z = max(row[6] + row[2], 0);
        return x * y + y * z + z * x;
    }
};

/// Bounds of the half centres of a group.
struct centre_range {
    float begin[4] = {FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX};
    float end[4] = {-FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};

    INSONIFY_INLINE void add(const lanes<4>& first, const lanes<4>& last) {
        store(min(load<4>(begin), first), begin);
        store(max(load<4>(end), last), end);
    }
    float widest() const { return max(end[0] - begin[0], max(end[1] - begin[1], end[2] - begin[2])); }
    bool holds(const centre_range& other) const {
        bool held = true;
        for (int k = 0; k < 3; ++k) held = held && begin[k] <= other.begin[k] && other.end[k] <= end[k];
        return held;
    }
    /// Extended on each side by a fraction of the widest extent.
    INSONIFY_INLINE centre_range widened(float fraction) const {
        const lanes<4> more(fraction * widest());
        centre_range wider;
        wider.add(load<4>(begin) - more, load<4>(end) + more);
        return wider;
    }
    /// Clipped to the box, which contains all centres.
    INSONIFY_INLINE centre_range within(const build_box& box) const {
        centre_range both;
        store(max(load<4>(begin), lanes<4>(-0.5F) * box.minus_lower()), both.begin);
        store(min(load<4>(end), lanes<4>(0.5F) * box.upper()), both.end);
        return both;
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
