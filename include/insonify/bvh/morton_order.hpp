#ifndef INSONIFY_BVH_MORTON_ORDER_HPP
#define INSONIFY_BVH_MORTON_ORDER_HPP

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/execution/simd_bits.hpp>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Primitives in the order of a curve that stays in a cell of space before it goes on to the next.
///
/// Each key has the cell of the primitive's centre above, 10 bits an axis taken in turn, and its index below; primitives
/// of one cell stay in the order of the range. Source: Morton 1966; Lauterbach et al. 2009, "Fast BVH construction on
/// GPUs".
class morton_order {
  public:
    template <class Policy, class Range>
    morton_order(const Policy& policy, const Range& range)
        : block_size_{std::max<std::size_t>(16384, range.size() / 32 + 1)},
          used_((range.size() + block_size_ - 1) / block_size_), keys_(range.size()) {
        find_keys(policy, range);
        for (const std::size_t one : used_) count_ += one;
        if (range.size() < 1024)
            std::sort(keys_.data(), keys_.data() + count_);
        else
            sort(policy);
    }

    std::size_t size() const { return count_; }
    INSONIFY_LAZY std::uint32_t cell(std::size_t place) const {
        return static_cast<std::uint32_t>(keys_[place] >> 32U);
    }
    INSONIFY_LAZY std::uint32_t primitive(std::size_t place) const { return static_cast<std::uint32_t>(keys_[place]); }

  private:
    struct alignas(16) centre {
        float place[4]; // halved; FLT_MAX, beyond all, for an empty box
    };
    static constexpr float last_cell = 1023; // along each axis
    static constexpr unsigned digit_bits = 10;
    static constexpr std::uint32_t digit_mask = (1U << digit_bits) - 1;
    using counts = std::array<std::uint32_t, digit_mask + 1>; // of each digit; then where the next one goes

    template <class Policy, class Range>
    void find_keys(const Policy& policy, const Range& range) {
        large_array<centre> centres(range.size());
        std::vector<centre_range> partial(used_.size());
        exec::for_each_block(policy, range.size(), block_size_, 5, [&](std::size_t begin, std::size_t end) {
            centre_range found;
            for (std::size_t i = begin; i < end; ++i) {
                const build_box box = leaf<Range, simd_width>::box(range, i);
                const lanes<4> place = box.empty() ? lanes<4>(FLT_MAX) : box.half_centre();
                store(place, centres[i].place);
                if (!box.empty()) found.add(place, place);
            }
            partial[begin / block_size_] = found;
        });
        centre_range all;
        for (const centre_range& one : partial) all.add(load<4>(one.begin), load<4>(one.end));
        if (!(all.begin[0] <= all.end[0])) return;
        const float widest = greater(all.end[0] - all.begin[0],
                                     greater(all.end[1] - all.begin[1], all.end[2] - all.begin[2])); // cells are cubes
        const lanes<4> start = load<4>(all.begin), scale(widest > 0 ? lesser(last_cell / widest, FLT_MAX) : 0.0F);
        exec::for_each_block(policy, range.size(), block_size_, 5, [&](std::size_t begin, std::size_t end) {
            std::uint64_t* next = keys_.data() + begin;
            for (std::size_t i = begin; i < end; ++i)
                if (centres[i].place[0] <= all.end[0])
                    *next++ = std::uint64_t{cell_at((load<4>(centres[i].place) - start) * scale)} << 32U | i;
            used_[begin / block_size_] = static_cast<std::size_t>(next - (keys_.data() + begin));
        });
    }

    // A radix sort. Blocks count and move at the same time, each to places of its own; the first move closes the gaps.
    template <class Policy>
    void sort(const Policy& policy) {
        large_array<std::uint64_t> sorted(keys_.size());
        std::vector<counts> found(used_.size());
        for (const unsigned shift : {32U, 32U + digit_bits, 32U + 2 * digit_bits}) {
            const auto digit = [shift](std::uint64_t key) { return key >> shift & digit_mask; };
            exec::for_each_index(policy, used_.size(), [&](std::size_t b) {
                found[b] = {};
                const std::uint64_t* const from = keys_.data() + b * block_size_;
                for (std::size_t i = 0; i < used_[b]; ++i) ++found[b][digit(from[i])];
            });
            std::uint32_t next = 0;
            for (std::size_t d = 0; d <= digit_mask; ++d)
                for (counts& count : found) next += std::exchange(count[d], next);
            exec::for_each_index(policy, used_.size(), [&](std::size_t b) {
                const std::uint64_t* const from = keys_.data() + b * block_size_;
                for (std::size_t i = 0; i < used_[b]; ++i) sorted[found[b][digit(from[i])]++] = from[i];
            });
            keys_.swap(sorted);
            for (std::size_t b = 0; b < used_.size(); ++b)
                used_[b] = std::min(count_ - std::min(count_, b * block_size_), block_size_);
        }
    }

    // The bits of x, y and z by turns; two zeros come between each coordinate's own.
    INSONIFY_LAZY static std::uint32_t cell_at(const lanes<4>& place) {
        auto bits = bits_of_whole<4>(greater(lesser(place, lanes<4>(last_cell)), lanes<4>(0.0F)));
        bits = (bits | bits << 16) & 0x30000FFU;
        bits = (bits | bits << 8) & 0x300F00FU;
        bits = (bits | bits << 4) & 0x30C30C3U;
        bits = (bits | bits << 2) & 0x9249249U;
        return bits[0] | bits[1] << 1U | bits[2] << 2U;
    }

    std::size_t block_size_;
    std::vector<std::size_t> used_; // of the keys in each block: primitives left out leave a gap after them
    large_array<std::uint64_t> keys_;
    std::size_t count_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
