#ifndef INSONIFY_BVH_SAH_BINS_HPP
#define INSONIFY_BVH_SAH_BINS_HPP

#include <insonify/bvh/build_box.hpp>
#include <insonify/core/algorithm.hpp>
#include <cstddef>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// How centres fall into bins: fewer bins for fewer primitives, 16 at most.
struct sah_grid {
    static constexpr int most = 16;

    int bins = most;
    float begin[4] = {}, scale[4] = {};

    sah_grid(const centre_range& centres, std::size_t count)
        : bins{count < 64 ? 8 + static_cast<int>(count) / 8 : most} {
        for (int axis = 0; axis < 3; ++axis) {
            const float extent = centres.end[axis] - centres.begin[axis];
            begin[axis] = centres.begin[axis];
            if (extent > 0) scale[axis] = lesser(static_cast<float>(bins) / extent, FLT_MAX);
        }
    }
};

/// A plane between two bins, and what lies on either side of it.
struct sah_plane {
    int axis = -1;
    std::uint32_t bin = 0; ///< the first one above
    std::size_t below = 0; ///< so many primitives

    /// @param places  bins along x, y and z, a byte each
    INSONIFY_INLINE bool is_above(std::uint32_t places) const {
        return (places >> (8U * static_cast<std::uint32_t>(axis)) & 0xFFU) >= bin;
    }
};

/// What lies in each bin along each axis.
class sah_bins {
  public:
    INSONIFY_LAZY explicit sah_bins(const sah_grid& grid) : bins_{grid.bins} {
        for (int axis = 0; axis < 3; ++axis)
            for (int k = 0; k < bins_; ++k) {
                box_[axis][k] = build_box::none();
                count_[axis][k] = 0;
            }
    }

    /// Adds boxes, and writes down which bins they fall into, so that those who move them agree.
    INSONIFY_LAZY void add(const sah_grid& grid, const build_box* boxes, std::uint32_t* places, std::size_t count) {
        const lanes<4> begin = load<4>(grid.begin), scale = load<4>(grid.scale);
        const lanes<4> last(static_cast<float>(bins_ - 1));
        const std::size_t half = count / 2; // neighbours share bins: each would wait until the last one is in
        for (std::size_t i = 0; i < half; ++i) {
            places[i] = add(boxes[i], begin, scale, last);
            places[half + i] = add(boxes[half + i], begin, scale, last);
        }
        if (count > 2 * half) places[2 * half] = add(boxes[2 * half], begin, scale, last);
    }

    INSONIFY_LAZY void add(const sah_bins& other) {
        for (int axis = 0; axis < 3; ++axis)
            for (int k = 0; k < bins_; ++k) {
                box_[axis][k].add(other.box_[axis][k]);
                count_[axis][k] += other.count_[axis][k];
            }
    }

    INSONIFY_LAZY std::size_t count_below(const sah_plane& plane) const {
        std::size_t count = 0;
        for (std::uint32_t k = 0; k < plane.bin; ++k) count += count_[plane.axis][k];
        return count;
    }
    INSONIFY_LAZY build_box box_of(const sah_plane& plane, bool above) const {
        side whole;
        const int begin = above ? static_cast<int>(plane.bin) : 0, end = above ? bins_ : static_cast<int>(plane.bin);
        for (int k = begin; k < end; ++k) whole.add(box_[plane.axis][k], count_[plane.axis][k]);
        return {whole.minus_lower, whole.upper};
    }

    /// The plane of least cost with primitives on both sides; axis -1 where there is none.
    template <int Width>
    sah_plane cheapest() const {
        sah_plane best;
        float least_cost = FLT_MAX;
        for (int axis = 0; axis < 3; ++axis) {
            float cost[sah_grid::most]; // of a plane below each bin; where it divides nothing none is dearer
            std::fill_n(cost, sah_grid::most, FLT_MAX);
            side above, below;
            for (int k = bins_ - 1; k > 0; --k) {
                above.add(box_[axis][k], count_[axis][k]);
                cost[k] = above.template cost<Width>();
            }
            for (int k = 1; k < bins_; ++k) {
                below.add(box_[axis][k - 1], count_[axis][k - 1]);
                cost[k] += below.template cost<Width>();
            }
            lanes<simd_width> cheap(FLT_MAX); // the least is found without branches, which no one could foresee
            for (int k = 0; k < sah_grid::most; k += simd_width) cheap = lesser(cheap, load<simd_width>(cost + k));
            const float here = least(cheap);
            if (!(here < least_cost)) continue;
            least_cost = here;
            int k = 1;
            while (cost[k] != here) ++k;
            best.axis = axis;
            best.bin = static_cast<std::uint32_t>(k);
            best.below = count_below(best);
        }
        return best;
    }

  private:
    // What lies on one side of a plane, in registers.
    struct side {
        lanes<4> minus_lower{-FLT_MAX}, upper{-FLT_MAX};
        std::uint32_t held = 0;

        INSONIFY_INLINE void add(const build_box& box, std::uint32_t count) {
            minus_lower = greater(minus_lower, box.minus_lower());
            upper = greater(upper, box.upper());
            held += count;
        }
        template <int Width>
        INSONIFY_INLINE float cost() const {
            float size[4];
            store(minus_lower + upper, size);
            const float area = size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
            return held != 0 ? area * static_cast<float>((held + Width - 1) / Width) : FLT_MAX;
        }
    };

    // @return its bins along x, y and z, a byte each
    template <class = void>
    INSONIFY_INLINE std::uint32_t add(const build_box& box, const lanes<4>& begin, const lanes<4>& scale,
                                      const lanes<4>& last) {
        float at[4];
        store(greater(lesser((box.half_centre() - begin) * scale, last), lanes<4>(0.0F)), at);
        const int x = static_cast<int>(at[0]), y = static_cast<int>(at[1]), z = static_cast<int>(at[2]);
        box_[0][x].add(box);
        box_[1][y].add(box);
        box_[2][z].add(box);
        ++count_[0][x];
        ++count_[1][y];
        ++count_[2][z];
        return static_cast<std::uint32_t>(x | y << 8 | z << 16);
    }

    int bins_;
    build_box box_[3][sah_grid::most];
    std::uint32_t count_[3][sah_grid::most];
};

} // namespace insonify::inline INSONIFY_ABI
#endif
