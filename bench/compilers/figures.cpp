#include "../support/chain_scene.hpp"
#include "../support/contest.hpp"
#include "../support/paper_scenes.hpp"
#include "../support/rays.hpp"
#include <cstdio>

/// What compilers and instruction sets are compared by: a line `figure=milliseconds` for each, medians, one thread.
/// compilers.cmake runs it.
int main() {
    using namespace insonify;
    using namespace bench;
    const mesh surface = organ_82k();
    bvh tree{exec::unseq, surface};
    bvh<mesh_view, simd_width, build_morton> quick{exec::unseq, mesh_view{surface}};
    const std::vector<ray> camera = camera_rays(256, 256), incoherent = incoherent_rays(16384);
    std::vector<hit> hits(camera.size());
    const scene cube = paper::scene_of(paper::one_cube(6)), organ = chain::organ();
    line_tracer<law2011> own;
    scan_lines lines;
    chain::frame chain;
    chain.draw(exec::unseq, organ);
    std::vector<contender> all{
        {"closest_camera",
         [&] {
             tree.closest(exec::unseq, camera, {hits.data(), camera.size()});
         }},
        {"closest_incoherent",
         [&] {
             tree.closest(exec::unseq, incoherent, {hits.data(), incoherent.size()});
         }},
        {"build_sah", [&] { tree.rebuild(exec::unseq); }},
        {"build_morton", [&] { quick.rebuild(exec::unseq); }},
        {"refit", [&] { tree.refit(exec::unseq); }},
        {"papers_frame",
         [&] {
             lines = trace(exec::unseq, cube, paper::probe, paper::at, law2011{}, paper::frame, own, std::move(lines));
         }},
        {"chain_trace", [&] { chain.trace_echoes(exec::unseq, organ); }},
        {"chain_convolve", [&] { chain.spread(exec::unseq); }},
        {"chain_envelope", [&] { chain.detect(exec::unseq); }},
        {"chain_log", [&] { chain.compress(exec::unseq); }},
        {"chain_scan_convert", [&] { chain.convert(exec::unseq); }},
    };
    run(all, {.seconds = 4});
    for (const contender& one : all) std::printf("%s=%.4f\n", one.name.c_str(), one.median() * 1e3);
}
