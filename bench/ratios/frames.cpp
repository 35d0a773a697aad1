#include "../support/embree_pixels.hpp"
#include "rows.hpp"
#include <span>

namespace bench {

using namespace insonify;
using paper::embree_pixels;

namespace {

double fraction_that_differs(std::span<const float> a, std::span<const float> b) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) different += std::fabs(a[i] - b[i]) > 1e-3F * std::fabs(b[i]) + 1e-6F;
    return static_cast<double>(different) / static_cast<double>(a.size());
}

void measure_resting(table& into, const std::string& work, const std::string& data, const std::vector<mesh>& objects,
                     double must) {
    const scene body = paper::scene_of(objects);
    const embree_pixels peer{objects};
    paper::frames<> ours;
    std::vector<float> theirs;
    ours(paper::best, body);
    struct {
        embree_pixels::rays how;
        const char* name;
        double must;
    } const peers[] = {{embree_pixels::rays::recursive, "its algorithm on Embree, hit by hit", must},
                       {embree_pixels::rays::single, "the same, filter function", 0},
                       {embree_pixels::rays::packets, "the same, packets of 8", 0}};
    for (const auto& one : peers) {
        peer.trace(one.how, embree_pixels::shade::intensities, theirs);
        into.measure({.work = work,
                      .data = data,
                      .unit = "ms",
                      .must = one.must,
                      .different = fraction_that_differs(ours.lines.values, theirs)},
                     {{"insonify", [&] { ours(paper::best, body); }},
                      {one.name, [&] { peer.trace(one.how, embree_pixels::shade::intensities, theirs); }}});
    }
}

void measure_moving(table& into, const std::string& data, const mesh& cube) {
    const std::vector<vec3>& rest = cube.positions;
    scene body = paper::scene_of({cube});
    paper::frames<> ours;
    std::vector<float> theirs;
    std::uint32_t number = 0;
    const contender we{"insonify",
                       [&] {
                           body.update(exec::par_unseq);
                           ours(paper::best, body);
                       },
                       [&] { paper::deform(body.positions(body.objects()[0].id), rest, ++number); }};
    struct {
        RTCBuildQuality quality;
        const char* name;
        double must;
    } const peers[] = {{RTC_BUILD_QUALITY_MEDIUM, "its algorithm on Embree, rebuilt", 50},
                       {RTC_BUILD_QUALITY_REFIT, "its algorithm on Embree, refitted", 15}};
    for (const auto& one : peers) {
        embree_pixels peer{{cube}, one.quality};
        const contender they{one.name,
                             [&] {
                                 peer.update();
                                 peer.trace(embree_pixels::rays::single, embree_pixels::shade::intensities, theirs);
                             },
                             [&] {
                                 paper::deform({peer.positions(), rest.size()}, rest, ++number);
                             }};
        we.prepare();
        we.work();
        --number;
        they.prepare();
        they.work();
        into.measure({.work = "paper's frame, moving",
                      .data = data,
                      .unit = "ms",
                      .must = one.must,
                      .different = fraction_that_differs(ours.lines.values, theirs)},
                     {we, they});
    }
}

/// The least that a frame takes: its crossings, and one power of two for each of its samples.
void measure_floor(table& into, const std::string& data, const mesh& cube) {
    const scene body = paper::scene_of({cube});
    paper::frames<> ours;
    paper::frames<paper::crossings_only> crossings;
    scan_lines powers;
    powers.reshape(paper::probe.lines, paper::frame.samples, paper::frame.depth);
    const auto take_powers = [&] {
        exec::for_each_block(exec::par_unseq, powers.values.size(), 8 * powers.samples, 0.5F,
                             [&](std::size_t begin, std::size_t end) {
                                 const lanes<simd_width> step(-1e-4F);
                                 lanes<simd_width> x(0.0F);
                                 for (std::size_t i = begin; i < end; i += simd_width, x = x + step)
                                     store(power_of_two<simd_width>(x), powers.values.data() + i);
                             });
    };
    into.measure({.work = "paper's frame over its floor", .data = data, .unit = "ms", .must = 0.4},
                 {{"insonify", [&] { ours(paper::best, body); }}, {"crossings, and a power for each sample", [&] {
                                                                       crossings(paper::best, body);
                                                                       take_powers();
                                                                   }}});
}

void measure_frame_rows(table& into) {
    if (into.wants("paper's frame"))
        for (const std::uint32_t subdivisions : {0U, 3U, 6U, 8U}) {
            const std::vector<mesh> cube = paper::one_cube(subdivisions);
            measure_resting(into, "paper's frame", std::to_string(cube[0].faces.size()) + " triangles", cube, 50);
        }
    if (into.wants("paper's frame over its floor"))
        for (const std::uint32_t subdivisions : {3U, 6U})
            measure_floor(into, std::to_string(12U << 2 * subdivisions) + " triangles",
                          paper::one_cube(subdivisions)[0]);
    if (into.wants("paper's frame, cubes"))
        measure_resting(into, "paper's frame, cubes", "32 behind one another", paper::behind_one_another(32), 300);
    if (into.wants("paper's frame, moving"))
        for (const std::uint32_t subdivisions : {6U, 8U}) {
            const mesh cube = paper::one_cube(subdivisions)[0];
            measure_moving(into, std::to_string(cube.faces.size()) + " triangles", cube);
        }
}

const rows of_frames{30, measure_frame_rows};

} // namespace
} // namespace bench
