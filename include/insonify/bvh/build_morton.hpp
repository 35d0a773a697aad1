#ifndef INSONIFY_BVH_BUILD_MORTON_HPP
#define INSONIFY_BVH_BUILD_MORTON_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/assemble.hpp>
#include <insonify/bvh/leaf.hpp>
#include <algorithm>
#include <array>
#include <bit>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Primitives sorted by Morton code. The upper half of a key is the code of the primitive's centre, 10 interleaved bits
/// per axis, the lower half its index, so the sort is stable.
///
/// Source: Morton 1966; Lauterbach et al. 2009, "Fast BVH construction on GPUs".
class morton_order {
  public:
    template <class Policy, class Range>
    morton_order(const Policy& policy, const Range& range)
        : block_size_{std::max<std::size_t>(8192, range.size() / 32 + 1)}, blocks_{(range.size() + block_size_ - 1) /
                                                                                   block_size_},
          keys_(range.size()) {
        find_keys(policy, range);
        if (range.size() < 1024)
            std::sort(keys_.begin(), keys_.end());
        else
            sort(policy);
    }

    std::size_t size() const { return keys_.size(); }
    std::uint32_t cell(std::size_t place) const { return static_cast<std::uint32_t>(keys_[place] >> 32U); }
    std::uint32_t primitive(std::size_t place) const { return static_cast<std::uint32_t>(keys_[place]); }

    /// The highest bit in which codes in [begin, end) differ, counted from 1; 0 if all are equal.
    std::uint32_t highest_step(std::size_t begin, std::size_t end) const {
        return static_cast<std::uint32_t>(std::bit_width(cell(begin) ^ cell(end - 1)));
    }
    /// The position where that bit changes; unique, since codes are sorted. @param step  above 0
    std::size_t place_of_step(std::size_t begin, std::size_t end, std::uint32_t step) const {
        const std::uint64_t* first = keys_.data() + begin; // bisection: branches would mispredict
        for (std::size_t count = end - begin; count > 1; count -= count / 2)
            first += (first[count / 2] >> (31 + step) & 1U) == 0 ? count / 2 : 0;
        return static_cast<std::size_t>(first + 1 - keys_.data());
    }

  private:
    static constexpr float last_cell = 1023; // along each axis
    template <unsigned Bits>
    using counts = std::array<std::uint32_t, 1U << Bits>; // a histogram of digits, then the next position of each

    // Estimates the bounds of all centres from a thousand; a second pass with exact bounds is rarely needed.
    template <class Policy, class Range>
    void find_keys(const Policy& policy, const Range& range) {
        centre_range some;
        const build_box first = first_box(range);
        build_box box = first;
        for (std::size_t i = 0; i < range.size(); i += range.size() / 1024 + 1) {
            leaf<Range, simd_width>::bound(range, i, box);
            some.add(box.half_centre(), box.half_centre());
        }
        const centre_range around = some.widened(1.0F / 64);
        const centre_range all = put_keys(policy, range, around, first);
        if (!around.holds(all)) put_keys(policy, range, all, first);
    }

    // Quantises half centres to a grid of cubes. @return their bounds
    template <class Policy, class Range>
    centre_range put_keys(const Policy& policy, const Range& range, const centre_range& grid,
                          const build_box& first_box) {
        std::vector<centre_range> partial(blocks_);
        const float widest = min(grid.widest(), FLT_MAX);
        const lanes<4> start = widest > 0 ? load<4>(grid.begin) : lanes<4>(0.0F);
        const lanes<4> scale(widest > 0 ? min(last_cell / widest, FLT_MAX) : 0.0F);
        exec::for_each_block(policy, range.size(), block_size_, 10, [&](std::size_t begin, std::size_t end) {
            build_box box = first_box;
            lanes<4> first(FLT_MAX), last(-FLT_MAX);
            for (std::size_t i = begin; i < end; ++i) {
                if constexpr (requires { range.prefetch_corners(0); })
                    if (range.size() >= prefetch_threshold && i + 16 < end) range.prefetch_corners(i + 16);
                leaf<Range, simd_width>::bound(range, i, box);
                const lanes<4> at = box.half_centre();
                first = min(first, at);
                last = max(last, at);
                std::uint32_t cell[4];
                store_bits<4>(spread((at - start) * scale), cell);
                keys_[i] = std::uint64_t{cell[0] | cell[1] << 1U | cell[2] << 2U} << 32U | i;
            }
            partial[begin / block_size_].add(first, last);
        });
        centre_range all;
        for (const centre_range& one : partial) all.add(load<4>(one.begin), load<4>(one.end));
        return all;
    }

    // Radix sort by the highest digit, blocks in parallel; then the keys of each digit by themselves, which fit into
    // the cache.
    template <class Policy>
    void sort(const Policy& policy) {
        large_array<std::uint64_t> apart(keys_.size());
        std::vector<counts<10>> places(blocks_);
        const auto digit = [](std::uint64_t key) { return static_cast<std::uint32_t>(key >> 52U); };
        const auto for_each_block = [&](const auto& body) {
            for_each_index(policy, blocks_, [&](std::size_t b) {
                const std::size_t begin = b * block_size_, count = std::min(block_size_, keys_.size() - begin);
                body(keys_.data() + begin, static_cast<std::uint32_t>(count), places[b]);
            });
        };
        for_each_block([&](const std::uint64_t* from, std::uint32_t count, counts<10>& place) {
            place = {};
            for (std::uint32_t i = 0; i < count; ++i) ++place[digit(from[i])];
        });
        counts<10> next = {}; // the histogram of all blocks, then the begin of each digit, at last its end
        for (const auto& some : places)
            for (std::size_t d = 0; d < next.size(); ++d) next[d] += some[d];
        exclusive_scan(next);
        for (auto& place : places)
            for (std::size_t d = 0; d < next.size(); ++d) next[d] += std::exchange(place[d], next[d]);
        for_each_block([&](const std::uint64_t* from, std::uint32_t count, counts<10>& place) {
            scatter(from, count, digit, place, apart.data());
        });
        std::swap(keys_, apart); // the old keys are not needed any more
        const auto first = [&next](std::size_t d) { return d > 0 ? next[d - 1] : 0; };
        constexpr std::size_t together = 4; // digits per task
        const float each = 12 * static_cast<float>(keys_.size()) / static_cast<float>(next.size());
        exec::for_each_in_blocks(policy, next.size(), together, each, [&](std::size_t d) {
            sort_cells(keys_.data() + first(d), apart.data() + first(d), next[d] - first(d));
        });
    }

    static void sort_cells(std::uint64_t* keys, std::uint64_t* other, std::uint32_t count) {
        if (count < 64)
            std::sort(keys, keys + count);
        else if (count < 512)
            sort_by_digits<7>(keys, other, count);
        else
            sort_by_digits<10>(keys, other, count);
    }

    // Radix sort by the remaining 20 bits, alternating between two arrays.
    template <unsigned Bits>
    static void sort_by_digits(std::uint64_t* keys, std::uint64_t* other, std::uint32_t count) {
        constexpr unsigned digits = (20 + Bits - 1) / Bits;
        counts<Bits> places[digits] = {};
        const auto digit = [](std::uint64_t key, unsigned k) {
            return static_cast<std::uint32_t>(key >> (32 + Bits * k)) & ((1U << Bits) - 1);
        };
        for (std::uint32_t i = 0; i < count; ++i)
            for (unsigned k = 0; k < digits; ++k) ++places[k][digit(keys[i], k)];
        for (unsigned k = 0; k < digits; ++k) {
            exclusive_scan(places[k]);
            const auto this_digit = [&](std::uint64_t key) { return digit(key, k); };
            scatter(keys, count, this_digit, places[k], other);
            std::swap(keys, other);
        }
        if constexpr (digits % 2 != 0) std::copy(keys, keys + count, other);
    }

    template <class Counts>
    static void exclusive_scan(Counts& counted) {
        std::uint32_t before = 0;
        for (std::uint32_t& one : counted) before += std::exchange(one, before);
    }

    template <class Digit, class Counts>
    static void scatter(const std::uint64_t* keys, std::uint32_t count, const Digit& digit, Counts& next,
                        std::uint64_t* to) {
        for (std::uint32_t i = 0; i < count; ++i) to[next[digit(keys[i])]++] = keys[i];
    }

    // Inserts two zeros after each bit of a coordinate.
    static bit_lanes<4> spread(const lanes<4>& place) {
        auto bits = bits_of_whole<4>(max(min(place, lanes<4>(last_cell)), lanes<4>(0.0F)));
        bits = (bits | bits << 16) & 0x30000FFU;
        bits = (bits | bits << 8) & 0x300F00FU;
        bits = (bits | bits << 4) & 0x30C30C3U;
        return (bits | bits << 2) & 0x9249249U;
    }

    std::size_t block_size_, blocks_;
    large_array<std::uint64_t> keys_;
};

/// Splits ranges of the Morton order for `tree_assembler`.
template <int Width>
class morton_splitter {
  public:
    struct group {
        std::size_t begin = 0;
        std::size_t end = 0;

        std::size_t size() const { return end - begin; }
    };

    template <class Policy, class Range>
    morton_splitter(const Policy& policy, const Range& range) : order_{policy, range} {}

    group all() const { return {0, order_.size()}; }

    void list(const group& held, std::uint32_t* slots) const {
        for (std::size_t i = 0; i < held.size(); ++i) slots[i] = order_.primitive(held.begin + i);
    }

    /// Larger cells are heavier, then those with more primitives.
    std::uint64_t weight(const group& g, std::uint32_t level) const {
        return std::uint64_t{cell_bits(g, level)} << 32U | g.size();
    }

    template <class Policy>
    void split(const Policy&, const group& whole, std::uint32_t level, group& below, group& above) const {
        const std::uint32_t bits = cell_bits(whole, level);
        std::size_t middle =
            bits != 0 ? order_.place_of_step(whole.begin, whole.end, bits) : whole.begin + whole.size() / 2;
        if (whole.size() <= 3 * Width) {
            const std::size_t full = (middle - whole.begin + Width / 2) / Width * Width;
            middle = whole.begin + std::clamp<std::size_t>(full, Width, (whole.size() - 1) / Width * Width);
        }
        below = {whole.begin, middle};
        above = {middle, whole.end};
    }

  private:
    // The highest bit in which codes of the group differ, counted from 1; 0 for a median split.
    std::uint32_t cell_bits(const group& g, std::uint32_t level) const {
        if (level >= free_levels) return 0;
        return order_.highest_step(g.begin, g.end);
    }

    morton_order order_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

/// Builds a wide BVH by splitting primitives in Morton order: several times faster than `build_sah`, and somewhat
/// slower to trace. For primitives that move so far that refits degrade the tree.
///
///     Morton codes:  0010 0010 0011 | 0100 0101     split where the highest differing bit changes, then
///     positions:        0    1    2 |    3    4     moved to the next multiple of Width, so that leaves are full
///
/// The tree depends only on the boxes. Primitives whose box is empty or not finite are kept, in the place of another
/// one.
struct build_morton {
    /// The tree over the boxes of a range of primitives.
    template <int Width, exec::policy Policy, class Range>
    topology<Width> operator()(const Policy& policy, const Range& range) const {
        detail::morton_splitter<Width> splitter{policy, range};
        return detail::tree_assembler<Width, detail::morton_splitter<Width>>{splitter}.assemble(policy, splitter.all());
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
