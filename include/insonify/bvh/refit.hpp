#ifndef INSONIFY_BVH_REFIT_HPP
#define INSONIFY_BVH_REFIT_HPP

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/execution/for_each.hpp>

namespace insonify::inline INSONIFY_ABI {

/// What follows the primitives when they move, beside the boxes in the nodes.
template <primitive_range Range, int Width>
struct tree_shape {
    large_array<leaf<Range, Width>> leaves{};
    large_array<aabb> boxes{}; ///< of each node, then of each leaf
    aabb box{};                ///< around all
    float reach = 0;           ///< no coordinate of a box is further from 0
    float leaf_size = 0;       ///< metres: the mean of leaves, as squares
    double cost = 0; ///< expected nodes and leaves below the root that a random ray visits: their areas over the root's

    /// So that `refit` allocates nothing.
    void make_room(const topology<Width>& tree) {
        leaves.reserve(tree.leaves());
        boxes.reserve(tree.nodes.size() + tree.leaves());
    }
};

/// Of a large mesh, whose faces lie anywhere: asks for the faces of a leaf further on, and for the corners of those that are
/// there by now.
template <primitive_range Range, int Width>
INSONIFY_INLINE void look_ahead(const topology<Width>& tree, std::uint32_t leaf, std::uint32_t leaf_end,
                                const Range& range) {
    if constexpr (requires { range.prefetch_face(0), range.prefetch_corners(0); }) {
        constexpr std::size_t to_faces = 8, to_corners = 4; // leaves
        if (range.size() < most_at_hand) return;
        const std::uint32_t* const slots = tree.slots.data() + std::size_t{leaf} * Width;
        if (leaf_end - leaf > to_faces)
            for (const std::uint32_t *slot = slots + to_faces * Width, *end = slot + Width; slot != end; ++slot)
                if (*slot != no_primitive) range.prefetch_face(*slot);
        if (leaf_end - leaf > to_corners)
            for (const std::uint32_t *slot = slots + to_corners * Width, *end = slot + Width; slot != end; ++slot)
                if (*slot != no_primitive) range.prefetch_corners(*slot);
    }
}

/// Fits the leaves of a part to their primitives, one after the other, and then the boxes in its nodes to their children,
/// which are leaves, among them, or fitted already. @return the areas of the boxes around each
template <primitive_range Range, int Width>
box_areas refit_part(topology<Width>& tree, const typename topology<Width>::part& part, const Range& range,
                     tree_shape<Range, Width>& shape) {
    aabb* const of_nodes = shape.boxes.data();
    aabb* const of_leaves = of_nodes + tree.nodes.size();
    box_areas area;
    for (std::uint32_t i = part.first_leaf; i < part.leaf_end; ++i) {
        look_ahead(tree, i, part.leaf_end, range);
        of_leaves[i] = shape.leaves[i].fill(range, tree.slots.data() + std::size_t{i} * Width);
        area.leaves += static_cast<double>(of_leaves[i].half_area());
    }
    const aabb none;
    for (std::uint32_t i = part.end; i-- > part.begin;) { // children come after their parent
        tree_node<Width>& node = tree.nodes[i];
        aabb all;
        for (int k = 0; k < Width; ++k) {
            const std::uint32_t child = node.child[k];
            const aabb* const boxes = (child & leaf_bit) != 0 ? of_leaves : of_nodes;
            const aabb box = child != no_child ? boxes[child & ~leaf_bit] : none;
            node.set_box(k, box);
            all = merged(all, box);
        }
        of_nodes[i] = all;
        area.nodes += static_cast<double>(all.half_area());
    }
    return area;
}

/// Moves every box to fit the primitives' present positions; who is whose child stays.
///
/// Cost: one pass over leaves and nodes, bottom up; allocates only when the tree is new.
/// @param range  same count and order as when the tree was built
/// Source: Wald, Boulos & Shirley 2007, section 3.
template <exec::policy Policy, primitive_range Range, int Width>
void refit(const Policy& policy, topology<Width>& tree, const Range& range, tree_shape<Range, Width>& shape) {
    shape.leaves.resize(tree.leaves());
    shape.boxes.resize(tree.nodes.size() + tree.leaves());
    shape.box = {};
    shape.reach = shape.leaf_size = 0;
    shape.cost = 0;
    if (tree.nodes.empty()) return;
    for_each_index(policy, tree.parts.size(),
                   [&](std::size_t i) { tree.parts[i].areas = refit_part(tree, tree.parts[i], range, shape); });
    const auto& first = tree.parts[0];
    box_areas area = refit_part(tree, {0, first.begin, 0, first.first_leaf}, range, shape);
    for (const auto& part : tree.parts) {
        area.nodes += part.areas.nodes;
        area.leaves += part.areas.leaves;
    }
    shape.box = shape.boxes[0];
    const float root_area = shape.box.half_area();
    const bool measured = root_area > 0 && is_finite(root_area);
    shape.cost = measured ? (area.nodes + area.leaves) / static_cast<double>(root_area) - 1 : 0; // 1: the root's own
    shape.leaf_size = static_cast<float>(std::sqrt(area.leaves / static_cast<double>(tree.leaves())));
    if (shape.box.empty()) return;
    const vec3 farthest = greater(absolute(shape.box.lower), absolute(shape.box.upper));
    shape.reach = greater(farthest.x, greater(farthest.y, farthest.z));
}

} // namespace insonify::inline INSONIFY_ABI
#endif
