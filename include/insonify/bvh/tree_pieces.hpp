#ifndef INSONIFY_BVH_TREE_PIECES_HPP
#define INSONIFY_BVH_TREE_PIECES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/node.hpp>
#include <insonify/execution/for_each.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// A part of a tree: nodes and leaves with local indices.
template <int Width>
struct tree_piece {
    std::vector<std::array<std::uint32_t, Width>> nodes{}; ///< child references
    std::vector<std::uint32_t> slots{};                    ///< primitives of the leaves
    std::uint32_t levels = 0;
};

/// The child reference of the top that leads to a piece.
struct piece_place {
    std::uint32_t parent = 0; ///< node of the top
    std::uint32_t child = 0;
};

/// The order of the pieces by size, the largest first, for load balance.
inline std::vector<std::size_t> largest_first(const std::vector<std::size_t>& sizes) {
    std::vector<std::size_t> order(sizes.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [&sizes](std::size_t a, std::size_t b) { return sizes[a] != sizes[b] ? sizes[a] > sizes[b] : a < b; });
    return order;
}

/// Concatenates the top and the pieces, and links node 0 of each piece to its parent.
/// @param places  one for each piece
template <int Width, class Policy>
topology<Width> join_pieces(const Policy& policy, tree_piece<Width>& top, const std::vector<tree_piece<Width>>& pieces,
                            const std::vector<piece_place>& places) {
    topology<Width> tree;
    tree.levels = top.levels;
    auto nodes = static_cast<std::uint32_t>(top.nodes.size());
    auto leaves = static_cast<std::uint32_t>(top.slots.size() / Width);
    tree.parts.resize(pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        if (!top.nodes.empty()) top.nodes[places[i].parent][places[i].child] = nodes;
        tree.parts[i] = {nodes, nodes + static_cast<std::uint32_t>(pieces[i].nodes.size()), leaves,
                         leaves + static_cast<std::uint32_t>(pieces[i].slots.size() / Width)};
        tree.levels = std::max(tree.levels, pieces[i].levels);
        nodes = tree.parts[i].end;
        leaves = tree.parts[i].leaf_end;
    }
    tree.nodes.resize(nodes);
    tree.slots.resize(std::size_t{leaves} * Width);
    const auto put = [&tree](const tree_piece<Width>& from, std::uint32_t first_node, std::uint32_t first_leaf) {
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

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
