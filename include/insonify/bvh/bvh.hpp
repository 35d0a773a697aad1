#ifndef INSONIFY_BVH_BVH_HPP
#define INSONIFY_BVH_BVH_HPP

#include <insonify/bvh/batch.hpp>
#include <insonify/bvh/storage.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/geometry/mesh.hpp>
#include <span>

namespace insonify::inline INSONIFY_ABI {

/// A bounding volume hierarchy over primitives that the caller owns and keeps alive.
///
///     bvh tree{exec::par, spheres};          // any contiguous container of a type with `bounds` and `intersect`
///     bvh tree{exec::par, some_mesh};        // triangles, watertight
///
/// Empty, single and identical primitives are legal. Queries are const and may run on many threads at once.
/// @tparam Width    children of a node and primitives of a leaf; as wide as a SIMD register, 4 to 8
/// @tparam Builder  makes the topology: `build_sah`, or `build_morton`, which is faster to build and slower to trace
template <primitive_range Range, int Width = simd_width, class Builder = build_sah>
class bvh {
  public:
    /// @throws geometry_error  where a face of a mesh names a vertex that is not there; here and in `rebuild`
    template <exec::policy Policy>
    bvh(const Policy& policy, const Range& range) : range_{range} {
        rebuild(policy);
    }
    /// Over the triangles of a mesh.
    template <exec::policy Policy>
    bvh(const Policy& policy, const mesh& triangles) requires std::same_as<Range, mesh_view>
        : bvh(policy, mesh_view{triangles}) {}
    template <exec::policy Policy>
    bvh(const Policy& policy, const mesh&& triangles) = delete; // the tree refers to the mesh: keep it in a variable
    /// Over what a span names.
    template <exec::policy Policy, class T>
    bvh(const Policy& policy, std::span<T> primitives) requires std::same_as<Range, view<const T>>
        : bvh(policy, Range{primitives.data(), primitives.size()}) {}
    /// Over any contiguous container.
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
        auto& found = later<Range>(hits);
        found.clear();
        view_of().for_each_hit(r, [&](const hit& one) { found.push_back(one); });
        std::sort(found.begin(), found.end(), nearer);
    }

    /// One nearest hit for each ray: the same as each gets alone.
    ///
    /// Neighbours in the span that go together are asked together (see `ray_packet::prepare`), so keep the lines of a
    /// fan and the pixels of a row side by side. @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void closest(const Policy& policy, later_t<Policy, std::span<const ray>> rays,
                 later_t<Policy, std::span<hit>> hits) const {
        check_sizes(rays.size(), hits.size());
        ask(policy, view_of(), rays, closest_query{hits.data()});
    }

    /// 1 for each ray that hits something, 0 for the others. @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void any(const Policy& policy, later_t<Policy, std::span<const ray>> rays,
             later_t<Policy, std::span<std::uint8_t>> met) const {
        check_sizes(rays.size(), met.size());
        ask(policy, view_of(), rays, any_query{met.data()});
    }

    /// Every hit of each ray, nearest first. Replaces what `hits` held, and allocates where that is not enough.
    /// @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void all(const Policy& policy, later_t<Policy, std::span<const ray>> rays,
             later_t<Policy, std::span<std::vector<hit>>> hits) const {
        check_sizes(rays.size(), hits.size());
        ask(policy, view_of(), rays, all_query{hits.data()});
    }

    /// The primitives whose bounds overlap a box or a plane, in ascending order. Replaces what `primitives` held.
    template <class Shape>
    void overlapping(const Shape& shape, std::vector<std::uint32_t>& primitives) const {
        auto& found = later<Range>(primitives);
        found.clear();
        view_of().for_each_overlap(shape, [&](std::uint32_t p) { found.push_back(p); });
        std::sort(found.begin(), found.end());
    }

    /// Follows primitives that moved; the topology stays.
    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    void refit(const Policy& policy) {
        storage_.refit(policy, range_);
    }

    /// Follows primitives that moved, by whichever of three ways pays: see `bvh_storage::update`.
    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    way_of_update update(const Policy& policy) {
        return storage_.update(policy, range_);
    }

    /// Builds anew over the primitives as they are now.
    template <exec::policy Policy>
    void rebuild(const Policy& policy) {
        if constexpr (std::same_as<Range, mesh_view>) check_faces(range_, "bvh: ");
        storage_.build(policy, range_);
    }

    /// How much dearer a random ray has become since the tree was built: 1 as built.
    double degradation() const { return storage_.degradation(); }
    /// Nodes, leaves, levels, bytes.
    bvh_statistics statistics() const { return storage_.statistics(); }
    /// The box around all primitives; empty for none.
    aabb box() const { return storage_.box(); }
    /// A trivially copyable handle that queries are asked of; good until the next rebuild, refit or update.
    bvh_view<Range, Width> view_of() const { return storage_.view_of(range_); }

  private:
    static void check_sizes(std::size_t rays, std::size_t results) {
        if (rays != results) throw usage_error{"bvh: as many results as rays are needed"};
    }

    Range range_{};
    bvh_storage<Range, Width, Builder> storage_{};
};

/// What `bvh tree{policy, primitives}` finds out by itself.
/// @{
template <class Policy>
bvh(const Policy&, const mesh&) -> bvh<mesh_view>;
template <class Policy, class T>
bvh(const Policy&, std::span<T>) -> bvh<view<const std::remove_const_t<T>>>;
template <class Policy, class Container>
    requires requires(const Container& c) { std::data(c); }
bvh(const Policy&, const Container&)
    ->bvh<view<const std::remove_cvref_t<decltype(*std::data(std::declval<const Container&>()))>>>;
/// @}

} // namespace insonify::inline INSONIFY_ABI
#endif
