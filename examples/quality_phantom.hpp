#ifndef INSONIFY_EXAMPLES_QUALITY_PHANTOM_HPP
#define INSONIFY_EXAMPLES_QUALITY_PHANTOM_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scene/scene.hpp>
#include <cmath>

/// A block of tissue-mimicking gel with things in it whose places and strengths are known, to measure a scanner by.
///
///     scene body = quality_phantom(probe, 1).build(exec::par);
///     image seen = b_mode(exec::par_unseq, body, probe, {.translation = {0, quality::targets_at, 0}}, {.depth = 50_mm});
///
/// Everything runs along y, the way that the probe slides: past wires, then cysts in two kinds of gel, then grey targets.
/// Points are {x, z} in the frame of the probe. All is given for scale 1, to be looked at 50 mm deep; for a deeper look
/// places, sizes and spacings are multiplied by the scale, but not the thickness of wires.
namespace quality {

using namespace insonify;

inline constexpr float wires_at = 0, cysts_at = 40_mm, targets_at = 80_mm; ///< y of the middle of each part
inline constexpr float part_length = 20_mm;                                ///< along y

/// Two wires; the spacing is from front to front.
struct wire_pair {
    vec2 middle{};
    float spacing = 0;
};
/// A cylinder of other gel.
struct target {
    vec2 centre{};
    float radius = 0;
    int level_db = 0; ///< echo against the gel around; a cyst has none
};

/// Steel, 0.1 mm thick; the places are those of their fronts. The first four, one below the other, stand aside a little,
/// for a straight beam does not bend around a wire.
inline constexpr float wire_radius = 0.05_mm;
inline constexpr vec2 wires[] = {{-2_mm, 10_mm},  {-1.5_mm, 20_mm}, {-1_mm, 30_mm}, {-0.5_mm, 40_mm},
                                 {-15_mm, 20_mm}, {-5_mm, 20_mm},   {5_mm, 20_mm},  {15_mm, 20_mm}};
inline constexpr vec2 focused_wire = wires[2];

/// Side by side across the beam. No spacing is between 0.7 and 1.41 of the beam's width, where neither can be asked for:
/// that two are seen, nor that one is.
inline constexpr wire_pair lateral_pairs[] = {
    {{2_mm, 30_mm}, 0.25_mm}, {{6.7_mm, 30_mm}, 0.6_mm}, {{9.5_mm, 30_mm}, 1_mm}, {{13_mm, 30_mm}, 2_mm}};
/// One behind the other along the beam, and to both sides of it by `stagger`, out of one another's shadow.
inline constexpr float stagger = 0.06_mm;
inline constexpr wire_pair axial_pairs[] = {
    {{-4.2_mm, 30_mm}, 0.1_mm}, {{-7.5_mm, 30_mm}, 0.25_mm}, {{-11_mm, 30_mm}, 0.5_mm}, {{-13.5_mm, 30_mm}, 1_mm}};

/// Without texture, in gel of 0.5 dB/(cm MHz) where x < 0, of 0.7 where x > 0.
inline constexpr target cysts[] = {{{-15_mm, 10_mm}, 1_mm}, {{-15_mm, 25_mm}, 2_mm}, {{-15_mm, 40_mm}, 3_mm},
                                   {{15_mm, 10_mm}, 1_mm},  {{15_mm, 25_mm}, 2_mm},  {{15_mm, 40_mm}, 3_mm}};
inline constexpr target targets[] = {
    {{-12_mm, 10_mm}, 2.5_mm, -6}, {{-4_mm, 10_mm}, 2.5_mm, -3},  {{4_mm, 10_mm}, 2.5_mm, 3},
    {{12_mm, 10_mm}, 2.5_mm, 6},   {{-12_mm, 25_mm}, 2.5_mm, -6}, {{-4_mm, 25_mm}, 2.5_mm, -3},
    {{4_mm, 25_mm}, 2.5_mm, 3},    {{12_mm, 25_mm}, 2.5_mm, 6},   {{-12_mm, 40_mm}, 2.5_mm, -6},
    {{-4_mm, 40_mm}, 2.5_mm, -3},  {{4_mm, 40_mm}, 2.5_mm, 3},    {{12_mm, 40_mm}, 2.5_mm, 6}};

/// A frame at a point of the part with wires: x across the beam that goes there, y along the wires, z along the beam.
template <transducer Probe>
pose on_beam(const Probe& probe, vec2 point) {
    const vec3 from{point.x, wires_at, point.y};
    return look_at(from, from + probe.beam(probe.locate(point).x).direction, {1, 0, 0});
}

} // namespace quality

/// The phantom, yet to be built, for a probe that stands at y = `quality::wires_at` and so on, and looks along z.
template <insonify::transducer Probe>
insonify::scene quality_phantom(const Probe& probe, float scale) {
    using namespace quality;
    medium gel = tissue::tmm_low;
    gel.roughness = 0; // it takes the shape of the wires that are cast in it, so that theirs counts
    scene body{gel};
    const vec3 half{0, 0.5F * part_length, 0};

    // Six sides: the one in front, half as wide as the wire is thick, faces the beam. Only a level side returns sound to
    // a focused aperture, and the sides of a rounder wire would fall between two rays.
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
