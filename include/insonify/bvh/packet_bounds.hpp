#ifndef INSONIFY_BVH_PACKET_BOUNDS_HPP
#define INSONIFY_BVH_PACKET_BOUNDS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/node.hpp>
#include <insonify/execution/simd.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Bounds of many rays in one of the directions u across z:  low + min_slope * z <= u <= high + max_slope * z.
struct packet_wedge {
    float low = 0, high = 0, min_slope = 0, max_slope = 0;

    float width(float z) const { return high - low + (max_slope - min_slope) * z; }
};

/// The volume that the rays of a packet sweep, for culling the children of a node in one test.
///
/// All rays have the same dominant axis z and sign along it, so forward * z grows along each of them. The volume lies
/// between four planes, and each axis gives an interval of forward * z in which rays can be inside a box.
template <int N>
struct packet_bounds {
    /// The points with  weight . point >= bound,  coordinates in the order of `axes`.
    struct half_space {
        float weight[3] = {};
        float bound = 0;
        std::uint32_t row[3] = {}; ///< of a node's sides: those of the corner where the weighted sum is greatest
    };
    /// The interval of forward * z in which some ray is between the two sides of a box across x or y: from
    /// entry_side * entry_scale + entry_offset  to  exit_side * exit_scale + exit_offset.
    struct slab {
        float entry_scale = 0, entry_offset = -FLT_MAX;
        float exit_scale = 0, exit_offset = FLT_MAX;
        std::uint32_t entry_row = 0, exit_row = 0;
    };
    half_space around[4]{};
    slab slabs[2]{};
    int axes[3] = {0, 1, 2}; ///< the world axes of x, y and z
    float forward = 1;       ///< the sign of the directions along z
    float begin = 0;         ///< the interval of forward * z between the limits of all rays
    float end = 0;
    std::uint32_t entry_row = 0, exit_row = 0; ///< of a node's sides: across z

    /// Sets slab `k` for rays that are at `start` where forward * z = z0, with these slopes. Rays nearly parallel to the
    /// sides leave it unbounded.
    void set_slab(int k, const packet_wedge& rays, float z0, float margin) {
        slab& one = slabs[k];
        one = {};
        const bool rises = rays.min_slope > 0.01F;
        if (!rises && !(rays.max_slope < -0.01F)) return;
        const float low = rays.low - margin, high = rays.high + margin;
        one.entry_scale = 1 / (rises ? rays.max_slope : rays.min_slope);
        one.exit_scale = 1 / (rises ? rays.min_slope : rays.max_slope);
        one.entry_offset = z0 - (rises ? high : low) * one.entry_scale - 2 * margin;
        one.exit_offset = z0 - (rises ? low : high) * one.exit_scale + 2 * margin;
        const auto axis = static_cast<std::uint32_t>(axes[k]), backwards = std::uint32_t{!rises};
        one.entry_row = tree_node<N>::row(backwards, axis);
        one.exit_row = tree_node<N>::row(1 - backwards, axis);
    }

    /// Sets the interval of forward * z and the sides across it.
    void set_begin(float z) {
        begin = z;
        const auto axis = static_cast<std::uint32_t>(axes[2]), backwards = std::uint32_t{forward < 0};
        entry_row = tree_node<N>::row(backwards, axis);
        exit_row = tree_node<N>::row(1 - backwards, axis);
    }

    /// Sets two planes that hold the rays between them along (x, y).
    void set_planes(half_space* two, float x, float y, const packet_wedge& rays) const {
        two[0] = half_space_of(x, y, -rays.min_slope, rays.low);
        two[1] = half_space_of(-x, -y, rays.max_slope, -rays.high);
    }

  private:
    half_space half_space_of(float x, float y, float z, float bound) const {
        half_space one{{x, y, z}, bound};
        for (int k = 0; k < 3; ++k)
            one.row[k] = tree_node<N>::row(one.weight[k] > 0, static_cast<std::uint32_t>(axes[k]));
        return one;
    }
};

/// Finds the children of a node whose boxes the packet may enter: conservative, so rounding never loses one.
/// @param entry  where, in terms of forward * z - begin; FLT_MAX for the others
/// @return a bit for each child
template <int N>
INSONIFY_INLINE std::uint32_t enter(const tree_node<N>& node, const packet_bounds<N>& p, lanes<N>& entry) {
    using floats = lanes<N>;
    const auto side = [&node](std::uint32_t row) { return load<N>(node.sides + row); };
    floats in = floats(p.forward) * side(p.entry_row), out = floats(p.forward) * side(p.exit_row);
    for (const auto& one : p.slabs) {
        in = max(in, multiply_add(side(one.entry_row), floats(one.entry_scale), floats(one.entry_offset)));
        out = min(out, multiply_add(side(one.exit_row), floats(one.exit_scale), floats(one.exit_offset)));
    }
    auto met = in <= min(out, floats(p.end)) && floats(p.begin) <= out;
    for (const auto& one : p.around) {
        const floats across =
            multiply_add(floats(one.weight[2]), side(one.row[2]), floats(one.weight[0]) * side(one.row[0]));
        met = met && floats(one.bound) <= multiply_add(floats(one.weight[1]), side(one.row[1]), across);
    }
    entry = select(met, in - floats(p.begin), floats(FLT_MAX));
    return bits_of(met);
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
