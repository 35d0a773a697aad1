#ifndef INSONIFY_BVH_SAH_BINS_HPP
#define INSONIFY_BVH_SAH_BINS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/build_box.hpp>
#include <insonify/bvh/node.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <cstddef>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI::detail {

/// Maps centres to bins; small groups use fewer of them.
struct sah_grid {
    static constexpr int max_bins = 16;

    int bins = max_bins;
    float begin[4] = {}, scale[4] = {};

    sah_grid(const centre_range& centres, std::size_t count)
        : bins{count < 64 ? 8 + static_cast<int>(count) / 8 : max_bins} {
        for (int axis = 0; axis < 3; ++axis) {
            const float extent = centres.end[axis] - centres.begin[axis];
            begin[axis] = centres.begin[axis];
            if (extent > 0) scale[axis] = min(static_cast<float>(bins) / extent, FLT_MAX);
        }
    }
};

/// A splitting plane between two bins.
struct sah_plane {
    int axis = -1;
    std::uint32_t bin = 0; ///< the first bin above the plane
    std::size_t below = 0; ///< the number of primitives

    /// @param places  bins along x, y and z, a byte each
    INSONIFY_INLINE bool is_above(std::uint32_t places) const {
        return (places >> (8U * static_cast<std::uint32_t>(axis)) & 0xFFU) >= bin;
    }
};

/// Bounding box and number of primitives of each bin along each axis.
class sah_bins {
  public:
    explicit sah_bins(const sah_grid& grid) : bins_{grid.bins} {
        for (int axis = 0; axis < 3; ++axis)
            for (int k = 0; k < bins_; ++k) {
                box_[axis][k] = build_box::none();
                count_[axis][k] = 0;
            }
    }

    /// Adds boxes and records their bins, so that the partition uses the very same bins.
    void add(const sah_grid& grid, const build_box* boxes, std::uint32_t* places, std::size_t count) {
        const lanes<4> begin = load<4>(grid.begin), scale = load<4>(grid.scale), zero(0.0F);
        const lanes<4> last(static_cast<float>(bins_ - 1));
        for (std::size_t i = 0; i < count; ++i) {
            float at[4];
            store(max(min((boxes[i].half_centre() - begin) * scale, last), zero), at);
            const int x = static_cast<int>(at[0]), y = static_cast<int>(at[1]), z = static_cast<int>(at[2]);
            places[i] = static_cast<std::uint32_t>(x | y << 8 | z << 16);
        }
        const std::size_t quarter =
            count / 4; // neighbours share bins: adding them in turn would be a chain of dependent stores
        for (std::size_t i = 0; i < quarter; ++i) {
            add(boxes[i], places[i]);
            add(boxes[quarter + i], places[quarter + i]);
            add(boxes[2 * quarter + i], places[2 * quarter + i]);
            add(boxes[3 * quarter + i], places[3 * quarter + i]);
        }
        for (std::size_t i = 4 * quarter; i < count; ++i) add(boxes[i], places[i]);
    }

    void add(const sah_bins& other) {
        for (int axis = 0; axis < 3; ++axis)
            for (int k = 0; k < bins_; ++k) {
                box_[axis][k].add(other.box_[axis][k]);
                count_[axis][k] += other.count_[axis][k];
            }
    }

    std::size_t count_below(const sah_plane& plane) const {
        std::size_t count = 0;
        for (std::uint32_t k = 0; k < plane.bin; ++k) count += count_[plane.axis][k];
        return count;
    }
    build_box box_of(const sah_plane& plane, bool above) const {
        side whole;
        const int begin = above ? static_cast<int>(plane.bin) : 0, end = above ? bins_ : static_cast<int>(plane.bin);
        for (int k = begin; k < end; ++k) whole.add(box_[plane.axis][k], count_[plane.axis][k]);
        return {whole.minus_lower, whole.upper};
    }

    /// The plane of minimum cost with primitives on both sides; axis -1 if there is none.
    template <int Width>
    sah_plane cheapest() const {
        sides below, above;
        side low[3], high[3];
        for (int k = 1, back = bins_ - 1; k < bins_; ++k, --back)
            for (int axis = 0; axis < 3; ++axis) {
                low[axis].add(box_[axis][k - 1], count_[axis][k - 1]);
                high[axis].add(box_[axis][back], count_[axis][back]);
                below.put(axis, k, low[axis]);
                above.put(axis, back, high[axis]);
            }
        sah_plane best;
        float min_cost = FLT_MAX;
        for (int axis = 0; axis < 3; ++axis) {
            float cost[sah_grid::max_bins];
            lanes<simd_width> cheap(FLT_MAX); // branchless: the branches would mispredict
            for (int k = 0; k < sah_grid::max_bins; k += simd_width) {
                const auto both = below.template cost<Width>(axis, k) + above.template cost<Width>(axis, k);
                store(both, cost + k);
                cheap = min(cheap, both);
            }
            const float here = reduce_min(cheap);
            if (!(here < min_cost)) continue;
            min_cost = here;
            int k = 1;
            while (cost[k] != here) ++k;
            best = {axis, static_cast<std::uint32_t>(k), below.held[axis][k]};
        }
        return best;
    }

  private:
    // The primitives on one side of a plane, kept in registers.
    struct side {
        lanes<4> minus_lower{-FLT_MAX}, upper{-FLT_MAX};
        std::uint32_t held = 0;

        INSONIFY_INLINE void add(const build_box& box, std::uint32_t count) {
            minus_lower = max(minus_lower, box.minus_lower());
            upper = max(upper, box.upper());
            held += count;
        }
    };

    // The same side of all planes, indexed by axis and by the bin above the plane.
    struct sides {
        float area[3][sah_grid::max_bins] = {}; // halved
        std::uint32_t held[3][sah_grid::max_bins] = {};

        INSONIFY_INLINE void put(int axis, int bin, const side& one) {
            float size[4];
            store(one.minus_lower + one.upper, size);
            area[axis][bin] = size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
            held[axis][bin] = one.held;
        }
        // SAH cost of this side for several planes: area times number of leaves; FLT_MAX for an empty side.
        template <int Width>
        INSONIFY_INLINE lanes<simd_width> cost(int axis, int bin) const {
            using floats = lanes<simd_width>;
            const auto all = load_bits<simd_width>(held[axis] + bin);
            const auto any = floats(0.0F) < floats_of<simd_width>(all);
            const auto leaves = floats_of<simd_width>((all + (Width - 1U)) >> width_bits<Width>);
            return select(any, load<simd_width>(area[axis] + bin), floats(FLT_MAX)) * max(leaves, floats(1.0F));
        }
    };

    // @param place  its bins along x, y and z, a byte each
    INSONIFY_INLINE void add(const build_box& box, std::uint32_t place) {
        for (int axis = 0; axis < 3; ++axis) {
            const std::uint32_t bin = place >> (8 * axis) & 0xFFU;
            box_[axis][bin].add(box);
            ++count_[axis][bin];
        }
    }

    int bins_;
    build_box box_[3][sah_grid::max_bins];
    std::uint32_t count_[3][sah_grid::max_bins];
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
