#ifndef INSONIFY_EXAMPLES_NERVE_BLOCK_PHANTOM_HPP
#define INSONIFY_EXAMPLES_NERVE_BLOCK_PHANTOM_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/examinations.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/scene/scene.hpp>
#include <string>

/// A procedural phantom of a limb for a nerve block.
///
///     scene body = nerve_block_phantom().build(exec::par);
///     image seen = b_mode(exec::par_unseq, body, nerve_block::probe, pose{}, nerve_block::settings);
///
/// World coordinates are those of a probe at `pose{}`: x lateral, y along the limb, z depth, with the skin 0.4 mm below
/// the face under a film of gel. Structures run along y and vary smoothly: the probe can slide by 20 mm to either side.
namespace nerve_block {

using namespace insonify;

inline const linear_array probe = presets::nerve_block.probe;
inline const b_mode_settings settings = presets::nerve_block.settings;
inline constexpr vec2 nerve_centre{3_mm, 17.5_mm}; ///< x, z at y = 0
inline constexpr vec2 bone_centre{11_mm, 36_mm};
inline constexpr float bone_radius = 8_mm;

/// A closed surface along the limb: `section(y, turn)` is the point {x, z} of its outline for turn from 0 to 1, from
/// the left along the side towards the probe, then back along the other side.
/// @param around  number of vertices of an outline, even
template <class Section>
mesh make_along_limb(float from, float to, std::uint32_t rings, std::uint32_t around, const Section& section) {
    mesh body;
    for (std::uint32_t ring = 0; ring <= rings; ++ring) {
        const float y = from + (to - from) * static_cast<float>(ring) / static_cast<float>(rings);
        for (std::uint32_t i = 0; i < around; ++i) {
            const vec2 point = section(y, (static_cast<float>(i) + 0.5F) / static_cast<float>(around));
            body.positions.push_back({point.x, y, point.y});
        }
    }
    const auto add_quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        body.faces.insert(body.faces.end(), {{a, b, c}, {a, c, d}});
    };
    for (std::uint32_t ring = 0; ring < rings; ++ring)
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t a = ring * around + i, b = ring * around + (i + 1) % around;
            add_quad(a, a + around, b + around, b);
        }
    const std::uint32_t last = rings * around; // the ends: quads between the upper and the lower side
    for (std::uint32_t i = 0; i + 1 < around / 2; ++i) {
        const std::uint32_t across = around - 1 - i;
        add_quad(i, i + 1, across - 1, across);
        add_quad(last + across, last + across - 1, last + i + 1, last + i);
    }
    return body;
}

/// Smooth waves across and along the limb, -1 to 1; lengths in metres, phase in turns.
inline float wave(float x, float y, float across, float along, float phase) {
    return std::sin(2 * pi * (x / across + phase)) * std::cos(2 * pi * (y / along + 0.37F * phase));
}

/// A smooth step from 0 to 1 at `middle`.
inline float step(float x, float middle, float width) { return 0.5F + 0.5F * std::tanh((x - middle) / width); }

/// Depths of the layers' boundaries in metres at (x, y).
inline float skin_top(float x, float y) { return 0.4_mm + 0.05_mm * wave(x, y, 26_mm, 60_mm, 0.2F); }
inline float fat_top(float x, float y) { return skin_top(x, y) + 1.4_mm + 0.1_mm * wave(x, y, 17_mm, 40_mm, 0.6F); }
inline float fascia_top(float x, float y) {
    return 7.1_mm + 1.5_mm * step(x, -2_mm, 5_mm) + 0.35_mm * wave(x, y, 21_mm, 70_mm, 0.1F) +
           0.12_mm * wave(x, y, 8_mm, 30_mm, 0.8F);
}
inline float upper_muscle_top(float x, float y) {
    return fascia_top(x, y) + 0.5_mm + 0.1_mm * wave(x, y, 15_mm, 25_mm, 0);
}
inline float upper_muscle_bottom(float x, float y) {
    return 19.8_mm + 3.4_mm * step(x, 1_mm, 7_mm) + 0.2_mm * wave(x, y, 19_mm, 50_mm, 0.5F);
}
inline float lower_muscle_top(float x, float y) {
    return upper_muscle_bottom(x, y) + 0.55_mm + 0.15_mm * wave(x, y, 23_mm, 30_mm, 0.3F);
}

inline constexpr float half_length = 30_mm; ///< of the phantom along the limb

/// A layer between two depths, `half_width` to either side.
template <class Top, class Bottom>
mesh make_layer(float half_width, const Top& top, const Bottom& bottom) {
    return make_along_limb(-half_length, half_length, 12, 80, [&](float y, float turn) -> vec2 {
        const float x = half_width * (turn < 0.5F ? 4 * turn - 1 : 3 - 4 * turn);
        return {x, turn < 0.5F ? top(x, y) : bottom(x, y)};
    });
}

/// A round cord along the limb, slightly winding.
struct cord {
    vec2 centre{};    ///< x, z at y = 0
    vec2 radii{};     ///< across, in depth
    vec2 drift{};     ///< amplitude of the centre's displacement
    float phase = 0;  ///< of the displacement, in turns
    float corner = 0; ///< fraction of the radius by which three edges protrude from an ellipse
    float length = 2 * half_length;
    std::uint32_t around = 48;

    vec2 centre_at(float y) const {
        const float turn = 2 * pi * (y / 60_mm + phase);
        return centre + drift * (vec2{std::sin(turn), std::sin(1.7F * turn)} -
                                 vec2{std::sin(2 * pi * phase), std::sin(3.4F * pi * phase)});
    }
    mesh surface() const {
        return make_along_limb(-0.5F * length, 0.5F * length, 24, around, [&](float y, float turn) {
            const float angle = 2 * pi * turn;
            const vec2 outwards{-std::cos(angle), -std::sin(angle)};
            return centre_at(y) + radii * (1 + corner * std::sin(3 * angle)) * outwards;
        });
    }
};

/// The lumens of its vessels.
inline constexpr cord artery{.centre = {-9_mm, 17_mm}, .radii = {3.1_mm, 3.1_mm}, .drift = {0.8_mm, 0.3_mm}},
    vein{.centre = {-15.6_mm, 16.4_mm}, .radii = {2.2_mm, 1.4_mm}, .drift = {0.6_mm, 0.4_mm}, .phase = 0.3F};

/// A nerve: hypoechoic fascicles in hyperechoic connective tissue, in a sheath (the "honeycomb").
inline void add_nerve(scene& body) {
    constexpr medium sheath{1075, 1630, 1.2_dB_per_cm, 1, 2.2F * tissue::nerve.backscatter, 20_um};
    constexpr medium between{1065, 1610, 1.0_dB_per_cm, 1, 1.5F * tissue::nerve.backscatter, 10_um};
    constexpr medium fascicle{1065, 1605, 1.0_dB_per_cm, 1, 0.35F * tissue::nerve.backscatter, 10_um};
    const cord outside{.centre = nerve_centre, .radii = {3.25_mm, 3.1_mm}, .drift = {0.5_mm, 0.3_mm}};
    cord nerve = outside;
    nerve.radii -= 0.3_mm;
    nerve.length -= 0.5_mm;
    body.add(outside.surface(), sheath, {.priority = 1, .name = "epineurium"});
    body.add(nerve.surface(), between, {.priority = 1, .name = "nerve"});
    const float pitch = 1.16_mm;
    std::uint64_t drawn = 0;
    for (int row = -2; row <= 2; ++row)
        for (int column = -2; column <= 2; ++column) {
            const vec2 from_centre{pitch * (static_cast<float>(column) + 0.5F * static_cast<float>(row & 1)),
                                   0.866F * pitch * static_cast<float>(row)};
            if (length(from_centre) > 2.45_mm) continue;
            const float radius = 0.32_mm + 0.1_mm * hash_uniform(7, drawn++);
            cord one = nerve;
            one.centre += from_centre;
            one.radii = {radius, 0.92F * radius};
            one.length -= 1_mm;
            one.around = 16;
            body.add(one.surface(), fascicle, {.priority = 1, .name = "fascicle"});
        }
}

/// The pose of the needle: its tip at a point, advancing to the right, its bevel towards the skin.
/// @param down   angle to the skin, radians
/// @param aside  angle to the slice plane, radians
inline pose needle_at(vec3 tip, float down, float aside) {
    const vec3 advance{std::cos(down) * std::cos(aside), -std::sin(aside), std::sin(down) * std::cos(aside)};
    return insonify::needle_pose(tip, advance, {std::sin(down), 0, -std::cos(down)});
}

/// Its pose in the phantom: the tip at the nerve, within a degree of the slice plane of a probe at `pose{}`.
inline pose needle_pose() { return needle_at({0, 0, 15.3_mm}, 22_deg, 1_deg); }

} // namespace nerve_block

/// The phantom: gel, skin, fat with its fasciae, two muscles, bone, artery, vein, nerve and needle. Call `build` on it.
///
/// Each layer extends to the bottom of the phantom; of nested objects the smaller one gives the medium. Objects inside
/// the muscles have priority 1, the needle 2.
inline insonify::scene nerve_block_phantom() {
    using namespace nerve_block;
    scene body{tissue::muscle};
    const auto below = [](float bottom) { return [bottom](float, float) { return bottom; }; };
    body.add(make_layer(33_mm, below(-20_mm), below(5_mm)), tissue::gel, {.priority = -1, .name = "gel"});
    body.add(make_layer(32_mm, skin_top, below(52_mm)), tissue::skin, {.name = "skin"});
    body.add(make_layer(31_mm, fat_top, below(51_mm)), tissue::fat, {.name = "fat"});
    body.add(make_layer(30_mm, fascia_top, below(50_mm)), tissue::fascia, {.name = "fascia"});
    body.add(make_layer(29_mm, upper_muscle_top, upper_muscle_bottom), tissue::muscle,
             {.name = "upper muscle", .fibres = {1, 0, 0.05F}});
    body.add(make_layer(29_mm, lower_muscle_top, below(49_mm)), tissue::muscle,
             {.name = "lower muscle", .fibres = {1, 0, -0.13F}});

    const auto add_vessel = [&](const cord& lumen, float wall, const std::string& name) {
        cord outer = lumen;
        outer.radii += wall;
        outer.length += 2 * wall;
        body.add(outer.surface(), tissue::vessel_wall, {.priority = 1, .name = name + " wall"});
        body.add(lumen.surface(), tissue::blood, {.priority = 1, .name = name});
    };
    add_vessel(artery, 0.4_mm, "artery");
    add_vessel(vein, 0.25_mm, "vein");
    add_nerve(body);
    const cord bone{
        .centre = bone_centre, .radii = vec2{bone_radius}, .drift = {0.8_mm, 0.6_mm}, .corner = 0.02F, .around = 80};
    body.add(bone.surface(), tissue::bone, {.priority = 1, .name = "bone"});
    body.add(
        make_needle(needle_diameter(22), 60_mm), tissue::steel,
        {.priority = 2, .at = needle_pose(), .name = "needle", .crease_angle = 12_deg}); // its bevel has an edge at 15
    return body;
}

#endif
