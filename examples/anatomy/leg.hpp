#ifndef INSONIFY_EXAMPLES_ANATOMY_LEG_HPP
#define INSONIFY_EXAMPLES_ANATOMY_LEG_HPP

#include <insonify/examinations.hpp>
#include "builder.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace anatomy {

/// What varies from leg to leg: lengths in metres, angles in radians.
///
/// Sources of the ranges: femoral artery: Sandgren et al., J. Vasc. Surg. 1999 29:503. Origin of the deep femoral
/// artery: 40 +- 9 mm below the inguinal ligament (a high one is rarer), which lies about 20 mm above the crease:
/// Eur. J. Anat., computed tomography of a Turkish population. Pennation: Blazevich et al., J. Anat. 2006 209:289
/// (thigh); Chow et al., Eur. J. Appl. Physiol. 2000 82:236 (calf). The others: Standring, Gray's Anatomy, 41st
/// edition, and convention.
struct leg {
    float side = 0;
    float variant = 1;
    float resolution = 1;
    float size = 1;
    float skin = 1.6_mm;
    float fat = 6.5_mm;
    float muscle = 1;
    float bone = 31_mm;
    float artery = 8.6_mm;
    float wall = 0.75_mm;
    float division = 20_mm;
    float vein_width = 11.5_mm;
    float vein_height = 8_mm;
    float vein_gap = 0.7_mm;
    float vein_behind = 0;
    float nerve_width = 10_mm;
    float nerve_height = 3.6_mm;
    float nerve_gap = 1.3_mm;
    float thigh_pennation = 15_deg;
    float calf_pennation = 19_deg;
    float second_vein = 0;

    static const std::vector<member<leg>>& members() {
        using of = leg;
        static const std::vector<member<leg>> all{
            {"side", "", "side of the body: 0 left, 1 right", &of::side, 0, 1, true},
            {"variant", "", "number of the irregularities of all surfaces", &of::variant, 0, 65535, true},
            {"resolution", "", "the cells of all meshes are divided by it", &of::resolution, 0.3F, 2},
            {"size", "", "height over the usual one, 1.68 m: lengths without a parameter follow it", &of::size, 0.9F,
             1.1F},
            {"skin", "m", "thickness of the skin", &of::skin, 1.2_mm, 2.2_mm},
            {"fat", "m", "thickness of the subcutaneous fat of the thigh; the calf has 0.7 of it", &of::fat, 3_mm,
             16_mm},
            {"muscle", "", "girth within the fascia over its usual value", &of::muscle, 0.85F, 1.15F},
            {"bone", "m", "depth of the head of the femur below the fascia lata", &of::bone, 27_mm, 36_mm},
            {"artery", "m", "inner diameter of the common femoral artery", &of::artery, 6.5_mm, 11_mm},
            {"wall", "m", "thickness of its intima and media", &of::wall, 0.5_mm, 1.1_mm},
            {"division", "m", "distance of the origin of the deep femoral artery below the inguinal crease",
             &of::division, -10_mm, 40_mm},
            {"vein_width", "m", "inner width of the common femoral vein", &of::vein_width, 8_mm, 15_mm},
            {"vein_height", "m", "its inner height", &of::vein_height, 4_mm, 10_mm},
            {"vein_gap", "m", "gap between artery and vein", &of::vein_gap, 0.3_mm, 3_mm},
            {"vein_behind", "m", "by how much the vein is deeper than usual", &of::vein_behind, 0, 2_mm},
            {"nerve_width", "m", "width of the femoral nerve at the inguinal crease", &of::nerve_width, 7_mm, 13_mm},
            {"nerve_height", "m", "its height", &of::nerve_height, 2.4_mm, 4.6_mm},
            {"nerve_gap", "m", "gap between artery and nerve", &of::nerve_gap, 0.5_mm, 6_mm},
            {"thigh_pennation", "rad", "angle of the fibres of vastus lateralis to its aponeuroses",
             &of::thigh_pennation, 10_deg, 20_deg},
            {"calf_pennation", "rad", "angle of the fibres of gastrocnemius and soleus to the aponeuroses between them",
             &of::calf_pennation, 14_deg, 25_deg},
            {"second_vein", "", "anterior accessory saphenous vein: 0 none, 1 present", &of::second_vein, 0, 1, true},
        };
        return all;
    }
};

namespace detail {

/// A part of the leg: what surrounds its muscles, and how its own coordinates lie in the body.
///
/// Own coordinates: y towards the feet; z into the limb, 0 at the fascia where views begin (in front on the thigh,
/// behind on the calf); x so that transverse images are seen from the feet, on the left leg.
struct limb {
    swept shape{};            ///< the deep fascia of a leg of usual girth
    swept fascia{};           ///< the same of this leg: its outer surface
    float fascia_size = 0;    ///< its thickness, metres
    std::uint64_t seed = 0;   ///< of that thickness
    float fat = 0;            ///< thickness of the subcutaneous fat, metres
    bool from_behind = false; ///< z points to the front

    static constexpr float fascia_uneven = 0.7F, fascia_patch = 16_mm; ///< of its thickness

    /// The point of a swept surface at an angle around it: 0 where z is least, pi/2 towards x.
    static vec3 surface_point(const swept& of, float y, float angle, float grown = 0) {
        return of.point(of.at(y), angle - 0.5F * pi, grown);
    }
    static vec3 inward(const swept& of, float y, float angle) {
        const vec3 along = surface_point(of, y, angle + 0.02F) - surface_point(of, y, angle - 0.02F);
        return normalize(vec3{-along.z, 0, along.x});
    }
    /// The direction along a surface at an angle, towards the feet, and the normal into the limb.
    static std::pair<vec3, vec3> axes(const swept& of, float y, float angle) {
        const vec3 along = normalize(surface_point(of, y + 12_mm, angle) - surface_point(of, y - 12_mm, angle));
        const vec3 n = inward(of, y, angle);
        return {along, normalize(n - dot(n, along) * along)};
    }
    /// A section parallel to the fascia, for a leg of usual girth.
    section parallel(float y, float angle, float deep, float half_width, float half_thickness, float turned = 0) const {
        const vec3 n = inward(shape, y, angle), centre = surface_point(shape, y, angle) + deep * n;
        const section here = shape.at(y);
        const float radius = 0.5F * (here.half_width + here.half_thickness);
        return {y,
                {centre.x, centre.z},
                half_width,
                half_thickness,
                std::atan2(-n.x, n.z) + turned,
                1 / max(radius - deep, 12_mm)};
    }
    /// Depth below the fascia, which is uneven, metres.
    float depth(vec3 p) const {
        return -fascia.distance(p) - fascia_size * (1 + fascia_uneven * noise(seed, p, fascia_patch));
    }
};

/// A leg in the making. x points to the patient's left, y towards the feet, z to the back. y is 0 at the inguinal
/// crease. The thigh and the lower leg are two bodies, with the knee between them left out.
struct leg_builder : builder {
    const leg& of;
    limb thigh{}, calf{};
    float m = 1;                          ///< girth over its usual value
    float artery_depth = 0;               ///< of the centre of the femoral artery at the inguinal crease
    float vein_place = 0, vein_depth = 0; ///< x and z of that of the femoral vein
    swept nerve{};                        ///< femoral

    static constexpr float thigh_top = -46_mm, thigh_bottom = 226_mm, calf_top = -20_mm, calf_bottom = 208_mm;
    static constexpr float adventitia = 0.5_mm;
    static constexpr float reversing = 1.2F; ///< resistive index of the arteries of a resting leg: their flow reverses
    static constexpr float vastus_angle = 48_deg, gastrocnemius_angle = 32_deg; ///< of their views

    explicit leg_builder(const leg& parameters) : of{parameters}, m{parameters.muscle} {
        seed = 1000 * static_cast<std::uint64_t>(of.variant);
        thigh = {.shape = {.sections = {{thigh_top, {14_mm, 78_mm}, 84_mm, 78_mm},
                                        {0, {14_mm, 78_mm}, 84_mm, 78_mm},
                                        {90_mm, {10_mm, 75_mm}, 78_mm, 75_mm},
                                        {thigh_bottom, {6_mm, 69_mm}, 71_mm, 69_mm}},
                           .power = 2.2F,
                           .start = 1_mm,
                           .end = 1_mm},
                 .fascia_size = 0.42_mm,
                 .fat = of.fat};
        calf = {.shape = {.sections = {{calf_top, {0, 50_mm}, 53_mm, 50_mm},
                                       {20_mm, {0, 51_mm}, 54_mm, 51_mm},
                                       {60_mm, {0, 53.5_mm}, 56_mm, 53.5_mm},
                                       {110_mm, {0, 52.5_mm}, 55_mm, 52.5_mm},
                                       {160_mm, {0, 46_mm}, 48_mm, 46_mm},
                                       {calf_bottom, {0, 39_mm}, 40_mm, 39_mm}},
                          .power = 2.1F,
                          .start = 1_mm,
                          .end = 1_mm},
                .fascia_size = 0.32_mm,
                .fat = 0.7F * of.fat,
                .from_behind = true};
        for (limb* part : {&thigh, &calf}) {
            part->seed = seed + (part->from_behind ? 41U : 40U);
            part->fascia = part->shape;
            part->fascia.sections = scaled(part->shape.sections);
        }
        artery_depth = 4.2_mm * m + 0.53F * of.artery + of.wall + adventitia;
        const float w = 0.5F * of.vein_width, t = 0.5F * of.vein_height;
        vein_place = -(0.5F * of.artery + of.wall + adventitia + of.vein_gap + w);
        vein_depth = max(artery_depth, 1.3F * t + 4_mm);
        for (const float part : {-1.0F, -0.8F, -0.6F}) // beneath the fascia, which falls off to the side
            vein_depth = max(vein_depth, front(thigh.fascia, vein_place + 1.1F * part * w - 1.5_mm) +
                                             1.1F * t * std::sqrt(1 - part * part) + 2.5_mm);
        vein_depth += of.vein_behind;
    }

    /// z of a fascia at the inguinal crease, where it is nearest to the skin.
    static float front(const swept& fascia, float x) {
        const section here = fascia.at(0);
        const float part = clamp(std::fabs(x - here.centre.x) / here.half_width, 0, 1);
        return here.centre.y - here.half_thickness * std::pow(1 - std::pow(part, fascia.power), 1 / fascia.power);
    }

    float cell(float usual) const { return usual * max(m, 1) / of.resolution; } ///< as many of them in a large leg
    std::vector<section> scaled(std::vector<section> table) const {
        for (section& one : table) {
            one.centre *= m;
            one.half_width *= m;
            one.half_thickness *= m;
            one.bend /= m;
        }
        return table;
    }

    // From a part's own coordinates to those of the body.
    vec3 direction(const limb& part, vec3 v) const {
        if (part.from_behind) v = {-v.x, v.y, -v.z};
        return {of.side > 0 ? -v.x : v.x, v.y, v.z};
    }
    vec3 placed(const limb& part, vec3 p) const {
        constexpr vec3 calf_origin{20_mm, 460_mm, 125_mm};
        return direction(part, p) + (part.from_behind ? direction(thigh, calf_origin) : vec3{0});
    }
    mesh placed(const limb& part, mesh surface) const {
        for (vec3& p : surface.positions) p = placed(part, p);
        if (of.side > 0)
            for (uvec3& face : surface.faces) std::swap(face.y, face.z);
        return surface;
    }
    /// @param within  the name of the object in which it lies
    void add(const limb& part, mesh surface, const medium& inside, int priority, const std::string& name,
             const std::string& within, vec3 fibres = {0, 0, 0}) {
        builder::add(placed(part, std::move(surface)), inside, priority, name, within, direction(part, fibres));
    }
    const char* compartments(const limb& part) const {
        return part.from_behind ? "compartments of the calf" : "compartments of the thigh";
    }

    /// The fascia of a part from one place to another.
    static swept piece(const swept& whole, float from, float to) {
        swept made = whole;
        made.sections.clear();
        constexpr int count = 6;
        for (int i = 0; i <= count; ++i)
            made.sections.push_back(whole.at(from + (to - from) * static_cast<float>(i) / count));
        return made;
    }

    /// A surface with bumps.
    /// @param size  of a bump, metres
    static mesh uneven(mesh surface, float height, float size, std::uint64_t number) {
        std::vector<vec3> steps = vertex_normals(surface);
        for (std::size_t i = 0; i < steps.size(); ++i) steps[i] *= height * noise(number, surface.positions[i], size);
        return displaced(std::move(surface), std::move(steps));
    }
    /// The axis along the septa of fat for which they are parallel to the skin at an angle. The axis across them is the
    /// one in which an object is flattest, made orthogonal to this one; that of a part of a limb is nearly z.
    vec3 layers(const limb& part, float from, float to, float angle) const {
        const auto [along, n] = limb::axes(part.shape, 0.5F * (from + to), angle);
        // The principal axes of an oblique cylinder tilt by more than its line does.
        const float length_squared = (to - from + 2 * part.fat) * (to - from + 2 * part.fat) / 12;
        const float depth_squared =
            0.25F * std::pow(part.fascia.at(0.5F * (from + to)).half_thickness + part.fat, 2.0F);
        const float slope = (limb_axis(part, to - 3_mm).z - limb_axis(part, from + 3_mm).z) / (to - from - 6_mm);
        const vec3 flattest =
            normalize(vec3{0, -slope * length_squared / max(length_squared - depth_squared, 0.2F * length_squared), 1});
        const vec3 in_skin = flattest - dot(flattest, n) * n;
        return length(in_skin) > 0.2F ? in_skin : cross(along, n);
    }

    void add_skin() {
        const float coarse = min(cell(3.9_mm), 5_mm); // thin layers must not cut each other
        mesh gel, skin;
        std::uint64_t number = 1;
        for (const limb* part : {&thigh, &calf}) {
            swept outside = part->fascia;
            outside.start = outside.end = 2_mm;
            append(gel, placed(*part, outside.surface(2.2F * coarse, part->fat + of.skin + 7_mm)));
            append(skin, placed(*part,
                                uneven(outside.surface(coarse, part->fat + of.skin), 0.15_mm, 16_mm, seed + number++)));
        }
        made.anatomy.add(std::move(gel), tissue::gel, {.priority = -1000, .name = "gel"});
        made.anatomy.add(std::move(skin), tissue::skin, {.name = "skin", .fibres = {0, 1, 0}});
        made.nested.emplace_back("skin", "gel");

        const auto add_fat = [&](const limb& part, float from, float to, float angle, const std::string& name) {
            swept outside = piece(part.fascia, from, to);
            outside.start = outside.end = 2_mm;
            add(part, uneven(outside.surface(coarse, part.fat), 0.5_mm, 12_mm, seed + number++), media::limb::fat, 0,
                name, "skin", layers(part, from, to, angle));
        };
        add_fat(thigh, thigh_top + 1_mm, 130_mm, 0, "fat of the groin");
        add_fat(thigh, 62_mm, thigh_bottom - 1_mm, vastus_angle, "fat of the thigh");
        add_fat(calf, calf_top + 1_mm, calf_bottom - 1_mm, 0.5F * gastrocnemius_angle, "fat of the calf");
        for (const limb* part : {&thigh, &calf}) {
            const std::string name = part->from_behind ? "crural fascia" : "fascia lata";
            mesh outer = part->fascia.surface(coarse);
            mesh inner = grown(outer, -part->fascia_size, limb::fascia_uneven, limb::fascia_patch, part->seed);
            add(*part, std::move(outer), media::limb::fascia, 1, name, "skin");
            add(*part, std::move(inner), media::limb::loose_tissue, 1, compartments(*part), name, {0, 1, 0});
        }
    }

    /// Depth below the uneven layer between the fascia and the muscles.
    float depth_in_compartment(const limb& part, vec3 p, std::uint64_t number) const {
        return part.depth(p) - 0.05_mm - 0.1_mm * (1 + noise(number, p, 13_mm));
    }
    swept muscle(std::vector<section> table, std::uint64_t number, float power = 2.4F) const {
        return {.sections = scaled(std::move(table)),
                .power = power,
                .start = 7_mm,
                .end = 7_mm,
                .waves = 0.35_mm,
                .seed = seed + number};
    }
    /// @param top  float(vec3): depth below what covers it, besides the fascia
    template <class Depth>
    void add_muscle(const limb& part, const swept& shape, int priority, const std::string& name, vec3 fibres,
                    float size, const Depth& top) {
        mesh surface = confined(shape.surface(cell(size)), top, 0.2_mm);
        surface = confined(
            std::move(surface), [&](vec3 p) { return depth_in_compartment(part, p, shape.seed); }, 0.07_mm);
        add(part, std::move(surface), media::limb::muscle, priority, name, compartments(part), fibres);
    }
    void add_muscle(const limb& part, const swept& shape, int priority, const std::string& name,
                    vec3 fibres = {0, 1, 0}, float size = 2.8_mm) {
        add_muscle(part, shape, priority, name, fibres, size, [](vec3) { return 1.0F; });
    }
    /// A muscle with an aponeurosis on its deep side.
    /// @param thickness  of the aponeurosis, mean, metres
    void add_pennate(const limb& part, const swept& shape, int priority, const std::string& name, vec3 fibres,
                     float thickness) {
        const mesh belly = confined(
            shape.surface(cell(2.7_mm)), [&](vec3 p) { return depth_in_compartment(part, p, shape.seed); }, 0.1_mm);
        std::vector<vec3> steps = vertex_normals(belly);
        constexpr float rest = 0.03_mm; // on its other sides
        for (std::size_t i = 0; i < steps.size(); ++i) {
            const vec3 p = belly.positions[i], here = limb_axis(part, p.y);
            const float to_end = min(p.y - shape.sections.front().along, shape.sections.back().along - p.y);
            const float deep = ramp(dot(steps[i], normalize(here - p)), 0.2F, 0.9F) * ramp(to_end, 1_mm, 9_mm);
            steps[i] *= rest + deep * thickness * (1 + 0.6F * noise(shape.seed, p, 7_mm));
        }
        add(part, displaced(belly, std::move(steps)), media::limb::aponeurosis, priority, name + ": aponeurosis",
            compartments(part));
        add(part, belly, media::limb::muscle, priority, name, name + ": aponeurosis", fibres);
    }
    static vec3 limb_axis(const limb& part, float y) {
        const section here = part.fascia.at(y);
        return {here.centre.x, y, here.centre.y};
    }
    /// The direction of fibres that descend into a limb at an angle.
    static vec3 pennate(const limb& part, float y, float angle, float pennation) {
        return vec3{0, std::cos(pennation), 0} + std::sin(pennation) * limb::inward(part.shape, y, angle);
    }

    /// Depth of the fascia iliaca below the fascia lata: it covers the iliopsoas and the femoral nerve, and passes
    /// beneath the vessels.
    float iliac_depth(float x, float y) const {
        const float r = 0.5F * of.artery + of.wall + adventitia;
        const float lateral = 10.2_mm * m + 0.05F * max(x - 14_mm, 0),
                    medial = max(artery_depth + r + 1.6_mm, vein_depth + 0.5F * of.vein_height + 2.2_mm);
        const float side = ramp(x, r - 6.5_mm, r + 4_mm);
        return medial + side * (lateral - medial) + 0.1F * max(y, 0) + 0.35_mm * noise(seed + 50, {x, y, 0}, 11_mm);
    }

    void add_thigh_muscles() {
        const auto at = [&](float y, float angle, float deep, float w, float t, float turned = 0) {
            return thigh.parallel(y, angle, deep, w, t, turned);
        };
        const float top = thigh_top + 4_mm, bottom = thigh_bottom - 4_mm;
        add_muscle(thigh,
                   muscle({{top, {47_mm, 8_mm}, 13_mm, 5.5_mm, 0.2F, 6},
                           {0, {36_mm, 5_mm}, 15_mm, 5.2_mm, 0.08F, 8},
                           {50_mm, {14_mm, 4.6_mm}, 16_mm, 5_mm, 0, 8},
                           {100_mm, {-10_mm, 6_mm}, 16_mm, 5.5_mm, -0.2F, 10},
                           {150_mm, {-28_mm, 12_mm}, 16_mm, 6_mm, -0.55F, 12},
                           {bottom, {-46_mm, 29_mm}, 15_mm, 6.5_mm, -0.9F, 14}},
                          1),
                   9, "sartorius", {-0.42F, 1, 0});
        add_muscle(thigh,
                   muscle({{-36_mm, {37_mm, 17_mm}, 6_mm, 5_mm, 0, 0},
                           {0, {43_mm, 15.5_mm}, 10_mm, 6.5_mm, 0.1F, 4},
                           {50_mm, {36_mm, 12_mm}, 17_mm, 9_mm, 0.1F, 8},
                           {110_mm, {22_mm, 10.5_mm}, 21_mm, 10.5_mm, 0.04F, 9},
                           {170_mm, {13_mm, 10.5_mm}, 21_mm, 10.5_mm, 0.02F, 9},
                           {bottom, {10_mm, 9.5_mm}, 18_mm, 8.5_mm, 0, 9}},
                          2),
                   8, "rectus femoris");
        // Its central tendon, on which both halves of its fibres end.
        add(thigh,
            muscle({{-10_mm, {43_mm, 14_mm}, 3_mm, 0.5_mm, 1.2F, 60},
                    {60_mm, {33_mm, 11_mm}, 5_mm, 0.5_mm, 1.1F, 70},
                    {120_mm, {21_mm, 10_mm}, 5_mm, 0.4_mm, 1.0F, 70},
                    {165_mm, {13_mm, 11_mm}, 3_mm, 0.35_mm, 0.7F, 40}},
                   3, 2)
                .surface(cell(2_mm)),
            tissue::fascia, 8, "central tendon of rectus femoris", compartments(thigh));
        add_muscle(thigh,
                   muscle({at(top, 58_deg, 11_mm, 19_mm, 10_mm), at(40_mm, 55_deg, 9.5_mm, 19_mm, 9_mm),
                           at(105_mm, 62_deg, 5_mm, 13_mm, 5_mm)},
                          4),
                   7, "tensor fasciae latae");
        add_pennate(thigh,
                    muscle({at(22_mm, 62_deg, 22_mm, 15_mm, 7_mm), at(70_mm, 60_deg, 14_mm, 38_mm, 12_mm),
                            at(120_mm, 54_deg, 12.5_mm, 46_mm, 13_mm), at(170_mm, 52_deg, 12_mm, 46_mm, 12.5_mm),
                            at(bottom, 54_deg, 11_mm, 42_mm, 11_mm)},
                           5),
                    6, "vastus lateralis", pennate(thigh, 165_mm, vastus_angle, of.thigh_pennation), 0.4_mm);
        add_muscle(thigh,
                   muscle({{70_mm, {2_mm, 42_mm}, 8_mm, 6_mm, 0.8F, 0},
                           at(120_mm, -22_deg, 30_mm, 22_mm, 10_mm, -0.7F),
                           at(170_mm, -42_deg, 19_mm, 28_mm, 13_mm, -0.1F),
                           at(bottom, -40_deg, 15_mm, 33_mm, 15_mm)},
                          6),
                   5, "vastus medialis", {0.3F, 1, 0});
        add_muscle(thigh,
                   muscle({{46_mm, {42_mm, 40_mm}, 14_mm, 6_mm, 0.25F, 10},
                           {90_mm, {34_mm, 37_mm}, 32_mm, 14_mm, 0.3F, 22},
                           {170_mm, {24_mm, 36_mm}, 36_mm, 15_mm, 0.35F, 24},
                           {bottom, {20_mm, 33_mm}, 36_mm, 15_mm, 0.35F, 24}},
                          7),
                   4, "vastus intermedius", pennate(thigh, 165_mm, vastus_angle, -0.05F), 2.6_mm);
        add_muscle(thigh,
                   muscle({{top, {19_mm, 23_mm}, 29_mm, 13_mm, 0.05F, 6},
                           {0, {18_mm, 24.5_mm}, 27_mm, 14.5_mm, 0, 6},
                           {40_mm, {20_mm, 34_mm}, 19_mm, 14_mm, -0.1F, 0},
                           {82_mm, {22_mm, 50_mm}, 8_mm, 6_mm, 0, 0}},
                          8),
                   5, "iliopsoas", {-0.1F, 1, 0.1F}, 2.2_mm, [&](vec3 p) { return p.z - iliac_depth(p.x, p.y); });
        // Its tendon, in front of the head of the femur.
        add(thigh,
            swept{.sections = {{thigh_top + 6_mm, {9_mm, of.bone - 9_mm}, 3.5_mm, 1.6_mm, 0.1F, 0},
                               {0, {0.5_mm, of.bone - 4.2_mm}, 3.8_mm, 1.4_mm, 0.1F, 30},
                               {35_mm, {10_mm * m, 37_mm * m}, 3.5_mm, 2.2_mm, 0.3F, 0},
                               {70_mm, {18_mm * m, 46_mm * m}, 2.5_mm, 1.8_mm, 0.3F, 0}},
                  .power = 2,
                  .waves = 0.4_mm,
                  .seed = seed + 15}
                .surface(cell(1.8_mm)),
            tissue::tendon, 6, "tendon of iliopsoas", compartments(thigh), {-0.05F, 1, 0.06F});
        add_muscle(thigh,
                   muscle({{top, {-30_mm, 20_mm}, 21_mm, 9_mm, 0.1F, 4},
                           {0, {-24_mm, 26_mm}, 22_mm, 8.5_mm, 0.2F, 6},
                           {40_mm, {-8_mm, 38_mm}, 19_mm, 8_mm, 0.5F, 4},
                           {85_mm, {10_mm, 54_mm}, 10_mm, 5_mm, 0.5F, 0}},
                          9),
                   4, "pectineus", {0.5F, 1, 0.3F});
        add_muscle(thigh,
                   muscle({{-34_mm, {-43_mm, 27_mm}, 9_mm, 6_mm, -0.4F, 0},
                           {15_mm, {-35_mm, 25_mm}, 17_mm, 9.5_mm, -0.3F, 10},
                           {70_mm, {-25_mm, 33_mm}, 24_mm, 9.5_mm, 0.3F, 10},
                           {130_mm, {-14_mm, 48_mm}, 22_mm, 8_mm, 0.6F, 4},
                           {200_mm, {6_mm, 62_mm}, 9_mm, 5_mm, 0.6F, 0}},
                          10),
                   3, "adductor longus", {0.35F, 1, 0.25F});
        // Out of the views: they fill the thigh.
        const float large = 4.5_mm;
        add_muscle(thigh,
                   muscle({{top, {-44_mm, 62_mm}, 28_mm, 36_mm, 0, 0},
                           {90_mm, {-32_mm, 72_mm}, 42_mm, 30_mm, 0.25F, 0},
                           {bottom, {-24_mm, 74_mm}, 36_mm, 24_mm, 0.35F, 0}},
                          11),
                   2, "adductor magnus", {0, 1, 0}, large);
        add_muscle(thigh, muscle({at(top, -82_deg, 4_mm, 18_mm, 4_mm), at(bottom, -86_deg, 5_mm, 14_mm, 5_mm)}, 12), 3,
                   "gracilis", {0, 1, 0}, large);
        add_muscle(thigh,
                   muscle({{top, {20_mm, 125_mm}, 66_mm, 26_mm, 0, 0},
                           {90_mm, {16_mm, 115_mm}, 50_mm, 28_mm, 0, 0},
                           {bottom, {6_mm, 106_mm}, 48_mm, 28_mm, 0, 0}},
                          13),
                   2, "gluteus maximus and hamstrings", {0, 1, 0}, large);
        add_muscle(thigh,
                   muscle({{top, {68_mm, 64_mm}, 26_mm, 40_mm, 0, 0}, {60_mm, {64_mm, 74_mm}, 20_mm, 34_mm, 0, 0}}, 14),
                   2, "gluteus medius", {0, 1, 0}, large);
    }

    void add_femur() {
        const float deeper = of.bone - 31_mm;
        const auto at = [&](float x, float y, float z, float r) {
            return tube_section{{x * m, y, z * m + deeper}, vec2{r}};
        };
        constexpr float head = 24_mm; // radius
        const vec3 centre{4_mm, -6_mm, of.bone + head};
        add(thigh,
            make_tube(smooth_line({{centre, vec2{head}},
                                   {centre + vec3{2.5_mm, 1.4_mm, 0.3_mm}, vec2{head - 0.15_mm}},
                                   {centre + vec3{9_mm, 5_mm, 1_mm}, vec2{head - 2.5_mm}},
                                   {centre + vec3{26_mm, 15_mm, 4_mm}, vec2{15_mm}},
                                   {centre + vec3{44_mm, 27_mm, 6_mm}, vec2{18_mm}}},
                                  cell(4_mm)),
                      {.segments = static_cast<std::uint32_t>(44 * of.resolution)}),
            tissue::bone, 14, "head and neck of the femur", compartments(thigh));
        add(thigh,
            make_tube(smooth_line({at(46_mm, 34_mm, 62_mm, 17_mm), at(40_mm, 60_mm, 60_mm, 15_mm),
                                   at(33_mm, 100_mm, 58.5_mm, 14_mm), at(25_mm, 165_mm, 56.5_mm, 14_mm),
                                   at(20_mm, thigh_bottom - 22_mm, 55_mm, 14.5_mm)},
                                  cell(5_mm)),
                      {.segments = static_cast<std::uint32_t>(40 * of.resolution)}),
            tissue::bone, 14, "femur", compartments(thigh));
    }

    void add_fascia_iliaca() {
        const auto columns = static_cast<std::uint32_t>(48 * of.resolution),
                   rows = static_cast<std::uint32_t>(18 * of.resolution);
        std::vector<sheet_point> points;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t column = 0; column < columns; ++column) {
                const float u = static_cast<float>(column) / static_cast<float>(columns - 1);
                const float v = static_cast<float>(row) / static_cast<float>(rows - 1);
                const float x = (-18_mm + 64_mm * u) * m, y = thigh_top + 5_mm + 100_mm * v;
                const float ends = ramp(u, 0, 0.3F) * ramp(1 - u, 0, 0.15F) * ramp(v, 0, 0.1F) * ramp(1 - v, 0, 0.3F);
                const float uneven = 1 + 0.6F * noise(seed + 51, {x, y, 0}, 5_mm);
                points.push_back({{x, y, iliac_depth(x, y)}, 0.08_mm + 0.27_mm * ends * uneven});
            }
        add(thigh, make_sheet(points, columns), media::limb::fascia, 10, "fascia iliaca", compartments(thigh));
    }

    /// A nerve: dark fascicles, as many as fit, in bright tissue.
    void add_nerve(const limb& part, const swept& shape, float pitch, int priority, const std::string& name,
                   const std::string& within, std::uint64_t number) {
        add(part, shape.surface(cell(1.2_mm)), tissue::epineurium, priority, name, within);
        const section& middle = shape.sections[shape.sections.size() / 2];
        const float rim = 0.5_mm;
        int count = 0;
        for (int row = -4; row <= 4; ++row)
            for (int column = -8; column <= 8; ++column) {
                const std::uint64_t own = number + static_cast<std::uint64_t>(100 * (row + 4) + column + 8);
                const auto drawn = [&](std::uint64_t i) { return hash_uniform(own, i) - 0.5F; };
                const float r = pitch * (0.37F + 0.26F * drawn(0));
                const vec2 place{
                    pitch * (static_cast<float>(column) + 0.5F * static_cast<float>(row & 1) + 0.5F * drawn(1)),
                    pitch * (0.86F * static_cast<float>(row) + 0.45F * drawn(2))};
                const vec2 room{middle.half_width - rim - 1.15F * r, middle.half_thickness - rim - 1.15F * r};
                if (!(min(room.x, room.y) > 0.05_mm) || length(place / room) > 1) continue;
                const vec2 fraction{place.x / middle.half_width, place.y / middle.half_thickness};
                swept fascicle = shape;
                fascicle.power = 2;
                fascicle.waves = 0.1F * r;
                fascicle.seed = own;
                for (section& one : fascicle.sections) {
                    const float c = std::cos(one.turn), s = std::sin(one.turn), k = one.bend;
                    const vec2 off{fraction.x * one.half_width,
                                   fraction.y * one.half_thickness +
                                       0.5F * k * fraction.x * fraction.x * one.half_width * one.half_width};
                    one.centre += vec2{c * off.x - s * off.y, s * off.x + c * off.y};
                    const float size =
                        min(one.half_width / middle.half_width, one.half_thickness / middle.half_thickness);
                    one.half_width = 1.12F * r * size;
                    one.half_thickness = 0.9F * r * size;
                    one.bend = 0;
                }
                fascicle = piece(fascicle, shape.sections.front().along + shape.start,
                                 shape.sections.back().along - shape.end);
                fascicle.start = fascicle.end = 2_mm;
                add(part, fascicle.surface(cell(1.1_mm)), tissue::nerve_fascicle, priority,
                    name + ": fascicle " + std::to_string(++count), name);
            }
    }

    void add_vessel(const limb& part, mesh lumen, const std::vector<wall_layer>& layers, int priority,
                    const std::string& name, std::uint64_t number, const std::string& within) {
        builder::add_vessel(placed(part, std::move(lumen)), layers, priority, name, number, within);
    }
    /// @param line  from the hip to the foot, in coordinates of the part, the first axes along x
    void flows(const limb& part, const std::string& name, vessel::kind type, const std::vector<tube_section>& line,
               float velocity) {
        std::vector<line_place> places = places_of(line, {1, 0, 0});
        for (line_place& one : places) {
            one.centre = placed(part, one.centre);
            one.first_axis = direction(part, one.first_axis);
        }
        if (type == vessel::kind::vein) std::reverse(places.begin(), places.end()); // towards the heart
        made.vessels.push_back({.name = name,
                                .type = type,
                                .line = sections_of(places),
                                .peak_velocity = velocity,
                                .resistive_index = reversing});
    }
    std::uint32_t segments(float usual) const { return static_cast<std::uint32_t>(usual * of.resolution); }

    void add_femoral_vessels() {
        const float r = 0.5F * of.artery, z = artery_depth;
        const auto round = [&](float x, float y, float deep, float radius) {
            return tube_section{{x, y, deep}, vec2{radius}};
        };
        const std::vector<wall_layer> fine{{"intima", tissue::intima, 0.28F * of.wall, 0.12F},
                                           {"media", tissue::tunica_media, 0.72F * of.wall, 0.15F},
                                           {"adventitia", media::limb::soft_adventitia, adventitia, 0.6F}};
        const auto wide = [&](float y) { return r * (1 - 0.2F * ramp(y, of.division - 5_mm, of.division + 12_mm)); };
        std::vector<tube_section> course{round(-3_mm, thigh_top + 10_mm, z - 0.3_mm, r), round(-1_mm, -20_mm, z, r),
                                         round(0, 0, z, wide(0))};
        for (const vec3 p : {vec3{-1_mm, 20_mm, 0.6_mm}, vec3{-3.5_mm, 42_mm, 2.2_mm}})
            course.push_back(round(p.x * m, p.y, z + p.z, wide(p.y)));
        for (const vec3 p : {vec3{-9_mm, 82_mm, 17_mm}, vec3{-16_mm, 125_mm, 25_mm}, vec3{-22_mm, 170_mm, 32_mm},
                             vec3{-26_mm, thigh_bottom - 10_mm, 38_mm}})
            course.push_back(round(p.x * m, p.y, p.z * m, wide(p.y)));
        const auto line = smooth_line(course, cell(3.8_mm));
        add_vessel(thigh, make_tube(line, {.segments = segments(36)}), fine, 20, "femoral artery", 300,
                   compartments(thigh));
        flows(thigh, "femoral artery", vessel::kind::artery, line, 0.9F);

        const float from = of.division, down = z + 0.5F * (max(from, 0) * 0.05F);
        const auto deep = smooth_line({round(0.2F * r, from - 3_mm, down + 0.2F * r, 0.6F * r),
                                       round(0.45F * r, from + 5_mm, down + 0.9F * r, 0.66F * r),
                                       round(0.9F * r, from + 16_mm, down + 1.8F * r, 0.64F * r),
                                       round(6_mm * m, from + 42_mm, down + 17_mm * m, 0.58F * r),
                                       round(6_mm * m, from + 90_mm, down + 29_mm * m, 0.5F * r)},
                                      cell(3_mm));
        add_vessel(thigh, make_tube(deep, {.segments = segments(28)}), fine, 20, "deep femoral artery", 310,
                   compartments(thigh));
        flows(thigh, "deep femoral artery", vessel::kind::artery, deep, 0.6F);

        const float w = 0.5F * of.vein_width, t = 0.5F * of.vein_height, x = vein_place;
        const auto oval = [&](float at, float y, float deep_at, float size) {
            return tube_section{{at, y, deep_at}, {w * size, t * size}, -0.12F};
        };
        const auto femoral = smooth_line(
            {oval(x - 1.5_mm, thigh_top + 9_mm, vein_depth, 1.05F),
             oval(x - 0.5_mm, -20_mm, vein_depth + 0.3_mm, 1.03F), oval(x, 0, vein_depth + 0.6_mm, 1),
             oval(0.92F * x - 1_mm, 22_mm, vein_depth + 2_mm, 0.95F),
             oval(0.7F * x - 4_mm, 45_mm, vein_depth + 6.5_mm, 0.85F), oval(-11_mm * m, 85_mm, 28_mm * m, 0.75F),
             oval(-15_mm * m, 125_mm, 35.5_mm * m, 0.72F), oval(-18_mm * m, 170_mm, 42_mm * m, 0.7F),
             oval(-21_mm * m, thigh_bottom - 12_mm, 48_mm * m, 0.7F)},
            cell(4_mm));
        const std::vector<wall_layer> thin{{"wall", tissue::vein_wall, 0.35_mm, 0.35F}};
        add_vessel(
            thigh,
            uneven(make_tube(femoral, {.segments = segments(32), .across = {1, 0, 0}}), 0.16F * t, 6_mm, seed + 325),
            thin, 17, "femoral vein", 320, compartments(thigh));
        flows(thigh, "femoral vein", vessel::kind::vein, femoral, 0.2F);

        // The great saphenous vein lies on the fascia lata, which it passes to join the femoral vein.
        const float high = min(1.5_mm, 0.27F * of.fat);
        const auto on = [&](float angle, float y, float size) {
            const vec3 p = limb::surface_point(thigh.fascia, y, angle, 0.45_mm + high * size);
            return tube_section{p, {min(1.9_mm, 1.7F * high) * size, high * size}};
        };
        const auto great = smooth_line({{{x - 0.5_mm, 9_mm, vein_depth + 1_mm - 0.3F * t}, vec2{min(high, 0.5F * t)}},
                                        {{x - 1_mm, 17_mm, 0.55F * (vein_depth - t)}, vec2{high}},
                                        on(-18_deg, 34_mm, 1.05F),
                                        on(-25_deg, 70_mm, 1),
                                        on(-40_deg, 120_mm, 0.95F),
                                        on(-60_deg, thigh_bottom - 14_mm, 0.9F)},
                                       cell(2.6_mm));
        const std::vector<wall_layer> faint{{"wall", tissue::vein_wall, 0.25_mm, 0.3F}};
        add_vessel(thigh, make_tube(great, {.segments = segments(20), .across = {1, 0, 0}}), faint, 15,
                   "great saphenous vein", 330, "skin");
        flows(thigh, "great saphenous vein", vessel::kind::vein, great, 0.1F);
        if (of.second_vein > 0) {
            const auto accessory = smooth_line(
                {on(-16_deg, 36_mm, 0.6F), on(-9_deg, 60_mm, 0.8F), on(-3_deg, 95_mm, 0.8F), on(8_deg, 150_mm, 0.7F)},
                cell(2.6_mm));
            add_vessel(thigh, make_tube(accessory, {.segments = segments(18), .across = {1, 0, 0}}), faint, 15,
                       "accessory saphenous vein", 340, "skin");
            flows(thigh, "accessory saphenous vein", vessel::kind::vein, accessory, 0.1F);
        }
    }

    void add_femoral_nerve() {
        const float w = 0.5F * of.nerve_width, t = 0.5F * of.nerve_height;
        const float beside = 0.5F * of.artery + of.wall + adventitia + of.nerve_gap + w;
        const auto at = [&](float y, float x, float width, float height) {
            const float slope = (iliac_depth(x + 0.7F * w, y) - iliac_depth(x - 0.7F * w, y)) / (1.4F * w);
            const float turn = clamp(std::atan(slope), -0.35F, 0.1F);
            float down = 0; // so that all of it is below the fascia
            for (int i = -2; i <= 2; ++i) {
                const float part = 0.45F * static_cast<float>(i), u = part * w * width;
                const float own = std::sin(turn) * u - std::sqrt(1 - part * part) * t * height;
                down = max(down, iliac_depth(x + u, y) + 0.3_mm - own);
            }
            return section{y, {x, down}, w * width, t * height, turn, 12};
        };
        nerve = {.sections = {at(thigh_top + 8_mm, beside + 2_mm, 0.8F, 1.15F),
                              at(-20_mm, beside + 0.5_mm, 0.95F, 1.05F), at(0, beside, 1, 1),
                              at(18_mm, beside + 0.5_mm, 1.1F, 0.85F), at(46_mm, beside + 1.5_mm, 1.05F, 0.55F)},
                 .power = 2,
                 .start = 4_mm,
                 .end = 8_mm,
                 .waves = 0.18_mm,
                 .seed = seed + 60};
        add_nerve(thigh, nerve, 1.5_mm, 13, "femoral nerve", compartments(thigh), seed + 6000);
    }

    void add_calf() {
        const auto at = [&](float y, float angle, float deep, float w, float t, float turned = 0) {
            return calf.parallel(y, angle, deep, w, t, turned);
        };
        const float top = calf_top + 4_mm, bottom = calf_bottom - 4_mm;
        const vec3 backwards = pennate(calf, 110_mm, gastrocnemius_angle, of.calf_pennation);
        add_pennate(calf,
                    muscle({at(top, 24_deg, 10_mm, 12_mm, 6_mm, 0.4F), at(20_mm, 30_deg, 8.5_mm, 20_mm, 7.5_mm),
                            at(60_mm, 34_deg, 9.5_mm, 29_mm, 9.5_mm), at(110_mm, 34_deg, 9_mm, 31_mm, 9.2_mm),
                            at(150_mm, 30_deg, 6.5_mm, 27_mm, 6.5_mm), at(192_mm, 22_deg, 2.5_mm, 15_mm, 1.6_mm)},
                           20),
                    7, "medial gastrocnemius", backwards, 0.4_mm);
        add_pennate(calf,
                    muscle({at(top, -26_deg, 9_mm, 12_mm, 6_mm, -0.4F), at(20_mm, -32_deg, 7.5_mm, 20_mm, 7_mm),
                            at(60_mm, -35_deg, 8.2_mm, 28_mm, 8.2_mm), at(110_mm, -34_deg, 7.5_mm, 29_mm, 7.6_mm),
                            at(145_mm, -30_deg, 4.5_mm, 24_mm, 4.5_mm), at(172_mm, -24_deg, 2_mm, 14_mm, 1.5_mm)},
                           21),
                    6, "lateral gastrocnemius", pennate(calf, 110_mm, -34_deg, 0.7F * of.calf_pennation), 0.35_mm);
        add_muscle(calf,
                   muscle({{10_mm, {-20_mm, 34_mm}, 10_mm, 6_mm, -0.3F, 0},
                           {50_mm, {-4_mm, 27_mm}, 38_mm, 13_mm, 0, 17},
                           {110_mm, {2_mm, 27_mm}, 43_mm, 14.5_mm, 0.02F, 18},
                           {155_mm, {2_mm, 20.5_mm}, 37_mm, 13.5_mm, 0, 18},
                           {bottom, {2_mm, 13_mm}, 26_mm, 12_mm, 0, 18}},
                          22),
                   5, "soleus", pennate(calf, 110_mm, gastrocnemius_angle, -of.calf_pennation), 2.5_mm);
        swept septum = muscle({{60_mm, {-2_mm, 29_mm}, 7_mm, 0.3_mm, -0.25F, 20},
                               {110_mm, {6_mm, 29.5_mm}, 9_mm, 0.25_mm, 0.3F, 10},
                               {160_mm, {2_mm, 21_mm}, 8_mm, 0.25_mm, -0.1F, 16}},
                              28, 2);
        septum.waves = 0.1_mm; // it is half a millimetre thick
        add(calf, septum.surface(cell(2.2_mm)), media::limb::aponeurosis, 5, "septum of soleus", compartments(calf));
        add_muscle(calf,
                   muscle({{20_mm, {20_mm, 50_mm}, 8_mm, 5_mm, 0.1F, 0},
                           {80_mm, {22_mm, 50_mm}, 13_mm, 8_mm, 0.35F, 8},
                           {bottom, {20_mm, 33_mm}, 10_mm, 8_mm, 0.2F, 0}},
                          23),
                   4, "flexor digitorum longus");
        add_muscle(calf,
                   muscle({{10_mm, {-8_mm, 52_mm}, 12_mm, 7_mm, 0, 0},
                           {80_mm, {-3_mm, 53.5_mm}, 17_mm, 10.5_mm, 0, 0},
                           {bottom, {2_mm, 38_mm}, 14_mm, 9_mm, 0, 0}},
                          24),
                   3, "tibialis posterior");
        add_muscle(calf,
                   muscle({{40_mm, {-24_mm, 46_mm}, 8_mm, 5_mm, -0.3F, 0},
                           {100_mm, {-21_mm, 47.5_mm}, 15_mm, 9.5_mm, -0.3F, 0},
                           {bottom, {-15_mm, 30_mm}, 15_mm, 9.5_mm, -0.2F, 0}},
                          25),
                   4, "flexor hallucis longus");
        const float large = 3.4_mm;
        add_muscle(calf, muscle({at(top, -100_deg, 10_mm, 18_mm, 9_mm), at(bottom, -95_deg, 8_mm, 15_mm, 8_mm)}, 26), 3,
                   "fibulares", {0, 1, 0}, large);
        add_muscle(
            calf,
            muscle({{top, {-14_mm, 84_mm}, 28_mm, 17_mm, -0.4F, 0}, {bottom, {-11_mm, 62_mm}, 22_mm, 15_mm, -0.4F, 0}},
                   27),
            2, "anterior muscles of the lower leg", {0, 1, 0}, large);

        const auto bone = [&](float x, float y, float z, float w, float t) {
            return section{y, {x * m, z * m}, w, t, 0, 0};
        };
        // Its sections are triangles with one side to the back.
        swept tibia{.sections = {bone(10_mm, top, 70_mm, 22_mm, 18_mm), bone(15_mm, 40_mm, 74_mm, 15_mm, 15_mm),
                                 bone(18_mm, 110_mm, 74_mm, 12.5_mm, 13.5_mm),
                                 bone(16_mm, bottom, 56_mm, 11_mm, 12_mm)},
                    .power = 2,
                    .start = 3_mm,
                    .end = 3_mm,
                    .waves = 0.25_mm,
                    .seed = seed + 30};
        mesh shaft = tibia.surface(cell(3_mm));
        for (vec3& p : shaft.positions) {
            const section here = tibia.at(p.y);
            const vec2 away{p.x - here.centre.x, p.z - here.centre.y};
            const float edges = 1 - 0.14F * std::cos(3 * (std::atan2(away.y, away.x) + 0.5F * pi));
            p.x = here.centre.x + edges * away.x;
            p.z = here.centre.y + edges * away.y;
        }
        shaft = confined(
            std::move(shaft), [&](vec3 p) { return calf.depth(p); }, 1_mm);
        add(calf, std::move(shaft), tissue::bone, 14, "tibia", compartments(calf));
        add(calf,
            swept{.sections = {bone(-30_mm, top, 60_mm, 10_mm, 9_mm), bone(-29_mm, 40_mm, 62_mm, 6.5_mm, 6.5_mm),
                               bone(-27_mm, 110_mm, 62_mm, 6_mm, 6.5_mm), bone(-22_mm, bottom, 46_mm, 6.5_mm, 6.5_mm)},
                  .power = 2.3F,
                  .start = 3_mm,
                  .end = 3_mm,
                  .waves = 0.25_mm,
                  .seed = seed + 31}
                .surface(cell(2_mm)),
            tissue::bone, 14, "fibula", compartments(calf));

        // The vessels and the nerve in fatty tissue between the soleus and the deep flexors.
        const vec3 course[] = {{0, top + 4_mm, 21_mm},      {1_mm, 20_mm, 27_mm},  {3_mm, 50_mm, 36_mm},
                               {6_mm, 80_mm, 41.5_mm},      {8_mm, 110_mm, 42_mm}, {9_mm, 150_mm, 35.5_mm},
                               {8_mm, bottom - 5_mm, 27_mm}};
        swept bundle{.power = 2.2F, .start = 4_mm, .end = 4_mm, .waves = 0.7_mm, .seed = seed + 32};
        swept tibial{.power = 2, .start = 3_mm, .end = 3_mm, .waves = 0.12_mm, .seed = seed + 33};
        std::vector<tube_section> artery, veins[2], fibular;
        for (const vec3 p : course) {
            const float high = 1 - ramp(p.y, 0, 85_mm); // popliteal
            const vec2 c{p.x * m, p.z * m};
            bundle.sections.push_back({p.y - (p.y < 0 ? 1.5_mm : 0) + (p.y > 190_mm ? 1.5_mm : 0), c + vec2{-2_mm, 0},
                                       9.5_mm + 2_mm * high, 3.6_mm + 3.5_mm * high, 0, 8});
            const auto beside = [&](float x, float z, float w, float t) {
                return tube_section{{c.x + x, p.y, c.y + z}, {w, t}};
            };
            artery.push_back(
                beside(1.2_mm * (1 - high), 1.2_mm * high, 1.35_mm + 1.4_mm * high, 1.35_mm + 1.4_mm * high));
            veins[0].push_back(
                beside(4.6_mm - 2.6_mm * high, -3_mm * high, 1.5_mm + 1.8_mm * high, 1_mm + 1_mm * high));
            if (p.y > 60_mm) veins[1].push_back(beside(-2_mm, 0.2_mm, 1.3_mm, 0.9_mm));
            if (p.y > 60_mm)
                fibular.push_back({{c.x - 4_mm - 18_mm * m * ramp(p.y, 75_mm, 120_mm), p.y,
                                    c.y + 2_mm + 5_mm * m * ramp(p.y, 75_mm, 120_mm)},
                                   vec2{1.1_mm}});
            tibial.sections.push_back({p.y, c + vec2{-6.6_mm + 1.5_mm * high, -2_mm * high}, 2.9_mm + 0.4_mm * high,
                                       1.8_mm + 0.6_mm * high, 0.05F, 0});
        }
        add(calf, bundle.surface(cell(2_mm)), media::limb::loose_tissue, 8, "sheath of the tibial vessels",
            compartments(calf), {0, 1, 0});
        const std::vector<wall_layer> plain{{"wall", tissue::vessel_wall, 0.4_mm, 0.3F}},
            thin{{"wall", tissue::vein_wall, 0.25_mm, 0.35F}};
        const auto add_line = [&](std::vector<tube_section> points, const std::vector<wall_layer>& layers, int priority,
                                  const std::string& name, std::uint64_t number, vessel::kind type) {
            const auto line = smooth_line(points, cell(3_mm));
            add_vessel(calf, make_tube(line, {.segments = segments(22), .across = {1, 0, 0}}), layers, priority, name,
                       number, compartments(calf));
            flows(calf, name, type, line, type == vessel::kind::artery ? 0.5F : 0.1F);
        };
        add_line(artery, plain, 20, "popliteal and posterior tibial artery", 400, vessel::kind::artery);
        add_line(veins[0], thin, 17, "popliteal and posterior tibial vein", 410, vessel::kind::vein);
        add_line(veins[1], thin, 17, "second posterior tibial vein", 420, vessel::kind::vein);
        add_line(fibular, plain, 20, "fibular artery", 430, vessel::kind::artery);
        const auto within_muscle = [&](float x, float y, float z, float r) {
            return tube_section{{x * m, y, z * m}, {r, 0.7F * r}};
        };
        add_line({within_muscle(-13_mm, 62_mm, 24_mm, 1_mm), within_muscle(-11_mm, 105_mm, 23_mm, 1.3_mm),
                  within_muscle(-6_mm, 155_mm, 18_mm, 0.9_mm)},
                 thin, 9, "soleal vein", 450, vessel::kind::vein);
        add_line({within_muscle(12_mm, 40_mm, 9_mm, 1_mm), within_muscle(15_mm, 100_mm, 9.5_mm, 0.8_mm),
                  within_muscle(15_mm, 145_mm, 7.5_mm, 0.6_mm)},
                 thin, 9, "gastrocnemius vein", 460, vessel::kind::vein);
        add_nerve(calf, tibial, 1.3_mm, 13, "tibial nerve", compartments(calf), seed + 8000);

        // The small saphenous vein lies between the crural fascia and a sheet of its own.
        const float high = min(1.1_mm, 0.22F * calf.fat);
        const auto over = [&](float x, float y, float above) {
            return limb::surface_point(calf.fascia, y, x / (50_mm * m), above);
        };
        const auto small_x = [&](float y) { return (-1_mm + 2.5_mm * std::sin(y / 40_mm)) * m; };
        std::vector<tube_section> small;
        for (const float y : {top + 6_mm, 30_mm, 65_mm, 100_mm, 135_mm, 170_mm, bottom - 4_mm})
            small.push_back({over(small_x(y), y, 0.4_mm + high), {1.35F * high, high}});
        const auto line = smooth_line(small, cell(2.6_mm));
        add_vessel(calf, make_tube(line, {.segments = segments(20), .across = {1, 0, 0}}),
                   {{"wall", tissue::vein_wall, 0.2_mm, 0.3F}}, 15, "small saphenous vein", 440, "skin");
        flows(calf, "small saphenous vein", vessel::kind::vein, line, 0.1F);
        const auto columns = static_cast<std::uint32_t>(24 * of.resolution),
                   rows = static_cast<std::uint32_t>(36 * of.resolution);
        std::vector<sheet_point> points;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t column = 0; column < columns; ++column) {
                const float u = 2 * static_cast<float>(column) / static_cast<float>(columns - 1) - 1;
                const float v = static_cast<float>(row) / static_cast<float>(rows - 1);
                const float y = top + 3_mm + (bottom - top - 6_mm) * v, x = small_x(y) + 13_mm * m * u;
                const float bell = 0.5F + 0.5F * std::cos(pi * u), uneven = noise(seed + 34, {x, y, 0}, 5_mm);
                points.push_back({over(x, y, 0.12_mm + (2 * high + 0.6_mm) * bell + 0.1_mm * uneven),
                                  0.05_mm + 0.13_mm * bell * (1 + 0.7F * uneven)});
            }
        add(calf, make_sheet(points, columns), media::limb::fascia, 1, "saphenous fascia", "skin");
    }

    void add_views() {
        const linear_array& probe = presets::nerve_block.probe;
        b_mode_settings settings = presets::nerve_block.settings;
        constexpr float film = 0.4_mm;
        const auto seen = [&](const limb& part, float y, float angle, bool lengthwise) {
            const vec3 on = placed(part, limb::surface_point(part.fascia, y, angle, part.fat + of.skin + film));
            const auto [along, n] = limb::axes(part.fascia, y, angle);
            const vec3 lateral = lengthwise ? vec3{0, 1, 0} : cross({0, 1, 0}, direction(part, n));
            return look_at(on, on + direction(part, n), lateral);
        };
        // An operator chooses a depth at which the deepest structure is seen, in steps of 5 mm.
        const auto add_view = [&](const char* name, const char* title, const limb& part, const pose& at,
                                  float deepest) {
            settings.depth = 5_mm * std::ceil((part.fat + of.skin + deepest) / 5_mm);
            made.views.push_back({name, title, at, probe, settings, {}});
        };
        const section front = thigh.fascia.at(0);
        const float to_artery =
            std::asin(clamp(-front.centre.x / front.half_width, -0.5F, 0.5F)); // superellipse: about
        add_view("femoral_block", "femoral nerve lateral to the femoral artery at the inguinal crease, across", thigh,
                 seen(thigh, 0, to_artery + 0.05F, false), of.bone + 4_mm);
        // Beneath the lateral corner of the nerve, from the lateral side.
        const float lateral = of.side > 0 ? -1.0F : 1.0F;
        const pose block = made.views.front().at;
        const section here = nerve.at(0);
        const vec3 corner = block.local_point(
            placed(thigh, {here.centre.x + 0.75F * here.half_width, 0, here.centre.y + 1.1F * here.half_thickness}));
        const vec3 target = block.point({corner.x, 0, corner.z});
        const vec3 out = block.direction({lateral * std::cos(28_deg), 0, -std::sin(28_deg)});
        float within = 0, beyond = 120_mm;
        for (int i = 0; i < 30; ++i) {
            const float half = 0.5F * (within + beyond);
            const vec3 p = direction(thigh, target + half * out);
            (thigh.fascia.distance(p) < of.fat + of.skin ? within : beyond) = half;
        }
        made.views.front().needle = needle_path{target + within * out, target};
        add_view("vastus_lateralis_lengthwise",
                 "vastus lateralis over vastus intermedius, along the thigh, the hip to the left", thigh,
                 seen(thigh, 165_mm, vastus_angle, true), 41_mm * m);
        add_view("calf_lengthwise", "medial gastrocnemius over soleus, along the calf, the knee to the left", calf,
                 seen(calf, 110_mm, gastrocnemius_angle, true), 38_mm * m);
        add_view("calf_transverse", "both heads of gastrocnemius over soleus, across", calf,
                 seen(calf, 105_mm, 4_deg, false), 43_mm * m);
        // Wider and lower in frequency, to the femur.
        const linear_array wide = presets::in_use(
            linear_array{.lines = 256, .width = 50_mm, .frequency = 6_MHz, .focus = 28_mm, .elevation_focus = 28_mm});
        add_view("thigh_transverse", "rectus femoris with its central tendon over vastus intermedius and femur, across",
                 thigh, seen(thigh, 140_mm, 3_deg, false), 50_mm * m);
        made.views.back().probe = wide;
        // From behind through all muscles to both bones.
        settings = presets::abdomen.settings;
        add_view("calf_deep_transverse", "tibia and fibula beneath the muscles of the calf, across", calf,
                 seen(calf, 105_mm, -2_deg, false), 82_mm * m);
        made.views.back().probe = presets::abdomen.probe;
        made.views.back().pressed = 6_mm;
    }
};

} // namespace detail

/// The thigh from the groin to its middle, and the calf below the knee.
inline body make(const leg& of) {
    return make_in_size(of, [](const leg& usual) {
        detail::leg_builder builder{usual};
        builder.add_skin();
        builder.add_thigh_muscles();
        builder.add_femur();
        builder.add_fascia_iliaca();
        builder.add_femoral_vessels();
        builder.add_femoral_nerve();
        builder.add_calf();
        builder.add_views();
        return std::move(builder.made);
    });
}

} // namespace anatomy

#endif
