// No legal picture divides by zero or makes a NaN on its way: either would stop this program.
#include <insonify/insonify.hpp>
#include <cfenv>
#include <cmath>
#include <cstdio>
#include <limits>

using namespace insonify;

namespace {

bool trapping() {
#if defined(__GLIBC__)
    return feenableexcept(FE_INVALID | FE_DIVBYZERO) != -1;
#else
    return false;
#endif
}

template <class Policy, transducer Probe>
void draw(const Policy& policy, scene& body, const Probe& probe, const pose& at) {
    const acquisition scan{.depth = 50_mm, .samples = 1024, .planes = 3};
    const image picture = b_mode(policy, body, probe, at, {.depth = 50_mm, .size = {128, 128}});
    trace(policy, body, probe, at, physical{}, scan, paths{});
    trace(policy, body, probe, at, physical{}, scan, paths{{.face_reflection = 0.3F}});
    trace(policy, body, probe, at, physical{}.with_scattering(poisson_scatterers{}), scan,
          straight_lines{line_search::rays});
    const scan_lines lines = trace(policy, body, probe, at, law2011{.band = law2011::band::after}, scan,
                                   straight_lines{line_search::slices});
    const label_settings labels{.depth = 50_mm, .samples = 256, .grid = label_settings::depth_grid::displayed};
    ground_truth(policy, body, probe, at, labels);
    const image flat = scan_convert(policy, lines, probe, {.size = {64, 64}});
    const scan_map map = make_scan_map(policy, probe, {.depth = 50_mm, .samples = 1024}, {.size = {64, 64}});
    progressive mean;
    mean.add(policy, radial_blur(policy, flat, probe, map), at);
    map_grey(policy, add_noise(policy, picture, make_noise(policy, picture.size)), {.gamma = 0.8F, .contrast = 0.5F});
    envelope(policy, to_rf(policy, trace(policy, body, probe, at, physical{}, {.depth = 50_mm, .samples = 4096}),
                           probe.frequency));
    diagnose(body, probe, at, scan);
}

} // namespace

int main() {
    if (!trapping()) {
        std::puts("this system's floating point does not trap: nothing is tested");
        return 0;
    }
    scene body{tissue::muscle};
    body.add(make_box({-10_mm, -10_mm, 0}, {10_mm, 10_mm, 10_mm}), tissue::fat); // the probe stands on its face
    body.add(make_sphere({0, 0, 25_mm}, 8_mm, 4), tissue::bone);
    body.add(make_cylinder({-8_mm, -20_mm, 12_mm}, {-8_mm, 20_mm, 12_mm}, 3_mm, 32), tissue::blood);
    body.add(make_cylinder({10_mm, 0, 0}, {10_mm, 0, 40_mm}, 1_mm, 16), tissue::steel, {.priority = 1});
    body.add(make_box({-15_mm, -5_mm, 30_mm}, {-12_mm, 5_mm, 30.0005_mm}), tissue::air);
    body.build(exec::par);
    const pose aslant = look_at({3_mm, 1_mm, -2_mm}, {0, 0, 30_mm}, {1, 0.1F, 0});
    for (const pose& at : {pose{}, aslant}) {
        draw(exec::seq, body, linear_array{.lines = 32}, at);
        draw(exec::par_unseq, body, linear_array{.lines = 32}, at);
        draw(exec::par_unseq, body, convex_array{.lines = 33}, at);
        draw(exec::par_unseq, body, phased_array{.lines = 32}, at);
        draw(exec::par_unseq, body, radial_array{.lines = 32, .frequency = 5_MHz}, at);
        trace_pixels(exec::par_unseq, body, linear_array{.lines = 32}, at, law2011{}, {.depth = 50_mm, .samples = 128});
    }
    const mesh sphere = make_sphere({0, 0, 0}, 1, 4);
    const bvh tree{exec::par, sphere};
    const std::vector<ray> afar(64, {.origin = {1e20F, 0, -5}, .direction = {0, 0, 1}}); // farther than floats can tell
    std::vector<hit> hits(afar.size());
    tree.closest(exec::par, afar, hits);
    if (tree.any(afar[0]) || tree.closest(afar[0]) || hits[0]) {
        std::puts("a ray that passes far away has met something");
        return 1;
    }
    const mesh box = make_box({-1, -1, -1}, {1, 1, 1}, 3);
    const bvh of_box{exec::par, box};
    std::vector<ray> along_sides; // side by side, so that whole packets see faces edge on
    for (int i = 0; i < 256; ++i)
        along_sides.push_back({.origin = {static_cast<float>(i % 64 - 32) / 32, static_cast<float>(i / 64 - 1), -3}});
    along_sides[70].max_distance = std::numeric_limits<float>::infinity();
    along_sides[100].max_distance = std::numeric_limits<float>::quiet_NaN();
    hits.resize(along_sides.size());
    of_box.closest(exec::par_unseq, along_sides, hits);
    for (std::size_t i = 0; i < hits.size(); ++i)
        if (hits[i] != of_box.closest(along_sides[i]) || (i / 64 == 1 && i % 64 > 0 && i != 100 && !hits[i])) {
            std::puts("rays along the sides of a box get something else together than alone");
            return 1;
        }
    body.update(exec::par);
    scene nothing{tissue::fat};
    draw(exec::seq, nothing.build(exec::seq), linear_array{.lines = 1}, pose{});
    std::puts("no division by zero and no NaN on the way to any picture");
}
