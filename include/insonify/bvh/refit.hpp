#ifndef INSONIFY_BVH_REFIT_HPP
#define INSONIFY_BVH_REFIT_HPP

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/execution/for_each.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What follows the primitives when they move: the bounds of nodes and the contents of leaves.
template <primitive_range Range, int Width>
struct tree_shape {
    std::vector<node_bounds<Width>> bounds_of{};
    std::vector<leaf<Range, Width>> leaves{};
    std::vector<aabb> leaf_boxes{};
    double cost = 0; ///< expected nodes and leaves that a random ray visits: areas of all boxes over that of the whole
};

/// Moves every bound to fit the primitives' present positions; the tree's topology stays.
///
/// Cost: one pass over leaves and nodes, bottom up; allocates only when the topology is new.
/// @param range  same count and order as when the tree was built
/// Source: Wald, Boulos & Shirley 2007, section 3.
template <exec::policy Policy, primitive_range Range, int Width>
void refit(const Policy& policy, const topology<Width>& tree, const Range& range, tree_shape<Range, Width>& shape) {
    shape.bounds_of.resize(tree.nodes.size());
    shape.leaves.resize(tree.leaves());
    shape.leaf_boxes.resize(tree.leaves());
    exec::for_each_block(policy, tree.leaves(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            shape.leaf_boxes[i] = shape.leaves[i].fill(range, tree.slots.data() + i * Width);
    });
    double area = 0;
    aabb whole;
    for (std::size_t node = tree.nodes.size(); node-- > 0;) { // children come after their parent
        whole = {};
        for (int i = 0; i < Width; ++i) {
            const std::uint32_t child = tree.nodes[node].child[i];
            aabb box;
            if (child != no_child)
                box = (child & leaf_bit) != 0 ? shape.leaf_boxes[child ^ leaf_bit] : shape.bounds_of[child].all();
            shape.bounds_of[node].set_box(i, box);
            whole = merged(whole, box);
            area += static_cast<double>(box.half_area());
        }
    }
    const auto root_area = static_cast<double>(whole.half_area());
    shape.cost = root_area > 0 ? area / root_area : 0;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
