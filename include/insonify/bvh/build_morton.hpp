#ifndef INSONIFY_BVH_BUILD_MORTON_HPP
#define INSONIFY_BVH_BUILD_MORTON_HPP

#include <insonify/bvh/assemble.hpp>
#include <insonify/bvh/morton_order.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Builds a wide tree from primitives sorted along a curve, by halving cells of space: several times faster than
/// `build_sah`, and rays take somewhat longer. For primitives that move so much that refitting does not keep up.
///
///     cells in order:  0010 0010 0011 | 0100 0101     halved where the highest bit that differs changes, then
///     places:             0    1    2 |    3    4     moved to the next multiple of Width, so that leaves are full
///
/// The tree depends on the boxes alone, not on the policy. Boxes that are empty or not finite are left out.
struct build_morton {
    template <int Width, exec::policy Policy, class Range>
    topology<Width> operator()(const Policy& policy, const Range& range) const;
};

/// Divides groups for `tree_assembler`: stretches of the order.
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
        std::sort(slots, slots + held.size());
    }

    template <class Policy>
    int divide(const Policy&, const group& whole, std::uint32_t level, group (&children)[Width]) const {
        children[0] = whole;
        std::uint64_t size[Width] = {size_of(whole, level)};
        int count = 1;
        while (count < Width) {
            int chosen = 0;
            for (int i = 1; i < count; ++i)
                if (size[i] > size[chosen]) chosen = i;
            if (size[chosen] == 0) break;
            const group parent = children[chosen];
            const std::size_t middle = middle_of(parent, level);
            children[chosen] = {parent.begin, middle};
            children[count] = {middle, parent.end};
            for (const int i : {chosen, count}) size[i] = size_of(children[i], level);
            ++count;
        }
        return count;
    }

  private:
    // What is split first: the largest cell, of equal ones the fullest; 0 for what is a leaf.
    std::uint64_t size_of(const group& g, std::uint32_t level) const {
        if (g.size() <= Width) return 0;
        const std::uint64_t differing = order_.cell(g.begin) ^ order_.cell(g.end - 1);
        const auto cell = level < free_levels ? static_cast<std::uint64_t>(std::bit_width(differing)) : 0;
        return cell << 32U | g.size();
    }

    std::size_t middle_of(const group& g, std::uint32_t level) const {
        const std::uint64_t differing = order_.cell(g.begin) ^ order_.cell(g.end - 1);
        std::size_t middle = g.begin + g.size() / 2;
        if (differing != 0 && level < free_levels) { // the first place of the upper half of the cell
            const auto shift = static_cast<unsigned>(std::bit_width(differing)) - 1;
            const std::uint64_t upper = order_.cell(g.end - 1) >> shift;
            std::size_t low = g.begin, high = g.end - 1;
            while (low + 1 < high) {
                middle = (low + high) / 2;
                (order_.cell(middle) >> shift < upper ? low : high) = middle;
            }
            middle = high;
        }
        if (g.size() > 3 * Width) return middle;
        const std::size_t full = (middle - g.begin + Width / 2) / Width * Width;
        return g.begin + std::clamp<std::size_t>(full, Width, (g.size() - 1) / Width * Width);
    }

    morton_order order_;
};

template <int Width, exec::policy Policy, class Range>
topology<Width> build_morton::operator()(const Policy& policy, const Range& range) const {
    morton_splitter<Width> splitter{policy, range};
    return tree_assembler<Width, morton_splitter<Width>>{splitter}.assemble(policy, splitter.all());
}

} // namespace insonify::inline INSONIFY_ABI
#endif
