#ifndef INSONIFY_BVH_BVH_HPP
#define INSONIFY_BVH_BVH_HPP

#include <insonify/bvh/build_sah.hpp>
#include <insonify/bvh/refit.hpp>
#include <insonify/bvh/traverse.hpp>
#include <insonify/core/error.hpp>
#include <insonify/geometry/mesh.hpp>
#include <span>

namespace insonify::inline INSONIFY_ABI {

/// Numbers about a tree.
struct bvh_statistics {
    std::size_t primitives = 0; ///< in leaves; those with bounds that are not finite are left out
    std::size_t nodes = 0;
    std::size_t leaves = 0;
    std::uint32_t levels = 0; ///< nodes on the longest way down
    double cost = 0;          ///< expected nodes and leaves visited by a random ray that meets the whole
    std::size_t bytes = 0;    ///< of all arrays
};

/// The owning arrays of a tree, without the primitives: what a caller that moves its primitives around keeps.
template <primitive_range Range, int Width = simd_width, class Builder = build_sah>
class bvh_storage {
  public:
    /// @throws usage_error  for more than 2^31 - 1 primitives
    template <exec::policy Policy>
    void build(const Policy& policy, const Range& range) {
        if (range.size() >= leaf_bit) throw usage_error{"bvh: more than 2147483647 primitives in one tree; split them"};
        std::vector<aabb> boxes(range.size());
        exec::for_each_block(policy, boxes.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) boxes[i] = bounds(range[i]);
        });
        tree_ = Builder{}.template operator()<Width>(policy, boxes);
        insonify::refit(policy, tree_, range, shape_);
        cost_as_built_ = shape_.cost;
        count_ = range.size();
    }

    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    void refit(const Policy& policy, const Range& range) {
        if (range.size() != count_)
            throw geometry_error{"bvh: refit needs as many primitives as the tree was built over; call rebuild"};
        insonify::refit(policy, tree_, range, shape_);
    }

    /// How much dearer a random ray has become since the tree was built: 1 as built; rebuild beyond about 1.5.
    double degradation() const { return cost_as_built_ > 0 ? shape_.cost / cost_as_built_ : 1; }

    bvh_view<Range, Width> view_of(const Range& range) const {
        return {tree_.nodes, shape_.bounds_of, shape_.leaves, tree_.slots, range};
    }

    /// The box around all primitives; empty for none.
    aabb box() const { return shape_.bounds_of.empty() ? aabb{} : shape_.bounds_of.front().all(); }

    bvh_statistics statistics() const {
        return {.primitives = tree_.slots.size() - static_cast<std::size_t>(std::count(
                                                       tree_.slots.begin(), tree_.slots.end(), no_primitive)),
                .nodes = tree_.nodes.size(),
                .leaves = tree_.leaves(),
                .levels = tree_.levels,
                .cost = shape_.cost,
                .bytes = tree_.nodes.size() * (sizeof(node_children<Width>) + sizeof(node_bounds<Width>)) +
                         tree_.slots.size() * sizeof(std::uint32_t) +
                         tree_.leaves() * (sizeof(leaf<Range, Width>) + sizeof(aabb))};
    }

  private:
    topology<Width> tree_{};
    tree_shape<Range, Width> shape_{};
    double cost_as_built_ = 0;
    std::size_t count_ = 0;
};

/// A bounding volume hierarchy over primitives that the caller owns and keeps alive.
///
///     bvh tree{exec::par, spheres};          // any contiguous container of a type with `bounds` and `intersect`
///     bvh tree{exec::par, some_mesh};        // triangles, watertight
///
/// Empty, single and identical primitives are legal. Queries are const and may run on many threads at once.
/// @tparam Width    children of a node and primitives of a leaf; as wide as a SIMD register, 4 to 8
/// @tparam Builder  makes the topology: `build_sah`
template <primitive_range Range, int Width = simd_width, class Builder = build_sah>
class bvh {
  public:
    /// @throws geometry_error  where a face of a mesh names a vertex that is not there; here and in `rebuild`
    template <exec::policy Policy>
    bvh(const Policy& policy, const Range& range) : range_{range} {
        rebuild(policy);
    }
    template <exec::policy Policy>
    bvh(const Policy& policy, const mesh& triangles) requires std::same_as<Range, mesh_view>
        : bvh(policy, mesh_view{triangles}) {}
    template <exec::policy Policy>
    bvh(const Policy& policy, const mesh&& triangles) = delete; // the tree refers to the mesh: keep it in a variable
    template <exec::policy Policy, class T>
    bvh(const Policy& policy, std::span<T> primitives) requires std::same_as<Range, view<const T>>
        : bvh(policy, Range{primitives.data(), primitives.size()}) {}
    template <exec::policy Policy, class Container>
    bvh(const Policy& policy, const Container& primitives) requires(!std::same_as<Container, Range> &&
                                                                    std::constructible_from<Range, const Container&>)
        : bvh(policy, Range{primitives}) {}
    template <exec::policy Policy, class T>
    bvh(const Policy& policy, const std::vector<T>&& primitives) = delete; // the tree refers to them: keep them

    /// The nearest hit within the ray's limits; of equally near ones the lowest primitive.
    hit closest(const ray& r) const { return view_of().closest(r); }

    /// Whether anything is hit within the ray's limits.
    bool any(const ray& r) const { return view_of().any(r); }

    /// Every hit within the ray's limits, nearest first, each primitive once. Replaces what `hits` held.
    void all(const ray& r, std::vector<hit>& hits) const {
        hits.clear();
        view_of().for_each_hit(r, [&](const hit& found) { hits.push_back(found); });
        std::sort(hits.begin(), hits.end(), nearer);
    }

    /// One nearest hit for each ray. @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void closest(const Policy& policy, std::span<const ray> rays, std::span<hit> hits) const {
        for_each_ray(policy, rays, hits.size(), [&](std::size_t i) { hits[i] = closest(rays[i]); });
    }

    /// 1 for each ray that hits something, 0 for the others. @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void any(const Policy& policy, std::span<const ray> rays, std::span<std::uint8_t> met) const {
        for_each_ray(policy, rays, met.size(), [&](std::size_t i) { met[i] = any(rays[i]) ? 1 : 0; });
    }

    /// The primitives whose bounds overlap a box or a plane, in ascending order. Replaces what `primitives` held.
    template <class Shape>
    void overlapping(const Shape& shape, std::vector<std::uint32_t>& primitives) const {
        primitives.clear();
        view_of().for_each_overlap(shape, [&](std::uint32_t p) { primitives.push_back(p); });
        std::sort(primitives.begin(), primitives.end());
    }

    /// Follows primitives that moved; the topology stays.
    template <exec::policy Policy>
    void refit(const Policy& policy) {
        storage_.refit(policy, range_);
    }

    /// Builds anew over the primitives as they are now.
    template <exec::policy Policy>
    void rebuild(const Policy& policy) {
        if constexpr (std::same_as<Range, mesh_view>) check_faces(range_, "bvh: ");
        storage_.build(policy, range_);
    }

    double degradation() const { return storage_.degradation(); }
    bvh_statistics statistics() const { return storage_.statistics(); }
    aabb box() const { return storage_.box(); }
    bvh_view<Range, Width> view_of() const { return storage_.view_of(range_); }

  private:
    template <class Policy, class Body>
    static void for_each_ray(const Policy& policy, std::span<const ray> rays, std::size_t results, const Body& body) {
        if (rays.size() != results) throw usage_error{"bvh: as many results as rays are needed"};
        exec::for_each_block(policy, rays.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(i);
        });
    }

    Range range_{};
    bvh_storage<Range, Width, Builder> storage_{};
};

template <class Policy>
bvh(const Policy&, const mesh&) -> bvh<mesh_view>;
template <class Policy, class T>
bvh(const Policy&, std::span<T>) -> bvh<view<const std::remove_const_t<T>>>;
template <class Policy, class Container>
    requires requires(const Container& c) { std::data(c); }
bvh(const Policy&, const Container&)
    ->bvh<view<const std::remove_cvref_t<decltype(*std::data(std::declval<const Container&>()))>>>;

} // namespace insonify::inline INSONIFY_ABI
#endif
