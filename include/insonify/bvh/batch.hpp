#ifndef INSONIFY_BVH_BATCH_HPP
#define INSONIFY_BVH_BATCH_HPP

#include <insonify/bvh/traverse_packet.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/later.hpp>
#include <insonify/execution/for_each.hpp>
#include <vector>

/// Many rays at once. Neighbours that go together walk in packets, the others alone; several of either take turns, so
/// that the memory of one comes while another is worked on.
///
/// Against one ray after the other: 1.8 to 2.9 times as fast where rays have nothing in common, 2 to 3 times along a fan
/// (bench/bvh.cpp).
namespace insonify::inline INSONIFY_ABI {

/// What the batches below ask of each ray: begin(i) before its first step, then step(tree, walk, i) until it is false; of
/// rays that go together step(tree, packet walk, the first one), then finish(packet walk, the first one).
struct closest_query {
    template <int Width>
    using order = nearest_first<Width>;
    hit* hits = nullptr;

    void begin(std::size_t i) const { hits[i] = {}; }
    template <class Range, int Width, class Order>
    bool step(const bvh_view<Range, Width>& tree, tree_walk<Range, Width, Order>& walk, std::size_t i) const {
        return walk.step_closest(tree, hits[i]);
    }
    template <class Range, int Width>
    bool step(const bvh_view<Range, Width>& tree, packet_walk<Range, Width>& walk, std::size_t) const {
        return walk.step_closest(tree);
    }
    template <class Range, int Width>
    void finish(const packet_walk<Range, Width>& walk, std::size_t i) const {
        for (std::size_t g = 0; g < walk.rays.groups; ++g) {
            float distance[Width];
            store(walk.nearest(g), distance);
            for (std::size_t k = 0; k < Width; ++k) hits[i + g * Width + k] = {distance[k], walk.best[g * Width + k]};
        }
    }
};

struct any_query {
    template <int Width>
    using order = any_order<Width>;
    std::uint8_t* met = nullptr;

    void begin(std::size_t i) const { met[i] = 0; }
    template <class Range, int Width, class Order>
    bool step(const bvh_view<Range, Width>& tree, tree_walk<Range, Width, Order>& walk, std::size_t i) const {
        return walk.step(tree, [&](const hit&) { met[i] = 1; }) && met[i] == 0;
    }
    template <class Range, int Width>
    bool step(const bvh_view<Range, Width>& tree, packet_walk<Range, Width>& walk, std::size_t) const {
        return walk.step_any(tree);
    }
    template <class Range, int Width>
    void finish(const packet_walk<Range, Width>& walk, std::size_t i) const {
        for (std::size_t k = 0; k < walk.rays.groups * Width; ++k) met[i + k] = walk.best[k] != no_primitive;
    }
};

struct all_query {
    template <int Width>
    using order = any_order<Width>;
    std::vector<hit>* hits = nullptr;

    INSONIFY_LAZY void begin(std::size_t i) const { later<Later>(hits)[i].clear(); }
    template <class Range, int Width, class Order>
    bool step(const bvh_view<Range, Width>& tree, tree_walk<Range, Width, Order>& walk, std::size_t i) const {
        if (walk.step(tree, [&](const hit& found) { later<Range>(hits)[i].push_back(found); })) return true;
        sort(later<Range>(hits)[i]);
        return false;
    }
    template <class Range, int Width>
    bool step(const bvh_view<Range, Width>& tree, packet_walk<Range, Width>& walk, std::size_t i) const {
        return walk.step_all(tree,
                             [&](std::uint32_t k, const hit& found) { later<Range>(hits)[i + k].push_back(found); });
    }
    template <class Range, int Width>
    void finish(const packet_walk<Range, Width>& walk, std::size_t i) const {
        for (std::size_t k = 0; k < walk.rays.groups * Width; ++k) sort(later<Range>(hits)[i + k]);
    }

  private:
    template <class Hits>
    static void sort(Hits& one) {
        std::sort(one.begin(), one.end(), nearer);
    }
};

/// Several walks, a step each in turn: start(walk) is false once there is nothing more to start, step(walk) at a walk's
/// end.
template <class Walk, std::size_t Most, class Start, class Step>
void take_turns(const Start& start, const Step& step) {
    struct place {
        std::size_t ray; // in one line of cache with what each step begins with
        bool taken;
        Walk walk;
    };
    place places[Most];
    std::size_t walking = 0;
    for (place& one : places) walking += one.taken = start(one.walk, one.ray);
    while (walking > 0)
        for (place& one : places)
            if (one.taken && !step(one.walk, one.ray)) walking -= !(one.taken = start(one.walk, one.ray));
}

/// Asks every ray. Packets begin at multiples of Width, so that nothing depends on the policy.
template <class Policy, class Range, int Width, class Query>
void ask(const Policy& policy, const bvh_view<Range, Width>& tree, view<const ray> rays, const Query& query) {
    using walk_of_one = tree_walk<Range, Width, typename Query::template order<Width>>;
    using walk_of_packet = packet_walk<Range, Width>;
    constexpr std::size_t block_size = 1024;
    exec::for_each_block(policy, rays.size(), block_size, 150, [&](std::size_t begin, std::size_t end) {
        std::size_t alone[block_size];
        std::size_t singles = 0, next = begin;
        if constexpr (triangle_range<Range>) {
            take_turns<walk_of_packet, 8>(
                [&](walk_of_packet& walk, std::size_t& i) {
                    while (next + Width <= end) {
                        i = next;
                        const std::size_t taken = walk.start(tree, rays.data() + i, end - i);
                        next += taken > 0 ? taken : Width;
                        for (std::size_t k = i; k < i + taken; ++k) query.begin(k);
                        if (taken > 0) return true;
                        for (std::size_t k = i; k < next; ++k) alone[singles++] = k;
                    }
                    return false;
                },
                [&](walk_of_packet& walk, std::size_t i) {
                    if (query.step(tree, walk, i)) return true;
                    query.finish(walk, i);
                    return false;
                });
        }
        while (next < end) alone[singles++] = next++;
        std::size_t started = 0;
        take_turns<walk_of_one, 12>(
            [&](walk_of_one& walk, std::size_t& i) {
                while (started < singles) {
                    i = alone[started++];
                    query.begin(i);
                    if (walk.start(tree, rays[i])) return true;
                }
                return false;
            },
            [&](walk_of_one& walk, std::size_t i) { return query.step(tree, walk, i); });
    });
}

} // namespace insonify::inline INSONIFY_ABI
#endif
