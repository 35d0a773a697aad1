#ifndef INSONIFY_BVH_STORAGE_HPP
#define INSONIFY_BVH_STORAGE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/build_morton.hpp>
#include <insonify/bvh/build_sah.hpp>
#include <insonify/bvh/traverse.hpp>
#include <algorithm>
#include <cfloat>
#include <new>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

/// Statistics of a BVH.
struct bvh_statistics {
    std::size_t primitives = 0; ///< in leaves: those with finite bounds
    std::size_t nodes = 0;      ///< with `Width` children each, empty ones included
    std::size_t leaves = 0;     ///< with at most `Width` primitives each
    std::uint32_t levels = 0;   ///< nodes on the longest path from the root
    double cost = 0;            ///< SAH cost: expected visits of nodes and leaves by a random ray that enters the root
    std::size_t bytes = 0;      ///< of all arrays: about 64 per triangle, and 85 during a build
};

/// What `bvh::update` did.
enum class bvh_update {
    refit,        ///< new boxes, same topology
    rebuild,      ///< by the tree's own builder
    quick_rebuild ///< by `build_morton`
};

namespace detail {

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

/// Recomputes all boxes in one pass over leaves and nodes, bottom up; the topology stays. Allocates only after a build.
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

/// The arrays of a BVH without its range of primitives, for owners whose range moves in memory.
template <primitive_range Range, int Width = simd_width, class Builder = build_sah>
class bvh_storage {
  public:
    /// @throws usage_error  for more than 2^31 - 1 primitives
    template <exec::policy Policy>
    void build(const Policy& policy, const Range& range) {
        build_by(Builder{}, policy, range);
    }

    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    void refit(const Policy& policy, const Range& range) {
        if (range.size() != count_)
            throw geometry_error{"bvh: refit needs as many primitives as the tree was built over; call rebuild"};
        detail::refit(policy, tree_, range, shape_);
        ++refits_;
    }

    /// Refits, and rebuilds once the SAH cost has grown by half since the build: by `build_morton` if the tree lasted
    /// fewer than 16 updates.
    ///
    /// A rebuild by `build_sah` takes as long as 14 to 22 refits, by `build_morton` as 3 to 7, and trees of the latter
    /// cost rays about 1.15 times as much (bench/bvh.cpp). If memory for a rebuild is not available, the refitted tree
    /// stays.
    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    bvh_update update(const Policy& policy, const Range& range) {
        refit(policy, range);
        if (degradation() <= 1.5) return bvh_update::refit;
        const bool soon = refits_ < 16;
        try {
            if (soon)
                build_by(build_morton{}, policy, range);
            else
                build(policy, range);
        } catch (const std::bad_alloc&) {
            return bvh_update::refit;
        }
        return soon ? bvh_update::quick_rebuild : bvh_update::rebuild;
    }

    /// The SAH cost relative to that at the last build: 1 after a build.
    double degradation() const {
        if (cost_as_built_ > 0) return shape_.cost / cost_as_built_;
        return shape_.cost > 0 ? DBL_MAX : 1; // built without an area: nothing was finite, or all in one place
    }

    /// Valid until the next build, refit or update.
    bvh_view<Range, Width> view_of(const Range& range) const {
        return {tree_.nodes, shape_.leaves, range, shape_.max_abs_coordinate, shape_.leaf_size, shape_.box};
    }

    /// The box around all primitives; empty for none.
    aabb box() const { return shape_.box; }

    /// Recomputed by every call.
    bvh_statistics statistics() const {
        std::size_t empty = 0;
        for (const auto& one : shape_.leaves)
            empty += static_cast<std::size_t>(std::count(one.primitive, one.primitive + Width, no_primitive));
        return {.primitives = tree_.slots.size() - empty,
                .nodes = tree_.nodes.size(),
                .leaves = tree_.leaves(),
                .levels = tree_.levels,
                .cost = shape_.cost,
                .bytes = tree_.nodes.size() * (sizeof(tree_node<Width>) + sizeof(aabb)) +
                         tree_.leaves() * (sizeof(leaf<Range, Width>) + sizeof(aabb)) +
                         tree_.slots.size() * sizeof(std::uint32_t)};
    }

  private:
    template <class Any, class Policy>
    void build_by(const Any& builder, const Policy& policy, const Range& range) {
        if (range.size() >= leaf_bit) throw usage_error{"bvh: more than 2147483647 primitives in one tree; split them"};
        topology<Width> made = builder.template operator()<Width>(policy, range);
        shape_.reserve(made); // the last call that may throw: strong exception guarantee
        tree_ = std::move(made);
        detail::refit(policy, tree_, range, shape_);
        cost_as_built_ = shape_.cost;
        count_ = range.size();
        refits_ = 0;
    }

    topology<Width> tree_{};
    tree_shape<Range, Width> shape_{};
    double cost_as_built_ = 0;
    std::size_t count_ = 0;
    std::uint32_t refits_ = 0; ///< since it was built
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
