#ifndef INSONIFY_BVH_REFIT_HPP
#define INSONIFY_BVH_REFIT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/execution/for_each.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// The data that a refit updates, beside the boxes in the nodes.
template <primitive_range Range, int Width>
struct tree_shape {
    large_array<leaf<Range, Width>> leaves{};
    large_array<aabb> boxes{};    ///< of each node, then of each leaf
    aabb box{};                   ///< around all
    float max_abs_coordinate = 0; ///< of all boxes
    float leaf_size = 0;          ///< metres: the edge of a square of the mean half area of leaves
    double cost = 0;              ///< SAH cost: expected visits of a random ray below the root, areas over the root's

    /// Allocates what `refit` needs.
    void reserve(const topology<Width>& tree) {
        leaves.reserve(tree.leaves());
        boxes.reserve(tree.nodes.size() + tree.leaves());
    }
};

/// Prefetches the faces of a leaf ahead, and the corners of a nearer one whose faces have arrived: in large meshes,
/// leaves access both at random.
template <primitive_range Range, int Width>
INSONIFY_INLINE void prefetch_leaves(const topology<Width>& tree, std::uint32_t leaf, std::uint32_t leaf_end,
                                     const Range& range) {
    if constexpr (requires { range.prefetch_face(0), range.prefetch_corners(0); }) {
        constexpr std::size_t to_faces = 8, to_corners = 4; // leaves
        if (range.size() < prefetch_threshold) return;
        const std::uint32_t* const slots = tree.slots.data() + std::size_t{leaf} * Width;
        if (leaf_end - leaf > to_faces)
            for (const std::uint32_t *slot = slots + to_faces * Width, *end = slot + Width; slot != end; ++slot)
                if (*slot != no_primitive) range.prefetch_face(*slot);
        if (leaf_end - leaf > to_corners)
            for (const std::uint32_t *slot = slots + to_corners * Width, *end = slot + Width; slot != end; ++slot)
                if (*slot != no_primitive) range.prefetch_corners(*slot);
    }
}

/// Refits the leaves of a part, then its nodes from the last to the first, so that children precede their parent.
/// @return the sums of half areas
template <primitive_range Range, int Width>
box_areas refit_part(topology<Width>& tree, const typename topology<Width>::part& part, const Range& range,
                     tree_shape<Range, Width>& shape) {
    aabb* const of_nodes = shape.boxes.data();
    aabb* const of_leaves = of_nodes + tree.nodes.size();
    box_areas area;
    for (std::uint32_t i = part.first_leaf; i < part.leaf_end; ++i) {
        prefetch_leaves(tree, i, part.leaf_end, range);
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

/// Recomputes all boxes from the current positions of the primitives; the topology stays.
///
/// One pass over leaves and nodes, bottom up. Allocates only after a build.
/// @param range  same count and order as when the tree was built
/// Source: Wald, Boulos & Shirley 2007, section 3.
template <exec::policy Policy, primitive_range Range, int Width>
void refit(const Policy& policy, topology<Width>& tree, const Range& range, tree_shape<Range, Width>& shape) {
    shape.leaves.resize(tree.leaves());
    shape.boxes.resize(tree.nodes.size() + tree.leaves());
    shape.box = {};
    shape.max_abs_coordinate = shape.leaf_size = 0;
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
    const vec3 farthest = max(abs(shape.box.lower), abs(shape.box.upper));
    shape.max_abs_coordinate = max(farthest.x, max(farthest.y, farthest.z));
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
