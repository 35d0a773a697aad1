#ifndef INSONIFY_EXAMPLES_QUALITY_PHANTOM_HPP
#define INSONIFY_EXAMPLES_QUALITY_PHANTOM_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>

/// A quality assurance phantom: a block of tissue-mimicking gel with targets of known position and level.
///
///     scene body = quality_phantom(probe, 1).build(exec::par);
///     const pose at{.translation = {0, quality::targets_at, 0}};
///     image seen = b_mode(exec::par_unseq, body, probe, at, {.depth = 50_mm});
///
/// All targets are parallel to y, along which the probe slides: over wires, then cysts in two kinds of gel, then
/// grey-scale targets. Points are {x, z} in probe coordinates, for scale 1 and a depth of 50 mm. The scale multiplies
/// positions, sizes and spacings, but not the thickness of wires.
namespace quality {

using namespace insonify;

inline constexpr float wires_at = 0, cysts_at = 40_mm, targets_at = 80_mm; ///< y of the middle of each part
inline constexpr float part_length = 20_mm;                                ///< along y

/// Two wires; the spacing is from front to front.
struct wire_pair {
    vec2 middle{};
    float spacing = 0;
};
/// A cylinder of another gel.
struct target {
    vec2 centre{};
    float radius = 0;
    float level_db = 0; ///< relative to the gel around; cysts are anechoic
};

/// Steel, 0.1 mm thick; positions are those of their fronts. The first four are not exactly below one another, because
/// straight beams do not bend around wires.
inline constexpr float wire_radius = 0.05_mm;
inline constexpr vec2 wires[] = {{-2_mm, 10_mm},  {-1.5_mm, 20_mm}, {-1_mm, 30_mm}, {-0.5_mm, 40_mm},
                                 {-15_mm, 20_mm}, {-5_mm, 20_mm},   {5_mm, 20_mm},  {15_mm, 20_mm}};
inline constexpr vec2 focused_wire = wires[2];

/// Pairs across the beam. No spacing is within 0.7 to 1.41 beam widths, where it is undefined whether a pair is
/// resolved.
inline constexpr wire_pair lateral_pairs[] = {
    {{2_mm, 30_mm}, 0.25_mm}, {{6.7_mm, 30_mm}, 0.6_mm}, {{9.5_mm, 30_mm}, 1_mm}, {{13_mm, 30_mm}, 2_mm}};
/// Pairs along the beam, offset to both sides by `stagger` so that neither is in the shadow of the other.
inline constexpr float stagger = 0.06_mm;
inline constexpr wire_pair axial_pairs[] = {
    {{-4.2_mm, 30_mm}, 0.1_mm}, {{-7.5_mm, 30_mm}, 0.25_mm}, {{-11_mm, 30_mm}, 0.5_mm}, {{-13.5_mm, 30_mm}, 1_mm}};

/// Anechoic, in gel of 0.5 dB/(cm MHz) for x < 0 and 0.7 for x > 0.
inline constexpr target cysts[] = {{{-15_mm, 10_mm}, 1_mm}, {{-15_mm, 25_mm}, 2_mm}, {{-15_mm, 40_mm}, 3_mm},
                                   {{15_mm, 10_mm}, 1_mm},  {{15_mm, 25_mm}, 2_mm},  {{15_mm, 40_mm}, 3_mm}};
inline constexpr target targets[] = {
    {{-12_mm, 10_mm}, 2.5_mm, -6}, {{-4_mm, 10_mm}, 2.5_mm, -3},  {{4_mm, 10_mm}, 2.5_mm, 3},
    {{12_mm, 10_mm}, 2.5_mm, 6},   {{-12_mm, 25_mm}, 2.5_mm, -6}, {{-4_mm, 25_mm}, 2.5_mm, -3},
    {{4_mm, 25_mm}, 2.5_mm, 3},    {{12_mm, 25_mm}, 2.5_mm, 6},   {{-12_mm, 40_mm}, 2.5_mm, -6},
    {{-4_mm, 40_mm}, 2.5_mm, -3},  {{4_mm, 40_mm}, 2.5_mm, 3},    {{12_mm, 40_mm}, 2.5_mm, 6}};

/// Coordinates at a point of the wire section: x across the beam through it, y along the wires, z along the beam.
template <transducer Probe>
pose on_beam(const Probe& probe, vec2 point) {
    const vec3 from{point.x, wires_at, point.y};
    return look_at(from, from + probe.beam(probe.locate(point).x).direction, {1, 0, 0});
}

} // namespace quality

/// The phantom for a probe at y = `quality::wires_at`, `cysts_at` or `targets_at` that looks along z. Call `build` on
/// it.
template <insonify::transducer Probe>
insonify::scene quality_phantom(const Probe& probe, float scale) {
    using namespace quality;
    medium gel = tissue::tmm_low;
    gel.roughness = 0; // the wires are cast into the gel, so that their roughness counts
    scene body{gel};
    const vec3 half{0, 0.5F * part_length, 0};

    // Six sides, of which one faces the beam and is half as wide as the wire. The sides of a rounder wire would be
    // narrower than the spacing of rays, and only a side at normal incidence returns sound to a focused aperture.
    const vec3 to_front{0, 0, std::sqrt(0.75F) * wire_radius};
    const mesh wire = make_cylinder(to_front - half, to_front + half, wire_radius, 6);
    const auto add_wire = [&](vec2 point, vec3 aside) {
        const pose beam = on_beam(probe, scale * point);
        body.add(wire, tissue::steel, {.at = {beam.rotation, beam.point(aside)}, .name = "wire"});
    };
    for (const vec2 point : wires) add_wire(point, {0, 0, 0});
    for (const wire_pair& two : lateral_pairs)
        for (const float side : {-0.5F, 0.5F}) add_wire(two.middle, {side * scale * two.spacing, 0, 0});
    for (const wire_pair& two : axial_pairs)
        for (const float side : {-0.5F, 0.5F})
            add_wire(two.middle, {2 * side * stagger, 0, side * scale * two.spacing});

    const auto add_target = [&](const target& one, float y, const medium& inside, const char* name) {
        const vec3 centre = scale * vec3{one.centre.x, 0, one.centre.y} + vec3{0, y, 0};
        body.add(make_cylinder(centre - half, centre + half, scale * one.radius, 128), inside, {.name = name});
    };
    const vec3 middle{0, cysts_at, 0};
    body.add(make_box(middle - half - vec3{0, 0, scale * 10_mm}, middle + half + scale * vec3{60_mm, 0, 60_mm}),
             tissue::tmm_high, {.name = "0.7 dB/(cm MHz)"});
    for (const target& one : cysts) add_target(one, cysts_at, tissue::tmm_cyst, "cyst");
    for (const target& one : targets) {
        medium grey = gel;
        grey.backscatter *= amplitude_of_decibels(one.level_db);
        add_target(one, targets_at, grey, "target");
    }
    return body;
}

#endif
