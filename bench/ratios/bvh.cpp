#include <insonify/acoustics/tissue.hpp>
#include <insonify/bvh/build_morton.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/tracing/slice_lines.hpp>
#include "../support/embree.hpp"
#include "../support/meshes.hpp"
#include "../support/rays.hpp"
#include "rows.hpp"
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace bench {
namespace {

bool same_distance(float a, float b) { return std::fabs(a - b) <= 1e-4F * (std::fabs(a) + std::fabs(b)) + 1e-6F; }

double share_that_differs(std::span<const hit> a, std::span<const hit> b) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) different += !same_distance(a[i].distance, b[i].distance);
    return static_cast<double>(different) / static_cast<double>(a.size());
}

struct workload {
    std::string name{};
    std::vector<ray> rays{};
    double must = 0;
};

// Ours, Embree's rays one by one, and its packets; ask(packets of N, their flags) is called with each kind.
template <class Packets>
std::vector<contender> with_packets(const embree_peer& peer, const std::string& before, std::vector<contender> all,
                                    const Packets& ask) {
    for (const auto& [kind, flags] : {std::pair{"packets", RTC_INTERSECT_CONTEXT_FLAG_NONE},
                                      std::pair{"coherent packets", RTC_INTERSECT_CONTEXT_FLAG_COHERENT}}) {
        all.push_back({before + kind, [&ask, flags] { ask(std::integral_constant<std::size_t, 8>{}, flags); }});
        if (peer.takes_sixteen())
            all.push_back(
                {before + kind + " of 16", [&ask, flags] { ask(std::integral_constant<std::size_t, 16>{}, flags); }});
    }
    return all;
}

void measure_rays(table& into, const std::string& name, const mesh& m) {
    const bvh tree{exec::par, m};
    const embree_peer peer{m};
    for (const workload& one : {workload{"fan", fan_rays(), 1.3}, workload{"camera", camera_rays(), 1.3},
                                workload{"incoherent", incoherent_rays(), 1.05}}) {
        const embree_rays theirs{one.rays};
        const auto items = static_cast<double>(one.rays.size());
        std::vector<hit> hits(one.rays.size()), expected(one.rays.size());
        std::vector<std::uint8_t> met(one.rays.size()), met_too(one.rays.size());
        if (into.wants("closest " + one.name)) {
            tree.closest(exec::unseq, one.rays, hits);
            peer.closest(theirs, expected);
            into.measure({.work = "closest " + one.name,
                          .data = name,
                          .unit = "M rays/s",
                          .must = one.must,
                          .different = share_that_differs(hits, expected)},
                         with_packets(peer, "Embree, ",
                                      {{"insonify", [&] { tree.closest(exec::unseq, one.rays, hits); }},
                                       {"Embree, one ray", [&] { peer.closest(theirs, expected); }}},
                                      [&](auto n, auto flags) { peer.closest_packets<n()>(theirs, expected, flags); }),
                         items);
        }
        if (into.wants("any " + one.name)) {
            tree.any(exec::unseq, one.rays, met);
            peer.any(theirs, met_too);
            std::size_t different = 0;
            for (std::size_t i = 0; i < met.size(); ++i) different += met[i] != met_too[i];
            into.measure({.work = "any " + one.name,
                          .data = name,
                          .unit = "M rays/s",
                          .must = 1.05,
                          .different = static_cast<double>(different) / items},
                         with_packets(peer, "Embree, ",
                                      {{"insonify", [&] { tree.any(exec::unseq, one.rays, met); }},
                                       {"Embree, one ray", [&] { peer.any(theirs, met_too); }}},
                                      [&](auto n, auto flags) { peer.any_packets<n()>(theirs, met_too, flags); }),
                         items);
        }
    }
}

// The lines of `fan_rays`, frame by frame, each cut at once.
void cut_fans(slice_lines& cut, const scene& body, const std::vector<ray>& rays, std::uint32_t lines,
              std::vector<line_crossings>& found) {
    const float in_plane = 0;
    slice_lines::block_crossings own;
    for (std::uint32_t fan = 0; fan * lines < rays.size(); ++fan) {
        cut.choose(body, probe_pose(fan), true);
        cut.cut(exec::unseq, body, probe_pose(fan), {&in_plane, 1}, 300_mm);
        for (std::uint32_t line = 0; line < lines; ++line) {
            if (line % slice_lines::block == 0) cut.start(line, own);
            line_crossings& of_line = found[fan * lines + line];
            cut.find(line, 0, rays[fan * lines + line].origin, own, of_line);
            of_line.sort();
        }
    }
}

void measure_all_crossings(table& into, const std::string& name, const mesh& m) {
    if (!into.wants("all crossings fan")) return;
    const bvh tree{exec::par, m};
    const embree_peer peer{m, {.flags = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION}};
    const convex_array probe{.lines = 512, .radius = 60_mm, .field_of_view = 70_deg, .frequency = 4_MHz};
    const std::vector<ray> rays = fan_rays(64, probe.lines);
    scene body{tissue::fat};
    body.add(m, tissue::liver);
    body.build(exec::par);
    slice_lines cut;
    cut.take(probe);
    const embree_rays theirs{rays};
    std::vector<std::vector<hit>> hits(rays.size()), expected(rays.size());
    std::vector<line_crossings> crossings(rays.size());
    peer.all(theirs, expected);
    std::size_t found = 0;
    for (const std::vector<hit>& one : expected) found += one.size();
    struct {
        contender way;
        double must;
        std::function<std::size_t(std::size_t)> count; // of the hits of a ray
    } const ours[] = {
        {{"all crossings fan, slice", [&] { cut_fans(cut, body, rays, probe.lines, crossings); }},
         2, // as `trace` finds them
         [&](std::size_t i) { return crossings[i].crossings.size(); }},
        {{"all crossings fan, packets", [&] { tree.all(exec::unseq, rays, hits); }},
         0,
         [&](std::size_t i) { return hits[i].size(); }},
        {{"all crossings fan, one ray",
          [&] {
              for (std::size_t i = 0; i < rays.size(); ++i) tree.all(rays[i], hits[i]);
          }},
         0,
         [&](std::size_t i) { return hits[i].size(); }},
    };
    for (const auto& one : ours) {
        one.way.work();
        std::size_t different = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) different += one.count(i) != expected[i].size();
        into.measure({.work = one.way.name,
                      .data = name,
                      .unit = "M hits/s",
                      .must = one.must,
                      .different = static_cast<double>(different) / static_cast<double>(rays.size())},
                     with_packets(peer, "Embree filter, ",
                                  {one.way, {"Embree filter, one ray", [&] { peer.all(theirs, expected); }}},
                                  [&](auto n, auto flags) { peer.all_packets<n()>(theirs, expected, flags); }),
                     static_cast<double>(found));
    }
}

void measure_trees(table& into, const std::string& name, const mesh& m, unsigned threads) {
    const std::string data = name + ", " + std::to_string(threads) + (threads == 1 ? " thread" : " threads");
    const auto policy = exec::par_unseq.threads(threads);
    if (into.wants("build SAH")) {
        embree_peer plain{m, {.threads = threads}}, compact{m, {.flags = RTC_SCENE_FLAG_COMPACT, .threads = threads}};
        into.measure({.work = "build SAH", .data = data, .unit = "ms", .must = 1.5},
                     {{"insonify",
                       [&] {
                           const bvh tree{policy, m};
                       }},
                      {"Embree MEDIUM", [&] { plain.build(m); }},
                      {"Embree MEDIUM compact", [&] { compact.build(m); }}},
                     0, {.seconds = 4});
    }
    if (into.wants("rebuild")) {
        bvh<mesh_view, simd_width, build_morton> tree{policy, mesh_view{m}};
        embree_peer peer{m, {.quality = RTC_BUILD_QUALITY_LOW, .flags = RTC_SCENE_FLAG_DYNAMIC, .threads = threads}};
        into.measure({.work = "rebuild", .data = data, .unit = "ms", .must = 1.5},
                     {{"insonify", [&] { tree.rebuild(policy); }}, {"Embree LOW", [&] { peer.update(); }}});
    }
    if (into.wants("refit")) {
        bvh tree{policy, m};
        embree_peer peer{m, {.quality = RTC_BUILD_QUALITY_REFIT, .flags = RTC_SCENE_FLAG_DYNAMIC, .threads = threads}};
        into.measure({.work = "refit", .data = data, .unit = "ms", .must = 1.3},
                     {{"insonify", [&] { tree.refit(policy); }}, {"Embree REFIT", [&] { peer.update(); }}});
    }
}

void measure_ray_rows(table& into) {
    measure_rays(into, "organ 82k", organ_82k());
    measure_rays(into, "organ 1.3M", organ_1_3m());
    measure_rays(into, "soup 500k", soup());
    measure_all_crossings(into, "organ 82k", organ_82k());
    measure_all_crossings(into, "shells 655k", shells());
}

void measure_tree_rows(table& into) {
    for (const unsigned threads : {1U, 2U}) {
        measure_trees(into, "cube 12", cube(0), threads);
        measure_trees(into, "organ 82k", organ_82k(), threads);
        measure_trees(into, "soup 500k", soup(), threads);
        measure_trees(into, "organ 1.3M", organ_1_3m(), threads);
    }
}

const rows of_rays{10, measure_ray_rows}, of_trees{20, measure_tree_rows};

} // namespace
} // namespace bench
