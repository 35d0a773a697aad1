#include <insonify/insonify.hpp>
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace insonify;

// Every sentence that the library throws, but for those about files, which tests/io checks.
namespace errors_test {
namespace {

struct refusal {
    std::function<void()> call{};
    std::string sentence{};
};

template <class Error>
void check(const std::vector<refusal>& refusals) {
    for (const refusal& one : refusals) {
        std::string said = "nothing";
        try {
            one.call();
        } catch (const Error& thrown) {
            said = thrown.what();
        } catch (const std::exception& other) {
            said = std::string{"another type: "} + other.what();
        }
        INFO("said: " << said);
        INFO("to be said: " << one.sentence);
        CHECK(said.find(one.sentence) != std::string::npos);
    }
}

const float nan = std::numeric_limits<float>::quiet_NaN();
const linear_array probe{.lines = 4};
const acquisition scan{.depth = 20_mm, .samples = 64};

scene body() {
    scene one{tissue::muscle};
    one.add(make_sphere({0, 0, 10_mm}, 4_mm, 1), tissue::bone, {.name = "bone"});
    one.build(exec::seq);
    return one;
}

struct flags { // a model whose samples cannot be averaged
    using sample_type = std::uint8_t;
    std::uint32_t samples(float, float) const { return 1; }
    void operator()(const auto&, const traced_line&, float, view<std::uint8_t>) const {}
};

struct needle { // a probe whose field has no width
    std::uint32_t lines = 1;
    float frequency = 5e6F;
    ray beam(float) const { return {}; }
    vec2 locate(vec2 point) const { return {0, point.y}; }
    void check() const {}
};

struct endless_range { // more primitives than a tree can hold
    std::size_t size() const { return std::size_t{1} << 31U; }
    triangle operator[](std::size_t) const { return {}; }
};

const image square{{4, 4}};

} // namespace

TEST_CASE("geometry that cannot be used is refused with a sentence") {
    mesh astray = make_box({0, 0, 0}, {1, 1, 1}), wild = astray;
    astray.faces[0].y = 99;
    wild.positions[2].x = nan;
    const mesh_view fewer{wild.positions, view<const uvec3>{wild.faces.data(), 3}};
    check<geometry_error>({
        {[&] {
             look_at({0, 0, 0}, {0, 0, 0}, {1, 0, 0});
         },
         "look_at: `from` and `towards` must be two different points"},
        {[&] {
             look_at({1e7F, 0, 0}, {0, 0, 0}, {1, 0, 0});
         },
         "within 1000 km of the origin"},
        {[&] {
             look_at({0, 0, 0}, {0, 0, 1}, {0, 0, 2});
         },
         "look_at: `lateral` is parallel to the line from `from`"},
        {[&] { scene{}.add(astray, tissue::fat, {.name = "a"}); },
         "object 'a': a face names vertex 99, but the mesh has 8"},
        {[&] { scene{}.add(wild, tissue::fat); }, "vertex 2 is not finite; repair the mesh (`validate` tells more)"},
        {[&] { scene{}.add({}, tissue::fat, {.at = {.rotation = mat3{2}}}); },
         "its pose is no rigid motion; scale the mesh"},
        {[&] {
             body().place(object_id{0}, {.translation = {nan, 0, 0}});
         },
         "place: the pose is no rigid motion"},
        {[&] { trace(exec::seq, body(), probe, {.rotation = mat3{0}}, law2011{}, scan); },
         "trace: the pose of the probe"},
        {[&] {
             (bvh{exec::seq, astray});
         },
         "bvh: a face names vertex 99"},
        {[&] {
             bvh_storage<mesh_view> tree;
             tree.build(exec::seq, mesh_view{wild});
             tree.refit(exec::seq, fewer);
         },
         "bvh: refit needs as many primitives as the tree was built over; call rebuild"},
        {[&] { subdivide(astray); }, "subdivide: face 0 names a vertex that is not there"},
        {[&] {
             make_box({0, 0, 0}, {1, 1, -1});
         },
         "along z must be above 0"},
        {[&] {
             make_sphere({nan, 0, 0}, 1, 1);
         },
         "every coordinate must be a number of metres within 1000 km"},
        {[&] {
             make_sphere({0, 0, 0}, 1, 11);
         },
         "at most 10 subdivisions, each makes four times as many triangles"},
        {[&] {
             make_sphere({1e6F, 0, 0}, 1e-3F, 3);
         },
         "vertices round to the same point"},
        {[&] {
             make_cylinder({0, 0, 0}, {0, 0, 1}, 1, 2);
         },
         "make_cylinder: it takes 3 to 1,000,000 segments"},
        {[&] {
             make_plane({0, 0, 0}, {0, 0, 0}, 1, 0.1F);
         },
         "make_plane: `normal` must be a direction"},
    });
}

TEST_CASE("settings of scenes and probes that make no sense are refused with a sentence") {
    scene unbuilt{tissue::fat}, waiting = body();
    unbuilt.add(make_box({0, 0, 0}, {1, 1, 1}), tissue::bone);
    waiting.positions(object_id{0});
    waiting.update(exec::seq, trees::wait);
    check<usage_error>({
        {[&] { (scene{{.density = -1}}); }, "scene: the background needs a density and a sound speed above 0"},
        {[&] { unbuilt.add({}, {.sound_speed = 0}); }, "its medium needs a density and a sound speed above 0"},
        {[&] { unbuilt.remove(object_id{7}); }, "scene: no object has the id 7"},
        {[&] { unbuilt.update(exec::seq); }, "scene: call build(policy) after the last add or remove"},
        {[&] { trace(exec::seq, unbuilt, probe, pose{}, law2011{}, scan); }, "scene: call build(policy)"},
        {[&] { trace_beams(exec::seq, waiting, probe, pose{}, law2011{}, scan); },
         "scene: the tree of object 'bone' waits; call update(policy) before tracing rays, or trace slices"},
        {[&] { linear_array{.lines = 0}.check(); }, "probe: `lines` must be at least 1"},
        {[&] { linear_array{.width = 0}.check(); }, "probe: `width` must be a number above 0, between 1e-9 and 1e12"},
        {[&] { linear_array{.frequency = nan}.check(); }, "probe: `frequency` must be a number above 0"},
        {[&] { linear_array{.focus = -1}.check(); }, "probe: `focus` must be a number above 0"},
        {[&] { convex_array{.field_of_view = 60}.check(); }, "convex_array: `field_of_view` is in radians"},
        {[&] { phased_array{.field_of_view = 90}.check(); }, "phased_array: `field_of_view` is in radians"},
        {[&] { beam_of(probe, 0); }, "beam_of: the depth of the picture must be from 1 nm to 1000 km"},
        {[&] { for_each_index(exec::par.threads(1025), 3, [](std::size_t) {}); }, "threads(n): n must be at most 1024"},
    });
}

TEST_CASE("settings of traces that make no sense are refused with a sentence") {
    const scene one = body();
    const auto with = [&](const acquisition& bad, const auto& model) {
        trace(exec::seq, one, probe, pose{}, model, bad);
    };
    path_estimate estimate;
    estimate.add(exec::seq, iq_lines{4, 8, 20_mm});
    check<usage_error>({
        {[&] { with({.depth = 0}, law2011{}); }, "trace: `depth` must be a number of metres, from 1 nm to 1000 km"},
        {[&] { with({.depth = 1e6F}, law2011{}); },
         "m is more than 2^24 wavelengths; give it in metres, such as 80_mm"},
        {[&] { with({.depth = 1_mm, .samples = ~0U}, law2011{}); },
         "trace: 4 lines of 4294967295 samples are more than 2^28"},
        {[&] { with({.depth = 1_mm, .planes = 2}, law2011{}); }, "trace: `planes` must be 1, 3, 5 or 7"},
        {[&] { with({.depth = 1_mm, .planes = 3}, flags{}); }, "samples of this model's type cannot be averaged"},
        {[&] { with(scan, physical{}.with_scattering(gaussian_field<>{.cell = 0})); }, "cell_field: `cell` must be"},
        {[&] { with(scan, physical<>{.texture_db = nan}); }, "physical: `texture_db` must be a finite number of dB"},
        {[&] { with(scan, physical<>{.shadow_floor_db = 3}); }, "physical: "},
        {[&] { with(scan, physical<>{.specular = {.power = -1}}); },
         "specular_return: `power` must be a finite number"},
        {[&] { poisson_numbers{.density = 0}.check(); }, "poisson"},
        {[&] { trace_paths(exec::seq, one, probe, pose{}, physical{}, scan, {.least_amplitude = 0}); },
         "trace_paths: `least_amplitude` and `rough_power` must be above 0, `face_reflection` within 1"},
        {[&] {
             estimate.add(exec::seq, iq_lines{4, 9, 20_mm});
         },
         "path_estimate: all frames must have the same lines"},
        {[&] {
             orthographic_camera{.size = {0, 5}}.check();
         },
         "camera: `size` must be at least 1 x 1 and at most 2^28"},
        {[&] { orthographic_camera{.at = {.rotation = mat3{0}}}.check(); }, "camera: its pose is no rigid motion"},
        {[&] {
             orthographic_camera{.extent = {0, 1}}.check();
         },
         "camera: `extent` must be two finite lengths"},
        {[&] { perspective_camera{.field_of_view = 4}.check(); }, "camera: `field_of_view` must lie between 0 and 180"},
        {[&] { b_mode(exec::seq, one, probe, pose{}, {.tgc = -1}); }, "b_mode: `tgc` must be a finite number of dB/m"},
    });
}

TEST_CASE("signals and their settings that make no sense are refused with a sentence") {
    const iq_lines echoes{4, 64, 2_mm};
    iq_lines torn = echoes;
    torn.values.pop_back();
    scan_lines short_lines{4, 64, 2_mm};
    short_lines.values.pop_back();
    const auto squeeze = [](const auto& settings) { log_compress(exec::seq, scan_lines{}, settings); };
    const auto amplify = [](const auto& settings) { tgc(exec::seq, scan_lines{}, 5_MHz, settings); };
    check<usage_error>({
        {[&] { convolve(exec::seq, iq_lines{}, pulse{}, probe); },
         "convolve: the echoes must have as many lines as the probe"},
        {[&] {
             convolve(exec::seq, iq_lines{4, 64, 0}, pulse{}, probe);
         },
         "convolve: the depth of the echoes must be from"},
        {[&] { convolve(exec::seq, echoes, pulse{}, probe, {.decimation = 7}); }, "convolve: `decimation` must divide"},
        {[&] {
             convolve(exec::seq, iq_lines{4, 8, 90_mm}, pulse{}, probe);
         },
         "convolve: the samples are too coarse"},
        {[&] { pulse{.cycles = 0}.check(5_MHz); }, "pulse: `cycles` must be a finite number above 0"},
        {[&] { pulse{.burst = -1}.check(5_MHz); }, "pulse: `burst` must be a finite number of cycles"},
        {[&] { pulse{.frequency = nan}.check(5_MHz); }, "pulse: `frequency` must be a finite number of hertz"},
        {[&] { pulse{.frequency = 7_MHz}.check(5_MHz); }, "Hz is not the probe's"},
        {[&] { make_lateral_kernel(probe, {.depth = 10_mm}); }, "make_lateral_kernel: `samples` must be stated"},
        {[&] { envelope(exec::seq, short_lines); },
         "envelope: the lines must have as many values as lines times samples"},
        {[&] { to_rf(exec::seq, torn, 5_MHz); }, "to_rf: the lines must have samples, and a depth above 0"},
        {[&] { to_rf(exec::seq, echoes, 0); }, "to_rf: the frequency must be a finite number of hertz above 0"},
        {[&] {
             to_rf(exec::seq, iq_lines{1, 8, 90_mm}, 5_MHz);
         },
         "to_rf: an oscillating signal needs four samples a cycle"},
        {[&] { squeeze(log_compress_settings{.dynamic_range_db = 0}); }, "log_compress: `dynamic_range_db` must be"},
        {[&] { squeeze(log_compress_settings{.gain_db = nan}); },
         "log_compress: `reference_db`, `gain_db` and `reject_db`"},
        {[&] { amplify(tgc_settings{.attenuation = -1}); }, "tgc: `attenuation` and `most_db` must be finite numbers"},
        {[&] {
             amplify(tgc_settings{.sliders = {0, nan}});
         },
         "tgc: `sliders` must be finite numbers of dB"},
        {[&] {
             amplify(tgc_settings{.curve = {{0.02F, 1}, {0.01F, 2}}});
         },
         "tgc: the points of `curve` must be finite"},
        {[&] { tgc(exec::seq, scan_lines{}, nan); }, "tgc: the frequency must be a finite number of hertz, 0 or more"},
        {[&] { persistence{1}; }, "persistence: the share of the past must be from 0 to below 1"},
        {[&] { add_electronic_noise(exec::seq, iq_lines{}, {.level_db = nan}); }, "add_electronic_noise: `level_db`"},
    });
}

TEST_CASE("pictures and their settings that make no sense are refused with a sentence") {
    const auto map_of = [](const acquisition& lines, const scan_convert_settings& settings) {
        return make_scan_map(exec::seq, linear_array{.lines = 4}, lines, settings);
    };
    const scan_map map = map_of(scan, {.size = {8, 8}});
    const image picture{{8, 8}};
    check<usage_error>({
        {[&] { map_of({.depth = 0, .samples = 1}, {}); }, "scan_convert: the lines need a depth from 1 nm to 1000 km"},
        {[&] { map_of({.depth = 1, .samples = 1U << 30U}, {}); },
         "scan_convert: at most 2^23 lines and 2^23 samples a line"},
        {[&] { map_of(scan, {.background = nan}); }, "scan_convert: `background` must be a finite grey"},
        {[&] {
             map_of(scan, {.size = {1U << 20U, 1U << 20U}});
         },
         "it must have at least 1 and at most 2^28 pixels"},
        {[&] {
             make_scan_map(exec::seq, needle{}, scan, {.size = {9, 0}});
         },
         "scan_convert: the field of view has no width; ask for a number of rows"},
        {[&] {
             scan_convert(exec::seq, scan_lines{4, 63, 20_mm}, map);
         },
         "scan_convert: lines, samples or depth differ"},
        {[&] {
             scan_convert(exec::seq, label_lines{4, 63, 20_mm}, map);
         },
         "scan_convert: lines, samples or depth differ"},
        {[&] { radial_blur(exec::seq, square, probe, map); },
         "radial_blur: the picture must have been made with this map"},
        {[&] { radial_blur(exec::seq, picture, probe, map, {.frames = 0}); },
         "radial_blur: `lines` must be a finite number"},
        {[&] {
             make_noise(exec::seq, {4, 4}, {.strength = 2});
         },
         "make_noise: `strength` must lie between 0 and 1"},
        {[&] { add_noise(exec::seq, picture, square); }, "add_noise: the noise must have the size of the picture"},
        {[&] { map_grey(exec::seq, square, {.gamma = 0}); }, "grey_map: `gamma` must be a finite number above 0"},
        {[&] { map_grey(exec::seq, square, {.contrast = 2}); }, "grey_map: `contrast` must be from 0 to 1"},
        {[&] { write_png("a.png", image{}); }, "it must have at least 1 and at most 2^28 pixels"},
    });
}

TEST_CASE("a tree says when it is asked for too much") {
    const mesh box = make_box({0, 0, 0}, {1, 1, 1});
    const bvh tree{exec::seq, box};
    const std::vector<ray> rays(3);
    std::vector<hit> hits(2);
    check<usage_error>({
        {[&] { tree.closest(exec::seq, rays, hits); }, "bvh: as many results as rays are needed"},
        {[&] {
             bvh_storage<endless_range> storage;
             storage.build(exec::seq, endless_range{});
         },
         "bvh: more than 2147483647 primitives in one tree; split them"},
    });
}

} // namespace errors_test
