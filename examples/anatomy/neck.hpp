#ifndef INSONIFY_EXAMPLES_ANATOMY_NECK_HPP
#define INSONIFY_EXAMPLES_ANATOMY_NECK_HPP

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

/// What varies from neck to neck: lengths in metres.
///
/// Sources of the ranges: carotid: Krejza et al., Stroke 2006 37:1103. Wall: Touboul et al., Cerebrovasc. Dis. 2012
/// 34:290 (Mannheim consensus). Trachea: Breatnach et al., Am. J. Roentgenol. 1984 142:903. The others: Standring,
/// Gray's Anatomy, 41st edition, and convention.
struct neck {
    float side = 0;
    float variant = 1;
    float resolution = 1;
    float size = 1;
    float skin = 1.7_mm;
    float fat = 2.8_mm;
    float muscle = 1;
    float carotid = 6.3_mm;
    float wall = 0.65_mm;
    float carotid_shift = 0;
    float division = 48_mm;
    float jugular_width = 12.5_mm;
    float jugular_height = 8_mm;
    float jugular_shift = 0;
    float lobe_width = 17_mm;
    float lobe_depth = 16_mm;
    float lobe_length = 50_mm;
    float isthmus = 3_mm;
    float trachea = 18.5_mm;
    float oesophagus = 7_mm;
    float roots = 1;
    float roots_shift = 0;
    float second_vein = 1;

    static const std::vector<member<neck>>& members() {
        using of = neck;
        static const std::vector<member<neck>> all{
            {"side", "", "side of the views: 0 left, 1 right", &of::side, 0, 1, true},
            {"variant", "", "number of the irregularities of all surfaces", &of::variant, 0, 65535, true},
            {"resolution", "", "the cells of all meshes are divided by it", &of::resolution, 0.3F, 2},
            {"size", "", "height over the usual one, 1.68 m: lengths without a parameter follow it", &of::size, 0.9F,
             1.1F},
            {"skin", "m", "thickness of the skin", &of::skin, 1.4_mm, 2.2_mm},
            {"fat", "m", "thickness of the subcutaneous fat", &of::fat, 1.5_mm, 8_mm},
            {"muscle", "", "thickness of the muscles over its usual value", &of::muscle, 0.8F, 1.2F},
            {"carotid", "m", "inner diameter of the common carotid artery", &of::carotid, 5.2_mm, 7.5_mm},
            {"wall", "m", "thickness of its intima and media", &of::wall, 0.45_mm, 1_mm},
            {"carotid_shift", "m", "distance of the carotid artery from its usual place, to the side",
             &of::carotid_shift, -1.5_mm, 2.5_mm},
            {"division", "m", "height of its division above the middle of the seventh vertebra", &of::division, 36_mm,
             52_mm},
            {"jugular_width", "m", "inner width of the internal jugular vein", &of::jugular_width, 9_mm, 16_mm},
            {"jugular_height", "m", "its inner height", &of::jugular_height, 4_mm, 11_mm},
            {"jugular_shift", "m", "distance of the vein from its usual place beside the artery, to the side",
             &of::jugular_shift, -2_mm, 3_mm},
            {"lobe_width", "m", "width of a lobe of the thyroid", &of::lobe_width, 15_mm, 20_mm},
            {"lobe_depth", "m", "its depth", &of::lobe_depth, 13_mm, 18_mm},
            {"lobe_length", "m", "its length", &of::lobe_length, 40_mm, 60_mm},
            {"isthmus", "m", "thickness of the thyroid's isthmus", &of::isthmus, 2_mm, 5_mm},
            {"trachea", "m", "outer width of the trachea", &of::trachea, 16_mm, 21_mm},
            {"oesophagus", "m", "distance of the oesophagus from the midline, to the left", &of::oesophagus, 4_mm,
             10_mm},
            {"roots", "", "diameter of the nerve roots over its usual value", &of::roots, 0.8F, 1.2F},
            {"roots_shift", "m", "distance of the roots from their usual place, along their groove towards the skin",
             &of::roots_shift, -1.5_mm, 2_mm},
            {"second_vein", "", "external jugular vein: 0 none, 1 present", &of::second_vein, 0, 1, true},
        };
        return all;
    }
};

namespace detail {

/// A neck in the making. x points to the patient's left, y towards the feet, z to the back: transverse images are seen
/// from the feet, as is usual. y is 0 at the middle of the seventh vertebra, z at the deep fascia in front.
struct neck_builder : builder {
    const neck& of;
    swept fascia{};              ///< the investing fascia: all muscles lie below it
    swept airway{};              ///< the trachea's outside
    std::vector<swept> straps{}; ///< what presses on the thyroid
    std::vector<std::vector<tube_section>> roots{};
    float sign = 1; ///< of x on the side of the views

    static constexpr float top = -70_mm, bottom = 52_mm;

    explicit neck_builder(const neck& parameters) : of{parameters} {
        sign = of.side > 0 ? -1.0F : 1.0F;
        seed = 1000 * static_cast<std::uint64_t>(of.variant);
        fascia = {.sections = {{top - 1_mm, {0, 52_mm}, 60_mm, 52_mm},
                               {-20_mm, {0, 52.5_mm}, 60_mm, 52.5_mm},
                               {10_mm, {0, 53_mm}, 61_mm, 53_mm},
                               {bottom + 1_mm, {0, 54_mm}, 66_mm, 54_mm}},
                  .power = 1.8F,
                  .start = 1_mm,
                  .end = 1_mm,
                  .waves = 0.08_mm,
                  .seed = seed + 4};
    }

    float cell(float usual) const { return usual / of.resolution; }
    /// Height of the carotid's division: the region ends above it.
    float division() const { return min(of.division, -top - 16_mm); }
    std::string sided(float side, const std::string& name) const { return (side > 0 ? "left " : "right ") + name; }
    /// Depth below the fascia, metres.
    float depth(vec3 p) const { return -fascia.distance(p); }
    /// A point at a depth below the fascia: below that of the given x, along the normal there.
    vec3 under(float x, float y, float deep) const {
        const vec3 on = on_fascia(x, y);
        return on + deep * inward(x, y);
    }
    vec3 on_fascia(float x, float y) const {
        const section here = fascia.at(y);
        const float part = clamp(std::fabs(x) / here.half_width, 0, 0.999F);
        const float high = std::pow(1 - std::pow(part, fascia.power), 1 / fascia.power);
        return {x, y, here.centre.y - here.half_thickness * high};
    }
    vec3 inward(float x, float y) const {
        const vec3 along = on_fascia(x + 1_mm, y) - on_fascia(x - 1_mm, y);
        return normalize(vec3{-along.z, 0, along.x});
    }
    /// A section that is parallel to the fascia, on either side.
    section parallel(float y, float x, float deep, float half_width, float half_thickness, float turned = 0,
                     float bend = 14) const {
        const vec3 centre = under(x, y, deep), n = inward(x, y);
        return {y, {centre.x, centre.z}, half_width, half_thickness, std::atan2(-n.x, n.z) + turned, bend};
    }
    /// The same on the other side of the body.
    static swept mirrored(swept of, float side) {
        if (side < 0)
            for (section& one : of.sections) {
                one.centre.x = -one.centre.x;
                one.turn = -one.turn;
            }
        return of;
    }
    static std::vector<tube_section> mirrored(std::vector<tube_section> line, float side) {
        if (side < 0)
            for (tube_section& one : line) one.centre.x = -one.centre.x;
        return line;
    }

    swept muscle(std::vector<section> table, std::uint64_t number, float power = 2.3F) const {
        for (section& one : table) one.half_thickness *= of.muscle;
        return {.sections = std::move(table),
                .power = power,
                .start = 5_mm,
                .end = 5_mm,
                .waves = 0.22_mm,
                .seed = seed + number};
    }
    void add_muscle(const swept& shape, const medium& inside, int priority, const std::string& name,
                    float size = 1.6_mm) {
        add(confined(
                shape.surface(cell(size)), [&](vec3 p) { return depth(p); }, 0.25_mm),
            inside, priority, name, "deep fascia");
    }

    void add_skin() {
        const float coarse = min(cell(3.6_mm), 4_mm);
        swept outside = fascia;
        outside.start = outside.end = 2_mm;
        outside.waves = 0.12_mm;
        outside.seed = seed + 1;
        add(outside.surface(coarse, of.fat + of.skin + 7_mm), tissue::gel, -1000, "gel", "");
        add(outside.surface(coarse, of.fat + of.skin), tissue::skin, 0, "skin", "gel");
        outside.waves = 0.2_mm;
        add(outside.surface(coarse, of.fat), tissue::fat, 0, "fat", "skin", {0, 1, 0}, own_surface{});
        add(fascia.surface(coarse), media::deep_fascia, 0, "deep fascia", "fat", {0, 1, 0}, own_surface{});
        // The platysma tapers to all sides, and has thin places.
        const float room = min(of.fat * of.fat / (1.5_mm * 1.5_mm), 1); // in thin fat
        for (const float side : {1.0F, -1.0F}) {
            const std::uint32_t columns = static_cast<std::uint32_t>(44 * of.resolution),
                                rows = static_cast<std::uint32_t>(30 * of.resolution);
            std::vector<sheet_point> points;
            for (std::uint32_t row = 0; row < rows; ++row)
                for (std::uint32_t column = 0; column < columns; ++column) {
                    const float u = static_cast<float>(column) / static_cast<float>(columns - 1);
                    const float v = static_cast<float>(row) / static_cast<float>(rows - 1);
                    const float y = top + 4_mm + (bottom - top - 8_mm) * v;
                    const float x = side * (7_mm + 4_mm * v + u * (45_mm + 3_mm * v));
                    const float ends =
                        ramp(u, 0, 0.35F) * ramp(1 - u, 0, 0.4F) * ramp(v, 0, 0.1F) * ramp(1 - v, 0, 0.1F);
                    const float thick = (0.15F + 0.85F * ramp(noise(seed + 2, {x, y, 0}, 9_mm), -0.6F, 0.4F)) * ends;
                    const float height = 0.75_mm * room + 0.08F * max(of.fat - 1.5_mm, 0) +
                                         0.06F * of.fat * noise(seed + 3, {x, y, side}, 8_mm);
                    points.push_back({under(x, y, -height), 0.08_mm + 0.9_mm * of.muscle * thick * room});
                }
            if (side < 0) // so that the upper side stays the upper one
                for (std::size_t row = 0; row < points.size(); row += columns)
                    std::reverse(&points[row], &points[row] + columns);
            add(make_sheet(points, columns), media::platysma, 1, sided(side, "platysma"), "fat");
        }
    }

    void add_muscles() {
        for (const float side : {1.0F, -1.0F}) {
            const std::uint64_t own = side > 0 ? 100 : 200;
            const auto place = [&](std::vector<section> table, std::uint64_t number, float power = 2.3F) {
                return mirrored(muscle(std::move(table), own + number, power), side);
            };
            const auto named = [&](const char* name) { return sided(side, name); };
            const float m = of.muscle;
            const swept sternomastoid = place(
                {parallel(top, 51_mm, 4.2_mm * m, 18_mm, 4.2_mm), parallel(-30_mm, 45_mm, 4.2_mm * m, 19.5_mm, 4.1_mm),
                 parallel(0, 38.5_mm, 4.1_mm * m, 19.5_mm, 3.9_mm), parallel(25_mm, 30_mm, 4_mm * m, 18_mm, 3.7_mm),
                 parallel(bottom, 20_mm, 3.8_mm * m, 15_mm, 3.4_mm)},
                1, 2.1F);
            add_muscle(sternomastoid, tissue::thin_muscle, 5, named("sternocleidomastoid"));
            const swept sternohyoid = place({parallel(top, 8.5_mm, 1.9_mm * m, 7_mm, 1.7_mm),
                                             parallel(-30_mm, 10_mm, 1.8_mm * m, 7.6_mm, 1.6_mm),
                                             parallel(0, 11.5_mm, 1.7_mm * m, 8.6_mm, 1.5_mm),
                                             parallel(bottom, 13.5_mm, 1.7_mm * m, 10_mm, 1.5_mm)},
                                            2, 2.5F);
            add_muscle(sternohyoid, tissue::thin_muscle, 6, named("sternohyoid"));
            const swept sternothyroid = place({parallel(-34_mm, 14_mm, 4.6_mm * m, 6_mm, 1.2_mm, 0.12F),
                                               parallel(-15_mm, 14.5_mm, 4.7_mm * m, 8.5_mm, 1.4_mm, 0.1F, 24),
                                               parallel(10_mm, 14_mm, 4.7_mm * m, 10.5_mm, 1.5_mm, 0.08F, 26),
                                               parallel(bottom, 11_mm, 4.6_mm * m, 10_mm, 1.5_mm, 0)},
                                              3, 2.4F);
            add_muscle(sternothyroid, tissue::thin_muscle, 4, named("sternothyroid"));
            straps.push_back(sternohyoid);
            straps.push_back(sternothyroid);
            straps.push_back(sternomastoid);
            add_muscle(place({{top, {9_mm, 33.5_mm}, 6.5_mm, 3.6_mm, 0.3F, 12},
                              {-20_mm, {12.5_mm, 34.2_mm}, 8.3_mm, 4.3_mm, 0.42F, 16},
                              {10_mm, {14_mm, 36_mm}, 8.6_mm, 4.5_mm, 0.48F, 16},
                              {bottom, {10.5_mm, 37_mm}, 6.5_mm, 3.2_mm, 0.4F, 10}},
                             4),
                       tissue::thin_muscle, 3, named("longus colli"));
            add_muscle(place({{top, {17.5_mm, 35_mm}, 7_mm, 4_mm, 0.45F, 10},
                              {-35_mm, {21_mm, 35.5_mm}, 6_mm, 3.3_mm, 0.5F, 10},
                              {-10_mm, {23.5_mm, 37.5_mm}, 3_mm, 1.8_mm, 0.6F, 0}},
                             5),
                       tissue::thin_muscle, 2, named("longus capitis"));
            add_muscle(place({{-52_mm, {31_mm, 37_mm}, 4_mm, 2.6_mm, -0.7F, 0},
                              {-25_mm, {33_mm, 36_mm}, 7.5_mm, 4.4_mm, -0.72F, 0},
                              {0, {36.3_mm, 35_mm}, 9.3_mm, 4.8_mm, -0.7F, -12},
                              {25_mm, {39_mm, 33.5_mm}, 9_mm, 5.2_mm, -0.55F, -14},
                              {bottom, {40_mm, 31_mm}, 8_mm, 5_mm, -0.4F, -10}},
                             6),
                       tissue::thin_muscle, 4, named("scalenus anterior"));
            add_muscle(place({{-62_mm, {38_mm, 45_mm}, 5.5_mm, 4.2_mm, -0.75F, 0},
                              {-25_mm, {42.5_mm, 44.5_mm}, 9_mm, 6_mm, -0.75F, 8},
                              {0, {47_mm, 44.8_mm}, 10.5_mm, 7.2_mm, -0.72F, 10},
                              {25_mm, {49.5_mm, 45_mm}, 11_mm, 7.8_mm, -0.65F, 10},
                              {bottom, {51_mm, 45_mm}, 11_mm, 8_mm, -0.6F, 8}},
                             7),
                       tissue::thin_muscle, 3, named("scalenus medius"));
            add_muscle(place({{-35_mm, {45_mm, 54_mm}, 5_mm, 3.8_mm, -0.5F, 0},
                              {0, {48_mm, 56_mm}, 8.5_mm, 5.5_mm, -0.45F, 8},
                              {bottom, {51.5_mm, 59_mm}, 9.5_mm, 6.5_mm, -0.4F, 8}},
                             8),
                       tissue::thin_muscle, 2, named("scalenus posterior"));
            add_muscle(place({{top, {50_mm, 56_mm}, 8.5_mm, 6.5_mm, -0.9F, 10},
                              {0, {51_mm, 66_mm}, 10.5_mm, 7_mm, -0.75F, 12},
                              {bottom, {53_mm, 73_mm}, 11_mm, 7_mm, -0.6F, 10}},
                             9),
                       tissue::muscle, 1, named("levator scapulae"), 2.2_mm);
            add_muscle(
                place({{top, {27_mm, 80_mm}, 25_mm, 19_mm, 0.1F, 0}, {bottom, {28_mm, 82_mm}, 26_mm, 20_mm, 0.1F, 0}},
                      10, 2.6F),
                tissue::muscle, 0, named("paraspinal muscles"), 3_mm);
            // From the scapula, beneath the sternocleidomastoid, to the hyoid bone.
            const auto belly = [&](float x, float y, float deep, float width, float thick, float turned) {
                const vec3 n = inward(x, y);
                return tube_section{under(x, y, deep * m), {width, thick * m}, std::atan2(-n.x, n.z) + turned};
            };
            const auto line = mirrored(
                smooth_line(
                    {belly(54_mm, 40_mm, 3.6_mm, 3.4_mm, 1.5_mm, 0), belly(48_mm, 27_mm, 6.5_mm, 4_mm, 1.6_mm, 0),
                     belly(38_mm, 14_mm, 9.2_mm, 2.6_mm, 1.0_mm, 0), belly(29_mm, -2_mm, 9_mm, 3_mm, 1.2_mm, 0),
                     belly(21_mm, -24_mm, 7_mm, 4_mm, 1.5_mm, 0), belly(15_mm, -50_mm, 4.6_mm, 4_mm, 1.5_mm, 0)},
                    cell(2_mm)),
                side);
            mesh omohyoid = make_tube(untwisted(line), {.segments = 20, .across = {side, 0, 0}});
            add(confined(
                    std::move(omohyoid), [&](vec3 p) { return depth(p); }, 0.25_mm),
                tissue::thin_muscle, 4, named("omohyoid"), "deep fascia");
        }
    }
    /// Turns are those of the ellipses about the line, not about y.
    static std::vector<tube_section> untwisted(std::vector<tube_section> line) {
        const float first = line.front().turn;
        for (tube_section& one : line) one.turn = 0.6F * (first - one.turn);
        return line;
    }

    void add_airway() {
        const float r = 0.5F * of.trachea, deep = 0.5F * 0.9F * of.trachea;
        const float front = 4.6_mm + 0.5F * of.isthmus + 1.5_mm * of.muscle;
        const vec2 centre{0, front + deep};
        const float back = centre.y + 0.62F * deep;
        airway = {.sections = {{top, centre, r, deep}, {bottom, centre + vec2{0, 4_mm}, r, deep}},
                  .power = 2.3F,
                  .start = 2_mm,
                  .end = 2_mm,
                  .waves = 0.15_mm,
                  .seed = seed + 20};
        const auto back_at = [&](float y) { return back + 4_mm * (y - top) / (bottom - top); };
        const auto flat_behind = [&](mesh m, float inwards) { // its back is a membrane without cartilage
            for (vec3& p : m.positions) p.z = smooth_min(p.z, back_at(p.y) - inwards, 2_mm);
            return m;
        };
        const float size = cell(1.5_mm);
        add(flat_behind(airway.surface(size), 0), tissue::fascia, 7, "trachea", "deep fascia");
        add(flat_behind(airway.surface(size, -1.5_mm), 1.3_mm), tissue::mucosa, 7, "tracheal mucosa", "trachea");
        add(flat_behind(airway.surface(size, -2.1_mm), 1.9_mm), tissue::air, 7, "tracheal air", "tracheal mucosa");
        mesh rings;
        for (int ring = 0; ring < 13; ++ring) {
            const float y = -24_mm + 6_mm * static_cast<float>(ring) +
                            0.5_mm * noise(seed + 21, {static_cast<float>(ring), 0, 0}, 1);
            if (y > bottom - 4_mm) break;
            std::vector<tube_section> line;
            const section here = airway.at(y);
            const std::uint32_t points = static_cast<std::uint32_t>(30 * of.resolution);
            for (std::uint32_t i = 0; i <= points; ++i) {
                const float part = static_cast<float>(i) / static_cast<float>(points);
                const float angle = (-0.5F + 1.58F * (part - 0.5F)) * pi, within = 1_mm;
                vec3 place = airway.point(here, angle, -within);
                place.z = smooth_min(place.z, back_at(y) - 1.5_mm, 2_mm);
                line.push_back({place, {1.9_mm - 0.3_mm * std::fabs(2 * part - 1), 0.55_mm}});
            }
            append(rings, make_tube(line, {.segments = 16, .across = {0, 1, 0}}));
        }
        add(std::move(rings), tissue::cartilage, 8, "tracheal cartilages", "trachea");

        add_larynx(front);

        // The gullet: to the left of the midline on either side of the views.
        const float z = back + 4.4_mm;
        const auto gullet = [&](float w, float t, float waves, std::uint64_t number, float shift, float shorter) {
            return swept{.sections = {{top + shorter, {0.6F * of.oesophagus, z}, w * 1.05F, t * 0.9F, 0.05F, -20},
                                      {-15_mm, {0.75F * of.oesophagus, z + 0.4_mm}, w, t, 0.12F, -26},
                                      {8_mm, {of.oesophagus + shift, z + 1.6_mm}, w, t * 1.05F, 0.2F, -30},
                                      {bottom - shorter, {of.oesophagus, z + 4_mm}, w * 1.05F, t, 0.1F, -20}},
                         .power = 2,
                         .start = 3_mm,
                         .end = 3_mm,
                         .waves = waves,
                         .seed = seed + number};
        };
        add(gullet(8.2_mm, 3.9_mm, 0.35_mm, 22, 0, 0).surface(size), tissue::muscularis, 6, "oesophagus",
            "deep fascia");
        add(gullet(5_mm, 1.6_mm, 0.4_mm, 23, 0.4_mm, 2_mm).surface(cell(1.2_mm)), tissue::mucosa, 6,
            "oesophageal mucosa", "oesophagus");
        add(gullet(3.2_mm, 0.35_mm, 0.15_mm, 24, 0.7_mm, 4_mm).surface(cell(0.9_mm)), media::mucus, 6,
            "oesophageal lumen", "oesophageal mucosa");
    }

    /// What is above the trachea: seen from far, it is beside the views.
    void add_larynx(float front) {
        constexpr float lower = -29_mm; // border of the thyroid cartilage is 6 mm above
        const float r = 0.5F * of.trachea;
        const swept inner{.sections = {{top, {0, front + 10.5_mm}, r + 3.2_mm, 10.5_mm},
                                       {lower + 1_mm, {0, front + 10.5_mm}, r + 2_mm, 10.2_mm}},
                          .power = 2.2F,
                          .start = 3_mm,
                          .end = 3_mm,
                          .waves = 0.2_mm,
                          .seed = seed + 25};
        add(inner.surface(cell(2.2_mm)), tissue::muscularis, 5, "laryngeal muscles", "deep fascia");
        const auto cricoid = [&](vec3 p) { // a signet ring: higher behind
            const float behind = ramp(p.z, front, front + 18_mm),
                        shell = std::fabs(airway.distance(p) - 0.5_mm) - 1.3_mm;
            return smooth_max(shell, std::fabs(p.y - lower + 5_mm * behind) - (3_mm + 5_mm * behind), 2_mm);
        };
        add(mesh_implicit(cricoid, {{-r - 4_mm, lower - 14_mm, front - 4_mm}, {r + 4_mm, lower + 6_mm, front + 24_mm}},
                          min(cell(1.4_mm), 1.4_mm), {.max_slope = 2}),
            tissue::cartilage, 8, "cricoid cartilage", "deep fascia");
        const auto columns = static_cast<std::uint32_t>(40 * of.resolution),
                   rows = static_cast<std::uint32_t>(14 * of.resolution) + 2;
        std::vector<sheet_point> shield;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t column = 0; column < columns; ++column) {
                const float u = 2 * static_cast<float>(column) / static_cast<float>(columns - 1) - 1;
                const float v = static_cast<float>(row) / static_cast<float>(rows - 1);
                const float from_middle = std::sqrt(u * u + 0.02F) - 0.14F;
                const float notch = 7_mm * std::exp(-u * u / 0.03F); // in its upper border
                const float y = lower - 32_mm + notch + (26_mm - notch) * v;
                const vec3 place{(r + 9_mm) * u, y, front - 0.8_mm + 2_mm * v + 24_mm * from_middle};
                shield.push_back({place, 0.3_mm + 1.9_mm * ramp(v, 0, 0.15F) * ramp(1 - v, 0, 0.15F) *
                                                      ramp(1 - std::fabs(u), 0, 0.1F)});
            }
        add(make_sheet(shield, columns), tissue::cartilage, 6, "thyroid cartilage", "deep fascia");
        for (const float side : {1.0F, -1.0F}) {
            const swept thyrohyoid = mirrored(muscle({{top, {12.5_mm, front + 6_mm}, 6_mm, 1.5_mm, 0.75F, 8},
                                                      {lower - 12_mm, {12_mm, front + 7.5_mm}, 6_mm, 1.4_mm, 0.8F, 8}},
                                                     side > 0 ? 26U : 27U),
                                              side);
            add_muscle(thyrohyoid, tissue::thin_muscle, 4, sided(side, "thyrohyoid"));
        }
    }

    void add_spine() {
        const float size = cell(2.2_mm);
        const char* names[] = {"fifth cervical vertebra", "sixth cervical vertebra", "seventh cervical vertebra",
                               "first thoracic vertebra"};
        for (int i = 0; i < 4; ++i) {
            const bool has_tubercle = i < 2;
            const float large = i == 1 ? 1.25F : 1.0F, long_process = i >= 2 ? 1.12F : 1.0F;
            const vec3 middle{0, 18.5_mm * static_cast<float>(i - 2), 45_mm + 0.5_mm * static_cast<float>(i)};
            const auto bone = [&](vec3 world) {
                vec3 p = world - middle;
                p.x = std::fabs(p.x); // both sides
                const float waist = 1.3_mm * (1 - (p.y / 7_mm) * (p.y / 7_mm));
                const vec2 across{p.x / 14_mm, p.z / 8.5_mm};
                const float round = (length(across) - 1) * 9.5_mm + waist;
                float all = smooth_max(round, std::fabs(p.y) - 6.9_mm, 3_mm);
                const auto join = [&](float part, float width) { all = smooth_min(all, part, width); };
                const float far = 1_mm * long_process;
                join(round_cone(p, {9_mm, 0, 0}, 2.9_mm, {20 * far, 1.5_mm, -1_mm}, 2_mm), 3_mm);
                if (has_tubercle)
                    join(round_cone(p, {20_mm, 1.5_mm, -1.5_mm}, 2.1_mm, {23.5_mm, 2.5_mm, -5.5_mm * large},
                                    1.6_mm * large),
                         2_mm);
                join(round_cone(p, {14_mm, 0, 8_mm}, 3.2_mm, {25 * far, 2.5_mm, 6_mm}, 2.5_mm), 3_mm);
                join(round_cone(p, {25 * far, 2.5_mm, 6_mm}, 2.5_mm, {29 * far, 4_mm, 7_mm}, 2.1_mm), 2_mm);
                join(round_cone(p, {21 * far, 2.5_mm, -0.5_mm}, 1.7_mm, {25 * far, 2.5_mm, 5_mm}, 1.7_mm), 2_mm);
                join(ellipsoid(p - vec3{18_mm, 0, 13_mm}, {6.5_mm, 9_mm, 6_mm}), 3_mm);
                join(round_cone(p, {16_mm, 0, 15_mm}, 3.2_mm, {0, 3_mm, 25_mm}, 3_mm), 3_mm);
                join(round_cone(p, {0, 3_mm, 25_mm}, 3_mm, {0, 8_mm, 33_mm * long_process}, 2.4_mm), 3_mm);
                return all + 0.25_mm * noise(seed + 30, world, 5_mm);
            };
            const aabb box{middle + vec3{-36_mm, -12_mm, -13_mm}, middle + vec3{36_mm, 14_mm, 42_mm}};
            add(mesh_implicit(bone, box, size, {.max_slope = 1.7F}), tissue::bone, 9, names[i], "deep fascia");
        }
        const swept column{.sections = {{top, {0, 44_mm}, 12.6_mm, 7.6_mm}, {bottom, {0, 46.5_mm}, 13.4_mm, 8_mm}},
                           .power = 2,
                           .waves = 0.2_mm,
                           .seed = seed + 31};
        add(column.surface(cell(2.4_mm)), media::disc, 8, "discs", "deep fascia");
    }

    /// Where the common carotid artery of the left side runs, from below.
    std::array<vec3, 4> carotid_course() const {
        const float aside = of.carotid_shift;
        return {vec3{24.5_mm + aside, bottom - 6_mm, 27_mm}, vec3{26.5_mm + aside, 25_mm, 25_mm},
                vec3{28_mm + aside, 0, 23.6_mm}, vec3{29_mm + aside, -20_mm, 22.8_mm}};
    }
    /// An artery. @param line  in the direction of flow
    void flows(const std::string& name, std::vector<tube_section> line, float velocity, float resistive_index) {
        made.vessels.push_back(
            {.name = name, .line = std::move(line), .peak_velocity = velocity, .resistive_index = resistive_index});
    }
    /// A vein, of the central pressure in a patient who lies.
    void drains(const std::string& name, std::vector<tube_section> line, float velocity) {
        made.vessels.push_back({.name = name,
                                .type = vessel::kind::vein,
                                .line = std::move(line),
                                .peak_velocity = velocity,
                                .pressure = 6_mmHg});
    }
    void add_vessels() {
        const float r = 0.5F * of.carotid;
        for (const float side : {1.0F, -1.0F}) {
            const bool viewed = side == sign;
            const std::uint64_t own = side > 0 ? 300 : 350;
            const float up = -division();
            // Common and internal carotid artery, with the bulb where it begins; and the external one. Both reach
            // beyond the view above the division.
            const float last = max(up - 18_mm, top + 6_mm), between = max(up - 10_mm, last + 4_mm);
            const auto round = [&](float x, float y, float z, float radius) {
                return tube_section{{x, y, z}, vec2{radius}};
            };
            const auto carotid = [&](float x, float y, float z, float radius) {
                return round(x + of.carotid_shift, y, z, radius * r);
            };
            std::vector<tube_section> course;
            constexpr float widths[] = {1.06F, 1.02F, 1, 1};
            for (std::size_t i = 0; i < 4; ++i) course.push_back({carotid_course()[i], vec2{widths[i] * r}});
            for (const tube_section& one :
                 {carotid(30_mm, up + 6_mm, 22.6_mm, 1.08F), carotid(31.5_mm, up - 3_mm, 23.5_mm, 1.2F),
                  carotid(33.7_mm, between, 25.6_mm, 0.9F), carotid(35_mm, last, 26.8_mm, 0.8F)})
                course.push_back(one);
            const auto line = mirrored(smooth_line(course, cell(1.5_mm)), side);
            const auto segments = static_cast<std::uint32_t>((viewed ? 40 : 24) * of.resolution);
            const std::string name = sided(side, "common carotid artery"),
                              branch = sided(side, "external carotid artery");
            const std::vector<wall_layer> fine{{"intima", tissue::intima, 0.28F * of.wall, 0.12F},
                                               {"media", tissue::tunica_media, 0.72F * of.wall, 0.15F},
                                               {"adventitia", tissue::adventitia, 0.5_mm, 0.7F}};
            const std::vector<wall_layer> plain{{"adventitia", tissue::adventitia, 0.55_mm + of.wall, 0.3F}};
            std::vector<wall_layer> layers = viewed ? fine : plain;
            add_vessel(make_tube(line, {.segments = segments}), layers, 10, name, own, "deep fascia");
            const auto other = mirrored(
                smooth_line({carotid(30.2_mm, up + 3_mm, 22.4_mm, 0.62F), carotid(28.6_mm, up - 5_mm, 20.3_mm, 0.68F),
                             carotid(27.4_mm, between, 18.8_mm, 0.62F), carotid(26.6_mm, last, 17.8_mm, 0.58F)},
                            cell(1.5_mm)),
                side);
            for (wall_layer& one : layers) one.thickness *= 0.75F; // a smaller vessel
            add_vessel(make_tube(other, {.segments = segments}), layers, 10, branch, own + 10, "deep fascia");
            if (viewed) {
                // Blood flows towards the head.
                flows(name, line, 0.8F, 0.72F);
                flows(branch, other, 0.8F, 0.8F);
            }

            // The right jugular vein is the larger one: Lobato et al., J. Anesth. 1999.
            const float large = side > 0 ? 0.95F : 1.08F, w = 0.5F * of.jugular_width * large,
                        t = 0.5F * of.jugular_height * large;
            const float clear = 8.3_mm * of.muscle + t; // beneath the sternocleidomastoid
            const auto beside = [&](float y, float x, float more, float wide, float turned) {
                return parallel(y, x + of.carotid_shift + of.jugular_shift, clear + more, w * wide, t * wide, turned,
                                10);
            };
            const swept vein = mirrored(
                swept{.sections = {beside(top + 3_mm, 49_mm, 0, 0.75F, 0.1F), beside(-35_mm, 47_mm, 0, 0.9F, 0.08F),
                                   beside(0, 45_mm, 0, 1, 0.1F), beside(25_mm, 43.5_mm, 0, 1.02F, 0.08F),
                                   beside(bottom - 3_mm, 38.5_mm, 0, 0.95F, 0.05F)},
                      .power = 2,
                      .start = 4_mm,
                      .end = 4_mm,
                      .waves = 0.22_mm,
                      .seed = seed + own + 20},
                side);
            add_vessel(vein.surface(cell(viewed ? 1.1_mm : 1.8_mm)), {{"wall", tissue::vein_wall, 0.3_mm, 0.35F}}, 8,
                       sided(side, "internal jugular vein"), own + 20, "deep fascia");
            if (viewed)
                drains(sided(side, "internal jugular vein"), lumen_of(vein, top + 8_mm, bottom - 8_mm, 25), 0.2F);

            // The vagus nerve in the groove behind both, and the vertebral artery in the foramina of the vertebrae.
            std::vector<tube_section> groove;
            for (const float y : {top + 4_mm, -40_mm, -20_mm, 0.0F, 20_mm, bottom - 4_mm}) {
                const section beside_it = vein.at(y);
                vec3 artery = line.front().centre;
                for (const tube_section& one : line)
                    if (std::fabs(one.centre.y - y) < std::fabs(artery.y - y)) artery = one.centre;
                const vec3 to_vein = normalize(vec3{beside_it.centre.x - artery.x, 0, beside_it.centre.y - artery.z});
                const vec3 behind = side > 0 ? vec3{-to_vein.z, 0, to_vein.x} : vec3{to_vein.z, 0, -to_vein.x};
                const float outside = r + of.wall + 0.55_mm;
                const vec3 at = artery + (outside + 0.8_mm) * to_vein + (0.5F * outside + 0.45F * t + 1.1_mm) * behind;
                groove.push_back(round(at.x, y, at.z, 0.75_mm));
            }
            const auto vagus = smooth_line(groove, cell(2_mm));
            mesh nerve = make_tube(vagus, {.segments = 16});
            add(grown(nerve, 0.35_mm, 0.2F, 3_mm, seed + own + 31), tissue::epineurium, 9, sided(side, "vagus nerve"),
                "deep fascia");
            add(std::move(nerve), tissue::nerve_fascicle, 9, sided(side, "vagus nerve: fascicle"),
                sided(side, "vagus nerve"));
            if (!viewed) continue;
            const auto vertebral =
                mirrored(smooth_line({round(20_mm, bottom - 3_mm, 36_mm, 1.9_mm), round(20_mm, 25_mm, 39_mm, 1.8_mm),
                                      round(19_mm, 2_mm, 42.5_mm, 1.7_mm), round(17.5_mm, -16_mm, 47.5_mm, 1.7_mm),
                                      round(17.5_mm, top + 3_mm, 47_mm, 1.7_mm)},
                                     cell(2_mm)),
                         side);
            add_vessel(make_tube(vertebral, {.segments = 24}), {{"wall", tissue::adventitia, 0.35_mm, 0.3F}}, 10,
                       sided(side, "vertebral artery"), own + 40, "deep fascia");
            flows(sided(side, "vertebral artery"), vertebral, 0.5F, 0.68F);
            if (of.second_vein > 0) {
                const auto on = [&](float x, float y, float wide) {
                    return tube_section{under(x, y, 0.3_mm), {wide, 0.75F * wide}};
                };
                const auto external = mirrored(
                    smooth_line({on(38_mm, top + 4_mm, 1.1_mm), on(42_mm, -35_mm, 1.3_mm), on(46_mm, 0, 1.4_mm),
                                 on(49_mm, 25_mm, 1.5_mm), on(50_mm, bottom - 5_mm, 1.4_mm)},
                                cell(2_mm)),
                    side);
                add_vessel(make_tube(external, {.segments = 20, .across = {1, 0, 0}}),
                           {{"wall", tissue::vein_wall, 0.2_mm, 0.3F}}, 3, sided(side, "external jugular vein"),
                           own + 50, "fat");
                drains(sided(side, "external jugular vein"), sections_of(places_of(external, {1, 0, 0})), 0.1F);
            }
        }
    }

    void add_roots() {
        // From the foramen above each vertebra, between the tubercles, to the groove between the scalene muscles.
        struct root {
            const char* name;
            float from, diameter;
            vec3 groove, below;
            int fascicles;
        };
        const root all[] = {
            {"fifth cervical root", -46_mm, 3_mm, {46.4_mm, -1_mm, 33.8_mm}, {50_mm, 40_mm, 33_mm}, 1},
            {"sixth cervical root", -27.5_mm, 3.6_mm, {43.6_mm, -1_mm, 36.7_mm}, {48.5_mm, 42_mm, 36.2_mm}, 2},
            {"seventh cervical root", -9.5_mm, 4.2_mm, {39.6_mm, 3_mm, 40.2_mm}, {46.5_mm, 44_mm, 39.4_mm}, 3}};
        std::uint64_t number = 400;
        for (const root& one : all) {
            const float radius = 0.5F * one.diameter * of.roots;
            const auto at = [&](vec3 p, float part) { return tube_section{p, vec2{part * radius}}; };
            const vec3 shift = of.roots_shift * normalize(vec3{6.8F, 0, -6.4F}); // along the row of the roots
            const vec3 exit{22_mm, one.from, 46_mm}, gutter{29_mm, one.from + 2_mm, 45.5_mm};
            const auto line = mirrored(
                smooth_line({at(exit, 0.9F), at(gutter, 0.95F), at(one.groove + shift, 1), at(one.below + shift, 1)},
                            cell(2_mm)),
                sign);
            roots.push_back(line);
            const std::string name = sided(sign, one.name);
            add(make_tube(line, {.segments = 28}), tissue::epineurium, 5, name, "deep fascia");
            for (int i = 0; i < one.fascicles; ++i) {
                const float turned = 2 * pi * (static_cast<float>(i) / static_cast<float>(one.fascicles)) + 0.7F;
                const float fraction = one.fascicles == 1 ? 0.8F : one.fascicles == 2 ? 0.47F : 0.42F;
                std::vector<tube_section> inner = line;
                for (std::size_t k = 0; k < inner.size(); ++k) {
                    tube_section& s = inner[k];
                    const vec3 along = line[std::min(k + 1, line.size() - 1)].centre - line[k > 0 ? k - 1 : 0].centre;
                    const vec3 aside = normalize(cross(along, vec3{0, 0, 1})), other = normalize(cross(along, aside));
                    const float off = one.fascicles == 1 ? 0 : 0.43F * s.radii.x;
                    s.centre += off * (std::cos(turned) * aside + std::sin(turned) * other);
                    s.radii *= fraction * (1 + 0.1F * noise(seed + number, s.centre, 6_mm));
                }
                inner.erase(inner.begin());
                inner.pop_back();
                add(make_tube(inner, {.segments = 18}), tissue::nerve_fascicle, 5,
                    name + ": fascicle " + std::to_string(i + 1), name);
                ++number;
            }
        }
    }

    void add_thyroid() {
        const float w = 0.5F * of.lobe_width, t = 0.5F * of.lobe_depth, half = 0.5F * of.lobe_length;
        const float middle = 0; // of the lobes along y
        std::vector<swept> lobes;
        for (const float side : {1.0F, -1.0F}) {
            const float own = side > 0 ? 0.96F : 1.04F; // the right one is larger
            const float x = 0.5F * of.trachea + 0.80F * w, z = 7.4_mm * of.muscle + 0.9F * t;
            lobes.push_back(mirrored(
                {.sections = {{middle - half, {x + 1.5_mm, z + 4_mm}, 0.35F * w, 0.4F * t, 0.9F, 0},
                              {middle - 0.45F * half, {x + 1_mm, z + 2.5_mm}, 0.78F * w * own, 0.8F * t, 0.6F, 8},
                              {middle + 0.15F * half, {x, z + 0.8_mm}, w * own, t, 0.4F, 12},
                              {middle + 0.6F * half, {x - 0.5_mm, z + 0.8_mm}, 0.95F * w, 0.95F * t, 0.3F, 12},
                              {middle + half, {x - 1.5_mm, z + 2_mm}, 0.6F * w, 0.6F * t, 0.2F, 0}},
                 .power = 2.2F,
                 .start = 0.5F * half,
                 .end = 0.45F * half,
                 .waves = 0.35_mm,
                 .seed = seed + (side > 0 ? 60U : 61U)},
                side));
        }
        std::vector<std::vector<tube_section>> carotids;
        const float r = 0.5F * of.carotid + of.wall + 0.9_mm;
        std::vector<tube_section> course;
        for (const vec3 place : carotid_course()) course.push_back({place, vec2{r}});
        course.push_back({{30_mm + of.carotid_shift, -42_mm, 22.6_mm}, vec2{r}});
        for (const float side : {1.0F, -1.0F}) carotids.push_back(mirrored(smooth_line(course, 12_mm), side));
        const auto gland = [&](vec3 p) {
            const float lobe = smooth_min(lobes[0].distance(p), lobes[1].distance(p), 2_mm);
            const float shell = airway.distance(p);
            const float across = std::fabs(shell - 0.2_mm - 0.5F * of.isthmus) - 0.5F * of.isthmus;
            const float behind = p.z - (airway.at(p.y).centre.y - 1_mm);
            const float slab = smooth_max(smooth_max(across, std::fabs(p.y - 7_mm) - 7_mm, 3_mm), behind, 4_mm);
            float all = smooth_min(lobe, slab, 5_mm);
            if (all > 2.5_mm) return all;
            all += 0.3_mm * noise(seed + 62, p, 8_mm);
            all = less(all, shell - 0.2_mm, 2.2_mm);
            for (const auto& one : carotids) all = less(all, chain(p, one), 3_mm);
            for (const swept& one : straps) all = less(all, one.distance(p) - 0.3_mm, 2_mm);
            return all;
        };
        const aabb box{{-34_mm, middle - half - 3_mm, 0}, {34_mm, max(middle + half, 14_mm) + 3_mm, 34_mm}};
        mesh thyroid =
            mesh_implicit(gland, box, min(cell(1.5_mm), max(0.5F * of.isthmus, 1.3_mm)), {.max_slope = 1.6F});
        add(grown(thyroid, 0.28_mm, 0.25F, 5_mm, seed + 63), tissue::capsule, 4, "thyroid capsule", "deep fascia");
        add(std::move(thyroid), tissue::thyroid, 4, "thyroid", "thyroid capsule");
        for (int i = 0; i < 3; ++i) { // small vessels in the lobe of the views
            const float y = 3_mm + 7_mm * static_cast<float>(i - 1), x = 0.5F * of.trachea + 0.8F * w;
            const auto at = [&](float across, float along, float deep) {
                return tube_section{{x + across * w, y + along * 1_mm, 7.4_mm + (0.9F + deep) * t},
                                    vec2{0.45_mm + 0.1_mm * static_cast<float>(i % 2)}};
            };
            const float lean = 0.17F * static_cast<float>(i - 1);
            const auto line = mirrored(
                smooth_line({at(0.45F, 3, 0.25F + lean), at(0.1F, 0, 0.1F + lean), at(-0.3F, -3, 0.05F + lean)},
                            cell(0.7_mm)),
                sign);
            add(make_tube(line, {.segments = 12}), tissue::blood, 5,
                sided(sign, "thyroid vein " + std::to_string(i + 1)), "thyroid");
        }
    }

    vec3 on_skin(float x, float y, float film) const { return under(x, y, -(of.fat + of.skin + film)); }
    void add_views() {
        const linear_array& probe = presets::nerve_block.probe;
        b_mode_settings settings = presets::nerve_block.settings;
        constexpr float film = 0.4_mm;
        const auto across = [&](float x, float y, float tilt = 0) {
            const vec3 from = on_skin(sign * x, y, film), n = inward(sign * x, y);
            const vec3 lateral{n.z, 0, -n.x};
            const vec3 towards = std::cos(tilt) * n + sign * std::sin(tilt) * lateral;
            return look_at(from, from + towards, lateral);
        };
        const auto centre_at = [](const std::vector<tube_section>& line, float y) {
            vec3 nearest = line.front().centre;
            for (const tube_section& one : line)
                if (std::fabs(one.centre.y - y) < std::fabs(nearest.y - y)) nearest = one.centre;
            return nearest;
        };
        const std::vector<tube_section>& carotid = made.vessels.front().line;
        made.views.push_back({"carotid_transverse",
                              "common carotid artery and jugular vein, across",
                              across(33_mm, 1_mm),
                              probe,
                              settings,
                              {}});
        made.views.push_back({"carotid_division",
                              "internal and external carotid artery above the division, across",
                              across(34_mm, max(-division() - 9_mm, top + 11_mm)),
                              probe,
                              settings,
                              {}});
        const vec3 upper = centre_at(carotid, -24_mm), lower = centre_at(carotid, 6_mm),
                   middle = 0.5F * (upper + lower);
        const vec3 from = on_skin(sign * 34_mm, middle.y, film);
        settings.depth = 35_mm;
        made.views.push_back({"carotid_lengthwise",
                              "common carotid artery, along it, the head to the left",
                              look_at(from, middle, lower - upper),
                              probe,
                              settings,
                              {}});
        settings.depth = 40_mm;
        made.views.push_back({"thyroid", "thyroid and trachea, across", across(8_mm, 6_mm), probe, settings, {}});
        settings.depth = 34_mm;
        const pose groove = across(50.5_mm, 6_mm);
        // Between the upper two roots, from behind, in the slice.
        vec3 target = groove.local_point(0.5F * (centre_at(roots[0], 6_mm) + centre_at(roots[1], 6_mm)));
        target = groove.point({target.x + sign * 2.2_mm, 0, target.z});
        const vec3 out = groove.direction({sign * std::cos(32_deg), 0, -std::sin(32_deg)});
        float within = 0, beyond = 60_mm;
        for (int i = 0; i < 30; ++i) {
            const float half = 0.5F * (within + beyond);
            (depth(target + half * out) > -(of.fat + of.skin) ? within : beyond) = half;
        }
        made.views.push_back({"interscalene", "roots of the brachial plexus between the scalene muscles", groove, probe,
                              settings, needle_path{target + within * out, target}});
    }
};

} // namespace detail

/// The neck from the fourth cervical to the first thoracic vertebra, with all structures on the side of the views.
inline body make(const neck& of) {
    return make_in_size(of, [](const neck& usual) {
        detail::neck_builder builder{usual};
        builder.add_skin();
        builder.add_muscles();
        builder.add_airway();
        builder.add_spine();
        builder.add_vessels();
        builder.add_roots();
        builder.add_thyroid();
        builder.add_views();
        return std::move(builder.made);
    });
}

} // namespace anatomy

#endif
