#ifndef INSONIFY_BVH_MORTON_ORDER_HPP
#define INSONIFY_BVH_MORTON_ORDER_HPP

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/execution/for_each.hpp>
#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Primitives in the order of a curve that stays in a cell of space before it goes on to the next.
///
/// Each key has the cell of the primitive's centre above, 11 bits an axis taken in turn, and its index below.
/// Source: Morton 1966; Lauterbach et al. 2009, "Fast BVH construction on GPUs".
class morton_order {
  public:
    static constexpr unsigned axis_bits = 11;
    static constexpr unsigned index_bits = 31;

    template <class Policy, class Range>
    morton_order(const Policy& policy, const Range& range) {
        block_size_ = std::max(least_block, (range.size() / 32 + group - 1) / group * group);
        const std::vector<float> centres = find_centres(policy, range);
        if (!(begin_[0] <= end_[0])) return;
        const float widest = greater(end_[0] - begin_[0], greater(end_[1] - begin_[1], end_[2] - begin_[2]));
        const float scale = widest > 0 ? lesser(2047.0F / widest, FLT_MAX) : 0.0F; // cells are cubes
        keys_ = array(range.size());
        std::vector<std::size_t> used(blocks(range.size()));
        exec::for_each_block(policy, range.size(), block_size_, [&](std::size_t begin, std::size_t end) {
            std::size_t next = begin;
            for (std::size_t i = begin; i < end; i += group) {
                const float* const centre = centres.data() + 3 * i;
                float place[3][group];
                for (std::size_t axis = 0; axis < 3; ++axis)
                    store((load<simd_width>(centre + axis * group) - floats(begin_[axis])) * floats(scale),
                          place[axis]);
                for (std::size_t k = 0; k < group && i + k < end; ++k)
                    if (centre[k] != absent)
                        keys_[next++] = (spread(place[0][k]) | spread(place[1][k]) << 1U | spread(place[2][k]) << 2U)
                                            << index_bits |
                                        (i + k);
            }
            used[begin / block_size_] = next - begin;
        });
        for (std::size_t b = 0; b < used.size(); ++b) { // closes the gaps that primitives left out have made
            if (count_ != b * block_size_)
                std::copy(&keys_[b * block_size_], &keys_[b * block_size_] + used[b], &keys_[count_]);
            count_ += used[b];
        }
        if (count_ < 2048) {
            std::sort(&keys_[0], &keys_[0] + count_);
            return;
        }
        spare_ = array(count_);
        for (unsigned digit = 0; digit < 3; ++digit) sort_by(policy, index_bits + digit * axis_bits);
    }

    std::size_t size() const { return count_; }
    std::uint64_t cell(std::size_t place) const { return keys_[place] >> index_bits; }
    std::uint32_t primitive(std::size_t place) const {
        return static_cast<std::uint32_t>(keys_[place] & ((std::uint64_t{1} << index_bits) - 1));
    }

  private:
    using floats = lanes<simd_width>;
    static constexpr std::size_t group = simd_width; // of primitives whose centres are found together
    static constexpr std::size_t least_block = 16384;
    static constexpr float absent = FLT_MAX; // in place of a centre

    std::size_t blocks(std::size_t count) const { return (count + block_size_ - 1) / block_size_; }
    static std::unique_ptr<std::uint64_t[]> array(std::size_t count) {
        return std::make_unique_for_overwrite<std::uint64_t[]>(count);
    }

    // Half the centres of all primitives (two of which never lie infinitely far apart), by groups: x..., y..., z...
    template <class Policy, class Range>
    std::vector<float> find_centres(const Policy& policy, const Range& range) {
        std::vector<float> centres((range.size() + group - 1) / group * group * 3);
        struct limits {
            floats begin[3]{FLT_MAX, FLT_MAX, FLT_MAX}, end[3]{-FLT_MAX, -FLT_MAX, -FLT_MAX};
        };
        std::vector<limits> partial(blocks(range.size()));
        exec::for_each_block(policy, range.size(), block_size_, [&](std::size_t begin, std::size_t end) {
            limits found;
            for (std::size_t i = begin; i < end; i += group) {
                const auto rows = leaf<Range, simd_width>::boxes(range, i, end - i);
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const floats lower = load<simd_width>(rows.sides + axis * group);
                    const floats upper = load<simd_width>(rows.sides + (3 + axis) * group);
                    const auto there = lower <= upper;
                    const floats centre = floats(0.25F) * lower + floats(0.25F) * upper;
                    store(select(there, centre, floats(absent)), centres.data() + 3 * i + axis * group);
                    found.begin[axis] = lesser(found.begin[axis], select(there, centre, floats(FLT_MAX)));
                    found.end[axis] = greater(found.end[axis], select(there, centre, floats(-FLT_MAX)));
                }
            }
            partial[begin / block_size_] = found;
        });
        for (const limits& one : partial)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                begin_[axis] = lesser(begin_[axis], least(one.begin[axis]));
                end_[axis] = greater(end_[axis], greatest(one.end[axis]));
            }
        return centres;
    }

    // The low 11 bits of a coordinate, two zeros between each.
    static std::uint64_t spread(float coordinate) {
        auto x = static_cast<std::uint64_t>(clamped(coordinate, 0, 2047));
        x = (x | x << 16U) & 0x70000FFULL;
        x = (x | x << 8U) & 0x700F00FULL;
        x = (x | x << 4U) & 0x430C30C3ULL;
        return (x | x << 2U) & 0x49249249ULL;
    }

    // One stable pass of a radix sort; blocks count and move at the same time, each to places of its own.
    template <class Policy>
    void sort_by(const Policy& policy, unsigned shift) {
        using histogram = std::array<std::uint32_t, 1U << axis_bits>;
        const auto digit = [shift](std::uint64_t key) { return key >> shift & ((1U << axis_bits) - 1); };
        std::vector<histogram> counts(blocks(count_));
        exec::for_each_block(policy, count_, block_size_, [&](std::size_t begin, std::size_t end) {
            histogram& count = counts[begin / block_size_];
            for (std::size_t i = begin; i < end; ++i) ++count[digit(keys_[i])];
        });
        std::uint32_t next = 0;
        for (std::size_t d = 0; d < std::tuple_size_v<histogram>; ++d)
            for (histogram& count : counts) next += std::exchange(count[d], next);
        exec::for_each_block(policy, count_, block_size_, [&](std::size_t begin, std::size_t end) {
            histogram& place = counts[begin / block_size_];
            for (std::size_t i = begin; i < end; ++i) spare_[place[digit(keys_[i])]++] = keys_[i];
        });
        keys_.swap(spare_);
    }

    std::size_t block_size_ = least_block; ///< of what one thread works on at a time
    float begin_[3] = {FLT_MAX, FLT_MAX, FLT_MAX}, end_[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
    std::unique_ptr<std::uint64_t[]> keys_{}, spare_{};
    std::size_t count_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
