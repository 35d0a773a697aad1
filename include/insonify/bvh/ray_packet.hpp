#ifndef INSONIFY_BVH_RAY_PACKET_HPP
#define INSONIFY_BVH_RAY_PACKET_HPP

#include <insonify/bvh/prepared_ray.hpp>
#include <insonify/execution/simd_bits.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Rays that go much the same way, as many as there are lanes: a node or a triangle is asked once for all of them.
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
    /// The points with  weight . point >= bound,  point in the order of the axes.
    struct half_space {
        float weight[3] = {};
        float bound = 0;
        std::uint32_t row[3] = {}; ///< of a node's sides: those where the weighted sum over a box is greatest
    };
    half_space around[4]{};
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
    alignas(32) float origin[3][N]; ///< in the order of the axes, as the shear
    alignas(32) float shear[3][N];
    alignas(32) float min_distance[N];
    alignas(32) float limit[N]; ///< what a hit must not be beyond; below 0: this ray is done

    /// Takes N rays. @return whether they go together; else ask them one by one
    ///
    /// They do where they are legal, have the same longest axis, go the same way, begin at 0 or later, and where they
    /// leave the tree make a row no longer than 16 of its leaves and no wider than 2. In longer or wider ones, rays that
    /// meet nothing together wait for one another.
    /// @param reach      no coordinate of a box is further from 0
    /// @param leaf_size  how wide a leaf is
    bool prepare(const ray* first, float reach, float leaf_size) {
        using floats = lanes<N>;
        if (!is_legal(first[0])) return false;
        const sheared_ray lead{first[0]};
        axes[0] = lead.x, axes[1] = lead.y, axes[2] = lead.z;
        forward = lead.shear.z < 0 ? -1.0F : 1.0F;
        alignas(32) float from[3][N], along[3][N], inverse[N];
        bool numbers = true;
        for (int i = 0; i < N; ++i) {
            const ray& r = first[i];
            from[0][i] = r.origin.x;
            from[1][i] = r.origin.y;
            from[2][i] = r.origin.z;
            along[0][i] = r.direction.x;
            along[1][i] = r.direction.y;
            along[2][i] = r.direction.z;
            min_distance[i] = r.min_distance;
            limit[i] = r.max_distance;
            numbers = numbers && is_number(r.min_distance) && is_number(r.max_distance);
            const float forth = along[lead.z][i]; // divided one by one: -ffast-math divides several less precisely
            inverse[i] = 1 / (forth != 0 ? forth : 1.0F);
        }
        if (!numbers) return false;
        bit_lanes<N> wild{};
        floats size[3];
        for (int k = 0; k < 3; ++k) {
            wild = wild | not_finite<N>(load<N>(from[k])) | not_finite<N>(load<N>(along[k]));
            size[k] = absolute(load<N>(along[k]));
        }
        const floats z = load<N>(along[lead.z]), scale = load<N>(inverse);
        // The axis that sheared_ray chooses, ties included.
        const auto longest = lead.z == 0   ? size[1] < size[0] && size[2] < size[0]
                             : lead.z == 1 ? size[0] <= size[1] && size[2] < size[1]
                                           : size[0] <= size[2] && size[1] <= size[2];
        const auto together = longest && floats(1e-30F) < floats(forward) * z &&
                              floats(0.0F) <= load<N>(min_distance) && floats(0.0F) <= floats_of<N>(wild);
        for (int k = 0; k < 3; ++k) {
            store(load<N>(from[axes[k]]), origin[k]);
            const floats settled = select(size[axes[k]] <= floats(1e-30F), floats(0.0F), load<N>(along[axes[k]]));
            store(k < 2 ? settled * scale : scale, shear[k]);
        }
        constexpr std::uint32_t all = (1U << static_cast<unsigned>(N)) - 1;
        return bits_of(together) == all && enclose(reach, leaf_size) && shorten();
    }

    /// Follows the limits of the rays. @return false where none of them has anything left to find
    bool shorten() {
        using floats = lanes<N>;
        const floats most = load<N>(limit), lengths = absolute(floats(1.0F) / load<N>(shear[2]));
        const floats last = multiply_add(most, lengths, floats(forward) * load<N>(origin[2]));
        end = greatest(select(floats(0.0F) <= most, last, floats(-FLT_MAX))) + margin_;
        return end >= begin;
    }

    /// One of the rays.
    sheared_ray operator[](std::uint32_t k) const {
        sheared_ray one;
        one.begin = {origin[0][k], origin[1][k], origin[2][k]};
        one.x = axes[0], one.y = axes[1], one.z = axes[2];
        one.shear = {shear[0][k], shear[1][k], shear[2][k]};
        return one;
    }

  private:
    bool enclose(float reach, float leaf_size) {
        using floats = lanes<N>;
        const floats z_begin = floats(forward) * load<N>(origin[2]);
        const float z0 = least(z_begin);
        float most = reach;
        for (const auto& row : origin) most = greater(most, greatest(absolute(load<N>(row))));
        if (!(1e-18F < most && most < 1e18F)) return false; // what follows might overflow, or vanish
        margin_ = 4e-6F * most; // more than shear, plane and its evaluation may round away together
        begin = z0 - margin_;
        const std::uint32_t z = static_cast<std::uint32_t>(axes[2]), backwards = forward < 0;
        entry_row = tree_node<N>::row(backwards, z);
        exit_row = tree_node<N>::row(1 - backwards, z);
        // Where they start, in a plane that they all have before them, and how they go on along forward * z.
        floats start[2], slope[2];
        for (int k = 0; k < 2; ++k) {
            slope[k] = floats(forward) * load<N>(shear[k]);
            start[k] = multiply_add(slope[k], floats(z0) - z_begin, load<N>(origin[k]));
            slabs[k] = slab_of(start[k], slope[k], z0, static_cast<std::uint32_t>(axes[k]));
        }
        const float far = greater(reach - z0, 0.0F);
        const floats x = multiply_add(slope[0], floats(far), start[0]),
                     y = multiply_add(slope[1], floats(far), start[1]);
        float across = x[N - 1] - x[0], along = y[N - 1] - y[0];
        const float spread = std::sqrt(across * across + along * along);
        across = spread > 0 ? across / spread : 1;
        along = spread > 0 ? along / spread : 0;
        return hold(&around[0], across, along, start, slope, z0, far, 16 * leaf_size) &&
               hold(&around[2], -along, across, start, slope, z0, far, 2 * leaf_size);
    }

    slab slab_of(const lanes<N>& start, const lanes<N>& slope, float z0, std::uint32_t axis) const {
        const float slowest = least(slope), fastest = greatest(slope);
        if (slowest > 0.01F) return slab_from(greatest(start) + margin_, 1 / fastest, z0, 0, axis);
        if (fastest < -0.01F) return slab_from(least(start) - margin_, 1 / slowest, z0, 1, axis);
        return {};
    }
    slab slab_from(float start, float inverse, float z0, std::uint32_t side, std::uint32_t axis) const {
        return {inverse, z0 - start * inverse - 2 * margin_, tree_node<N>::row(side, axis)};
    }

    // Two planes with opposite sides.
    bool hold(half_space* two, float x, float y, const lanes<N>* start, const lanes<N>* slope, float z0, float far,
              float widest) const {
        using floats = lanes<N>;
        const floats from = multiply_add(floats(x), start[0], floats(y) * start[1]);
        const floats more = multiply_add(floats(x), slope[0], floats(y) * slope[1]);
        const float low = least(from) - margin_, high = greatest(from) + margin_;
        const float more_low = least(more), more_high = greatest(more);
        if (!(high - low + (more_high - more_low) * far < widest)) return false;
        two[0] = half_space_of(x, y, -more_low, low - more_low * z0);
        two[1] = half_space_of(-x, -y, more_high, -(high - more_high * z0));
        return true;
    }

    half_space half_space_of(float x, float y, float z, float bound) const {
        half_space one{{x, y, z * forward}, bound};
        for (int k = 0; k < 3; ++k)
            one.row[k] = tree_node<N>::row(one.weight[k] > 0, static_cast<std::uint32_t>(axes[k]));
        return one;
    }

    float margin_ = 0;
};

/// Where the packet enters the boxes of a node's children, in terms of forward * z - begin; `met` has a bit for each
/// box that some ray may meet.
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
    entry = in - floats(p.begin);
    return bits_of(met);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
