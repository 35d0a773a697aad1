#ifndef INSONIFY_BVH_RAY_PACKET_HPP
#define INSONIFY_BVH_RAY_PACKET_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/node.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI::detail {

/// Consecutive rays in structure-of-arrays layout.
template <int N>
struct ray_lanes {
    lanes<N> origin[3], direction[3], min_distance, max_distance;

    INSONIFY_INLINE explicit ray_lanes(const ray* first) {
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

    /// Sets slab `k` for rays that are at `start` where forward * z = z0, with these slopes. Rays nearly parallel to
    /// the sides leave it unbounded.
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

/// A packet of coherent rays, up to four groups of as many rays as there are lanes. Node tests are shared by the
/// packet; a triangle is intersected by the groups whose part of the row it overlaps.
///
/// The rays form a row, as the lines of a fan and the pixels of an image row do. Of the planes around them, seen along
/// z, two lie along the row and two across it:
///
///              _ - |
///      | _ - o     |
///      |   o   _ - '        o: rays
///      ' - '
template <int N>
struct ray_packet : packet_bounds<N> {
    using packet_bounds<N>::axes, packet_bounds<N>::forward;
    static constexpr std::size_t max_groups = 4;
    static constexpr std::size_t max_rays = max_groups * N;

    /// Bounds of the rays across the row, in terms of z.
    packet_wedge across{};
    float row[2] = {1, 0}; ///< the direction of the row, in x and y; across it is (-row[1], row[0])
    std::size_t groups = 0;
    /// The rays of a group, and the part of the row that they occupy.
    struct alignas(32) group {
        float origin[3][N]; ///< in the order of the axes, as the shear
        float shear[3][N];
        float length[N]; ///< of a step of 1 along z
        float min_distance[N];
        float limit[N];       ///< hits beyond it do not count; below 0: the ray is finished
        float end = -FLT_MAX; ///< of forward * z between the limits of the rays
        packet_wedge along;   ///< bounds of the rays along the row, in terms of z
    };
    group of[max_groups];

    /// Loads coherent rays from the first of `count` on. @return how many: whole groups, or 0
    ///
    /// Rays are coherent where they are valid, share their dominant axis and sign along it, begin at 0 or later, and
    /// form a row that, halfway through the box, is at most 4 leaves long and 2 wide (measured by bench_ratios).
    /// @param box  around all primitives
    std::size_t prepare(const ray* first, std::size_t count, const aabb& box, float max_abs_coordinate,
                        float leaf_size) {
        groups = 0;
        if (count < N || !similar(first[0], first[N - 1])) return 0;
        const sheared_ray lead{first[0]};
        axes[0] = lead.x, axes[1] = lead.y, axes[2] = lead.z;
        forward = lead.shear.z < 0 ? -1.0F : 1.0F;
        const float near = forward > 0 ? box.lower[lead.z] : -box.upper[lead.z];
        const float far = forward > 0 ? box.upper[lead.z] : -box.lower[lead.z];
        const float middle = 0.5F * (max(near, forward * lead.begin.z) + far);
        const std::size_t wanted = coherent_groups(first, count / N, forward * middle, leaf_size);
        while (groups < wanted && take(of[groups], first + groups * N, box, max_abs_coordinate)) ++groups;
        while (groups > 0 && !enclose(max_abs_coordinate, far, middle, max_row_width * leaf_size)) groups /= 2;
        shorten();
        return groups * N;
    }

    /// Updates the ends of all groups from the limits of their rays: skipping unchanged groups would mispredict.
    void shorten() {
        using floats = lanes<N>;
        this->end = -FLT_MAX;
        for (std::size_t g = 0; g < groups; ++g) {
            group& one = of[g];
            const floats largest = load<N>(one.limit);
            const floats last = multiply_add(largest, load<N>(one.length), floats(forward) * load<N>(one.origin[2]));
            one.end = reduce_max(select(floats(0.0F) <= largest, last, floats(-FLT_MAX))) + margin_;
            this->end = max(this->end, one.end);
        }
    }

    /// One of the rays.
    sheared_ray one(std::size_t g, std::uint32_t k) const {
        sheared_ray r;
        r.begin = {of[g].origin[0][k], of[g].origin[1][k], of[g].origin[2][k]};
        r.x = axes[0], r.y = axes[1], r.z = axes[2];
        r.shear = {of[g].shear[0][k], of[g].shear[1][k], of[g].shear[2][k]};
        return r;
    }

  private:
    // Leaves: of a row where it is halfway through the box.
    static constexpr float max_row = 4, max_row_width = 2;

    // Directions less than 45 degrees apart: a quick test before the rays are loaded.
    static bool similar(const ray& a, const ray& b) {
        const float both = dot(a.direction, b.direction);
        return both > 0 && 2 * both * both > dot(a.direction, a.direction) * dot(b.direction, b.direction);
    }

    // How many groups, at most, make a row that is short enough where z is `middle`.
    std::size_t coherent_groups(const ray* rays, std::size_t available, float middle, float leaf_size) const {
        const auto at = [&](const ray& r, int k) {
            const float steps = (middle - r.origin[axes[2]]) / r.direction[axes[2]];
            return r.origin[axes[k]] + r.direction[axes[k]] * steps;
        };
        const float first[2] = {at(rays[0], 0), at(rays[0], 1)};
        for (std::size_t wanted = std::min<std::size_t>(available, max_groups); wanted > 0; wanted /= 2) {
            const ray& last = rays[wanted * N - 1];
            if (!(forward * last.direction[axes[2]] > 1e-30F)) continue;
            const float x = at(last, 0) - first[0], y = at(last, 1) - first[1];
            if (x * x + y * y < max_row * max_row * leaf_size * leaf_size) return wanted;
        }
        return 0;
    }

    // Loads a group. Rays that miss the box are finished at once. @return false where one is not coherent with the lead
    bool take(group& rays, const ray* first, const aabb& box, float max_abs_coordinate) const {
        using floats = lanes<N>;
        const ray_lanes<N> all{first};
        floats size[3];
        for (int axis = 0; axis < 3; ++axis) size[axis] = abs(all.direction[axis]);
        // The axis that sheared_ray chooses, ties included.
        const auto longest = axes[2] == 0   ? size[1] < size[0] && size[2] < size[0]
                             : axes[2] == 1 ? size[0] <= size[1] && size[2] < size[1]
                                            : size[0] <= size[2] && size[1] <= size[2];
        const floats z = all.direction[axes[2]];
        const auto together = longest && floats(1e-30F) < floats(forward) * z && floats(0.0F) <= all.min_distance &&
                              floats(0.0F) <= all.wild();
        constexpr std::uint32_t every_ray = (1U << static_cast<unsigned>(N)) - 1;
        if (bits_of(together) != every_ray) return false;
        const floats scale = inverse(z);
        for (int k = 0; k < 3; ++k) {
            store(all.origin[axes[k]], rays.origin[k]);
            const floats settled = select(size[axes[k]] <= floats(1e-30F), floats(0.0F), all.direction[axes[k]]);
            store(k < 2 ? settled * scale : scale, rays.shear[k]);
        }
        store(abs(z), rays.length);
        store(all.min_distance, rays.min_distance);
        store(all.max_distance, rays.limit);
        for (std::uint32_t out = every_ray & ~may_enter(box, max_abs_coordinate, all); out != 0; out &= out - 1)
            rays.limit[lowest_bit(out)] = -1;
        return true;
    }

    // Bounds the groups. @return false where they are too wide across the row, or coordinates too large or small
    bool enclose(float max_abs_coordinate, float far, float middle, float max_width) {
        using floats = lanes<N>;
        floats nearest(FLT_MAX), furthest(max_abs_coordinate);
        for (std::size_t g = 0; g < groups; ++g) {
            nearest = min(nearest, floats(forward) * load<N>(of[g].origin[2]));
            for (const auto& one : of[g].origin) furthest = max(furthest, abs(load<N>(one)));
        }
        const float z0 = reduce_min(nearest), range = reduce_max(furthest), depth = max(far - z0, 0.0F);
        if (!(1e-18F < range && range < 1e18F)) return false; // what follows might overflow, or underflow
        float way[2];                                         // from the first to the last, where they leave the box
        for (int k = 0; k < 2; ++k) {
            const auto at = [&](const group& one, int i) {
                return one.origin[k][i] + one.shear[k][i] * (forward * (z0 + depth) - one.origin[2][i]);
            };
            way[k] = at(of[groups - 1], N - 1) - at(of[0], 0);
        }
        const float length = std::sqrt(way[0] * way[0] + way[1] * way[1]);
        row[0] = length > 0 ? way[0] / length : 1;
        row[1] = length > 0 ? way[1] / length : 0;
        // Where the rays cross forward * z = z0, which lies behind all origins, and their slopes along forward * z.
        floats start[2][max_groups], slope[2][max_groups];
        for (int k = 0; k < 2; ++k)
            for (std::size_t g = 0; g < groups; ++g) {
                const floats behind = floats(z0) - floats(forward) * load<N>(of[g].origin[2]);
                slope[k][g] = floats(forward) * load<N>(of[g].shear[k]);
                start[k][g] = multiply_add(slope[k][g], behind, load<N>(of[g].origin[k]));
            }
        floats start_along[max_groups], slope_along[max_groups], start_across[max_groups], slope_across[max_groups];
        for (std::size_t g = 0; g < groups; ++g) {
            start_along[g] = multiply_add(floats(row[0]), start[0][g], floats(row[1]) * start[1][g]);
            slope_along[g] = multiply_add(floats(row[0]), slope[0][g], floats(row[1]) * slope[1][g]);
            start_across[g] = multiply_add(floats(row[0]), start[1][g], floats(-row[1]) * start[0][g]);
            slope_across[g] = multiply_add(floats(row[0]), slope[1][g], floats(-row[1]) * slope[0][g]);
        }
        across = wedge_of(start_across, slope_across, groups);
        if (!(across.width(max(middle - z0, 0.0F)) < max_width)) return false;
        margin_ = 4e-6F * range; // above the rounding of shear, planes and their evaluation together
        this->set_begin(z0 - margin_);
        for (int k = 0; k < 2; ++k) this->set_slab(k, wedge_of(start[k], slope[k], groups), z0, margin_);
        for (std::size_t g = 0; g < groups; ++g)
            of[g].along = from_zero(wedge_of(start_along + g, slope_along + g, 1), z0);
        across = from_zero(across, z0);
        this->set_planes(&this->around[0], row[0], row[1], from_zero(wedge_of(start_along, slope_along, groups), z0));
        this->set_planes(&this->around[2], -row[1], row[0], across);
        return true;
    }

    static packet_wedge wedge_of(const lanes<N>* start, const lanes<N>* slope, std::size_t count) {
        lanes<N> low(FLT_MAX), high(-FLT_MAX), min_slope(FLT_MAX), max_slope(-FLT_MAX);
        for (std::size_t g = 0; g < count; ++g) {
            low = min(low, start[g]);
            high = max(high, start[g]);
            min_slope = min(min_slope, slope[g]);
            max_slope = max(max_slope, slope[g]);
        }
        return {reduce_min(low), reduce_max(high), reduce_min(min_slope), reduce_max(max_slope)};
    }

    // The same bounds in terms of z instead of forward * z - z0, widened on both sides by the margin.
    packet_wedge from_zero(const packet_wedge& w, float z0) const {
        return {w.low - margin_ - w.min_slope * z0, w.high + margin_ - w.max_slope * z0, w.min_slope * forward,
                w.max_slope * forward};
    }

    float margin_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
