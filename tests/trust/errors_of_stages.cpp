// Covers tracing/plan/frame_plan.hpp.
#include "refusals.hpp"
#include <cstdint>
#include <doctest/doctest.h>
#include <limits>
#include <string>
#include <vector>

using namespace insonify;

namespace errors_test {
namespace {

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

const image square{{4, 4}};

} // namespace

TEST_CASE("settings of traces out of range are refused with a sentence") {
    const scene one = body();
    const auto with = [&](const acquisition& bad, const auto& model) {
        trace(exec::seq, one, probe, pose{}, model, bad);
    };
    check<usage_error>({
        {[&] { with({.depth = 0}, law2011{}); }, "trace: depth is 0 m; it must be from 1 nm to 10 m"},
        {[&] { trace(exec::seq, body(), linear_array{.frequency = 9e9F}, pose{}, law2011{}, {.depth = 9}); },
         "trace: a depth of 9 m at 9e+09 Hz is more than 2^24 wavelengths; lower the depth or the frequency"},
        {[&] { with({.depth = 1_mm, .samples = ~0U}, law2011{}); },
         "trace: 4 lines of 4294967295 samples are more than 2^28"},
        {[&] { with({.depth = 1_mm, .planes = 2}, law2011{}); }, "trace: `planes` is 2; it must be 1, 3, 5 or 7"},
        {[&] { with({.depth = 1_mm, .planes = 3}, flags{}); }, "samples of this model's type cannot be averaged"},
        {[&] { with(scan, physical{}.with_scattering(gaussian_field{.cell = 0})); }, "cell_field: `cell` must be"},
        {[&] { with(scan, physical<>{.texture_db = nan}); }, "physical: `texture_db` must be a finite number of dB"},
        {[&] { with(scan, physical<>{.shadow_floor_db = 3}); }, "physical: "},
        {[&] { poisson_numbers{.density = 0}.check(); }, "poisson"},
        {[&] { trace(exec::seq, one, probe, pose{}, physical{}, scan, paths{{.min_amplitude = 0}}); },
         "paths: `min_amplitude` must be above 0, at most 1, `face_reflection` from -1 to 1"},
        {[&] {
             orthographic_camera{.size = {0, 5}}.check();
         },
         "camera: size 0x5 has no pixels; it must be at least 1x1"},
        {[&] {
             orthographic_camera{.extent = {0, 1}}.check();
         },
         "camera: `extent` must be two finite lengths"},
        {[&] { perspective_camera{.field_of_view = 4}.check(); }, "camera: `field_of_view` must lie between 0 and 180"},
        {[&] { b_mode(exec::seq, one, probe, pose{}, {.tgc = -1}); },
         "b_mode: `tgc` must be finite and above 0, in dB/m at 1 MHz"},
    });
    check<geometry_error>({{[&] { orthographic_camera{.at = {.rotation = mat3{0}}}.check(); },
                            "camera: the pose is not a rigid transform"}});
}

TEST_CASE("signals and their settings out of range are refused with a sentence") {
    const iq_lines echoes{4, 64, 2_mm};
    iq_lines torn = echoes;
    torn.values.pop_back();
    scan_lines short_lines{4, 64, 2_mm};
    short_lines.values.pop_back();
    const auto squeeze = [](const auto& settings) { log_compress(exec::seq, scan_lines{}, settings); };
    const auto amplify = [](const auto& settings) { tgc(exec::seq, scan_lines{}, 5_MHz, settings); };
    check<usage_error>({
        {[&] { convolve(exec::seq, iq_lines{}, pulse{}, probe); },
         "convolve: the echoes must have as many lines as the probe, and a value for every sample"},
        {[&] {
             convolve(exec::seq, iq_lines{4, 64, 0}, pulse{}, probe);
         },
         "convolve: depth is 0 m; it must be from"},
        {[&] { convolve(exec::seq, echoes, pulse{}, probe, {.decimation = 7}); },
         "convolve: decimation is 7; it must be a divisor of the number of samples, 64"},
        {[&] {
             convolve(exec::seq, iq_lines{4, 8, 90_mm}, pulse{}, probe);
         },
         "convolve: the samples are too coarse"},
        {[&] { pulse{.cycles = 0}.check(5_MHz); }, "pulse: `cycles` must be finite and above 0"},
        {[&] { pulse{.burst = -1}.check(5_MHz); }, "pulse: `burst` must be a finite number of cycles"},
        {[&] { pulse{.frequency = nan}.check(5_MHz); }, "pulse: `frequency` must be finite and above 0"},
        {[&] { pulse{.frequency = 7_MHz}.check(5_MHz); }, "Hz; make them equal, or leave that of the pulse at 0"},
        {[&] { detail::make_lateral_kernel(probe, {.depth = 10_mm}); }, "make_lateral_kernel: `samples` is 0"},
        {[&] { envelope(exec::seq, short_lines); }, "envelope: 4 lines of 64 samples need as many values, not 255"},
        {[&] { to_rf(exec::seq, torn, 5_MHz); },
         "to_rf: the lines must have a depth above 0 and a value for every sample"},
        {[&] { to_rf(exec::seq, echoes, 0); }, "to_rf: the frequency must be finite and above 0"},
        {[&] {
             to_rf(exec::seq, iq_lines{1, 8, 90_mm}, 5_MHz);
         },
         "to_rf: RF needs four samples per cycle"},
        {[&] { squeeze(log_compress_settings{.dynamic_range_db = 0}); }, "log_compress: `dynamic_range_db` must be"},
        {[&] { squeeze(log_compress_settings{.gain_db = nan}); },
         "log_compress: `reference_db`, `gain_db` and `reject_db`"},
        {[&] { amplify(tgc_settings{.attenuation = -1}); },
         "tgc: `attenuation` and `max_db` must be finite and not negative"},
        {[&] {
             amplify(tgc_settings{.sliders = {0, nan}});
         },
         "tgc: `sliders` must be finite"},
        {[&] {
             amplify(tgc_settings{.curve = {{0.02F, 1}, {0.01F, 2}}});
         },
         "tgc: the points of `curve` must be finite"},
        {[&] { tgc(exec::seq, scan_lines{}, nan); }, "tgc: the frequency must be finite and not negative"},
        {[&] { persistence{1}; }, "persistence: the weight of the past must be at least 0 and below 1"},
        {[&] { add_electronic_noise(exec::seq, iq_lines{}, {.level_db = nan}); }, "add_electronic_noise: `level_db`"},
    });
}

TEST_CASE("pictures and their settings out of range are refused with a sentence") {
    const auto map_of = [](const acquisition& lines, const scan_convert_settings& settings) {
        return make_scan_map(exec::seq, linear_array{.lines = 4}, lines, settings);
    };
    const scan_map map = map_of(scan, {.size = {8, 8}});
    const image picture{{8, 8}};
    check<usage_error>({
        {[&] { map_of({.depth = 0, .samples = 1}, {}); }, "scan_convert: depth is 0 m; it must be from 1 nm to 10 m"},
        {[&] { map_of({.depth = 1, .samples = 1U << 30U}, {}); },
         "scan_convert: at most 2^23 lines and 2^23 samples a line"},
        {[&] { map_of(scan, {.background = nan}); }, "scan_convert: `background` must be finite"},
        {[&] {
             map_of(scan, {.size = {1U << 20U, 1U << 20U}});
         },
         "scan_convert: size 1048576x1048576 exceeds 16384 pixels a side; the field of view is "},
        {[&] { map_of({.depth = 8, .samples = 64}, {}); },
         "scan_convert: size 512x107790 exceeds 16384 pixels a side; depth is 8 m: did you mean 8_mm?"},
        {[&] {
             scan_convert(exec::seq, scan_lines{4, 0, 20_mm}, probe);
         },
         "scan_convert: the lines have no samples"},
        {[&] {
             make_scan_map(exec::seq, needle{}, scan, {.size = {9, 0}});
         },
         "scan_convert: the field of view has no width; give the number of rows"},
        {[&] {
             scan_convert(exec::seq, scan_lines{4, 63, 20_mm}, map);
         },
         "scan_convert: the number of lines, of samples or the depth differs from that of the map"},
        {[&] {
             scan_convert(exec::seq, label_lines{4, 63, 20_mm}, map);
         },
         "scan_convert: the number of lines, of samples or the depth differs from that of the map"},
        {[&] { radial_blur(exec::seq, square, probe, map); },
         "radial_blur: the image must have been made with this map"},
        {[&] { radial_blur(exec::seq, picture, probe, map, {.frames = 0}); },
         "radial_blur: `lines` must be finite and not negative"},
        {[&] {
             make_noise(exec::seq, {4, 4}, {.strength = 2});
         },
         "make_noise: `strength` must be from 0 to 1"},
        {[&] { add_noise(exec::seq, picture, square); }, "add_noise: the noise must have the size of the image"},
        {[&] { map_grey(exec::seq, square, {.gamma = 0}); }, "grey_map: `gamma` must be finite and above 0"},
        {[&] { map_grey(exec::seq, square, {.contrast = 2}); }, "grey_map: `contrast` must be from 0 to 1"},
        {[&] { write_png("a.png", image{}); }, "write_png: size 0x0 has no pixels; it must be at least 1x1"},
    });
}

TEST_CASE("numbers that are not finite are refused where they enter, also those of flow and of gain") {
    const float infinite = std::numeric_limits<float>::infinity();
    const scene one = body();
    const flow_lines flow{{4, 64, 20_mm}};
    const std::vector<vec2> echoes(256, vec2{1, 0});
    const image grey{{16, 16}};
    for (const float bad : {nan, infinite, -infinite}) {
        check<geometry_error>(
            {{[&] {
                  automatic_tgc(exec::seq, one, probe, {.translation = {0, bad, 0}}, 20_mm);
              },
              "automatic_tgc: the pose of the probe is not a rigid transform; make it with look_at"}});
        pressed_face low;
        low.skin[3][5] = bad;
        const std::string finite = "`left`, `right` and `skin` finite";
        const std::string spectrum = "spectrum_of: the prf and the largest velocity must be finite and above 0";
        const std::string picture = "doppler_picture: `min_power_db` and `min_velocity` must be finite";
        const std::string overlay = "colour_overlay: `power_range_db` must be above 0, `max_velocity` at least 0";
        check<usage_error>({
            {[&] { pressed_face{.left = bad}.check(); }, finite},
            {[&] { pressed_face{.right = bad}.check(); }, finite},
            {[&] { low.check(); }, finite},
            {[&] { spectrum_of(exec::seq, echoes, bad, 0.3F, 0, {}); }, spectrum},
            {[&] { spectrum_of(exec::seq, echoes, 4e3F, bad, 0, {}); }, spectrum},
            {[&] { spectrum_of(exec::seq, echoes, 4e3F, 0.3F, bad, {}); }, spectrum},
            {[&] { doppler_picture(exec::seq, flow, probe, {.min_power_db = bad}); }, picture},
            {[&] { doppler_picture(exec::seq, flow, probe, {.min_velocity = bad}); }, picture},
            {[&] { colour_overlay(exec::seq, grey, flow, probe, {.max_velocity = bad}); }, overlay},
            {[&] { colour_overlay(exec::seq, grey, flow, probe, {.power_range_db = bad}); }, overlay},
            {[&] { colour_overlay(exec::seq, grey, flow, probe, {.min_power_db = bad}); }, overlay},
            {[&] { colour_overlay(exec::seq, grey, flow, probe, {.min_velocity = bad}); }, overlay},
            {[&] { colour_overlay(exec::seq, grey, flow, probe, {.max_grey = bad}); }, overlay},
        });
    }
}

} // namespace errors_test
