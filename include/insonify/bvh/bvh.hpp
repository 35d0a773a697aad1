#ifndef INSONIFY_BVH_BVH_HPP
#define INSONIFY_BVH_BVH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/storage.hpp>
#include <algorithm>
#include <span>
#include <vector>

/// Batches of rays. Coherent neighbours are traced in packets, the others one by one; several traversals are
/// interleaved to hide memory latency: 1.8 to 2.9 times faster for incoherent rays, 2 to 3 along a fan (bench/bvh.cpp).
namespace insonify::inline INSONIFY_ABI::detail {

/// The traversal of a packet, one node or leaf per step: see `ray_traversal`.
template <class Range, int Width>
struct packet_traversal {
    using tree_view = bvh_view<Range, Width>;
    using floats = lanes<Width>;

    ray_packet<Width> rays;
    std::uint32_t best[ray_packet<Width>::max_rays]; ///< the hit primitive of each ray, or `no_primitive`
    nearest_first<Width> stack;

    /// Loads coherent rays from the first of `count` on. @return how many: 0 for none
    std::size_t start(const tree_view& tree, const ray* first, std::size_t count) {
        const std::size_t taken = rays.prepare(first, count, tree.box, tree.max_abs_coordinate, tree.leaf_size);
        for (std::size_t k = 0; k < taken; ++k) best[k] = no_primitive;
        stack.start();
        return taken;
    }

    /// Calls visit(group, index of its first ray, primitive, distances, hits) for every triangle that some ray of a
    /// group may hit. The mask `hits` is set for rays that hit it between their limits. visit returns 0 if it lowered
    /// no limit. Traverses front to back. @return false when the traversal is finished
    template <class Visit>
    INSONIFY_INLINE bool step(const tree_view& tree, const Visit& visit) {
        if ((stack.next & leaf_bit) == 0) {
            const tree_node<Width>& node = tree.nodes[stack.next];
            floats entry;
            if (const std::uint32_t met = enter(node, rays, entry); met != 0) {
                stack.descend(node, entry, met);
                tree.prefetch(stack.next);
                return true;
            }
        } else if (stack.next != no_child) {
            tree.leaves[stack.next ^ leaf_bit].intersect_packet(
                rays, [&](auto& group, std::uint32_t first, std::uint32_t primitive, const floats& distance) {
                    const auto hits = load<Width>(group.min_distance) <= distance && distance < floats(FLT_MAX) &&
                                      distance <= load<Width>(group.limit);
                    return visit(group, first, primitive, distance, hits);
                });
        }
        if (!stack.pop(rays.end - rays.begin)) return false;
        tree.prefetch(stack.next);
        return true;
    }

    /// Records the primitive for the rays of a group that hit it, and their new limits. @return a bit for each
    INSONIFY_INLINE std::uint32_t take(typename ray_packet<Width>::group& group, const lane_mask<Width>& hits,
                                       std::uint32_t primitive, std::uint32_t first, const floats& limit) {
        std::uint32_t* const held = best + first;
        store(select(hits, limit, load<Width>(group.limit)), group.limit);
        store_bits<Width>(select_bits<Width>(hits, bit_lanes<Width>{} + primitive, load_bits<Width>(held)), held);
        return bits_of(hits);
    }
};

/// A query initialises the result of ray i with begin(i), and advances its traversal with step(tree, traversal, i)
/// until that returns false. For a packet whose first ray is i it uses step_packet, then finish(traversal, i).
struct closest_query {
    hit* hits = nullptr;

    void begin(std::size_t i) const { hits[i] = {}; }
    template <class Tree, class Traversal>
    bool step(const Tree& tree, Traversal& traversal, std::size_t i) const {
        return traversal.step_closest(tree, hits[i]);
    }
    template <class Range, int Width>
    bool step_packet(const bvh_view<Range, Width>& tree, packet_traversal<Range, Width>& packet, std::size_t) const {
        return packet.step(tree, [&](auto& group, std::uint32_t first, std::uint32_t primitive,
                                     const lanes<Width>& distance, const lane_mask<Width>& within) {
            const lanes<Width> limit = load<Width>(group.limit);
            for (std::uint32_t left = bits_of(within && distance == limit); left != 0; left &= left - 1) {
                std::uint32_t& held = packet.best[first + lowest_bit(left)];
                if (primitive < held) held = primitive;
            }
            return packet.take(group, within && distance < limit, primitive, first, distance);
        });
    }
    template <class Range, int Width>
    void finish(const packet_traversal<Range, Width>& packet, std::size_t i) const {
        for (std::size_t k = 0; k < packet.rays.groups * Width; ++k) {
            const std::uint32_t primitive = packet.best[k];
            if (primitive != no_primitive) hits[i + k] = {packet.rays.of[k / Width].limit[k % Width], primitive};
        }
    }
};

struct any_query {
    std::uint8_t* met = nullptr;

    void begin(std::size_t i) const { met[i] = 0; }
    template <class Tree, class Traversal>
    bool step(const Tree& tree, Traversal& traversal, std::size_t i) const {
        return traversal.step(tree, [&](const hit&) { met[i] = 1; }) && met[i] == 0;
    }
    template <class Range, int Width>
    bool step_packet(const bvh_view<Range, Width>& tree, packet_traversal<Range, Width>& packet, std::size_t) const {
        return packet.step(tree, [&](auto& group, std::uint32_t first, std::uint32_t primitive, const lanes<Width>&,
                                     const lane_mask<Width>& within) {
            return packet.take(group, within, primitive, first, lanes<Width>(-1.0F));
        });
    }
    template <class Range, int Width>
    void finish(const packet_traversal<Range, Width>& packet, std::size_t i) const {
        for (std::size_t k = 0; k < packet.rays.groups * Width; ++k) met[i + k] = packet.best[k] != no_primitive;
    }
};

struct all_query {
    std::vector<hit>* hits = nullptr;

    void begin(std::size_t i) const { hits[i].clear(); }
    template <class Tree, class Traversal>
    bool step(const Tree& tree, Traversal& traversal, std::size_t i) const {
        if (traversal.step(tree, [&](const hit& found) { hits[i].push_back(found); })) return true;
        std::sort(hits[i].begin(), hits[i].end(), nearer);
        return false;
    }
    template <class Range, int Width>
    bool step_packet(const bvh_view<Range, Width>& tree, packet_traversal<Range, Width>& packet, std::size_t i) const {
        return packet.step(tree, [&](auto&, std::uint32_t first, std::uint32_t primitive, const lanes<Width>& distance,
                                     const lane_mask<Width>& within) {
            alignas(sizeof(distance)) float found[Width];
            store(distance, found);
            for (std::uint32_t left = bits_of(within); left != 0; left &= left - 1)
                hits[i + first + lowest_bit(left)].push_back({found[lowest_bit(left)], primitive});
            return 0U;
        });
    }
    template <class Range, int Width>
    void finish(const packet_traversal<Range, Width>& packet, std::size_t i) const {
        for (std::size_t k = 0; k < packet.rays.groups * Width; ++k)
            std::sort(hits[i + k].begin(), hits[i + k].end(), nearer);
    }
};

/// Advances several traversals in turn, one step each. start(traversal) returns false when no ray is left,
/// step(traversal) when the traversal is finished.
template <class Traversal, std::size_t MaxCount, class Start, class Step>
void interleave(const Start& start, const Step& step) {
    struct slot {
        std::size_t ray; // in one cache line with what each step reads first
        bool active;
        Traversal traversal;
    };
    slot slots[MaxCount];
    std::size_t active = 0;
    for (slot& one : slots) active += one.active = start(one.traversal, one.ray);
    while (active > 0)
        for (slot& one : slots)
            if (one.active && !step(one.traversal, one.ray)) active -= !(one.active = start(one.traversal, one.ray));
}

/// Runs the query for every ray. Packets begin at multiples of Width, so results do not depend on the policy.
template <class Policy, class Range, int Width, class Query>
void trace_batch(const Policy& policy, const bvh_view<Range, Width>& tree, view<const ray> rays, const Query& query) {
    using single = ray_traversal<Range, Width>;
    using packet = packet_traversal<Range, Width>;
    constexpr std::size_t block_size = 1024;
    if (tree.nodes.empty()) {
        for (std::size_t i = 0; i < rays.size(); ++i) query.begin(i);
        return;
    }
    exec::for_each_block(policy, rays.size(), block_size, 150, [&](std::size_t begin, std::size_t end) {
        std::size_t alone[block_size];
        std::size_t singles = 0, next = begin;
        for (std::size_t i = begin; i < end; ++i) query.begin(i);
        if constexpr (triangle_range<Range>) {
            interleave<packet, 8>(
                [&](packet& traversal, std::size_t& i) {
                    for (; next + Width <= end; next += Width) {
                        i = next;
                        std::uint32_t entering =
                            may_enter(tree.box, tree.max_abs_coordinate, ray_lanes<Width>{rays.data() + i});
                        if (entering == 0) continue;
                        if (const std::size_t taken = traversal.start(tree, rays.data() + i, end - i); taken > 0) {
                            next += taken;
                            return true;
                        }
                        for (; entering != 0; entering &= entering - 1) alone[singles++] = i + lowest_bit(entering);
                    }
                    return false;
                },
                [&](packet& traversal, std::size_t i) {
                    if (query.step_packet(tree, traversal, i)) return true;
                    query.finish(traversal, i);
                    return false;
                });
        }
        while (next < end) alone[singles++] = next++;
        std::size_t started = 0;
        interleave<single, 12>(
            [&](single& traversal, std::size_t& i) {
                while (started < singles) {
                    i = alone[started++];
                    if (traversal.start(tree, rays[i])) return true;
                }
                return false;
            },
            [&](single& traversal, std::size_t i) { return query.step(tree, traversal, i); });
    });
}

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

/// A bounding volume hierarchy over primitives that the caller owns and keeps alive.
///
///     bvh tree{exec::par, spheres};          // any contiguous container of a type with `bounds` and `intersect`
///     bvh tree{exec::par, some_mesh};        // triangles, watertight
///
/// Empty, single and identical primitives are legal. Queries are const and may run on many threads at once.
/// @tparam Width    children per node and primitives per leaf, 4 or 8; the SIMD width is fastest, and of more lanes than a
///                  register has compilers may warn (-Wpsabi)
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
    /// Coherent neighbours are traced in packets: keep the lines of a fan, or the pixels of a row, adjacent.
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

    /// The primitives whose bounds overlap a box, in ascending order. Replaces the contents of `primitives`.
    void overlapping(const aabb& region, std::vector<std::uint32_t>& primitives) const {
        primitives.clear();
        view_of().for_each_overlap(region, [&](std::uint32_t p) { primitives.push_back(p); });
        std::sort(primitives.begin(), primitives.end());
    }

    /// Recomputes the boxes after primitives moved; the topology stays.
    /// @throws geometry_error  where the number of primitives has changed
    template <exec::policy Policy>
    void refit(const Policy& policy) {
        storage_.refit(policy, range_);
    }

    /// Refits after primitives moved, and rebuilds once rays have become 1.5 times as expensive: by `build_morton`
    /// where the tree lasted fewer than 16 updates.
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
