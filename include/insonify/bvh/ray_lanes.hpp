#ifndef INSONIFY_BVH_RAY_LANES_HPP
#define INSONIFY_BVH_RAY_LANES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/simd_bits.hpp>
#include <insonify/geometry/aabb.hpp>
#include <insonify/geometry/ray.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Consecutive rays in structure-of-arrays layout.
template <int N>
struct ray_lanes {
    lanes<N> origin[3], direction[3], min_distance, max_distance;

    INSONIFY_INLINE explicit ray_lanes(const ray* first) {
#if !defined(INSONIFY_NO_SIMD)
        if constexpr (N == 8) {
            transpose(first);
            return;
        }
#endif
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = each_lane<N>([&](int i) { return first[i].origin[axis]; });
            direction[axis] = each_lane<N>([&](int i) { return first[i].direction[axis]; });
        }
        min_distance = each_lane<N>([&](int i) { return first[i].min_distance; });
        max_distance = each_lane<N>([&](int i) { return first[i].max_distance; });
    }

    /// Negative where a coordinate is not finite or a limit is not a number: such a ray is traced by itself.
    INSONIFY_INLINE lanes<N> wild() const {
        bit_lanes<N> bits = not_number<N>(min_distance) | not_number<N>(max_distance);
        for (int axis = 0; axis < 3; ++axis) bits = bits | not_finite<N>(origin[axis]) | not_finite<N>(direction[axis]);
        return floats_of<N>(bits);
    }

  private:
#if !defined(INSONIFY_NO_SIMD)
    // A ray is eight floats: three rounds of interleaving rows i and i + 4 transpose eight of them.
    INSONIFY_INLINE void transpose(const ray* first) {
        using floats = detail::vector<float, 8>;
        static_assert(sizeof(ray) == sizeof(floats));
        floats rows[8];
        for (int i = 0; i < 8; ++i) __builtin_memcpy(rows + i, first + i, sizeof(floats));
        for (int round = 0; round < 3; ++round) {
            const floats before[8] = {rows[0], rows[1], rows[2], rows[3], rows[4], rows[5], rows[6], rows[7]};
            for (std::size_t i = 0; i < 4; ++i) {
                rows[2 * i] = __builtin_shufflevector(before[i], before[i + 4], 0, 8, 1, 9, 2, 10, 3, 11);
                rows[2 * i + 1] = __builtin_shufflevector(before[i], before[i + 4], 4, 12, 5, 13, 6, 14, 7, 15);
            }
        }
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = __builtin_bit_cast(lanes<N>, rows[axis]);
            direction[axis] = __builtin_bit_cast(lanes<N>, rows[3 + axis]);
        }
        min_distance = __builtin_bit_cast(lanes<N>, rows[6]);
        max_distance = __builtin_bit_cast(lanes<N>, rows[7]);
    }
#endif
};

/// A bit for each ray that may enter the box between its limits. Conservative: rounding never loses a ray, also not in
/// the triangle test; rays that are not valid may get either answer.
/// @param max_abs_coordinate  of the box
template <int N>
INSONIFY_INLINE std::uint32_t may_enter(const aabb& box, float max_abs_coordinate, const ray_lanes<N>& rays) {
    using floats = lanes<N>;
    constexpr float min_length = 1e-16F, max_range = 1e12F; // beyond them the test below might overflow
    constexpr std::uint32_t all = (1U << static_cast<unsigned>(N)) - 1;
    if (bits_of(rays.wild() < floats(0.0F)) != 0) return all; // NaN would trap below

    floats size[3], longest(0.0F), range(max_abs_coordinate);
    for (int axis = 0; axis < 3; ++axis) {
        size[axis] = abs(rays.direction[axis]);
        longest = max(longest, size[axis]);
        range = max(range, abs(rays.origin[axis]));
    }
    // Components of 0 become too small to matter, and can be divided by.
    const floats min_size = max(longest, floats(min_length)) * floats(1e-9F), margin = range * floats(1e-6F);
    floats in = rays.min_distance, out = rays.max_distance;
    for (int axis = 0; axis < 3; ++axis) {
        const floats scale = inverse(select(size[axis] < min_size, min_size, rays.direction[axis]));
        const floats lower = (floats(box.lower[axis]) - margin - rays.origin[axis]) * scale;
        const floats upper = (floats(box.upper[axis]) + margin - rays.origin[axis]) * scale;
        in = max(in, min(lower, upper));
        out = min(out, max(lower, upper));
    }
    const auto misses = out < in && floats(min_length) < longest && range < floats(max_range);
    return all & ~bits_of(misses);
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
