#include <insonify/acoustics/tissue.hpp>
#include <insonify/bvh/build_morton.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/io/obj.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tracing/find/slice_finder.hpp>
#include "../support/embree.hpp"
#include "../support/meshes.hpp"
#include "../support/rays.hpp"
#include "rows.hpp"
#include <cstddef>
#include <filesystem>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace bench {
namespace {

bool same_distance(float a, float b) { return std::fabs(a - b) <= 1e-4F * (std::fabs(a) + std::fabs(b)) + 1e-6F; }

double fraction_that_differs(std::span<const hit> a, std::span<const hit> b) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) different += !same_distance(a[i].distance, b[i].distance);
    return static_cast<double>(different) / static_cast<double>(a.size());
}

struct workload {
    std::string name{};
    std::vector<ray> rays{};
    double must = 0;
    double must_any = 1.05;
};

// Appends Embree's packets to the contenders; query(packets of N, coherence) runs one kind.
template <class Packets>
std::vector<contender> with_packets(const embree_peer& peer, const std::string& before, std::vector<contender> all,
                                    const Packets& query) {
    for (const auto& [name, kind] :
         {std::pair{"packets", coherence::unknown}, std::pair{"coherent packets", coherence::coherent}}) {
        all.push_back({before + name, [&query, kind] { query(std::integral_constant<std::size_t, 8>{}, kind); }});
        if (peer.takes_sixteen())
            all.push_back(
                {before + name + " of 16", [&query, kind] { query(std::integral_constant<std::size_t, 16>{}, kind); }});
    }
    return all;
}

// Debian's Embree 3.13 has assertions enabled; Embree 4 in a release build is faster.
constexpr double must_of_packets = RTC_VERSION_MAJOR >= 4 ? 1.1 : 1.3, must_of_rays = 1.05;

std::vector<workload> compact_workloads() {
    return {{"fan", fan_rays(), must_of_packets},
            {"camera", camera_rays(), must_of_packets},
            {"incoherent", incoherent_rays(), must_of_rays}};
}
std::vector<workload> leg_workloads() {
    return {{"fan", leg_fan_rays(), 1.1, 1.1}, {"camera", leg_camera_rays(), 1.1, 1.1}};
}

void measure_rays(table& into, const std::string& name, const mesh& m, const std::vector<workload>& workloads) {
    const bvh tree{exec::par, m};
    const embree_peer peer{m};
    for (const workload& one : workloads) {
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
                          .different = fraction_that_differs(hits, expected)},
                         with_packets(peer, "Embree, ",
                                      {{"insonify", [&] { tree.closest(exec::unseq, one.rays, hits); }},
                                       {"Embree, one ray", [&] { peer.closest(theirs, expected); }}},
                                      [&](auto n, auto kind) { peer.closest_packets<n()>(theirs, expected, kind); }),
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
                          .must = one.must_any,
                          .different = static_cast<double>(different) / items},
                         with_packets(peer, "Embree, ",
                                      {{"insonify", [&] { tree.any(exec::unseq, one.rays, met); }},
                                       {"Embree, one ray", [&] { peer.any(theirs, met_too); }}},
                                      [&](auto n, auto kind) { peer.any_packets<n()>(theirs, met_too, kind); }),
                         items);
        }
    }
}

// The lines of `fan_rays`, frame by frame, each cut at once.
void cut_fans(detail::slice_finder& finder, const scene_view& flat, const std::vector<ray>& rays, std::uint32_t lines,
              std::vector<std::vector<crossing>>& found) {
    const detail::elevation_plane middle{};
    const view<const detail::elevation_plane> planes{&middle, 1};
    detail::crossing_lists of_block;
    std::vector<crossing> room(4096);
    for (std::uint32_t fan = 0; fan * lines < rays.size(); ++fan) {
        finder.choose(flat, probe_pose(fan), planes, true, 1);
        finder.cut(exec::unseq, flat, probe_pose(fan), planes, 300_mm);
        for (std::uint32_t line = 0; line < lines; ++line) {
            if (line % detail::slice_finder::block == 0) finder.find_block(line, of_block);
            line_crossings sorted{.room = view<crossing>{room}};
            for (const crossing& one : std::as_const(of_block)[detail::slice_finder::list_of(line, 0)])
                if (one.distance >= 0) sorted.add(one);
            sorted.sort();
            found[fan * lines + line].assign(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(sorted.count));
        }
    }
}

void measure_all_crossings(table& into, const std::string& name, const mesh& m) {
    if (!into.wants("all crossings fan")) return;
    const bvh tree{exec::par, m};
    const embree_peer peer{m, {.flags = embree_filter_flag}};
    const convex_array probe{.lines = 512, .radius = 60_mm, .field_of_view = 70_deg, .frequency = 4_MHz};
    const std::vector<ray> rays = fan_rays(64, probe.lines);
    scene body{tissue::fat};
    body.add(m, tissue::liver);
    body.build(exec::par);
    detail::slice_finder finder;
    finder.assign(probe);
    const scene_view flat = body.view_for_slices(exec::par);
    const embree_rays theirs{rays};
    std::vector<std::vector<hit>> hits(rays.size()), expected(rays.size());
    std::vector<std::vector<crossing>> crossings(rays.size());
    peer.all(theirs, expected);
    std::size_t found = 0;
    for (const std::vector<hit>& one : expected) found += one.size();
    struct {
        contender way;
        double must;
        std::function<std::size_t(std::size_t)> count; // of the hits of a ray
    } const ours[] = {
        {{"all crossings fan, slice", [&] { cut_fans(finder, flat, rays, probe.lines, crossings); }},
         2, // as `trace` finds them
         [&](std::size_t i) { return crossings[i].size(); }},
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
                                  [&](auto n, auto kind) { peer.all_packets<n()>(theirs, expected, kind); }),
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
    const std::vector<workload> compact = compact_workloads();
    measure_rays(into, "organ 82k", organ_82k(), compact);
    measure_rays(into, "organ 1.3M", organ_1_3m(), compact);
    measure_rays(into, "soup 500k", soup(), compact);
    measure_rays(into, "leg 1M", leg_1m(), leg_workloads());
    measure_all_crossings(into, "organ 82k", organ_82k());
    measure_all_crossings(into, "shells 655k", shells());
}

// Files that the user names, brought to the size of the other meshes.
void measure_files(table& into) {
    for (const std::string& path : into.files()) {
        mesh m = load_obj(path, {.unit = 1_mm});
        aabb box;
        for (const vec3& p : m.positions) box = merged(box, p);
        const vec3 size = box.size(), middle = box.centre();
        for (vec3& p : m.positions) p = (100_mm / max(size.x, max(size.y, size.z))) * (p - middle);
        measure_rays(into, std::filesystem::path{path}.stem().string(), m, compact_workloads());
    }
}

void measure_tree_rows(table& into) {
    for (const unsigned threads : {1U, 2U}) {
        measure_trees(into, "cube 12", cube(0), threads);
        measure_trees(into, "organ 82k", organ_82k(), threads);
        measure_trees(into, "soup 500k", soup(), threads);
        measure_trees(into, "organ 1.3M", organ_1_3m(), threads);
    }
}

const rows of_rays{10, measure_ray_rows}, of_files{15, measure_files}, of_trees{20, measure_tree_rows};

} // namespace
} // namespace bench
