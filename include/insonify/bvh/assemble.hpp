#ifndef INSONIFY_BVH_ASSEMBLE_HPP
#define INSONIFY_BVH_ASSEMBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/tree_pieces.hpp>
#include <insonify/execution/any_policy.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Builds a wide BVH by repeated binary splits.
///
///     [      all      ]  ->  [   a   |   b   ]  ->  [   a   | b1 | b2 ]  ->  ...  Width children of a node
///
/// The next child to split is the heaviest of those that need more than one node; then one whose leaves all fit into
/// this node, which saves a node. So nodes are full where that is free.
///
///     1  [ large groups, one after the other, each split by all threads ]   the top
///     2  [ small | small | small | small | ... ]                            one part each, in parallel
///
/// The partition of the work depends only on the number of primitives, so the tree does not depend on the policy.
/// @tparam Splitter  `group` with `size()`; `split(policy, group, level, below, above)` into two that are not empty;
///                   `weight(group, level)` above 0; `list(group, slots)` writes the primitives
template <int Width, class Splitter>
class tree_assembler {
  public:
    using group = typename Splitter::group;

    explicit tree_assembler(Splitter& splitter) : splitter_{splitter} {}

    template <class Policy>
    topology<Width> assemble(const Policy& policy, const group& all) {
        if (all.size() == 0) return {};
        small_ = std::max<std::size_t>(all.size() / 64, 8192);
        piece top;
        std::vector<subtree> postponed;
        if (all.size() <= small_)
            postponed.push_back({all, 1, {}});
        else
            add_node(policy, top, all, 1, &postponed);
        std::vector<piece> pieces(postponed.size());
        std::vector<piece_place> places;
        std::vector<std::size_t> sizes;
        for (const subtree& one : postponed) {
            places.push_back(one.place);
            sizes.push_back(one.all.size());
        }
        const std::vector<std::size_t> order = largest_first(sizes);
        for_each_index(policy, postponed.size(), [&](std::size_t i) {
            const subtree& from = postponed[order[i]];
            piece& made = pieces[order[i]];
            const std::size_t leaves = from.all.size() / Width;
            made.nodes.reserve(leaves / 4);
            made.slots.reserve((leaves + leaves / 4) * Width);
            add_node(any_policy<false>{exec::seq}, made, from.all, from.level, nullptr);
        });
        return join_pieces(policy, top, pieces, places);
    }

  private:
    using piece = tree_piece<Width>;

    // A postponed piece.
    struct subtree {
        group all{};
        std::uint32_t level = 0;
        piece_place place{};
    };

    template <class Policy>
    std::uint32_t add_node(const Policy& policy, piece& tree, const group& all, std::uint32_t level,
                           std::vector<subtree>* postponed) {
        const auto node = static_cast<std::uint32_t>(tree.nodes.size());
        tree.nodes.emplace_back();
        tree.levels = std::max(tree.levels, level);
        group children[Width];
        const std::uint32_t count = divide(policy, all, level, children);
        for (std::uint32_t i = 0; i < Width; ++i) {
            std::uint32_t code = no_child;
            if (i < count && children[i].size() <= Width)
                code = add_leaf(tree, children[i]);
            else if (i < count && postponed != nullptr && children[i].size() <= small_)
                postponed->push_back({children[i], level + 1, {node, i}});
            else if (i < count)
                code = add_node(policy, tree, children[i], level + 1, postponed);
            tree.nodes[node][i] = code;
        }
        return node;
    }

    // Splits until the node is full. @return the number of children
    template <class Policy>
    std::uint32_t divide(const Policy& policy, const group& all, std::uint32_t level, group (&children)[Width]) {
        using weight = decltype(splitter_.weight(all, level));
        children[0] = all;
        weight weights[Width] = {};
        std::uint32_t count = 1;
        for (std::uint32_t chosen = 0; count < Width; ++count) {
            int best = 0;
            for (std::uint32_t i = 0; i < count; ++i) {
                const std::size_t size = children[i].size();
                if (size <= Width) continue;
                const bool fits = (size - 1) / Width <= Width - count;
                const int rank = size > std::size_t{Width} * Width ? 3 : fits ? 2 : 1;
                if (rank < best || (rank == best && !(weights[chosen] < weights[i]))) continue;
                best = rank;
                chosen = i;
            }
            if (best == 0) break;
            const group parent = children[chosen];
            splitter_.split(policy, parent, level, children[chosen], children[count]);
            weights[chosen] = splitter_.weight(children[chosen], level);
            weights[count] = splitter_.weight(children[count], level);
        }
        return count;
    }

    std::uint32_t add_leaf(piece& tree, const group& held) {
        const std::size_t begin = tree.slots.size();
        tree.slots.resize(begin + Width, no_primitive);
        splitter_.list(held, tree.slots.data() + begin);
        return static_cast<std::uint32_t>(begin / Width) | leaf_bit;
    }

    Splitter& splitter_;
    std::size_t small_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
