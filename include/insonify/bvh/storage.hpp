#ifndef INSONIFY_BVH_STORAGE_HPP
#define INSONIFY_BVH_STORAGE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/build_morton.hpp>
#include <insonify/bvh/build_sah.hpp>
#include <insonify/bvh/refit.hpp>
#include <insonify/bvh/traverse.hpp>
#include <insonify/core/error.hpp>
#include <algorithm>
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

    /// Refits, and rebuilds once the SAH cost has grown by half since the build: by `build_morton` if the tree lasted fewer
    /// than 16 updates.
    ///
    /// A rebuild by `build_sah` takes as long as 14 to 22 refits, by `build_morton` as 3 to 7, and trees of the latter cost
    /// rays about 1.15 times as much (bench/bvh.cpp). Spread over 16 updates, `build_sah` adds about one refit each.
    /// The choice depends on the positions only. Also rebuilds where a primitive that was left out has become finite. If
    /// memory for a rebuild is not available, the refitted tree stays.
    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    bvh_update update(const Policy& policy, const Range& range) {
        refit(policy, range);
        const bool lacks = lacks_usable(range);
        if (degradation() <= 1.5 && !lacks) return bvh_update::refit;
        const bool soon = refits_ < 16;
        try {
            if (soon)
                build_by(build_morton{}, policy, range);
            else
                build(policy, range);
        } catch (const std::bad_alloc&) {
            if (lacks) throw;
            return bvh_update::refit;
        }
        return soon ? bvh_update::quick_rebuild : bvh_update::rebuild;
    }

    /// The SAH cost relative to that at the last build: 1 after a build.
    double degradation() const { return cost_as_built_ > 0 ? shape_.cost / cost_as_built_ : 1; }

    /// Valid until the next build, refit or update.
    bvh_view<Range, Width> view_of(const Range& range) const {
        return {tree_.nodes, shape_.leaves, range, shape_.max_abs_coordinate, shape_.leaf_size, shape_.box};
    }

    /// The box around all primitives; empty for none.
    aabb box() const { return shape_.box; }

    /// Recomputed by every call.
    bvh_statistics statistics() const {
        return {.primitives = tree_.slots.size() - static_cast<std::size_t>(std::count(
                                                       tree_.slots.begin(), tree_.slots.end(), no_primitive)),
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
        std::vector<std::uint32_t> left_out = left_out_by(made, range.size());
        shape_.reserve(made); // the last call that may throw: strong exception guarantee
        tree_ = std::move(made);
        left_out_ = std::move(left_out);
        detail::refit(policy, tree_, range, shape_);
        cost_as_built_ = shape_.cost;
        count_ = range.size();
        refits_ = 0;
    }

    static std::vector<std::uint32_t> left_out_by(const topology<Width>& tree, std::size_t count) {
        std::vector<std::uint32_t> left_out;
        const auto empty = static_cast<std::size_t>(std::count(tree.slots.begin(), tree.slots.end(), no_primitive));
        if (tree.slots.size() - empty == count) return left_out;
        std::vector<std::uint8_t> held(count);
        for (const std::uint32_t slot : tree.slots)
            if (slot != no_primitive) held[slot] = 1;
        for (std::size_t i = 0; i < count; ++i)
            if (held[i] == 0) left_out.push_back(static_cast<std::uint32_t>(i));
        return left_out;
    }

    bool lacks_usable(const Range& range) const {
        return std::any_of(left_out_.begin(), left_out_.end(),
                           [&](std::uint32_t i) { return is_finite(bounds(range[i])); });
    }

    topology<Width> tree_{};
    tree_shape<Range, Width> shape_{};
    double cost_as_built_ = 0;
    std::size_t count_ = 0;
    std::uint32_t refits_ = 0;              ///< since it was built
    std::vector<std::uint32_t> left_out_{}; ///< primitives that were not finite when it was built
};

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
