#ifndef INSONIFY_TESTS_PICTURES_PHANTOMS_HPP
#define INSONIFY_TESTS_PICTURES_PHANTOMS_HPP

#include <insonify/insonify.hpp>
#include "../../examples/nerve_block_phantom.hpp"
#include "../../examples/quality_phantom.hpp"

/// Eight pictures of 256 x 256 that between them use every probe, tracer and acoustic model.
namespace pictures {

using namespace insonify;

inline constexpr uvec2 size{256, 256};
inline constexpr b_mode_settings::noise_level silent{
    .level_db = no_level_db}; // of electronic noise: what tissue and sound make

struct phantom {
    const char* name;
    image (*draw)();
};

// The paper's cube of bone in muscle, by its own model and pixel by pixel.
inline image paper_cube() {
    scene body{tissue::muscle};
    body.add(make_box({-10_mm, -10_mm, 9.2137_mm}, {10_mm, 10_mm, 29.2137_mm}, 3), tissue::bone);
    body.build(exec::par);
    const linear_array probe{.lines = 256, .width = 40_mm, .frequency = 5_MHz};
    const scan_lines lines =
        trace_pixels(exec::par_unseq, body, probe, pose{}, law2011{}, {.depth = 40_mm, .samples = 256});
    return scan_convert(exec::par_unseq, lines, probe, {.size = size});
}

// By the transducer's own pulse and aperture, finer than those of a scanner in use.
inline image nerve_block() {
    const linear_array probe{
        .lines = 256, .width = 38_mm, .frequency = 7.5_MHz, .focus = 18_mm, .elevation_focus = 18_mm};
    b_mode_settings settings = ::nerve_block::settings;
    settings.size = size;
    settings.noise = silent;
    return b_mode(exec::par_unseq, nerve_block_phantom().build(exec::par), probe, pose{}, settings);
}

// Cysts and grey targets of known strength.
inline image quality_targets() {
    const linear_array probe{.lines = 192};
    return b_mode(exec::par_unseq, quality_phantom(probe, 1).build(exec::par), probe,
                  {.translation = {0, quality::targets_at, 0}}, {.depth = 50_mm, .size = size, .noise = silent});
}

// A lumpy organ with a vessel, from outside.
inline image organ() {
    mesh lumps = make_sphere({0, 0, 70_mm}, 40_mm, 4);
    for (vec3& p : lumps.positions) p.z += 3_mm * std::sin(150 * p.x) * std::cos(120 * p.y);
    scene body{tissue::fat};
    body.add(std::move(lumps), tissue::liver);
    body.add(make_cylinder({-30_mm, -30_mm, 75_mm}, {30_mm, 30_mm, 65_mm}, 6_mm, 48), tissue::blood);
    const convex_array probe{.lines = 128, .radius = 60_mm, .field_of_view = 60_deg, .frequency = 3.5_MHz};
    return b_mode(exec::par_unseq, std::move(body).build(exec::par), probe, pose{},
                  {.depth = 130_mm, .size = size, .tgc = tissue::fat.attenuation, .noise = silent});
}

// Between ribs, which cast shadows.
inline image between_ribs() {
    scene body{tissue::muscle};
    for (const float x : {-25_mm, 0_mm, 25_mm})
        body.add(make_cylinder({x, -30_mm, 25_mm}, {x, 30_mm, 25_mm}, 5_mm, 48), tissue::bone);
    body.add(make_sphere({10_mm, 0, 70_mm}, 18_mm, 4), tissue::liver);
    const phased_array probe{.lines = 128, .width = 20_mm, .field_of_view = 80_deg, .frequency = 3_MHz};
    return b_mode(exec::par_unseq, std::move(body).build(exec::par), probe, pose{},
                  {.depth = 100_mm, .size = size, .noise = silent});
}

// A vessel from within.
inline image lumen() {
    scene body{tissue::fat};
    body.add(make_cylinder({0.3_mm, -10_mm, 0}, {0.3_mm, 10_mm, 0}, 2.6_mm, 96), tissue::vessel_wall);
    body.add(make_cylinder({0.3_mm, -10_mm, 0}, {0.3_mm, 10_mm, 0}, 2_mm, 96), tissue::blood);
    return b_mode(exec::par_unseq, std::move(body).build(exec::par), radial_array{}, pose{},
                  {.depth = 5_mm, .size = size, .tgc = tissue::fat.attenuation, .noise = silent});
}

// A needle whose metal rings, by paths.
inline image needle() {
    medium smooth_steel = tissue::steel;
    smooth_steel.roughness = 0;
    scene body{tissue::muscle};
    body.add(make_cylinder({0, -20_mm, 12_mm}, {0, 20_mm, 12_mm}, 0.6_mm, 192), smooth_steel);
    body.add(make_box({-20_mm, -20_mm, 30_mm}, {20_mm, 20_mm, 31_mm}), tissue::fascia);
    body.build(exec::par);
    const linear_array probe{.lines = 192, .width = 20_mm, .frequency = 7.5_MHz, .focus = 12_mm};
    const iq_lines echoes = trace(exec::par_unseq, body, probe, pose{}, physical<>{}, {.depth = 25_mm, .samples = 1024},
                                  paths{{.bounces = 12}});
    scan_lines lines = envelope(exec::par_unseq, convolve(exec::par_unseq, echoes, pulse{}, probe));
    lines = log_compress(exec::par, tgc(exec::par, std::move(lines), probe.frequency, {.attenuation = 100}));
    return scan_convert(exec::par, lines, probe, {.size = size});
}

// Tissue pressed by the probe to nine tenths of its depth.
inline image pressed() {
    scene body{tissue::fat};
    body.add(make_box({-30_mm, -30_mm, 8_mm}, {30_mm, 30_mm, 60_mm}, 3), tissue::muscle);
    body.add(make_cylinder({0, -30_mm, 22_mm}, {0, 30_mm, 22_mm}, 4_mm, 64), tissue::nerve);
    body.build(exec::par);
    body.deform(exec::par, [](vec3 rest) { return vec3{rest.x, rest.y, 0.9F * rest.z}; });
    return b_mode(exec::par_unseq, body, linear_array{.lines = 192}, pose{},
                  {.depth = 40_mm, .size = size, .tgc = tissue::fat.attenuation, .noise = silent});
}

inline constexpr phantom all[] = {{"paper_cube", paper_cube},
                                  {"nerve_block", nerve_block},
                                  {"quality_targets", quality_targets},
                                  {"organ", organ},
                                  {"between_ribs", between_ribs},
                                  {"lumen", lumen},
                                  {"needle", needle},
                                  {"pressed", pressed}};

} // namespace pictures
#endif
