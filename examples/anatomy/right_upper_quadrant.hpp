#ifndef INSONIFY_EXAMPLES_ANATOMY_RIGHT_UPPER_QUADRANT_HPP
#define INSONIFY_EXAMPLES_ANATOMY_RIGHT_UPPER_QUADRANT_HPP

#include <insonify/examinations.hpp>
#include "builder.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace anatomy {

/// What varies in the right upper quadrant: lengths in metres.
///
/// Sources of the ranges: liver: Kratzer et al., J. Ultrasound Med. 2003 22:1155. Portal vein: Weinreb et al., Am. J.
/// Roentgenol. 1982 139:497. Kidney: Emamian et al., Am. J. Roentgenol. 1993 160:83. Gallbladder: Caroli-Bosc et al.,
/// Dig. Dis. Sci. 1999 44:1630. Vena cava: Mintz et al., Circulation 1981 64:1018. The others: Standring, Gray's
/// Anatomy, 41st edition, and convention.
struct right_upper_quadrant {
    float variant = 1;
    float resolution = 1;
    float size = 1;
    float skin = 2_mm;
    float fat = 12_mm;
    float muscle = 1;
    float liver = 136_mm;
    float portal = 11.5_mm;
    float cava = 20_mm;
    float hepatic = 9.2_mm;
    float aorta = 19_mm;
    float gallbladder_length = 78_mm;
    float gallbladder_width = 29_mm;
    float gallbladder_shift = 0;
    float stone = 0;
    float stone_size = 11_mm;
    float kidney_length = 108_mm;
    float perirenal = 5_mm;
    float rib_spacing = 25_mm;
    float fluid = 0;

    static const std::vector<member<right_upper_quadrant>>& members() {
        using of = right_upper_quadrant;
        static const std::vector<member<right_upper_quadrant>> all{
            {"variant", "", "number of the irregularities of all surfaces", &of::variant, 0, 65535, true},
            {"resolution", "", "the cells of all meshes are divided by it", &of::resolution, 0.3F, 2},
            {"size", "", "height over the usual one, 1.68 m: lengths without a parameter follow it", &of::size, 0.9F,
             1.1F},
            {"skin", "m", "thickness of the skin", &of::skin, 1.5_mm, 2.8_mm},
            {"fat", "m", "thickness of the subcutaneous fat", &of::fat, 4_mm, 30_mm},
            {"muscle", "", "thickness of the flat muscles over its usual value", &of::muscle, 0.8F, 1.1F},
            {"liver", "m", "length of the liver in the midclavicular line", &of::liver, 120_mm, 155_mm},
            {"portal", "m", "inner diameter of the portal vein", &of::portal, 9_mm, 13_mm},
            {"cava", "m", "inner diameter of the inferior vena cava", &of::cava, 14_mm, 24_mm},
            {"hepatic", "m", "inner diameter of the right hepatic vein, 20 mm from its mouth", &of::hepatic, 6.5_mm,
             11_mm},
            {"aorta", "m", "inner diameter of the aorta at the celiac trunk", &of::aorta, 15_mm, 23_mm},
            {"gallbladder_length", "m", "length of the gallbladder", &of::gallbladder_length, 60_mm, 95_mm},
            {"gallbladder_width", "m", "its width", &of::gallbladder_width, 20_mm, 38_mm},
            {"gallbladder_shift", "m", "distance of its fundus from its usual place, towards the midline",
             &of::gallbladder_shift, -12_mm, 12_mm},
            {"stone", "", "gallstone: 0 none, 1 present", &of::stone, 0, 1, true},
            {"stone_size", "m", "its diameter", &of::stone_size, 6_mm, 16_mm},
            {"kidney_length", "m", "length of the kidney", &of::kidney_length, 95_mm, 122_mm},
            {"perirenal", "m", "thickness of the fat at the side of the kidney", &of::perirenal, 2.5_mm, 14_mm},
            {"rib_spacing", "m", "distance between the ribs, from middle to middle", &of::rib_spacing, 22_mm, 29_mm},
            {"fluid", "", "free fluid between liver and kidney: 0 none, 1 present", &of::fluid, 0, 1, true},
        };
        return all;
    }
};

namespace detail {

/// The right upper quadrant in the making. x points to the patient's left, y towards the feet, z to the back. y is 0 at
/// the first lumbar vertebra, x in the midline, z at the deep fascia in front. Angles around the trunk are 0 in front,
/// 90 degrees at the right side.
struct right_upper_quadrant_builder : builder {
    const right_upper_quadrant& of;
    swept trunk{};                         ///< its deep fascia
    vec3 long_axis{}, lateral{}, across{}; ///< of the kidney: towards the feet, away from its hilum, backwards
    std::vector<tube_section> gallbladder{};
    vec3 seen_in_gallbladder{}; ///< its middle, or its stone

    static constexpr float top = -165_mm, bottom = 125_mm;
    static constexpr float chest = 14.4_mm;    ///< from the deep fascia to the pleura
    static constexpr float wall = 18_mm;       ///< from the deep fascia to the peritoneum
    static constexpr float diaphragm = 3.2_mm; ///< its thickness
    static constexpr float half_width = 140_mm, half_depth = 95_mm;
    static constexpr float roundness = 2.25F; ///< power of the superellipse across the trunk
    static constexpr vec3 kidney_centre{-66_mm, 18_mm, 114_mm};

    explicit right_upper_quadrant_builder(const right_upper_quadrant& parameters) : of{parameters} {
        seed = 1000 * static_cast<std::uint64_t>(of.variant);
        trunk = {.sections = {{top, {0, half_depth}, 0.98F * half_width, 1.02F * half_depth},
                              {-60_mm, {0, half_depth}, half_width, half_depth},
                              {bottom, {0, half_depth}, half_width, half_depth}},
                 .power = roundness,
                 .start = 1_mm,
                 .end = 1_mm};
        long_axis = normalize(vec3{-0.2F, 0.95F, -0.24F});
        const vec3 side{-0.85F, 0, 0.42F}; // its hilum faces the midline and the front
        lateral = normalize(side - dot(side, long_axis) * long_axis);
        across = cross(long_axis, lateral);
        if (across.z < 0) across = -across;
    }

    float cell(float usual) const { return usual / of.resolution; }
    std::uint32_t subdivisions(int usual) const {
        return static_cast<std::uint32_t>(max(static_cast<float>(usual) + std::round(std::log2(of.resolution)), 1));
    }
    std::uint32_t count(float usual) const {
        return static_cast<std::uint32_t>(max(std::round(usual * of.resolution), 10));
    }
    /// A point at a depth below the deep fascia.
    /// @param around  degrees from the front to the right
    vec3 at(float around, float y, float deep) const {
        const float a = around * pi / 180;
        const section here = trunk.at(clamp(y, top + 2_mm, bottom - 2_mm));
        const auto powered = [](float value) {
            return std::copysign(std::pow(std::fabs(value), 2 / roundness), value);
        };
        const vec3 on{-here.half_width * powered(std::sin(a)), y,
                      here.centre.y - here.half_thickness * powered(std::cos(a))};
        return on + deep * inward(around, y);
    }
    vec3 inward(float around, float y) const {
        const float a = around * pi / 180;
        const section here = trunk.at(clamp(y, top + 2_mm, bottom - 2_mm));
        const auto powered = [](float value) {
            return std::copysign(std::pow(std::fabs(value), 2 - 2 / roundness), value);
        };
        return normalize(vec3{powered(std::sin(a)) / here.half_width, 0, powered(std::cos(a)) / here.half_thickness});
    }
    /// Along the skin, towards the front.
    vec3 forward(float around, float y) const {
        const vec3 n = inward(around, y);
        return {n.z, 0, -n.x};
    }

    /// Middle of a rib.
    float rib_at(int number, float around) const {
        const float side = -24_mm + of.rib_spacing * static_cast<float>(number - 10);
        return around > 90 ? side - 62_mm * (around - 90) / 90 : side + 30_mm * (90 - around) / 50;
    }
    /// Where the bone of a rib ends, and its cartilage begins.
    static float end_of_rib(int number) {
        constexpr float ends[] = {36, 42, 48, 58, 82};
        return ends[number - 7];
    }
    /// The costal margin.
    float margin(float around) const {
        struct place {
            float around, y;
        };
        const place all[] = {{0, rib_at(7, 36) - 22_mm},   {12, rib_at(7, 36) - 8_mm},   {22, rib_at(8, 42) - 22_mm},
                             {34, rib_at(9, 48) - 18_mm},  {46, rib_at(10, 58) - 14_mm}, {60, rib_at(10, 58) + 6_mm},
                             {74, rib_at(10, 74) + 9_mm},  {84, rib_at(11, 84) + 8_mm},  {120, rib_at(11, 120) + 8_mm},
                             {180, rib_at(11, 180) + 8_mm}};
        std::size_t i = 0;
        while (i + 2 < std::size(all) && all[i + 1].around < around) ++i;
        return all[i].y + (all[i + 1].y - all[i].y) * ramp(around, all[i].around, all[i + 1].around);
    }

    /// A flat muscle of the wall between two angles, along lines from its upper to its lower border.
    template <class Upper, class Lower, class Depth, class Thickness>
    void add_sheet(float from, float to, const Upper& upper, const Lower& lower, const Depth& depth,
                   const Thickness& thickness, const medium& inside, const std::string& name, vec3 fibres) {
        const std::uint32_t columns = count(40), rows = count(30);
        std::vector<sheet_point> points;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t column = 0; column < columns; ++column) {
                const float u = static_cast<float>(column) / static_cast<float>(columns - 1);
                const float v = static_cast<float>(row) / static_cast<float>(rows - 1);
                const float around = from + (to - from) * u;
                const float y = upper(around) + (lower(around) - upper(around)) * v;
                const float borders =
                    ramp(u, 0, 0.08F) * ramp(1 - u, 0, 0.08F) * ramp(v, 0, 0.05F) * ramp(1 - v, 0, 0.05F);
                const float uneven = 1 + 0.06F * noise(seed + 5, at(around, y, 0), 25_mm);
                points.push_back(
                    {at(around, y, depth(around)), 0.4_mm + (thickness(around) * uneven - 0.4_mm) * borders});
            }
        add(make_sheet(points, columns), inside, 3, name, "body wall", fibres);
    }

    void add_wall() {
        const float coarse = cell(7_mm);
        swept outside = trunk;
        outside.waves = 0.15_mm;
        outside.seed = seed + 1;
        add(outside.surface(coarse, of.fat + of.skin + 14_mm), tissue::gel, -1000, "gel", "");
        add(outside.surface(coarse, of.fat + of.skin), tissue::skin, 0, "skin", "gel", vec3{0, 1, 0});
        outside.waves = 0.25_mm;
        add(outside.surface(coarse, of.fat), tissue::fat, 0, "fat", "skin", vec3{0, 1, 0}, own_surface{});
        add(trunk.surface(coarse), media::deep_fascia, 0, "body wall", "fat", vec3{0, 1, 0}, own_surface{});

        const float m = of.muscle;
        const auto constant = [](float value) { return [value](float) { return value; }; };
        const auto under_margin = [&](float around) { return margin(around) + 1.5_mm; };
        // Both recti, from the ribs down, and the flat muscles beside them.
        for (const float side : {1.0F, -1.0F})
            add_sheet(side > 0 ? 2.5F : -29, side > 0 ? 29 : -2.5F, constant(-88_mm), constant(bottom - 2_mm),
                      constant(0.8_mm + 4.5_mm * m), constant(9_mm * m), tissue::thin_muscle,
                      side > 0 ? "right rectus abdominis" : "left rectus abdominis", {0, 1, 0});
        add_sheet(32, 140, constant(-105_mm), constant(bottom - 2_mm), constant(0.5_mm + 2.6_mm * m),
                  constant(5.2_mm * m), tissue::thin_muscle, "external oblique", {0.3F, 0.7F, -0.6F});
        add_sheet(31, 135, under_margin, constant(bottom - 2_mm), constant(1_mm + 8.7_mm * m), constant(6.4_mm * m),
                  tissue::thin_muscle, "internal oblique", {0.3F, -0.7F, -0.6F});
        add_sheet(26, 135, under_margin, constant(bottom - 2_mm), constant(1.4_mm + 13.9_mm * m), constant(3.4_mm * m),
                  tissue::thin_muscle, "transversus abdominis", {0.3F, 0, -0.95F});
        add_sheet(12, 165, constant(-150_mm), [&](float around) { return margin(around) - 1_mm; }, constant(10.3_mm),
                  constant(7.2_mm), tissue::thin_muscle, "intercostal muscles", {0.2F, 0.7F, -0.7F});
        const auto back = [&](std::vector<section> table, std::uint64_t number) {
            return swept{.sections = std::move(table), .power = 2.3F, .waves = 0.4_mm, .seed = seed + number};
        };
        for (const float side : {1.0F, -1.0F})
            add(back({{top + 15_mm, {side * 36_mm, 166_mm}, 30_mm, 17_mm},
                      {bottom - 2_mm, {side * 38_mm, 164_mm}, 34_mm, 20_mm}},
                     10)
                    .surface(cell(4_mm)),
                tissue::muscle, 3, side > 0 ? "left erector spinae" : "right erector spinae", "body wall",
                vec3{0, 1, 0});
        add(back({{-14_mm, {-60_mm, 146_mm}, 12_mm, 5_mm, 0.25F},
                  {40_mm, {-72_mm, 149_mm}, 22_mm, 8_mm, 0.3F},
                  {bottom - 2_mm, {-84_mm, 147_mm}, 26_mm, 9_mm, 0.4F}},
                 11)
                .surface(cell(3_mm)),
            tissue::muscle, 3, "quadratus lumborum", "body wall", vec3{0, 1, 0});
        add(back({{-8_mm, {-30_mm, 122_mm}, 8_mm, 7_mm},
                  {30_mm, {-36_mm, 119_mm}, 14_mm, 15_mm},
                  {bottom - 2_mm, {-47_mm, 113_mm}, 20_mm, 20_mm}},
                 12)
                .surface(cell(3_mm)),
            tissue::muscle, 3, "psoas", "body wall", vec3{0, 1, 0});
    }

    void add_ribs() {
        const char* names[] = {"seventh", "eighth", "ninth", "tenth", "eleventh"};
        const auto segments = count(22);
        for (int number = 6; number <= 11; ++number) {
            const float end = number == 6 ? 36 : end_of_rib(number);
            std::vector<tube_section> line;
            for (float around = number == 6 ? 112.0F : 160.0F; around >= end; around -= 3) {
                if (rib_at(number, around) < top + 10_mm) continue; // it goes on above the region
                const float tip = ramp(around, end, end + 12);      // round where the cartilage begins
                line.push_back({at(around, rib_at(number, around),
                                   10.2_mm + 0.4_mm * noise(seed + 20, {around * 1_mm, 0, 0}, 15_mm)),
                                {(6.3_mm - 0.5_mm * (1 - tip)), 3.4_mm}});
            }
            const std::string name = number == 6 ? "sixth" : names[number - 7];
            add(make_tube(line, {.segments = segments, .across = {0, 1, 0}}), tissue::bone, 6, name + " rib",
                "body wall");
            if (number == 6 || number == 11) continue;
            // The cartilages of the eighth to the tenth rib each join the one above.
            const float y = rib_at(number, end);
            std::vector<tube_section> knots{{at(end + 6, rib_at(number, end + 6), 10.2_mm), {5.2_mm, 3.1_mm}},
                                            {at(end - 2, y + 1_mm, 10.5_mm), {5.6_mm, 3.4_mm}},
                                            {at(end - 9, y - 4_mm, 12.2_mm), {5.3_mm, 3.4_mm}}};
            if (number == 7) {
                knots.push_back({at(18, y - 15_mm, 13.4_mm), {5.5_mm, 3.4_mm}});
                knots.push_back({at(6, y - 27_mm, 13.4_mm), {5.5_mm, 3.4_mm}});
            } else {
                const float above = rib_at(number - 1, end_of_rib(number - 1)) + 4_mm;
                knots.push_back({at(end - 17, 0.5F * (y - 4_mm + above), 13.2_mm), {4.8_mm, 3.1_mm}});
            }
            add(make_tube(smooth_line(knots, cell(2.5_mm)), {.segments = segments, .across = {0, 1, 0}}),
                tissue::cartilage, 5, name + " costal cartilage", "body wall");
        }
        const char* bodies[] = {"tenth thoracic vertebra", "eleventh thoracic vertebra", "twelfth thoracic vertebra",
                                "first lumbar vertebra",   "second lumbar vertebra",     "third lumbar vertebra"};
        for (int i = 0; i < 6; ++i) {
            const float y = 31_mm * static_cast<float>(i - 3), large = 0.93F + 0.03F * static_cast<float>(i);
            add(swept{.sections = {{y - 13_mm, {0, 115_mm}, 22_mm * large, 16_mm * large},
                                   {y, {0, 115_mm}, 20.5_mm * large, 15_mm * large},
                                   {y + 13_mm, {0, 115_mm}, 22_mm * large, 16_mm * large}},
                      .power = 2.2F,
                      .waves = 0.3_mm,
                      .seed = seed + 30}
                    .surface(cell(3_mm)),
                tissue::bone, 9, bodies[i], "body wall");
        }
        add(swept{.sections = {{top + 20_mm, {0, 115_mm}, 20.5_mm, 15.2_mm},
                               {bottom - 2_mm, {0, 115_mm}, 21_mm, 15.5_mm}},
                  .power = 2.2F}
                .surface(cell(4_mm)),
            media::disc, 8, "discs", "body wall");
    }

    /// About a distance from what the diaphragm and the wall enclose.
    /// @param grown  outwards, metres
    float enclosed(vec3 p, float grown) const {
        const float side = trunk.distance({p.x, clamp(p.y, top + 5_mm, bottom - 5_mm), p.z}) + wall - grown;
        // The domes of both sides; below their base the wall alone.
        const float up = min(p.y + 35_mm, 0);
        const float right = ellipsoid(vec3{p.x + 52_mm, up, p.z - 90_mm}, vec3{96_mm, 77_mm, 88_mm} + vec3{grown});
        const float left = ellipsoid(vec3{p.x - 60_mm, up, p.z - 90_mm}, vec3{85_mm, 66_mm, 88_mm} + vec3{grown});
        return smooth_max(side, smooth_min(right, left, 12_mm), 14_mm);
    }

    void add_cavity() {
        add(swept{.sections = {{top + 0.5_mm, {0, half_depth}, 0.98F * half_width - chest, 1.02F * half_depth - chest},
                               {-60_mm, {0, half_depth}, half_width - chest, half_depth - chest},
                               {-40_mm, {0, half_depth}, half_width - chest, half_depth - chest}},
                  .power = roundness,
                  .start = 1_mm,
                  .end = 1_mm}
                .surface(cell(6_mm)),
            tissue::lung, 0, "lung", "body wall");
        const vec3 centre{-10_mm, -5_mm, 92_mm}, radii{120_mm, 110_mm, 75_mm};
        const float lowest = max(margin(84), margin(74)) + 4_mm;
        add(star_shaped([&](vec3 p) { return smooth_max(enclosed(p, diaphragm), p.y - lowest, 6_mm); }, centre, radii,
                        subdivisions(5)),
            tissue::thin_muscle, 1, "diaphragm", "body wall");
        add(star_shaped([&](vec3 p) { return smooth_max(enclosed(p, 0), p.y - (bottom - 3_mm), 4_mm); }, centre, radii,
                        subdivisions(5)),
            media::visceral_fat, 2, "abdominal cavity", "body wall", vec3{0, 1, 0});
    }

    vec3 in_kidney(vec3 p) const {
        const vec3 away = p - kidney_centre;
        return {dot(away, long_axis), dot(away, lateral), dot(away, across)};
    }
    vec3 from_kidney(vec3 q) const { return kidney_centre + q.x * long_axis + q.y * lateral + q.z * across; }
    float half_kidney() const { return 0.5F * of.kidney_length; }
    /// About a distance from the kidney, in its own coordinates; `grown` without its hilum: the fat around it.
    float kidney(vec3 q, float grown = 0) const {
        const float half = half_kidney(), part = q.x / half;
        q.y += 7_mm * (part * part - 0.3F); // its ends bend to the midline
        if (grown > 0) {
            q += vec3{0, 0.35F * grown, -0.1F * grown}; // more fat behind and towards the midline
            return ellipsoid(q, vec3{half, 0.25F * of.kidney_length, 22_mm} + vec3{1.1F, 1.35F, 1.1F} * grown);
        }
        const float all = ellipsoid(q, {half, 0.25F * of.kidney_length, 22_mm}) + 0.5_mm * noise(seed + 40, q, 20_mm);
        return less(all, ellipsoid(q - vec3{0, -0.27F * of.kidney_length, 0}, {17_mm, 13_mm, 9_mm}), 6_mm);
    }
    float sinus(vec3 q) const {
        const float middle = ellipsoid(q + vec3{0, 4_mm, 0}, {0.55F * half_kidney(), 0.1F * of.kidney_length, 9_mm});
        const float hilum = round_cone(q, {0, -6_mm, 0}, 8_mm, {0, -0.19F * of.kidney_length, -2_mm}, 6_mm);
        return smooth_min(middle, hilum, 6_mm) + 2.2_mm * noise(seed + 41, q, 9_mm) + 1_mm * noise(seed + 42, q, 5_mm);
    }

    void add_kidney() {
        const vec3 sizes{half_kidney(), 27_mm, 22_mm};
        const auto turned = [&](mesh m) {
            for (vec3& p : m.positions) p = from_kidney(p);
            if (dot(cross(long_axis, lateral), across) < 0)
                for (uvec3& f : m.faces) std::swap(f.y, f.z);
            return m;
        };
        add(turned(star_shaped([&](vec3 q) { return kidney(q, of.perirenal); }, {0, 0, 0}, sizes, subdivisions(4))),
            media::perirenal_fat, 4, "perirenal fat", "body wall");
        if (of.fluid > 0)
            add(turned(star_shaped(
                    [&](vec3 q) {
                        const vec3 here = q - vec3{-0.2F * of.kidney_length, 30_mm, -10_mm};
                        return smooth_max(kidney(q, of.perirenal) - recess(q), ellipsoid(here, {52_mm, 27_mm, 30_mm}),
                                          6_mm);
                    },
                    {-0.2F * of.kidney_length, 22_mm, -8_mm}, {50_mm, 18_mm, 28_mm}, subdivisions(4))),
                tissue::saline, 3, "free fluid", "body wall");
        const mesh outside =
            turned(star_shaped([&](vec3 q) { return kidney(q); }, {0, 3_mm, 0}, sizes, subdivisions(5)));
        add(turned(star_shaped([&](vec3 q) { return kidney(q) - 0.6_mm; }, {0, 3_mm, 0}, sizes, subdivisions(5))),
            tissue::capsule, 5, "renal capsule", "perirenal fat");
        add(outside, tissue::kidney, 6, "right kidney", "renal capsule");
        add(turned(mesh_implicit([&](vec3 q) { return sinus(q); },
                                 {{-0.36F * of.kidney_length, -0.4F * of.kidney_length, -18_mm},
                                  {0.36F * of.kidney_length, 0.2F * of.kidney_length, 18_mm}},
                                 cell(2.2_mm), {.max_slope = 2})),
            media::renal_sinus, 8, "renal sinus", "perirenal fat");

        // Pyramids: their bases below the cortex, their tips in the sinus.
        int number = 0;
        const auto exit = [](const auto& function, vec3 from, vec3 out) {
            float within = 0, beyond = 70_mm;
            for (int i = 0; i < 18; ++i) {
                const float half = 0.5F * (within + beyond);
                (function(from + half * out) < 0 ? within : beyond) = half;
            }
            return within;
        };
        const auto add_pyramid = [&](float along, float around) {
            const float lean = 0.5F * std::copysign(std::pow(std::fabs(along), 2.0F), along);
            const vec3 from{0.52F * along * half_kidney(), 0, 0};
            const vec3 out = normalize(vec3{1.9F * lean, std::cos(around), std::sin(around)});
            const float base = exit([&](vec3 q) { return kidney(q); }, from, out) - 7_mm;
            const float tip = min(exit([&](vec3 q) { return sinus(q); }, from, out) - 1_mm, base - 8_mm);
            const float wide =
                (6.4_mm + 0.7_mm * noise(seed + 44, {along, around, 0}, 0.3F)) * min((base - tip) / 9_mm, 1.1F);
            std::vector<tube_section> line;
            for (int i = 0; i <= 8; ++i) {
                const float part = static_cast<float>(i) / 8; // from the base to the tip
                const float shape = i == 0 ? 0.7F : 1.03F - 0.72F * part;
                const float beside = part < 0.12F ? 0.06F : part;
                line.push_back({from_kidney(from + (base + (tip - base) * (i == 0 ? 0 : beside)) * out),
                                {wide * shape * 1.05F, wide * shape * 0.95F}});
            }
            add(make_tube(line, {.segments = count(20), .ends = tube_settings::end_shape::flat}), media::renal_pyramid,
                7, "renal pyramid " + std::to_string(++number), "right kidney");
        };
        for (const float along : {-1.0F, -0.62F, -0.2F, 0.22F, 0.64F, 1.0F})
            add_pyramid(along, (number % 2 == 0 ? 0.13F : -0.13F) - 0.2F);
        for (const float side : {1.0F, -1.0F})
            for (const float along : {-0.75F, -0.28F, 0.24F, 0.72F}) add_pyramid(along, side * 1.45F - 0.1F);
    }
    /// How far free fluid parts the liver from the fat around the kidney.
    float recess(vec3 q) const {
        return 6_mm * ramp(q.x, 0.4F * of.kidney_length, 0.1F * of.kidney_length) * ramp(q.y, 2_mm, 14_mm);
    }

    /// The liver's lower surface: the height of its border.
    float underside(vec3 p) const {
        struct place {
            float x, y;
        };
        constexpr place all[] = {{-150_mm, 34_mm}, {-112_mm, 27_mm}, {-82_mm, 7_mm}, {-56_mm, -16_mm},
                                 {-30_mm, -29_mm}, {5_mm, -37_mm},   {70_mm, -56_mm}};
        std::size_t i = 0;
        while (i + 2 < std::size(all) && all[i + 1].x < p.x) ++i;
        const float slope = (all[i + 1].y - all[i].y) / (all[i + 1].x - all[i].x);
        const float y = all[i].y + slope * (clamp(p.x, all[0].x, 70_mm) - all[i].x);
        const float front = max(62_mm - p.z, 0); // it hangs lower in front
        return y + (of.liver - 136_mm) + 0.28F * front;
    }
    float liver(vec3 p) const {
        float all = smooth_max(enclosed(p, -1.2_mm), 0.8F * (p.y - underside(p)), 12_mm);
        // The left lobe is thin: the stomach lies behind it.
        const float thin = ramp(p.x, -28_mm, 6_mm);
        const float behind = p.z - (170_mm - thin * (104_mm + 0.35F * max(p.x, 0)));
        all = smooth_max(all, 0.6F * behind, 14_mm);
        all = smooth_max(all, p.x - 58_mm, 16_mm);
        if (all > 8_mm) return all;
        const vec3 q = in_kidney(p);
        all = less(all, kidney(q, of.perirenal) - (of.fluid > 0 ? recess(q) + 0.6_mm : 1.2_mm), 8_mm);
        return all + 0.7_mm * noise(seed + 50, p, 30_mm);
    }

    static std::vector<tube_section> vein(std::initializer_list<std::pair<vec3, float>> places, float spacing = 3_mm) {
        std::vector<tube_section> knots;
        for (const auto& [place, radius] : places) knots.push_back({place, vec2{radius}});
        return smooth_line(knots, spacing);
    }
    /// Of a line that narrows: where the coarsest mesh still holds it.
    static std::vector<tube_section> wide_part(std::vector<tube_section> line) {
        while (!line.empty() && line.back().radii.x < 2.4_mm) line.pop_back();
        return line;
    }
    /// @param line  in the direction of flow
    void flows(const std::string& name, vessel::kind type, std::vector<tube_section> line, float velocity) {
        made.vessels.push_back({.name = name,
                                .type = type,
                                .line = std::move(line),
                                .peak_velocity = velocity,
                                .resistive_index = 0.85F, // of the aorta above the renal arteries
                                .pressure = 6_mmHg});     // central veins, and nearly the portal one
    }
    enum class tree_flow { into_branches, into_trunk };
    /// @param lines  from the trunk outwards, the trunk first
    void flows(const std::string& name, const std::vector<std::vector<tube_section>>& lines, float velocity,
               tree_flow course) {
        for (const std::vector<tube_section>& branch : lines) {
            std::vector<tube_section> line = wide_part(branch);
            if (line.size() < 2) continue;
            if (course == tree_flow::into_trunk) std::reverse(line.begin(), line.end());
            flows(name, vessel::kind::vein, std::move(line), velocity);
        }
    }
    /// A tree of vessels as a function: all lines joined smoothly.
    struct tree {
        std::vector<std::vector<tube_section>> lines{};
        float operator()(vec3 p) const {
            float all = 1;
            for (const auto& line : lines) all = smooth_min(all, chain(p, line), 2_mm);
            return all;
        }
        aabb box(float margin) const {
            aabb all;
            for (const auto& line : lines)
                for (const tube_section& one : line) all = merged(all, one.centre);
            return {all.lower - vec3{margin}, all.upper + vec3{margin}};
        }
    };

    void add_liver() {
        const mesh outside = star_shaped([&](vec3 p) { return liver(p); }, {-62_mm, -44_mm, 72_mm},
                                         {85_mm, 62_mm, 62_mm}, subdivisions(5));
        add(star_shaped([&](vec3 p) { return liver(p) - 0.7_mm; }, {-62_mm, -44_mm, 72_mm}, {85_mm, 62_mm, 62_mm},
                        subdivisions(5)),
            tissue::capsule, 5, "liver capsule", "body wall");
        add(outside, tissue::liver, 5, "liver", "liver capsule");

        const float r = 0.5F * of.cava;
        const auto cava = vein({{{-21_mm, -112_mm, 74_mm}, r},
                                {{-21_mm, -88_mm, 79_mm}, r},
                                {{-21_mm, -50_mm, 88_mm}, r},
                                {{-20_mm, 0, 90_mm}, 0.96F * r},
                                {{-19_mm, 60_mm, 89_mm}, 0.92F * r},
                                {{-18_mm, bottom - 12_mm, 90_mm}, 0.9F * r}});
        add_vessel(make_tube(cava, {.segments = count(36)}), 0.9_mm, tissue::vein_wall, "inferior vena cava", 60,
                   "body wall");
        flows("inferior vena cava", {cava}, 0.3F, tree_flow::into_trunk);
        const auto aorta = vein({{{10_mm, top + 25_mm, 86_mm}, 0.53F * of.aorta},
                                 {{10_mm, -60_mm, 87_mm}, 0.5F * of.aorta},
                                 {{9_mm, 0, 88_mm}, 0.47F * of.aorta},
                                 {{8_mm, bottom - 14_mm, 89_mm}, 0.42F * of.aorta}});
        add_vessel(make_tube(aorta, {.segments = count(36)}), 1.4_mm, tissue::vessel_wall, "aorta", 61, "body wall");
        flows("aorta", vessel::kind::artery, aorta, 1);

        const float p = 0.5F * of.portal, fine = min(cell(2_mm), 2.2_mm);
        tree portal;
        // Both right branches lie in the slice of the intercostal view.
        const auto trunk_line = vein({{{6_mm, 2_mm, 70_mm}, p},
                                      {{-14_mm, -14_mm, 69_mm}, p},
                                      {{-36_mm, -29_mm, 67_mm}, 0.97F * p},
                                      {{-56_mm, -33_mm, 71_mm}, 0.82F * p},
                                      {{-78_mm, -34_mm, 84_mm}, 0.6F * p},
                                      {{-98_mm, -38_mm, 93_mm}, 0.38F * p},
                                      {{-115_mm, -41_mm, 99_mm}, 0.24F * p}});
        portal.lines = {trunk_line,
                        vein({{{-54_mm, -33_mm, 70_mm}, 0.72F * p},
                              {{-72_mm, -29_mm, 60_mm}, 0.6F * p},
                              {{-90_mm, -23_mm, 50_mm}, 0.38F * p},
                              {{-100_mm, -19.5_mm, 46_mm}, 0.26F * p}}),
                        vein({{{-70_mm, -30_mm, 61_mm}, 0.5F * p},
                              {{-80_mm, -43_mm, 54_mm}, 0.4F * p},
                              {{-91_mm, -57_mm, 50_mm}, 0.3F * p},
                              {{-101_mm, -69_mm, 50_mm}, 0.22F * p}}),
                        vein({{{-88_mm, -54_mm, 51_mm}, 0.3F * p},
                              {{-93_mm, -58_mm, 63_mm}, 0.26F * p},
                              {{-102_mm, -56_mm, 74_mm}, 0.2F * p}}),
                        vein({{{-79_mm, -42_mm, 54_mm}, 0.3F * p},
                              {{-78_mm, -60_mm, 60_mm}, 0.26F * p},
                              {{-76_mm, -77_mm, 66_mm}, 0.2F * p}}),
                        vein({{{-96_mm, -37_mm, 92_mm}, 0.3F * p},
                              {{-106_mm, -31_mm, 82_mm}, 0.25F * p},
                              {{-114_mm, -25_mm, 72_mm}, 0.2F * p}}),
                        vein({{{-80_mm, -34_mm, 85_mm}, 0.4F * p},
                              {{-94_mm, -47_mm, 100_mm}, 0.32F * p},
                              {{-105_mm, -57_mm, 108_mm}, 0.24F * p}}),
                        vein({{{-34_mm, -31_mm, 67_mm}, 0.7F * p},
                              {{-22_mm, -42_mm, 58_mm}, 0.66F * p},
                              {{-6_mm, -46_mm, 50_mm}, 0.6F * p},
                              {{0, -44_mm, 38_mm}, 0.5F * p},
                              {{-2_mm, -40_mm, 28_mm}, 0.3F * p}}),
                        vein({{{0, -46_mm, 46_mm}, 0.4F * p},
                              {{16_mm, -54_mm, 42_mm}, 0.32F * p},
                              {{30_mm, -60_mm, 38_mm}, 0.24F * p}}),
                        vein({{{0, -44_mm, 40_mm}, 0.36F * p},
                              {{-16_mm, -50_mm, 32_mm}, 0.28F * p},
                              {{-26_mm, -54_mm, 28_mm}, 0.22F * p}})};
        const mesh lumen = mesh_implicit(portal, portal.box(p + 3_mm), fine, {.max_slope = 1.1F});
        add(mesh_implicit([&](vec3 q) { return portal(q) - 1.1_mm - 0.3_mm * noise(seed + 62, q, 8_mm); },
                          portal.box(p + 5_mm), fine, {.max_slope = 1.2F}),
            media::portal_tract, 6, "portal vein: wall", "body wall");
        add(lumen, tissue::blood, 8, "portal vein", "portal vein: wall");
        flows("portal vein", portal.lines, 0.2F, tree_flow::into_branches);

        const float h =
            of.hepatic / right_upper_quadrant{}.hepatic * 1_mm; // the radii below are those of a usual liver
        tree hepatic;
        const vec3 mouth{-21_mm, -86_mm, 76_mm};
        // Almost straight: it lies in the slice of the subcostal view.
        const auto right = vein({{mouth, 5.4F * h},
                                 {{-40_mm, -75_mm, 79_mm}, 4.6F * h},
                                 {{-62_mm, -61.5_mm, 83_mm}, 3.8F * h},
                                 {{-82_mm, -48.5_mm, 87_mm}, 2.8F * h},
                                 {{-99_mm, -37_mm, 90.5_mm}, 1.9F * h},
                                 {{-110_mm, -30_mm, 92.5_mm}, 1.3F * h}});
        hepatic.lines = {right,
                         vein({{mouth, 4.6F * h},
                               {{-27_mm, -76_mm, 63_mm}, 4.0F * h},
                               {{-38_mm, -64_mm, 52_mm}, 3.3F * h},
                               {{-50_mm, -50_mm, 43_mm}, 2.5F * h},
                               {{-62_mm, -34_mm, 35_mm}, 1.6F * h},
                               {{-70_mm, -22_mm, 31_mm}, 1.2F * h}}),
                         vein({{mouth, 4.4F * h},
                               {{-10_mm, -78_mm, 63_mm}, 3.6F * h},
                               {{6_mm, -68_mm, 50_mm}, 2.8F * h},
                               {{22_mm, -60_mm, 40_mm}, 1.8F * h},
                               {{34_mm, -58_mm, 34_mm}, 1.2F * h}}),
                         vein({{{-62_mm, -61.5_mm, 83_mm}, 2.4F * h},
                               {{-80_mm, -68_mm, 74_mm}, 2.0F * h},
                               {{-94_mm, -76_mm, 66_mm}, 1.3F * h}}),
                         vein({{{-82_mm, -48.5_mm, 87_mm}, 2.2F * h},
                               {{-94_mm, -53_mm, 98_mm}, 1.7F * h},
                               {{-104_mm, -54_mm, 104_mm}, 1.2F * h}}),
                         vein({{{-40_mm, -62_mm, 50_mm}, 2.2F * h},
                               {{-56_mm, -64_mm, 42_mm}, 1.7F * h},
                               {{-70_mm, -66_mm, 38_mm}, 1.2F * h}})};
        add(mesh_implicit(hepatic, hepatic.box(8_mm), fine, {.max_slope = 1.1F}), tissue::blood, 9, "hepatic veins",
            "body wall");
        flows("hepatic veins", hepatic.lines, 0.25F, tree_flow::into_trunk);

        // Vessels of the kidney, in front of it and behind the vena cava.
        const vec3 hilum = from_kidney({2_mm, -0.22F * of.kidney_length, -2_mm});
        const auto renal = vein({{hilum, 3.2_mm},
                                 {0.5F * (hilum + vec3{-24_mm, 12_mm, 90_mm}) + vec3{0, -2_mm, -3_mm}, 4_mm},
                                 {{-24_mm, 12_mm, 90_mm}, 4.2_mm}},
                                2.5_mm);
        add_vessel(make_tube(renal, {.segments = count(20)}), 0.5_mm, tissue::vein_wall, "right renal vein", 63,
                   "body wall");
        flows("right renal vein", vessel::kind::vein, renal, 0.2F);
    }
    void add_vessel(mesh lumen, float thickness, const medium& around, const std::string& name, std::uint64_t number,
                    const std::string& within) {
        builder::add_vessel(std::move(lumen), {{"wall", around, thickness, 0.3F}}, 6, name, number, within);
    }

    void add_gallbladder() {
        const float wide = 0.5F * of.gallbladder_width, length_of = of.gallbladder_length;
        const vec3 neck{-46_mm, -24_mm, 69_mm};
        const vec3 down = normalize(vec3{-25_mm + 0.5F * of.gallbladder_shift, 37_mm, -16_mm});
        const auto along = [&](float part, float radius, vec3 aside = {0, 0, 0}) {
            return std::pair<vec3, float>{neck + part * (length_of - wide) * down + aside, radius};
        };
        const vec3 over{2_mm, 3_mm, 2_mm}; // it bends towards the back at its neck
        gallbladder = vein({{neck - 15_mm * down + vec3{3_mm, 5_mm, 0}, 1.6_mm},
                            {neck - 8_mm * down + vec3{1_mm, 1_mm, 0}, 1.8_mm},
                            along(0, 2.8_mm),
                            along(0.14F, 0.5F * wide, over),
                            along(0.36F, 0.85F * wide, over),
                            along(0.62F, wide, 0.6F * over),
                            along(0.85F, 0.97F * wide),
                            along(1, 0.84F * wide)},
                           cell(2_mm));
        // Its fundus lies against the wall of the abdomen.
        const mesh lumen = confined(
            make_tube(gallbladder, {.segments = count(40)}), [&](vec3 p) { return -trunk.distance(p); }, wall + 3_mm,
            7_mm);
        add(grown(lumen, 1.8_mm, 0.2F, 10_mm, seed + 70), tissue::gallbladder_wall, 7, "gallbladder wall", "body wall");
        add(lumen, tissue::bile, 9, "gallbladder", "gallbladder wall");
        seen_in_gallbladder = gallbladder[gallbladder.size() / 2].centre;
        if (of.stone == 0) return;
        // On the lowest place of its body, the patient lying on the back.
        const float size = min(0.5F * of.stone_size, 0.6F * wide);
        const tube_section here = gallbladder[gallbladder.size() * 62 / 100];
        const vec3 below = normalize(vec3{0, 0, 1} - dot(vec3{0, 0, 1}, down) * down);
        const vec3 place = seen_in_gallbladder = here.centre + (here.radii.x - 1.15F * size - 0.6_mm) * below;
        add(star_shaped(
                [&](vec3 q) { return length(q - place) - size * (1 + 0.12F * noise(seed + 71, q, 0.7F * size)); },
                place, vec3{size}, subdivisions(4)),
            media::gallstone, 10, "gallstone", "gallbladder");
    }

    vec3 on_skin(float around, float y) const {
        constexpr float film = 0.6_mm;
        swept outside = trunk;
        for (section& one : outside.sections) {
            one.half_width += of.fat + of.skin;
            one.half_thickness += of.fat + of.skin;
        }
        float within = 0, beyond = 60_mm;
        for (int i = 0; i < 20; ++i) {
            const float half = 0.5F * (within + beyond);
            (outside.distance(at(around, y, -half)) < 0 ? within : beyond) = half;
        }
        return at(around, y, -(within + film));
    }
    void add_views() {
        const convex_array& probe = presets::abdomen.probe;
        b_mode_settings settings = presets::abdomen.settings;
        // So that the skin lies on most of the curved face, also where the probe stands obliquely.
        constexpr float pressed = 7_mm, pressed_obliquely = 9_mm;
        settings.depth = 150_mm;
        // Below the ribs, up to where the hepatic veins join the vena cava; the right hepatic vein lies in the slice.
        const vec3 below = on_skin(37, margin(37) + 36_mm);
        const vec3 mouth{-21_mm, -86_mm, 76_mm}, tip{-82_mm, -48.5_mm, 87_mm};
        const vec3 to_mouth = normalize(mouth - below), to_tip = normalize(tip - below);
        made.views.push_back({"subcostal",
                              "liver with its hepatic veins, from below the ribs",
                              look_at(below, below + normalize(to_mouth + to_tip), to_mouth - to_tip),
                              probe,
                              settings,
                              {},
                              pressed_obliquely});
        settings.depth = 140_mm;
        const float side = 72, between = 0.5F * (rib_at(9, side) + rib_at(10, side));
        const vec3 beside = on_skin(side, between);
        const vec3 along_rib = on_skin(side - 4, 0.5F * (rib_at(9, side - 4) + rib_at(10, side - 4))) - beside;
        made.views.push_back({"intercostal",
                              "liver with the right portal vein, between the ninth and the tenth rib",
                              look_at(beside, {-46_mm, -31_mm, 81_mm}, along_rib),
                              probe,
                              settings,
                              {},
                              pressed_obliquely});
        // Along the gallbladder, through its stone.
        const vec3 neck = gallbladder[gallbladder.size() / 3].centre, fundus = gallbladder.back().centre;
        const vec3 above = on_skin(30, 0.6F * neck.y + 0.4F * fundus.y);
        made.views.push_back({"gallbladder",
                              "gallbladder lengthwise, the head to the left",
                              look_at(above, seen_in_gallbladder, fundus - neck),
                              probe,
                              settings,
                              {},
                              pressed});
        // Straight in, along the kidney, which is towards the feet.
        const auto at_kidney = [&](vec3 from) {
            const float along = (from.y - kidney_centre.y) / long_axis.y;
            return look_at(from, kidney_centre + along * long_axis, long_axis);
        };
        const float flank = 100;
        made.views.push_back({"morison",
                              "kidney lengthwise beside the liver: the hepatorenal recess",
                              at_kidney(on_skin(flank, rib_at(11, flank) + 11_mm)),
                              probe,
                              settings,
                              {},
                              pressed});
        // The small face of a phased array stands between two ribs, across them.
        const float axillary = 84;
        settings = presets::heart.settings;
        settings.depth = 140_mm;
        made.views.push_back({"trauma",
                              "hepatorenal recess between the ribs, by a phased array",
                              at_kidney(on_skin(axillary, 0.5F * (rib_at(10, axillary) + rib_at(11, axillary)))),
                              presets::heart.probe,
                              settings,
                              {},
                              pressed});
    }
};

} // namespace detail

/// The right upper quadrant of the abdomen, with the lower ribs.
inline body make(const right_upper_quadrant& of) {
    return make_in_size(of, [](const right_upper_quadrant& usual) {
        detail::right_upper_quadrant_builder builder{usual};
        builder.add_wall();
        builder.add_ribs();
        builder.add_cavity();
        builder.add_kidney();
        builder.add_liver();
        builder.add_gallbladder();
        builder.add_views();
        return std::move(builder.made);
    });
}

} // namespace anatomy

#endif
