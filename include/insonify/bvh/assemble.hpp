#ifndef INSONIFY_BVH_ASSEMBLE_HPP
#define INSONIFY_BVH_ASSEMBLE_HPP

#include <insonify/bvh/node.hpp>
#include <insonify/execution/for_each.hpp>
#include <algorithm>

namespace insonify::inline INSONIFY_ABI {

/// Makes a tree from a way to divide a group of primitives among the children of a node.
///
///     1  [ large groups, one after the other, each by all threads ]         the top
///     2  [ small | small | small | small | ... ]                            a part each, all at once
///
/// How the work is cut depends on the number of primitives alone, so the tree does not depend on the policy.
/// @tparam Splitter  has a `group` with `size()`; `divide(policy, group, level, children)` that fills up to Width
///                   children, none of them empty, and returns how many; `list(group, slots)` that writes its primitives
template <int Width, class Splitter>
class tree_assembler {
  public:
    using group = typename Splitter::group;

    explicit tree_assembler(Splitter& splitter) : splitter_{splitter} {}

    template <class Policy>
    topology<Width> assemble(const Policy& policy, const group& all) {
        topology<Width> tree;
        if (all.size() == 0) return tree;
        small_ = std::max<std::size_t>(all.size() / 64, 4096);
        if (all.size() <= small_) {
            add_node(exec::seq, tree, all, 1, nullptr);
            tree.parts = {{0, static_cast<std::uint32_t>(tree.nodes.size())}};
            return tree;
        }
        std::vector<subtree> later;
        add_node(policy, tree, all, 1, &later);
        std::vector<topology<Width>> parts(later.size());
        for_each_index(policy, later.size(), [&](std::size_t i) {
            const std::size_t leaves = later[i].all.size() / Width;
            parts[i].nodes.reserve(leaves / 2);
            parts[i].slots.reserve((leaves + leaves / 4) * Width);
            add_node(exec::seq, parts[i], later[i].all, later[i].level, nullptr);
        });
        join(policy, tree, parts, later);
        return tree;
    }

  private:
    // A part of the tree that is built by itself, and where it will hang.
    struct subtree {
        group all{};
        std::uint32_t level = 0;
        std::uint32_t parent = 0;
        std::uint32_t place = 0;
    };

    template <class Policy>
    std::uint32_t add_node(const Policy& policy, topology<Width>& tree, const group& all, std::uint32_t level,
                           std::vector<subtree>* later) {
        const auto node = static_cast<std::uint32_t>(tree.nodes.size());
        tree.nodes.emplace_back();
        tree.levels = std::max(tree.levels, level);
        group children[Width];
        const int count = splitter_.divide(policy, all, level, children);
        for (int i = 0; i < Width; ++i) {
            std::uint32_t code = no_child;
            if (i < count && children[i].size() <= Width)
                code = add_leaf(tree, children[i]);
            else if (i < count && later != nullptr && children[i].size() <= small_)
                later->push_back({children[i], level + 1, node, static_cast<std::uint32_t>(i)});
            else if (i < count)
                code = add_node(policy, tree, children[i], level + 1, later);
            tree.nodes[node].child[i] = code;
        }
        return node;
    }

    std::uint32_t add_leaf(topology<Width>& tree, const group& held) {
        const auto index = static_cast<std::uint32_t>(tree.leaves());
        tree.slots.resize(tree.slots.size() + Width, no_primitive);
        splitter_.list(held, tree.slots.data() + std::size_t{index} * Width);
        return index | leaf_bit;
    }

    // Hangs the parts under their parents; node 0 of a part takes the next free index.
    template <class Policy>
    static void join(const Policy& policy, topology<Width>& tree, const std::vector<topology<Width>>& parts,
                     const std::vector<subtree>& where) {
        std::vector<std::uint32_t> first_leaf(parts.size());
        auto nodes = static_cast<std::uint32_t>(tree.nodes.size());
        auto leaves = static_cast<std::uint32_t>(tree.leaves());
        for (std::size_t i = 0; i < parts.size(); ++i) {
            tree.nodes[where[i].parent].child[where[i].place] = nodes;
            first_leaf[i] = leaves;
            tree.parts.push_back({nodes, nodes + static_cast<std::uint32_t>(parts[i].nodes.size())});
            tree.levels = std::max(tree.levels, parts[i].levels);
            nodes = tree.parts.back().end;
            leaves += static_cast<std::uint32_t>(parts[i].leaves());
        }
        tree.nodes.resize(nodes);
        tree.slots.resize(std::size_t{leaves} * Width);
        for_each_index(policy, parts.size(), [&](std::size_t i) {
            std::copy(parts[i].slots.begin(), parts[i].slots.end(),
                      tree.slots.begin() + static_cast<std::ptrdiff_t>(std::size_t{first_leaf[i]} * Width));
            const std::uint32_t first_node = tree.parts[i].begin;
            for (std::size_t n = 0; n < parts[i].nodes.size(); ++n)
                for (int k = 0; k < Width; ++k) {
                    std::uint32_t child = parts[i].nodes[n].child[k];
                    if (child != no_child) child += (child & leaf_bit) != 0 ? first_leaf[i] : first_node;
                    tree.nodes[first_node + n].child[k] = child;
                }
        });
    }

    Splitter& splitter_;
    std::size_t small_ = 0;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
