#ifndef INSONIFY_BVH_ASSEMBLE_HPP
#define INSONIFY_BVH_ASSEMBLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/node.hpp>
#include <insonify/execution/policy.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
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
        piece top{.all = all};
        std::vector<piece> pieces;
        if (all.size() <= small_)
            pieces.push_back(top);
        else
            add_node(policy, top, all, 1, &pieces);
        for_each_index(policy, pieces.size(), [&](std::size_t i) {
            piece& one = pieces[i];
            add_node(any_policy<false>{exec::seq}, one, one.all, one.level, nullptr);
        });
        return joined(policy, top, pieces);
    }

  private:
    // A part of a tree: nodes and leaves with local indices.
    struct piece {
        group all{};                                           // what it holds
        std::uint32_t level = 1;                               // of its root
        std::uint32_t parent = 0, place = 0;                   // the node of the top and the child that leads to it
        std::uint32_t levels = 0;                              // nodes on the longest path from the root of the tree
        std::vector<std::array<std::uint32_t, Width>> nodes{}; // child references
        std::vector<std::uint32_t> slots{};                    // primitives of the leaves
    };

    // Concatenates the top and the pieces, and links node 0 of each piece to its parent.
    template <class Policy>
    static topology<Width> joined(const Policy& policy, piece& top, const std::vector<piece>& pieces) {
        topology<Width> tree;
        tree.levels = top.levels;
        auto nodes = static_cast<std::uint32_t>(top.nodes.size());
        auto leaves = static_cast<std::uint32_t>(top.slots.size() / Width);
        tree.parts.resize(pieces.size());
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const piece& one = pieces[i];
            if (!top.nodes.empty()) top.nodes[one.parent][one.place] = nodes;
            tree.parts[i] = {nodes, nodes + static_cast<std::uint32_t>(one.nodes.size()), leaves,
                             leaves + static_cast<std::uint32_t>(one.slots.size() / Width)};
            tree.levels = std::max(tree.levels, one.levels);
            nodes = tree.parts[i].end;
            leaves = tree.parts[i].leaf_end;
        }
        tree.nodes.resize(nodes);
        tree.slots.resize(std::size_t{leaves} * Width);
        const auto put = [&tree](const piece& from, std::uint32_t first_node, std::uint32_t first_leaf) {
            std::copy(from.slots.begin(), from.slots.end(), tree.slots.data() + std::size_t{first_leaf} * Width);
            for (std::size_t n = 0; n < from.nodes.size(); ++n)
                for (std::size_t k = 0; k < Width; ++k) {
                    std::uint32_t child = from.nodes[n][k];
                    if (child != no_child) child += (child & leaf_bit) != 0 ? first_leaf : first_node;
                    tree.nodes[first_node + n].child[k] = child;
                }
        };
        put(top, 0, 0);
        for_each_index(policy, pieces.size(),
                       [&](std::size_t i) { put(pieces[i], tree.parts[i].begin, tree.parts[i].first_leaf); });
        return tree;
    }

    template <class Policy>
    std::uint32_t add_node(const Policy& policy, piece& tree, const group& all, std::uint32_t level,
                           std::vector<piece>* postponed) {
        const auto node = static_cast<std::uint32_t>(tree.nodes.size());
        tree.nodes.emplace_back();
        tree.levels = std::max(tree.levels, level);
        group children[Width];
        const std::uint32_t count = divide(policy, all, level, children);
        for (std::uint32_t i = 0; i < Width; ++i) {
            std::uint32_t code = no_child;
            if (i < count && children[i].size() <= Width) {
                const std::size_t slots = tree.slots.size();
                tree.slots.resize(slots + Width, no_primitive);
                splitter_.list(children[i], tree.slots.data() + slots);
                code = static_cast<std::uint32_t>(slots / Width) | leaf_bit;
            } else if (i < count && postponed != nullptr && children[i].size() <= small_)
                postponed->push_back({.all = children[i], .level = level + 1, .parent = node, .place = i});
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

    Splitter& splitter_;
    std::size_t small_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
