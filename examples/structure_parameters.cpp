// The parameters of `structure`: for each, three pictures side by side, below, at and above its value in a tissue.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include "picture_strip.hpp"
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

using namespace insonify;

namespace {

constexpr std::uint32_t height = 120;

/// How a parameter is shown.
struct strip {
    std::string name{};                           ///< of the file
    medium tissue{};                              ///< has the value in the middle
    std::function<void(structure&, float)> set{}; ///< the parameter
    float values[3]{};                            ///< from left to right
    vec3 fibres{1, 0, 0};
    float depth = 18_mm;      ///< of the picture
    bool has_surface = false; ///< the tissue begins at a round surface
};

image picture_of(const medium& tissue, const strip& of) {
    const vec3 flat = of.fibres.y == 0 ? vec3{-of.fibres.z, 0, of.fibres.x} : vec3{0, 0, 1};
    medium around = tissue; // of the same impedance, so that the surface itself is not seen
    around.structure = structure{};
    scene body{of.has_surface ? around : tissue};
    if (of.has_surface)
        body.add(make_cylinder({0, -60_mm, 43_mm}, {0, 60_mm, 43_mm}, 40_mm, 192), tissue, {.fibres = of.fibres});
    else
        body.set_background_fibres(of.fibres, flat);
    body.build(exec::par);
    const linear_array probe = presets::in_use(
        linear_array{.lines = 160, .width = of.depth * 4 / 3, .frequency = 9_MHz, .focus = of.depth / 2});
    const float per_metre = tissue.attenuation * std::pow(9.0F, tissue.attenuation_power - 1); // at 9 MHz, over 9
    return b_mode(exec::par_unseq, body, probe, pose{},
                  {.depth = of.depth, .size = {0, height}, .reference_db = -30, .tgc = per_metre});
}

/// Mean absolute difference of brightness.
float difference(const image& a, const image& b) {
    float sum = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::fabs(a.pixels[i] - b.pixels[i]);
    return sum / static_cast<float>(a.pixels.size());
}

} // namespace

int main() {
    const vec3 across{0, 1, 0}, tilted{std::cos(20_deg), 0, std::sin(20_deg)};
    const medium &muscle = tissue::muscle, &fat = tissue::fat, &tendon = tissue::tendon, &nerve = tissue::nerve;
    medium clouded = muscle;
    clouded.structure.mottling.deviation_db = 8;
    medium layered = muscle;
    layered.structure.sheets.cell = {17_mm, 10_mm, 2_mm};
    using s = structure;
    const std::vector<strip> strips = {
        {"fill", muscle, [](s& of, float v) { of.sheets.fill = v; }, {0.1F, 0.64F, 1}},
        {"lattices", muscle, [](s& of, float v) { of.sheets.lattices = static_cast<std::uint32_t>(v); }, {1, 3, 5}},
        {"length", muscle, [](s& of, float v) { of.sheets.cell.x = v; }, {8_mm, 17_mm, 60_mm}},
        {"distance", muscle, [](s& of, float v) { of.sheets.cell.z = v; }, {1_mm, 2_mm, 4_mm}},
        {"thickness", muscle, [](s& of, float v) { of.sheets.thickness = v; }, {0.05_mm, 0.1_mm, 0.3_mm}},
        {"level", muscle, [](s& of, float v) { of.sheets.level_db = v; }, {11, 21, 31}},
        {"spread", muscle, [](s& of, float v) { of.sheets.spread_db = v; }, {0, 8.5F, 14}},
        {"turn", layered, [](s& of, float v) { of.sheets.turn = v; }, {0.05F, 0.8F, pi / 2}, across, 13_mm},
        {"bend", layered, [](s& of, float v) { of.sheets.bend = v; }, {0, 0.5F, 1}, across, 13_mm},
        {"tilt", muscle, [](s& of, float v) { of.sheets.tilt = v; }, {0, 0.04F, 0.2F}},
        {"waviness", muscle, [](s& of, float v) { of.sheets.waviness = v; }, {0.05F, 0.4F, 1}, tilted},
        {"diffuse", tendon, [](s& of, float v) { of.sheets.diffuse_db = v; }, {-60, -30, -15}, tilted},
        {"mottling", muscle, [](s& of, float v) { of.mottling.deviation_db = v; }, {0, 3.5F, 8}},
        {"mottling_size",
         clouded,
         [](s& of, float v) {
             of.mottling.size = v * vec3{2, 1, 1};
         },
         {1.5_mm, 4_mm, 10_mm}},
        {"grain", muscle, [](s& of, float v) { of.grain.deviation_db = v; }, {0, 1.8F, 8}},
        {"wave", muscle, [](s& of, float v) { of.wave = v; }, {0, 0.2_mm, 0.8_mm}},
        {"septa_distance", fat, [](s& of, float v) { of.septa.cell.z = v; }, {3_mm, 6.5_mm, 13_mm}},
        {"septa_level", fat, [](s& of, float v) { of.septa.level_db = v; }, {15, 25, 35}},
        {"bundles_size",
         nerve,
         [](s& of, float v) { of.bundles.spacing = v, of.bundles.diameter = v / 1.2F; },
         {0.7_mm, 1.2_mm, 2_mm},
         across,
         9_mm},
        {"bundles_level", nerve, [](s& of, float v) { of.bundles.level_db = v; }, {-6, -18, -40}, across, 9_mm},
        {"sheath_thickness",
         muscle,
         [](s& of, float v) { of.sheath.thickness = v; },
         {0.5_mm, 1_mm, 2_mm},
         {1, 0, 0},
         9_mm,
         true},
        {"sheath_level", muscle, [](s& of, float v) { of.sheath.level_db = v; }, {10, 24, 36}, {1, 0, 0}, 9_mm, true},
        {"sheath_insertion",
         muscle,
         [](s& of, float v) { of.sheath.insertion = v; },
         {0, 20_mm, 60_mm},
         {std::cos(20_deg), 0, std::sin(20_deg)},
         14_mm,
         true},
    };
    bool all_differ = true;
    for (const strip& of : strips) {
        image pictures[3];
        picture_strip side_by_side{height};
        for (int i = 0; i < 3; ++i) {
            medium tissue = of.tissue;
            of.set(tissue.structure, of.values[i]);
            pictures[i] = picture_of(tissue, of);
            side_by_side.add(pictures[i]);
        }
        write_png("structure_" + of.name + ".png", side_by_side.picture());
        const float low = difference(pictures[0], pictures[1]), high = difference(pictures[1], pictures[2]);
        std::printf("%-20s %.3f %.3f\n", of.name.c_str(), low, high);
        all_differ = all_differ && low > 0.01F && high > 0.01F;
    }
    return all_differ ? 0 : 1;
}
