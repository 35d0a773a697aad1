#ifndef INSONIFY_BVH_MORTON_ORDER_HPP
#define INSONIFY_BVH_MORTON_ORDER_HPP

#include <insonify/bvh/concepts.hpp>
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
        const aabb centres = box_of_centres(policy, range);
        if (centres.empty()) return;
        const vec3 size = centres.size();
        const float widest = greater(size.x, greater(size.y, size.z)); // cells are cubes
        const float scale = widest > 0 ? lesser(2047.0F / widest, FLT_MAX) : 0.0F;
        keys_ = array(range.size());
        spare_ = array(range.size());
        std::vector<std::size_t> used(blocks(range.size()));
        exec::for_each_block(policy, range.size(), block_size, [&](std::size_t begin, std::size_t end) {
            std::size_t next = begin;
            for (std::size_t i = begin; i < end; ++i) {
                const aabb box = bounds(range[i]);
                if (!is_finite(box)) continue;
                const vec3 at = scale * (half_centre(box) - centres.lower);
                keys_[next++] = (spread(at.x) | spread(at.y) << 1U | spread(at.z) << 2U) << index_bits | i;
            }
            used[begin / block_size] = next - begin;
        });
        for (std::size_t b = 0; b < used.size(); ++b) { // closes the gaps that primitives left out have made
            if (count_ != b * block_size)
                std::copy(&keys_[b * block_size], &keys_[b * block_size] + used[b], &keys_[count_]);
            count_ += used[b];
        }
        for (unsigned digit = 0; digit < 3; ++digit) sort_by(policy, index_bits + digit * axis_bits);
    }

    std::size_t size() const { return count_; }
    std::uint64_t cell(std::size_t place) const { return keys_[place] >> index_bits; }
    std::uint32_t primitive(std::size_t place) const {
        return static_cast<std::uint32_t>(keys_[place] & ((std::uint64_t{1} << index_bits) - 1));
    }

  private:
    static constexpr std::size_t block_size = 16384;
    static constexpr std::size_t blocks(std::size_t count) { return (count + block_size - 1) / block_size; }
    static std::unique_ptr<std::uint64_t[]> array(std::size_t count) {
        return std::make_unique_for_overwrite<std::uint64_t[]>(count);
    }

    // Two of them never lie infinitely far apart.
    static vec3 half_centre(const aabb& box) { return 0.25F * box.lower + 0.25F * box.upper; }

    template <class Policy, class Range>
    static aabb box_of_centres(const Policy& policy, const Range& range) {
        std::vector<aabb> partial(blocks(range.size()));
        exec::for_each_block(policy, range.size(), block_size, [&](std::size_t begin, std::size_t end) {
            aabb whole;
            for (std::size_t i = begin; i < end; ++i)
                if (const aabb box = bounds(range[i]); is_finite(box)) whole = merged(whole, half_centre(box));
            partial[begin / block_size] = whole;
        });
        aabb whole;
        for (const aabb& one : partial) whole = merged(whole, one);
        return whole;
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
        exec::for_each_block(policy, count_, block_size, [&](std::size_t begin, std::size_t end) {
            histogram& count = counts[begin / block_size];
            for (std::size_t i = begin; i < end; ++i) ++count[digit(keys_[i])];
        });
        std::uint32_t next = 0;
        for (std::size_t d = 0; d < std::tuple_size_v<histogram>; ++d)
            for (histogram& count : counts) next += std::exchange(count[d], next);
        exec::for_each_block(policy, count_, block_size, [&](std::size_t begin, std::size_t end) {
            histogram& place = counts[begin / block_size];
            for (std::size_t i = begin; i < end; ++i) spare_[place[digit(keys_[i])]++] = keys_[i];
        });
        keys_.swap(spare_);
    }

    std::unique_ptr<std::uint64_t[]> keys_{}, spare_{};
    std::size_t count_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
