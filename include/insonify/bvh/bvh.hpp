#ifndef INSONIFY_BVH_BVH_HPP
#define INSONIFY_BVH_BVH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/batch.hpp>
#include <insonify/bvh/storage.hpp>
#include <algorithm>
#include <span>

namespace insonify::inline INSONIFY_ABI {

/// A bounding volume hierarchy over primitives that the caller owns and keeps alive.
///
///     bvh tree{exec::par, spheres};          // any contiguous container of a type with `bounds` and `intersect`
///     bvh tree{exec::par, some_mesh};        // triangles, watertight
///
/// Empty, single and identical primitives are legal. Queries are const and may run on many threads at once.
/// @tparam Width    children per node and primitives per leaf; the SIMD width, 4 to 8
/// @tparam Builder  `build_sah`, or `build_morton`, which builds faster and traces slower
template <primitive_range Range, int Width = simd_width, class Builder = build_sah>
class bvh {
  public:
    /// @throws geometry_error  here and in `rebuild`: a face of a mesh refers to a vertex that does not exist
    template <exec::policy Policy>
    bvh(const Policy& policy, const Range& range) : range_{range} {
        rebuild(policy);
    }
    /// Over the triangles of a mesh, or the elements of a contiguous container.
    template <exec::policy Policy, class Container>
    bvh(const Policy& policy, const Container& primitives) requires(!std::same_as<Container, Range> &&
                                                                    std::constructible_from<Range, const Container&>)
        : bvh(policy, Range{primitives}) {}
    template <exec::policy Policy>
    bvh(const Policy& policy, const mesh&& triangles) = delete; // the tree refers to the mesh: keep it in a variable
    template <exec::policy Policy, class T>
    bvh(const Policy& policy, const std::vector<T>&& primitives) = delete; // the same

    /// The closest hit within the ray's limits; ties go to the lowest primitive.
    hit closest(const ray& r) const { return view_of().closest(r); }

    /// Whether anything is hit within the ray's limits.
    bool any(const ray& r) const { return view_of().any(r); }

    /// Every hit within the ray's limits, nearest first, once per primitive. Replaces the contents of `hits`.
    void all(const ray& r, std::vector<hit>& hits) const {
        hits.clear();
        view_of().for_each_hit(r, [&](const hit& one) { hits.push_back(one); });
        std::sort(hits.begin(), hits.end(), nearer);
    }

    /// The closest hit of each ray, the same as from a call per ray.
    ///
    /// Coherent neighbours in the span are traced in packets, so keep the lines of a fan and the pixels of a row adjacent.
    /// @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void closest(const Policy& policy, std::span<const ray> rays, std::span<hit> hits) const {
        check_sizes(rays.size(), hits.size());
        detail::trace_batch(policy, view_of(), rays, detail::closest_query{hits.data()});
    }

    /// 1 for each ray that hits something, 0 for the others. @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void any(const Policy& policy, std::span<const ray> rays, std::span<std::uint8_t> met) const {
        check_sizes(rays.size(), met.size());
        detail::trace_batch(policy, view_of(), rays, detail::any_query{met.data()});
    }

    /// Every hit of each ray, nearest first. Replaces the contents of `hits`; allocates only where they grow.
    /// @throws usage_error  where the sizes differ
    template <exec::policy Policy>
    void all(const Policy& policy, std::span<const ray> rays, std::span<std::vector<hit>> hits) const {
        check_sizes(rays.size(), hits.size());
        detail::trace_batch(policy, view_of(), rays, detail::all_query{hits.data()});
    }

    /// The primitives whose bounds overlap a box or a plane, in ascending order. Replaces the contents of `primitives`.
    template <class Shape>
    void overlapping(const Shape& shape, std::vector<std::uint32_t>& primitives) const {
        primitives.clear();
        view_of().for_each_overlap(shape, [&](std::uint32_t p) { primitives.push_back(p); });
        std::sort(primitives.begin(), primitives.end());
    }

    /// Recomputes the boxes after primitives moved; the topology stays.
    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    void refit(const Policy& policy) {
        storage_.refit(policy, range_);
    }

    /// Refits after primitives moved, and rebuilds once rays have become 1.5 times as expensive: by `build_morton` where the
    /// tree lasted fewer than 16 updates.
    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    bvh_update update(const Policy& policy) {
        return storage_.update(policy, range_);
    }

    /// Builds a new tree from the current primitives.
    template <exec::policy Policy>
    void rebuild(const Policy& policy) {
        if constexpr (std::same_as<Range, mesh_view>) detail::check_faces(range_, "bvh: ");
        storage_.build(policy, range_);
    }

    /// The expected cost of a random ray relative to that at the last build: 1 after a build.
    double degradation() const { return storage_.degradation(); }
    /// Counts and sizes of the tree.
    bvh_statistics statistics() const { return storage_.statistics(); }
    /// The box around all primitives; empty for none.
    aabb box() const { return storage_.box(); }
    /// A trivially copyable view for queries, valid until the next rebuild, refit or update.
    bvh_view<Range, Width> view_of() const { return storage_.view_of(range_); }

  private:
    static void check_sizes(std::size_t rays, std::size_t results) {
        if (rays != results) throw usage_error{"bvh: as many results as rays are needed"};
    }

    Range range_{};
    detail::bvh_storage<Range, Width, Builder> storage_{};
};

/// Deduce the range from `bvh tree{policy, primitives}`.
/// @{
template <class Policy>
bvh(const Policy&, const mesh&) -> bvh<mesh_view>;
template <class Policy, class Container>
    requires requires(const Container& c) { std::data(c); }
bvh(const Policy&, const Container&)
    ->bvh<view<const std::remove_cvref_t<decltype(*std::data(std::declval<const Container&>()))>>>;
/// @}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
