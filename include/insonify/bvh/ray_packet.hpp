#ifndef INSONIFY_BVH_RAY_PACKET_HPP
#define INSONIFY_BVH_RAY_PACKET_HPP

#include <insonify/bvh/prepared_ray.hpp>
#include <insonify/execution/simd_bits.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Rays that go much the same way, in up to four groups of as many as there are lanes: a node is asked once for all of
/// them, a triangle by the groups whose part of the row it reaches.
///
/// All have the same longest axis z and walk it in the same direction. Four planes hold them from where the first one
/// begins; a box or a triangle beyond one of the planes is met by none. In the plane across z, two of them stand along
/// the row that the rays form, two across it, so that the lines of a fan have little between them:
///
///              _ - |
///      | _ - o     |
///      |   o   _ - '        o: rays, seen along z
///      ' - '
template <int N>
struct ray_packet {
    static constexpr std::size_t most_groups = 4;
    static constexpr std::size_t most_rays = most_groups * N;

    /// The points with  weight . point >= bound,  point in the order of the axes.
    struct half_space {
        float weight[3] = {};
        float bound = 0;
        std::uint32_t row[3] = {}; ///< of a node's sides: those where the weighted sum over a box is greatest
    };
    half_space around[4]{};
    /// Between which two lines across a direction u rays stay:  low + slowest * z <= u <= high + fastest * z.
    struct wedge {
        float low = 0, high = 0, slowest = 0, fastest = 0;

        float width(float z) const { return high - low + (fastest - slowest) * z; }
    };
    wedge across{};
    /// Where a point stands in the row as it fans out, 0 where the row begins and 1 where it ends:
    ///
    ///     inwards / width,    inwards = u - low - slowest * z,    width = widest + widening * z,    u along the row
    ///
    /// As a quotient of two linear functions it only rises or only falls along a ray, and is extreme at the corners of a
    /// triangle, wherever the width is above 0. Rays of a fan keep their place, others nearly.
    struct ruler {
        float low = 0, slowest = 0, widest = 0, widening = 0;
        float valid_from = 0; ///< in terms of forward * z: nearer points can have any place

        INSONIFY_INLINE lanes<N> inwards(const lanes<N>& u, const lanes<N>& z) const {
            return multiply_add(lanes<N>(-slowest), z, u) - lanes<N>(low);
        }
        INSONIFY_INLINE lanes<N> width(const lanes<N>& z) const {
            return multiply_add(lanes<N>(widening), z, lanes<N>(widest));
        }
        /// Of points that are not valid any number, or an infinite one.
        INSONIFY_INLINE static lanes<N> place(const lanes<N>& inwards, const lanes<N>& width) {
            return inwards / greater(lanes<N>(1e-22F), width);
        }
    };
    ruler places{};
    float row[2] = {1, 0}; ///< the direction of the row, in x and y; across it is (-row[1], row[0])
    /// Where, in terms of forward * z, none of the rays has come to a box yet, seen along x or y: side * inverse + from.
    struct slab {
        float inverse = 0;
        float from = -FLT_MAX;
        std::uint32_t row = 0;
    };
    slab slabs[2]{};
    int axes[3] = {0, 1, 2}; ///< of the world, in the order of the shear: x, y and z above
    float forward = 1;       ///< the direction along z, 1 or -1; forward * z grows along the rays
    float begin = 0;         ///< the stretch of forward * z that concerns any of the rays
    float end = 0;
    std::uint32_t entry_row = 0, exit_row = 0;
    std::size_t groups = 0;
    /// What each ray has of its own, and the part of the row where they stay.
    struct alignas(32) group {
        float origin[3][N]; ///< in the order of the axes, as the shear
        float shear[3][N];
        float length[N]; ///< of a step of 1 along z
        float min_distance[N];
        float limit[N];       ///< what a hit must not be beyond; below 0: this ray is done
        float end = -FLT_MAX; ///< of the stretch of forward * z that concerns any of the group's rays
        float first, last;    ///< the places of its rays
    };
    group of[most_groups];

    /// Takes rays from the first of `count` on, as many as go together. @return how many: whole groups, 0 for none
    ///
    /// They do where they are legal, have the same longest axis, go the same way, begin at 0 or later, and where they
    /// leave the tree make a row no longer than 16 of its leaves and no wider than 2. In longer or wider ones, rays that
    /// meet nothing together wait for one another.
    /// @param reach      no coordinate of a box is further from 0
    /// @param leaf_size  how wide a leaf is
    std::size_t prepare(const ray* first, std::size_t count, float reach, float leaf_size) {
        groups = 0;
        if (count < N || !look_alike(first[0], first[N - 1])) return 0;
        const sheared_ray lead{first[0]};
        axes[0] = lead.x, axes[1] = lead.y, axes[2] = lead.z;
        forward = lead.shear.z < 0 ? -1.0F : 1.0F;
        while (groups < most_groups && (groups + 1) * N <= count && take(of[groups], first + groups * N)) ++groups;
        while (groups > 0 && !enclose(reach, leaf_size)) groups /= 2;
        shorten();
        return groups * N;
    }

    /// Follows the limits of the rays. Of all groups, since which of them have moved no one foresees.
    void shorten() {
        using floats = lanes<N>;
        end = -FLT_MAX;
        for (std::size_t g = 0; g < groups; ++g) {
            group& one = of[g];
            const floats most = load<N>(one.limit);
            const floats last = multiply_add(most, load<N>(one.length), floats(forward) * load<N>(one.origin[2]));
            one.end = greatest(select(floats(0.0F) <= most, last, floats(-FLT_MAX))) + margin_;
            end = greater(end, one.end);
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
    // Whether it is worth while to look closer: their directions are less than 45 degrees apart.
    static bool look_alike(const ray& a, const ray& b) {
        const float both = dot(a.direction, b.direction);
        return both > 0 && 2 * both * both > dot(a.direction, a.direction) * dot(b.direction, b.direction);
    }

    bool take(group& rays, const ray* first) const {
        using floats = lanes<N>;
        floats from[3], along[3], size[3];
        bit_lanes<N> wild{};
        for (int axis = 0; axis < 3; ++axis) {
            from[axis] = each_lane<N>([&](int i) { return first[i].origin[axis]; });
            along[axis] = each_lane<N>([&](int i) { return first[i].direction[axis]; });
            size[axis] = absolute(along[axis]);
            wild = wild | not_finite<N>(from[axis]) | not_finite<N>(along[axis]);
        }
        const floats nearest = each_lane<N>([&](int i) { return first[i].min_distance; });
        const floats furthest = each_lane<N>([&](int i) { return first[i].max_distance; });
        wild = wild | not_number<N>(nearest) | not_number<N>(furthest);
        // The axis that sheared_ray chooses, ties included.
        const auto longest = axes[2] == 0   ? size[1] < size[0] && size[2] < size[0]
                             : axes[2] == 1 ? size[0] <= size[1] && size[2] < size[1]
                                            : size[0] <= size[2] && size[1] <= size[2];
        const floats z = along[axes[2]];
        const auto together = longest && floats(1e-30F) < floats(forward) * z && floats(0.0F) <= nearest &&
                              floats(0.0F) <= floats_of<N>(wild);
        constexpr std::uint32_t all = (1U << static_cast<unsigned>(N)) - 1;
        if (bits_of(together) != all) return false;
        const floats scale = inverse(z);
        for (int k = 0; k < 3; ++k) {
            store(from[axes[k]], rays.origin[k]);
            const floats settled = select(size[axes[k]] <= floats(1e-30F), floats(0.0F), along[axes[k]]);
            store(k < 2 ? settled * scale : scale, rays.shear[k]);
        }
        store(absolute(z), rays.length);
        store(nearest, rays.min_distance);
        store(furthest, rays.limit);
        return true;
    }

    bool enclose(float reach, float leaf_size) {
        using floats = lanes<N>;
        floats nearest(FLT_MAX), furthest(reach);
        for (std::size_t g = 0; g < groups; ++g) {
            nearest = lesser(nearest, floats(forward) * load<N>(of[g].origin[2]));
            for (const auto& one : of[g].origin) furthest = greater(furthest, absolute(load<N>(one)));
        }
        const float z0 = least(nearest), most = greatest(furthest), depth = greater(reach - z0, 0.0F);
        if (!(1e-18F < most && most < 1e18F)) return false; // what follows might overflow, or vanish
        float way[2];                                       // from the first to the last, where they leave the tree
        for (int k = 0; k < 2; ++k) {
            const auto at = [&](const group& one, int i) {
                return one.origin[k][i] + one.shear[k][i] * (forward * (z0 + depth) - one.origin[2][i]);
            };
            way[k] = at(of[groups - 1], N - 1) - at(of[0], 0);
        }
        const float spread = std::sqrt(way[0] * way[0] + way[1] * way[1]);
        const float longest = 16 * leaf_size, widest = 2 * leaf_size;
        if (!(spread < longest)) return false;
        row[0] = spread > 0 ? way[0] / spread : 1;
        row[1] = spread > 0 ? way[1] / spread : 0;
        // Where they start, in a plane that they all have before them, and how they go on along forward * z.
        floats start[2][most_groups], slope[2][most_groups];
        for (int k = 0; k < 2; ++k)
            for (std::size_t g = 0; g < groups; ++g) {
                const floats behind = floats(z0) - floats(forward) * load<N>(of[g].origin[2]);
                slope[k][g] = floats(forward) * load<N>(of[g].shear[k]);
                start[k][g] = multiply_add(slope[k][g], behind, load<N>(of[g].origin[k]));
            }
        floats start_along[most_groups], slope_along[most_groups], start_across[most_groups], slope_across[most_groups];
        for (std::size_t g = 0; g < groups; ++g) {
            start_along[g] = multiply_add(floats(row[0]), start[0][g], floats(row[1]) * start[1][g]);
            slope_along[g] = multiply_add(floats(row[0]), slope[0][g], floats(row[1]) * slope[1][g]);
            start_across[g] = multiply_add(floats(row[0]), start[1][g], floats(-row[1]) * start[0][g]);
            slope_across[g] = multiply_add(floats(row[0]), slope[1][g], floats(-row[1]) * slope[0][g]);
        }
        const wedge along = wedge_of(start_along, slope_along);
        across = wedge_of(start_across, slope_across);
        if (!(along.width(depth) < longest && across.width(depth) < widest)) return false;
        margin_ = 4e-6F * most; // more than shear, plane and its evaluation may round away together
        begin = z0 - margin_;
        const std::uint32_t z = static_cast<std::uint32_t>(axes[2]), backwards = forward < 0;
        entry_row = tree_node<N>::row(backwards, z);
        exit_row = tree_node<N>::row(1 - backwards, z);
        for (std::uint32_t k = 0; k < 2; ++k)
            slabs[k] = slab_of(start[k], slope[k], z0, static_cast<std::uint32_t>(axes[k]));
        place_groups(along, start_along, slope_along, z0, depth);
        across = from_zero(across, z0, margin_);
        hold(&around[0], row[0], row[1], from_zero(along, z0, margin_));
        hold(&around[2], -row[1], row[0], across);
        return true;
    }

    // Gives each group the places of its rays at two depths after z0, between which they keep.
    void place_groups(wedge along, const lanes<N>* start, const lanes<N>* slope, float z0, float depth) {
        using floats = lanes<N>;
        // Where the row is this wide, rounding moves places by less than a hundredth: they count from there on. In a row
        // that never is they count from the start, with room to each side.
        const float wide = 400 * margin_;
        const float needed = greater(0.0F, (wide - along.width(0)) / greater(along.fastest - along.slowest, 1e-30F));
        const bool opens = needed < depth;
        const float first = opens ? needed : 0.0F, room = (opens ? 2.0F : 50.0F) * margin_;
        along.low -= room;
        along.high += room;
        const wedge world = from_zero(along, z0, 0);
        places = {world.low, world.slowest, world.high - world.low, world.fastest - world.slowest, z0 + first};
        for (std::size_t g = 0; g < groups; ++g) {
            const auto place = [&](float at) {
                return (start[g] - floats(along.low) + floats(at) * (slope[g] - floats(along.slowest))) *
                       floats(1 / along.width(at));
            };
            const floats one = place(first), other = place(depth);
            of[g].first = least(lesser(one, other)) - 2 * margin_ / along.width(first);
            of[g].last = greatest(greater(one, other)) + 2 * margin_ / along.width(first);
        }
    }

    /// The least and the greatest of all rays.
    struct extent {
        lanes<N> low{FLT_MAX}, high{-FLT_MAX};

        void add(const lanes<N>& value) {
            low = lesser(low, value);
            high = greater(high, value);
        }
    };
    extent extent_of(const lanes<N>* values) const {
        extent all;
        for (std::size_t g = 0; g < groups; ++g) all.add(values[g]);
        return all;
    }

    slab slab_of(const lanes<N>* start, const lanes<N>* slope, float z0, std::uint32_t axis) const {
        const extent speed = extent_of(slope);
        const float slowest = least(speed.low), fastest = greatest(speed.high);
        if (slowest > 0.01F) return slab_from(greatest(extent_of(start).high) + margin_, 1 / fastest, z0, 0, axis);
        if (fastest < -0.01F) return slab_from(least(extent_of(start).low) - margin_, 1 / slowest, z0, 1, axis);
        return {};
    }
    slab slab_from(float start, float inverse, float z0, std::uint32_t side, std::uint32_t axis) const {
        return {inverse, z0 - start * inverse - 2 * margin_, tree_node<N>::row(side, axis)};
    }

    wedge wedge_of(const lanes<N>* start, const lanes<N>* slope) const {
        const extent from = extent_of(start), more = extent_of(slope);
        return {least(from.low), greatest(from.high), least(more.low), greatest(more.high)};
    }

    // From where forward * z is z0 to where z is 0, and wider on both sides.
    wedge from_zero(const wedge& w, float z0, float more) const {
        return {w.low - more - w.slowest * z0, w.high + more - w.fastest * z0, w.slowest * forward,
                w.fastest * forward};
    }

    // Two planes with opposite sides.
    void hold(half_space* two, float x, float y, const wedge& w) const {
        two[0] = half_space_of(x, y, -w.slowest, w.low);
        two[1] = half_space_of(-x, -y, w.fastest, -w.high);
    }

    half_space half_space_of(float x, float y, float z, float bound) const {
        half_space one{{x, y, z}, bound};
        for (int k = 0; k < 3; ++k)
            one.row[k] = tree_node<N>::row(one.weight[k] > 0, static_cast<std::uint32_t>(axes[k]));
        return one;
    }

    float margin_ = 0;
};

/// Where the packet enters the boxes of a node's children, in terms of forward * z - begin; FLT_MAX for those that it
/// does not meet.
/// @return a bit for each box that some ray may meet
template <int N>
INSONIFY_INLINE std::uint32_t enter(const tree_node<N>& node, const ray_packet<N>& p, lanes<N>& entry) {
    using floats = lanes<N>;
    const floats forward(p.forward);
    floats in = forward * load<N>(node.sides + p.entry_row);
    const floats out = forward * load<N>(node.sides + p.exit_row);
    for (const auto& slab : p.slabs)
        in = greater(in, multiply_add(load<N>(node.sides + slab.row), floats(slab.inverse), floats(slab.from)));
    auto met = in <= floats(p.end) && floats(p.begin) <= out;
    for (const auto& one : p.around) {
        const auto weighted = [&](int k) { return floats(one.weight[k]) * load<N>(node.sides + one.row[k]); };
        const floats most =
            multiply_add(floats(one.weight[1]), load<N>(node.sides + one.row[1]),
                         multiply_add(floats(one.weight[2]), load<N>(node.sides + one.row[2]), weighted(0)));
        met = met && floats(one.bound) <= most;
    }
    entry = select(met, in - floats(p.begin), floats(FLT_MAX));
    return bits_of(met);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
