#ifndef INSONIFY_EXAMPLES_ANATOMY_LUMBAR_HPP
#define INSONIFY_EXAMPLES_ANATOMY_LUMBAR_HPP

#include <insonify/examinations.hpp>
#include "builder.hpp"
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace anatomy {

/// What varies in the lumbar spine: lengths in metres.
///
/// Sources of the ranges: vertebrae and canal: Panjabi et al., Spine 1992 17:299; Zhou et al., Eur. Spine J. 2000 9:242.
/// Interlaminar space: Ebraheim et al., Spine 1997 22:2183. Ligamentum flavum: Horlocker 2000, Reg. Anesth. Pain Med.
/// 25:411, and Standring, Gray's Anatomy, 41st edition. Depth of the epidural space: Balki et al., Anesth. Analg. 2009
/// 108:1876. The others: convention.
struct lumbar {
    float side = 1;
    float variant = 1;
    float resolution = 1;
    float size = 1;
    float skin = 2.2_mm;
    float fat = 9_mm;
    float muscle = 1;
    float pitch = 36_mm;
    float interspace = 13_mm;
    float flexion = 0.5F;
    float canal_depth = 17_mm;
    float canal_width = 23_mm;
    float spinous = 30_mm;
    float flavum = 4_mm;
    float epidural = 4_mm;

    static const std::vector<member<lumbar>>& members() {
        using of = lumbar;
        static const std::vector<member<lumbar>> all{
            {"side", "", "side of the paramedian view: 0 left, 1 right", &of::side, 0, 1, true},
            {"variant", "", "number of the irregularities of all surfaces", &of::variant, 0, 65535, true},
            {"resolution", "", "the cells of all meshes are divided by it", &of::resolution, 0.3F, 2},
            {"size", "", "height over the usual one, 1.68 m: lengths without a parameter follow it", &of::size, 0.9F,
             1.1F},
            {"skin", "m", "thickness of the skin", &of::skin, 1.6_mm, 3_mm},
            {"fat", "m", "thickness of the subcutaneous fat", &of::fat, 3_mm, 25_mm},
            {"muscle", "", "thickness of the muscles over its usual value", &of::muscle, 0.85F, 1.1F},
            {"pitch", "m", "distance between the middles of two vertebral bodies", &of::pitch, 33_mm, 39_mm},
            {"interspace", "m", "height of the gap between two laminae, not flexed", &of::interspace, 9_mm, 16_mm},
            {"flexion", "", "how far the lordosis is straightened: 0 upright, 1 bent", &of::flexion, 0, 1},
            {"canal_depth", "m", "depth of the vertebral canal", &of::canal_depth, 14_mm, 20_mm},
            {"canal_width", "m", "width of the vertebral canal", &of::canal_width, 20_mm, 27_mm},
            {"spinous", "m", "length of the spinous processes, from the laminae on", &of::spinous, 24_mm, 35_mm},
            {"flavum", "m", "thickness of the ligamentum flavum", &of::flavum, 2.5_mm, 5.5_mm},
            {"epidural", "m", "depth of the epidural space in the midline, behind the dura", &of::epidural, 2.5_mm,
             6_mm},
        };
        return all;
    }
};

namespace detail {

/// A lumbar spine in the making. x points to the patient's right, y towards the feet, z to the front: transverse images
/// are seen from the feet, the patient lying on the face. y is 0 in the middle between the third and the fourth lumbar
/// vertebra.
struct lumbar_builder : builder {
    /// Where a vertebra is: in its own coordinates x is as above, y along the spine, z across it, 0 in the middle of
    /// the canal.
    struct frame {
        vec3 middle{0, 0, 0}; ///< of the canal
        float tilt = 0;       ///< of y to the back, radians
        vec3 along() const { return {0, std::cos(tilt), -std::sin(tilt)}; }
        vec3 forward() const { return {0, std::sin(tilt), std::cos(tilt)}; }
        vec3 point(vec3 p) const { return middle + vec3{p.x, 0, 0} + p.y * along() + p.z * forward(); }
        vec3 local(vec3 p) const { return {p.x - middle.x, dot(p - middle, along()), dot(p - middle, forward())}; }
    };

    const lumbar& of;
    std::array<frame, 5> bones{}; ///< L2 to L5, and the sacrum
    swept back{};                 ///< under the thoracolumbar fascia
    float half_lamina = 9_mm;
    float behind = 25.5_mm; ///< from the middle of the canal to that of a vertebral body

    static constexpr float top = -118_mm, bottom = 165_mm, width = 125_mm, thickness = 75_mm, roundness = 3.2F;
    static constexpr float body_depth = 17_mm, body_height = 13.5_mm, tip = 4_mm; ///< of a process below the fascia
    static constexpr float lordosis[] = {-9_deg, 0, 8_deg, 19_deg, 40_deg};

    explicit lumbar_builder(const lumbar& parameters) : of{parameters} {
        seed = 1000 * static_cast<std::uint64_t>(of.variant);
        behind = 0.5F * of.canal_depth + body_depth;
        float tilts[5];
        for (int i = 0; i < 5; ++i) tilts[i] = lordosis[i] * (1 - 0.7F * of.flexion);
        // The middles of the bodies, from the third vertebra on to both sides.
        const float deep = tip + of.spinous + 14.5_mm + behind; // from the fascia
        vec3 bodies[5];
        const auto step = [&](int i) { return frame{{0, 0, 0}, 0.5F * (tilts[i] + tilts[i + 1])}.along(); };
        bodies[1] = vec3{0, 0, deep} - 0.5F * of.pitch * step(1);
        bodies[2] = vec3{0, 0, deep} + 0.5F * of.pitch * step(1);
        bodies[0] = bodies[1] - of.pitch * step(0);
        bodies[3] = bodies[2] + of.pitch * step(2);
        bodies[4] = bodies[3] + 0.94F * of.pitch * step(3);
        for (int i = 0; i < 5; ++i) {
            bones[static_cast<std::size_t>(i)].tilt = tilts[i];
            bones[static_cast<std::size_t>(i)].middle =
                bodies[i] - behind * bones[static_cast<std::size_t>(i)].forward();
        }
        const float spacing = of.pitch - (behind + 14_mm) * 8_deg; // of the laminae, not flexed
        half_lamina = 0.5F * (spacing - of.interspace);
        // The fascia follows the tips of the processes.
        std::vector<section> table;
        const auto add_section = [&](float y, float z) { table.push_back({y, {0, z + thickness}, width, thickness}); };
        const vec3 first = tip_of(0);
        add_section(top, first.z - tip - 2_mm);
        for (int i = 0; i < 4; ++i) add_section(tip_of(i).y, tip_of(i).z - tip);
        const vec3 crest = bones[4].point({0, 22_mm, -24_mm}), low = bones[4].point({0, 55_mm, -22_mm});
        add_section(crest.y, crest.z - tip);
        add_section(min(low.y, bottom - 5_mm), low.z - tip);
        add_section(bottom + 12_mm, low.z - tip);
        back = {.sections = std::move(table), .power = roundness, .start = 1_mm, .end = 1_mm};
    }

    float cell(float usual) const { return usual / of.resolution; }
    std::uint32_t count(float usual) const {
        return static_cast<std::uint32_t>(max(std::round(usual * of.resolution), 8));
    }
    float length_of(int i) const { return i < 3 ? of.spinous : 0.8F * of.spinous; }
    /// The tip of a spinous process.
    vec3 tip_of(int i) const { return bones[static_cast<std::size_t>(i)].point({0, 8_mm, -14.5_mm - length_of(i)}); }
    /// Between two neighbours.
    frame between(int i) const {
        const frame &upper = bones[static_cast<std::size_t>(i)], &lower = bones[static_cast<std::size_t>(i) + 1];
        return {0.5F * (upper.middle + lower.middle), 0.5F * (upper.tilt + lower.tilt)};
    }

    void add_skin() {
        const float coarse = min(cell(6_mm), 8_mm); // the muscles lie close below
        swept outside = back;
        outside.waves = 0.12_mm;
        outside.seed = seed + 1;
        constexpr float fascia = 1.4_mm;
        add(outside.surface(coarse, fascia + of.fat + of.skin + 14_mm), tissue::gel, -1000, "gel", "");
        add(outside.surface(coarse, fascia + of.fat + of.skin), tissue::skin, 0, "skin", "gel", {0, 1, 0});
        outside.waves = 0.2_mm;
        add(outside.surface(coarse, fascia + of.fat), tissue::fat, 0, "fat", "skin", {0, 1, 0}, own_surface{});
        add(back.surface(coarse, fascia), tissue::fascia, 0, "thoracolumbar fascia", "fat", {0, 1, 0});
        add(back.surface(coarse), media::deep_fascia, 0, "back", "thoracolumbar fascia", {0, 1, 0});
    }

    /// How high the fascia is.
    float fascia_at(float y) const {
        const section here = back.at(clamp(y, top + 2_mm, bottom));
        return here.centre.y - here.half_thickness;
    }
    void add_muscles() {
        const float m = of.muscle;
        for (const float side : {1.0F, -1.0F}) {
            const std::string sided = side > 0 ? "right " : "left ";
            const auto place = [&](float y, float x, float z, float half_width, float half_thickness, float turn = 0,
                                   float bend = 0) {
                return section{
                    y, {side * x, fascia_at(y) + z * m}, half_width, half_thickness * m, side * turn, side * bend};
            };
            const auto belly = [&](std::vector<section> table, std::uint64_t number, float power) {
                const swept shape{.sections = std::move(table),
                                  .power = power,
                                  .start = 6_mm,
                                  .end = 6_mm,
                                  .waves = 0.4_mm,
                                  .seed = seed + number + (side > 0 ? 0U : 20U)};
                constexpr float room = 1.2_mm; // for the fascia of the multifidus, below that of the back
                return confined(
                    shape.surface(cell(3_mm)), [&](vec3 p) { return -back.distance(p); }, room);
            };
            const auto muscle = [&](mesh shape, const std::string& name, int priority, vec3 fibres) {
                add(std::move(shape), media::back_muscle, priority, sided + name, "back", fibres);
            };
            // They overlap one another and the bones: priorities cut them, so that they touch.
            const float last = bottom - 8_mm;
            // Its border leans: at the fascia it is wider than at the laminae.
            const mesh multifidus =
                belly({place(top + 3_mm, 14_mm, 15_mm, 12_mm, 17_mm, 0.2F), place(0, 16_mm, 16_mm, 15_mm, 18_mm, 0.32F),
                       place(50_mm, 19_mm, 16_mm, 18_mm, 17_mm, 0.32F),
                       place(90_mm, 20_mm, 12_mm, 17_mm, 11.5_mm, 0.2F), place(last, 16_mm, 6_mm, 12_mm, 5_mm)},
                      100, 2.6F);
            // Between it and the erector spinae. Of the same priority, so that the muscle, which is added later, fills it.
            add(grown(multifidus, 0.35_mm, 0.8F, 6_mm, seed + 140), tissue::fascia, 3,
                sided + "fascia of the multifidus", "back");
            muscle(multifidus, "multifidus", 3, {-0.2F * side, -1, 0.08F});
            muscle(belly({place(top + 3_mm, 42_mm, 20_mm, 27_mm, 20_mm), place(0, 47_mm, 21_mm, 27_mm, 20.5_mm),
                          place(50_mm, 50_mm, 17_mm, 24_mm, 16.5_mm), place(90_mm, 51_mm, 9_mm, 18_mm, 8.5_mm)},
                         101, 3.2F),
                   "erector spinae", 2, {0, 1, 0});
            muscle(belly({place(top + 3_mm, 58_mm, 45_mm, 22_mm, 9_mm), place(0, 62_mm, 46_mm, 25_mm, 9_mm),
                          place(45_mm, 66_mm, 44_mm, 24_mm, 8_mm)},
                         102, 2.6F),
                   "quadratus lumborum", 1, {0, 1, 0});
            muscle(belly({place(top + 3_mm, 32_mm, 72_mm, 15_mm, 20_mm), place(0, 38_mm, 74_mm, 21_mm, 25_mm),
                          place(80_mm, 48_mm, 80_mm, 24_mm, 24_mm)},
                         103, 2.4F),
                   "psoas", 0, {0, 1, 0});
        }
    }

    /// The arch of a vertebra with its processes, in its own coordinates.
    float arch(vec3 p, int i) const {
        p.x = std::fabs(p.x);
        const float wide = 0.5F * of.canal_width, deep = 0.5F * of.canal_depth;
        const auto join = [](float& to, float part, float over) { to = smooth_min(to, part, over); };
        // Laminae: plates that slope to the back, their lower borders more than their upper ones.
        const vec2 outer{wide + 3_mm, -deep + 3_mm}, inner{0, -deep - 6_mm};
        const vec2 at{p.x, p.z + 0.2F * (p.y - 3_mm)};
        const float part = clamp(dot(at - outer, inner - outer) / dot(inner - outer, inner - outer), 0, 1);
        const float plate = length(at - outer - part * (inner - outer)) - 3_mm;
        float all = smooth_max(plate, std::fabs(p.y - 3_mm) - half_lamina, 3_mm);
        // The spinous process: a plate that is thicker at its tip.
        const float from_lamina = -deep - 6_mm - p.z, end = length_of(i);
        const float thick = 2.7_mm + 1.5_mm * ramp(from_lamina, 0.5F * end, end);
        const float high = min(half_lamina, 9_mm) + 0.5_mm;
        const float flat = smooth_max(p.x - thick, std::fabs(p.y - 4_mm - 0.13F * from_lamina) - high, 3.5_mm);
        join(all, smooth_max(flat, std::fabs(from_lamina - 0.5F * end) - 0.5F * end, 4_mm), 4_mm);
        // Pedicles, transverse and articular processes.
        join(all,
             round_cone(p, {wide + 2.5_mm, -5_mm, deep + 3_mm}, 4.6_mm, {wide + 3_mm, -5_mm, -deep + 6_mm}, 4.6_mm),
             3_mm);
        const float reach = i == 1 || i == 2 ? 41_mm : 37_mm;
        join(all, round_cone(p, {wide + 3_mm, -4_mm, -deep + 6_mm}, 4.8_mm, {reach, -6_mm, -deep + 2_mm}, 3.2_mm),
             3_mm);
        join(all,
             round_cone(p, {wide + 4_mm, -3_mm, -deep + 4_mm}, 5_mm, {wide + 8_mm, -13_mm, -deep + 1.5_mm}, 4.6_mm),
             3_mm);
        join(all, round_cone(p, {wide, 7_mm, -deep - 4_mm}, 4.8_mm, {wide + 0.8_mm, 20_mm, -deep - 5.5_mm}, 4.4_mm),
             3_mm);
        return all;
    }
    /// The back of the sacrum, in its own coordinates.
    float sacrum(vec3 p) const {
        p.x = std::fabs(p.x);
        const float wide = 0.5F * of.canal_width, deep = 0.5F * of.canal_depth;
        const auto join = [](float& to, float part, float over) { to = smooth_min(to, part, over); };
        const float from_back = p.z + deep + 6_mm - 0.1F * p.x - 0.0022F / 1_mm * (p.y - 20_mm) * (p.y - 20_mm);
        float all = smooth_max(smooth_max(std::fabs(from_back) - 3_mm, p.x - (30_mm - 0.22F * p.y), 6_mm),
                               std::fabs(p.y - 30_mm) - 29_mm, 5_mm);
        for (const float y : {12_mm, 32_mm, 50_mm}) // the median crest
            join(all, ellipsoid(p - vec3{0, y, -deep - 9_mm}, {3.4_mm, 8_mm, 8_mm - 0.06F * y}), 4_mm);
        for (const float y : {14_mm, 36_mm}) // the lateral crest, and the foramina inside it
            join(all, ellipsoid(p - vec3{27_mm - 0.2F * y, y, -deep - 5_mm}, {4_mm, 7_mm, 4_mm}), 4_mm);
        for (const float y : {22_mm, 44_mm})
            all = less(all, round_cone(p, {17_mm, y, -deep - 16_mm}, 3.2_mm, {17_mm, y, deep}, 3.2_mm), 2_mm);
        join(all, round_cone(p, {wide + 4_mm, 0, -deep + 4_mm}, 5_mm, {wide + 8_mm, -11_mm, -deep + 1_mm}, 4.6_mm),
             4_mm);
        join(all, round_cone(p, {wide + 5_mm, 2_mm, deep}, 7_mm, {wide + 6_mm, 4_mm, -deep + 2_mm}, 6_mm), 4_mm);
        join(all, round_cone(p, {20_mm, 6_mm, 14_mm}, 12_mm, {46_mm, 16_mm, 10_mm}, 13_mm), 6_mm);
        return all;
    }

    /// The ligamenta flava across the spine: two plates that meet in the midline.
    float flava(vec3 p) const {
        const float wide = 0.5F * of.canal_width, deep = 0.5F * of.canal_depth;
        const vec2 outer{wide + 1_mm, -deep + 3_mm}, inner{0, -deep - 4.5_mm};
        const vec2 at{std::fabs(p.x), p.z + 0.1F * (p.y - 3_mm)};
        const float part = clamp(dot(at - outer, inner - outer) / dot(inner - outer, inner - outer), 0, 1);
        return length(at - outer - part * (inner - outer)) - 0.5F * of.flavum;
    }

    void add_spine() {
        const char* names[] = {"second lumbar vertebra", "third lumbar vertebra", "fourth lumbar vertebra",
                               "fifth lumbar vertebra", "sacrum"};
        const float fine = cell(1.65_mm);
        std::vector<tube_section> column, canal, ligament;
        for (int i = 0; i < 5; ++i) {
            const frame& here = bones[static_cast<std::size_t>(i)];
            const auto placed = [&](mesh m) {
                for (vec3& p : m.positions) p = here.point(p);
                return m;
            };
            const float reach = 47_mm, rear = -0.5F * of.canal_depth - 6_mm - of.spinous - 5_mm;
            const auto uneven = [&](vec3 p) { return 0.3_mm * noise(seed + 30, here.point(p), 6_mm); };
            if (i < 4)
                add(placed(mesh_implicit([&](vec3 p) { return arch(p, i) + uneven(p); },
                                         {{-reach, -22_mm, rear}, {reach, 27_mm, 0.5F * of.canal_depth + 9_mm}}, fine,
                                         {.max_slope = 1.5F})),
                    tissue::bone, 9, std::string{names[i]} + ": arch", "back");
            else
                add(placed(mesh_implicit([&](vec3 p) { return sacrum(p) + uneven(p); },
                                         {{-62_mm, -20_mm, -0.5F * of.canal_depth - 20_mm}, {62_mm, 62_mm, 26_mm}},
                                         cell(2.3_mm), {.max_slope = 1.8F})),
                    tissue::bone, 9, "sacrum: back", "back");
            // The body: longer above and below than in its middle, slightly hollow behind.
            const float large = i == 4 ? 1.1F : 1.0F;
            const auto level = [&](float y, float more) {
                return section{y, {0, behind}, (22.5_mm + more) * large, body_depth + more};
            };
            swept solid{.sections = {level(-body_height, 0.4_mm), level(-body_height + 3_mm, 0.4_mm), level(0, -1.6_mm),
                                     level(body_height - 3_mm, 0.4_mm), level(body_height, 0.4_mm)},
                        .power = 2.2F,
                        .start = 2_mm,
                        .end = 2_mm,
                        .waves = 0.25_mm,
                        .seed = seed + 31};
            add(placed(solid.surface(cell(1.8_mm))), tissue::bone, 9, std::string{names[i]} + ": body", "back");
        }
        // From above the second vertebra to the sacrum.
        const auto line_at = [&](float z, vec2 radii, float y_last) {
            std::vector<tube_section> line{{bones[0].point({0, -30_mm, z}), radii}};
            for (const frame& one : bones) line.push_back({one.point({0, 0, z}), radii});
            line.push_back({bones[4].point({0, y_last, z + 2_mm}), 0.75F * radii});
            return smooth_line(line, cell(2.2_mm));
        };
        const tube_settings settings{
            .segments = count(36), .ends = tube_settings::end_shape::round, .across = {1, 0, 0}};
        add(make_tube(line_at(behind, {21.5_mm, body_depth - 0.4_mm}, 6_mm), settings), media::annulus, 8, "discs",
            "back");
        const float wide = 0.5F * of.canal_width, deep = 0.5F * of.canal_depth;
        add(make_tube(line_at(-1_mm, {wide + 1_mm, deep + 3_mm}, 30_mm), settings), media::epidural_fat, 4,
            "epidural fat", "back");
        add(make_tube(line_at(deep - 0.3_mm, {7_mm, 0.8_mm}, 12_mm), {.segments = count(24), .across = {1, 0, 0}}),
            media::dura, 7, "posterior longitudinal ligament", "back");
        // The sac lies at the front of the canal.
        const float half_sac = 0.5F * (of.canal_depth + 2_mm - of.epidural) - 0.9_mm, sac_at = deep - 0.9_mm - half_sac;
        const auto sac = line_at(sac_at, {wide - 2.5_mm, half_sac}, 22_mm);
        const mesh fluid = make_tube(sac, settings);
        add(grown(fluid, 0.7_mm, 0.2F, 8_mm, seed + 32), media::dura, 6, "dura mater", "back");
        add(fluid, media::cerebrospinal_fluid, 6, "cerebrospinal fluid", "dura mater");
        for (std::uint64_t k = 0; k < 14; ++k) { // spread over the sac, further to the sides further down
            const float angle = 2 * pi * (static_cast<float>(k) / 14 + 0.05F * hash_uniform(seed + 40, k));
            const float out = 0.25F + 0.45F * hash_uniform(seed + 41, k);
            std::vector<tube_section> root;
            for (std::size_t s = 3; s + 4 < sac.size(); ++s) {
                const float along = static_cast<float>(s) / static_cast<float>(sac.size());
                const float x = (0.75F + 0.25F * along) * out * std::cos(angle), z = 0.9F * out * std::sin(angle);
                const frame here{{0, 0, 0}, tilt_at(sac[s].centre.y)};
                const auto wave = [&](std::uint64_t of_axis) {
                    return 0.7_mm * noise(seed + 42 + 2 * k + of_axis, sac[s].centre, 24_mm);
                };
                root.push_back({sac[s].centre + vec3{x * sac[s].radii.x + wave(0), 0, 0} +
                                    (z * sac[s].radii.y + wave(1)) * here.forward(),
                                vec2{0.45_mm}});
            }
            add(make_tube(root, {.segments = count(8)}), tissue::nerve_fascicle, 7,
                "nerve root " + std::to_string(k + 1), "cerebrospinal fluid");
        }
        const char* gaps[] = {"second", "third", "fourth", "fifth"};
        for (int i = 0; i < 4; ++i) {
            const frame here = between(i);
            const float space =
                length(bones[static_cast<std::size_t>(i) + 1].middle - bones[static_cast<std::size_t>(i)].middle);
            const auto flavum = [&](vec3 p) {
                return smooth_max(flava(p), std::fabs(p.y - 3_mm) - 0.42F * space, 2_mm) +
                       0.25_mm * noise(seed + 50, p + here.middle, 6_mm);
            };
            const auto placed = [&](mesh m) {
                for (vec3& p : m.positions) p = here.point(p);
                return m;
            };
            const std::string level = std::string{gaps[i]};
            add(placed(mesh_implicit(flavum, {{-wide - 6_mm, -22_mm, -deep - 11_mm}, {wide + 6_mm, 26_mm, 4_mm}},
                                     min(cell(1.8_mm), 0.7F * of.flavum), {.max_slope = 1.6F})),
                media::ligamentum_flavum, 5, level + " ligamentum flavum", "back");
            const float rear = -deep - 6_mm - (i < 2 ? of.spinous : 0.75F * of.spinous), front = -deep - 6_mm;
            const auto sheet = [&](vec3 p) {
                const float flat = smooth_max(std::fabs(p.x) - 2.2_mm, std::fabs(p.y - 5_mm) - 0.5F * space, 2_mm);
                const float all =
                    smooth_max(flat, std::fabs(p.z - 0.5F * (front + rear)) - 0.5F * (front - rear), 3_mm);
                return smooth_max(all, back.distance(here.point(p)) + 3_mm, 2_mm) +
                       0.5_mm * noise(seed + 51, p + here.middle, 7_mm);
            };
            add(placed(mesh_implicit(sheet, {{-5_mm, -20_mm, rear - 3_mm}, {5_mm, 30_mm, front + 3_mm}},
                                     min(cell(2.2_mm), 2.8_mm), {.max_slope = 1.6F})),
                media::interspinous_ligament, 5, level + " interspinous ligament", "back", here.forward());
        }
        std::vector<tube_section> tips;
        for (int i = 0; i < 4; ++i) tips.push_back({tip_of(i) - vec3{0, 0, 1.6_mm}, {3.6_mm, 1.5_mm}});
        tips.push_back({bones[4].point({0, 12_mm, -deep - 16.5_mm}), {3_mm, 1.2_mm}});
        add(make_tube(smooth_line(tips, cell(2.5_mm)), {.segments = count(20), .across = {1, 0, 0}}), tissue::tendon, 8,
            "supraspinous ligament", "back", vec3{0, 1, 0});
    }
    float tilt_at(float y) const {
        for (std::size_t i = 0; i + 1 < bones.size(); ++i)
            if (y < bones[i + 1].middle.y) {
                const float part = clamp((y - bones[i].middle.y) / (bones[i + 1].middle.y - bones[i].middle.y), 0, 1);
                return bones[i].tilt + part * (bones[i + 1].tilt - bones[i].tilt);
            }
        return bones.back().tilt;
    }

    /// The point of the skin on a line.
    /// @param out  to the outside
    vec3 skin_on(vec3 from, vec3 out) const {
        swept outside = back;
        const float above = 1.4_mm + of.fat + of.skin;
        for (section& one : outside.sections) {
            one.half_width += above;
            one.half_thickness += above;
        }
        float within = 0, beyond = 130_mm;
        for (int i = 0; i < 22; ++i) {
            const float half = 0.5F * (within + beyond);
            (outside.distance(from + half * out) < 0 ? within : beyond) = half;
        }
        return from + within * out;
    }
    void add_views() {
        const convex_array& probe = presets::abdomen.probe;
        b_mode_settings settings = presets::abdomen.settings;
        settings.depth = 105_mm;
        constexpr float film = 1_mm, pressed = 6_mm;
        const frame gap = between(1);
        // In the middle of the canal, and between the tips of the processes behind it.
        const vec3 canal = gap.point({0, 3_mm, 0}), gap_of_tips = gap.point({0, 8_mm, -14.5_mm - of.spinous});
        const auto on_line = [&](vec3 target, vec3 out) { return skin_on(target, out) + film * out; };
        const vec3 aside = normalize(vec3{(of.side > 0 ? 1 : -1) * std::tan(24_deg), 0, 0} - gap.forward());
        const vec3 from = on_line(canal, aside);
        const pose oblique = look_at(from, canal, gap.along());
        // From below, in the slice, between the laminae to the space behind the dura.
        float through = 0;
        while (flava(gap.local(canal + through * aside)) > 0.7_mm) through += 0.1_mm;
        const vec3 target = canal + through * aside;
        const vec3 out = normalize(std::cos(30_deg) * aside + std::sin(30_deg) * gap.along());
        made.views.push_back({"paramedian_oblique",
                              "laminae lengthwise, the canal in the gaps between them, the head to the left", oblique,
                              probe, settings, needle_path{skin_on(target, out), target}, pressed});
        const vec3 backwards = normalize(gap_of_tips - canal);
        made.views.push_back({"transverse_interlaminar",
                              "across, between the third and the fourth lumbar vertebra, for a midline puncture",
                              look_at(on_line(canal, backwards), canal, {1, 0, 0}), probe, settings,
                              needle_path{skin_on(canal, backwards), canal}, pressed});
        const frame& third = bones[1];
        const vec3 process = tip_of(1);
        made.views.push_back({"transverse_spinous",
                              "across, over the spinous process of the third lumbar vertebra",
                              look_at(on_line(process, -third.forward()), process, {1, 0, 0}),
                              probe,
                              settings,
                              {},
                              pressed});
    }
};

} // namespace detail

/// The lumbar spine from the second vertebra to the sacrum, seen from behind.
inline body make(const lumbar& of) {
    return make_in_size(of, [](const lumbar& usual) {
        detail::lumbar_builder builder{usual};
        builder.add_skin();
        builder.add_muscles();
        builder.add_spine();
        builder.add_views();
        return std::move(builder.made);
    });
}

} // namespace anatomy

#endif
