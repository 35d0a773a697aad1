#include <insonify/image/image.hpp>
#include <insonify/paper/pixels.hpp>
#include <insonify/tracing/trace.hpp>
#include "support/contest.hpp"
#include "support/embree_pixels.hpp"
#include "support/paper_figures.hpp"
#include "support/table.hpp"
#include <cstdio>
#include <cstdlib>

/// The paper's performance tests 1 to 4 and its figures 4 to 6, by pixels, beams and slice, and beside them the paper's
/// per-pixel algorithm on Embree, on all processors. Pictures are compared before time is.
///
///     bench_paper [folder] [seconds a row]       tables to the screen; *.dat, figures.gp and, where gnuplot is, figure_*.png
namespace {

using namespace insonify;
using namespace bench;
using paper::at;
using paper::crossings_only;
using paper::draw;
using paper::embree_pixels;
using paper::frame;
using paper::model;
using paper::probe;
using paper::test;

double seconds_a_row = 2;

std::vector<double> milliseconds_of(std::vector<contender> contenders) {
    run(contenders, {.seconds = seconds_a_row, .min_rounds = 5, .max_rounds = 1000});
    std::vector<double> all;
    for (const contender& one : contenders) all.push_back(one.median() * 1e3);
    return all;
}

/// Share of the pixels that differ by more than a thousandth. Stops where pictures are not the same.
void compare(const std::string& what, std::span<const float> a, std::span<const float> b) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) different += std::fabs(a[i] - b[i]) > 1e-3F * std::fabs(b[i]) + 1e-6F;
    const double fraction = static_cast<double>(different) / static_cast<double>(a.size());
    if (a.size() == b.size() && fraction < 2e-3) return;
    std::fprintf(stderr, "%s: %.2g of the pixels differ\n", what.c_str(), fraction);
    std::exit(1);
}

/// The points where r1 meets the slice, and nothing else: test 1c.
float primary_rays(const orthographic_camera& seen_by) {
    std::vector<float> sums(seen_by.size.y);
    exec::for_each_index(exec::par, seen_by.size.y, [&](std::size_t y) {
        for (std::uint32_t x = 0; x < seen_by.size.x; ++x) {
            const ray r1 = seen_by.through({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F});
            const vec3 from = at.local_point(r1.origin), along = at.local_direction(r1.direction);
            const vec3 point = from - from.y / along.y * along;
            const vec2 place = probe.locate({point.x, point.z});
            sums[y] += place.x + place.y;
        }
    });
    float sum = 0;
    for (const float each : sums) sum += each;
    return sum;
}

/// What all tests of scenes at rest measure: the complete frame by every algorithm.
std::vector<double> complete_frames(const std::string& name, const std::vector<mesh>& objects) {
    const scene body = paper::scene_of(objects);
    const embree_pixels peer{objects};
    const orthographic_camera camera = paper::over_the_slice();
    std::vector<float> theirs, recursive, packets;
    peer.trace(embree_pixels::rays::single, embree_pixels::shade::intensities, theirs);
    peer.trace(embree_pixels::rays::recursive, embree_pixels::shade::intensities, recursive);
    peer.trace(embree_pixels::rays::packets, embree_pixels::shade::intensities, packets);
    paper::frames<> beams, slice;
    beams(paper::rays, body);
    slice(paper::slices, body);
    compare(name + ", Embree hit by hit", recursive, theirs);
    compare(name + ", Embree's packets", packets, theirs);
    compare(name + ", beams", beams.lines.values, theirs);
    compare(name + ", slice", slice.lines.values, theirs);
    compare(name + ", pixels", trace_pixels(exec::par_unseq, body, probe, at, model, frame).values, theirs);
    return milliseconds_of(
        {{"Embree hit by hit",
          [&] { peer.trace(embree_pixels::rays::recursive, embree_pixels::shade::intensities, recursive); }},
         {"Embree", [&] { peer.trace(embree_pixels::rays::single, embree_pixels::shade::intensities, theirs); }},
         {"Embree packets",
          [&] { peer.trace(embree_pixels::rays::packets, embree_pixels::shade::intensities, packets); }},
         {"pixels", [&] { trace_pixels(exec::par_unseq, body, probe, at, model, frame, camera); }},
         {"beams", [&] { beams(paper::rays, body); }},
         {"slice", [&] { slice(paper::slices, body); }}});
}
const std::vector<std::string> complete_curves{
    "Embree, hit by hit", "Embree, filter", "Embree, packets", "pixels", "beams", "slice"};

std::vector<double> frames_without_intensities(const std::vector<mesh>& objects) {
    const scene body = paper::scene_of(objects);
    const embree_pixels peer{objects};
    std::vector<float> theirs;
    paper::frames<crossings_only> beams, slice;
    return milliseconds_of(
        {{"Embree", [&] { peer.trace(embree_pixels::rays::single, embree_pixels::shade::crossings, theirs); }},
         {"Embree packets", [&] { peer.trace(embree_pixels::rays::packets, embree_pixels::shade::crossings, theirs); }},
         {"beams", [&] { beams(paper::rays, body); }},
         {"slice", [&] { slice(paper::slices, body); }}});
}

/// Every vertex moves before each frame; rays refit the tree first, slices need none.
std::vector<double> moving_frames(const mesh& cube) {
    const std::vector<vec3>& rest = cube.positions;
    embree_pixels rebuilt{{cube}, RTC_BUILD_QUALITY_MEDIUM}, refitted{{cube}, RTC_BUILD_QUALITY_REFIT};
    scene refitted_scene = paper::scene_of({cube}), treeless = paper::scene_of({cube});
    std::vector<float> theirs;
    paper::frames<> own;
    const auto peer = [&](embree_pixels& body) {
        return contender{"Embree",
                         [&] {
                             body.update();
                             body.trace(embree_pixels::rays::packets, embree_pixels::shade::intensities, theirs);
                         },
                         [&, number = 0U]() mutable {
                             paper::deform({body.positions(), rest.size()}, rest, ++number);
                         }};
    };
    const auto ours = [&](scene& body, straight_lines how) {
        return contender{
            "ours",
            [&, how] {
                body.update(exec::par_unseq);
                own(how, body);
            },
            [&, number = 0U]() mutable { paper::deform(body.positions(body.objects()[0].id), rest, ++number); }};
    };
    contender check[] = {peer(rebuilt), peer(refitted), ours(refitted_scene, paper::rays),
                         ours(treeless, paper::slices)};
    std::vector<float> first;
    for (contender& one : check) {
        one.prepare();
        one.work();
        const bool by_peer = one.name == "Embree";
        if (first.empty()) first = theirs;
        compare("test 1d", by_peer ? theirs : own.lines.values, first);
    }
    return milliseconds_of({check[0], check[1], check[2], check[3]});
}

/// Test 2, no tree: every ray asks every triangle. So slow that only one of so many rays is traced and the time
/// multiplied; the slice is measured whole.
std::vector<double> frames_without_tree(const mesh& cube) {
    const scene body = paper::scene_of({cube});
    const mesh_view triangles{cube};
    const auto crossings_along = [&](const ray& r) {
        const sheared_ray prepared{r};
        std::size_t met = 0;
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const float distance = intersect(prepared, triangles[i]).distance;
            met += distance >= 0 && distance <= r.max_distance;
        }
        return met;
    };
    const auto one_in = [&](std::size_t rays) {
        return std::max<std::size_t>(1, rays * triangles.size() / 20'000'000);
    };
    const std::size_t pixels = std::size_t{probe.lines} * frame.samples;
    const std::size_t pixel_step = one_in(2 * pixels), beam_step = std::min<std::size_t>(64, one_in(probe.lines));
    std::vector<std::size_t> met(pixels);
    paper::frames<> slice;
    paper::frames<crossings_only> cut;
    std::vector<double> found =
        milliseconds_of({{"pixels",
                          [&] {
                              exec::for_each_index(exec::par, pixels / pixel_step, [&](std::size_t i) {
                                  const std::size_t pixel = i * pixel_step;
                                  const float depth = (static_cast<float>(pixel % frame.samples) + 0.5F) * 0.1_mm;
                                  const ray line =
                                      detail::world_beam(probe, at, static_cast<float>(pixel / frame.samples));
                                  const vec3 point = line.at(depth);
                                  met[i] = crossings_along({point, -line.direction, 0, depth}) +
                                           crossings_along({point, line.direction, 0, model.reflection_length});
                              });
                          }},
                         {"beams",
                          [&] {
                              exec::for_each_index(exec::par, probe.lines / beam_step, [&](std::size_t i) {
                                  ray line = detail::world_beam(probe, at, static_cast<float>(i * beam_step));
                                  line.max_distance = frame.depth;
                                  met[i] = crossings_along(line);
                              });
                          }},
                         {"slice", [&] { slice(paper::slices, body); }},
                         {"slice, b", [&] { cut(paper::slices, body); }}});
    found[0] *= static_cast<double>(pixel_step);
    found[1] *= static_cast<double>(beam_step);
    return found;
}

} // namespace

int main(int count, char** arguments) {
    const std::string folder = count > 1 ? arguments[1] : ".";
    if (count > 2) seconds_a_row = std::atof(arguments[2]);
    std::printf("%s\n", bench::table::circumstances().c_str());

    test whole{"Test 1a, complete", "triangles", complete_curves};
    test crossings{
        "Test 1b, without intensities", "triangles", {"Embree, filter", "Embree, packets", "beams", "slice"}};
    test primary{"Test 1c, without secondary rays", "triangles", {"Embree, filter", "Embree, packets", "pixels"}};
    test moving{"Test 1d, every vertex moves", "triangles", {"Embree, rebuilt", "Embree, refitted", "beams", "slice"}};
    test treeless{"Test 2, no tree", "triangles", {"pixels", "beams", "slice", "slice, without intensities"}};
    for (std::uint32_t subdivisions = 0; subdivisions <= 8; ++subdivisions) {
        const std::vector<mesh> cube = paper::one_cube(subdivisions);
        whole.add(static_cast<double>(cube[0].faces.size()), complete_frames("test 1a", cube));
    }
    for (std::uint32_t subdivisions = 0; subdivisions <= 8; ++subdivisions) {
        const std::vector<mesh> cube = paper::one_cube(subdivisions);
        crossings.add(static_cast<double>(cube[0].faces.size()), frames_without_intensities(cube));
    }
    float sum = 0;
    for (std::uint32_t subdivisions = 0; subdivisions <= 8; ++subdivisions) {
        const embree_pixels peer{paper::one_cube(subdivisions)};
        std::vector<float> theirs;
        primary.add(
            12.0 * std::pow(4.0, subdivisions),
            milliseconds_of(
                {{"Embree", [&] { peer.trace(embree_pixels::rays::single, embree_pixels::shade::none, theirs); }},
                 {"Embree packets",
                  [&] { peer.trace(embree_pixels::rays::packets, embree_pixels::shade::none, theirs); }},
                 {"pixels", [&] { sum += primary_rays(paper::over_the_slice()); }}}));
    }
    if (!is_finite(sum)) return 1;
    for (std::uint32_t subdivisions = 0; subdivisions <= 8; ++subdivisions) {
        const mesh cube = paper::one_cube(subdivisions)[0];
        moving.add(static_cast<double>(cube.faces.size()), moving_frames(cube));
    }
    for (std::uint32_t subdivisions = 0; subdivisions <= 8; ++subdivisions) {
        const mesh cube = paper::one_cube(subdivisions)[0];
        treeless.add(static_cast<double>(cube.faces.size()), frames_without_tree(cube));
    }
    test behind{"Test 3, cubes behind one another", "cubes", complete_curves};
    test beside{"Test 4, separate cubes", "cubes", complete_curves};
    for (std::uint32_t cubes = 1; cubes <= 64; cubes *= 2)
        behind.add(cubes, complete_frames("test 3", paper::behind_one_another(cubes)));
    for (std::uint32_t cubes = 1; cubes <= 64; cubes *= 2)
        beside.add(cubes, complete_frames("test 4", paper::beside_one_another(cubes)));

    whole.write(folder + "/test_1a.dat");
    crossings.write(folder + "/test_1b.dat");
    primary.write(folder + "/test_1c.dat");
    moving.write(folder + "/test_1d.dat");
    treeless.write(folder + "/test_2.dat");
    behind.write(folder + "/test_3.dat");
    beside.write(folder + "/test_4.dat");
    draw(folder);
}
