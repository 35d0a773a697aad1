#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/motion/press.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <string>
#include <utility>

using namespace insonify;

namespace press_test {
namespace {

constexpr medium air{.density = 1.2F, .sound_speed = 343};
constexpr linear_array probe{.lines = 96, .width = 30_mm};

/// A limb: a cylinder along y whose skin is at z = 0 on its top, of fat around muscle.
scene limb(float radius) {
    scene body{air};
    body.add(make_cylinder({0, -60_mm, radius}, {0, 60_mm, radius}, radius, 256, 64), tissue::fat, {.name = "skin"});
    body.add(make_cylinder({0, -50_mm, radius}, {0, 50_mm, radius}, 0.8F * radius, 128, 32), tissue::muscle);
    body.build(exec::par);
    return body;
}
/// Two layers that touch, with flat skin at z = 0.
scene layers() {
    scene body{air};
    body.add(make_box({-60_mm, -30_mm, 0}, {60_mm, 30_mm, 3_mm}, 6), tissue::fat);
    body.add(make_box({-60_mm, -30_mm, 3_mm}, {60_mm, 30_mm, 60_mm}, 6), tissue::muscle);
    body.build(exec::par);
    return body;
}

/// A probe of a user: lines ever further apart along a face like a saddle, the first one on the right.
struct own_probe {
    std::uint32_t lines = 24;
    float frequency = 5_MHz;
    float elevation_height = 6_mm;

    ray beam(float line) const {
        const float part = (line + 0.5F) / static_cast<float>(lines), x = 20_mm - 30_mm * part * (0.4F + 0.6F * part);
        return {.origin = {x, 0, 1.5_mm * std::sin(x / 8_mm)}, .direction = {0, 0, 1}};
    }
    vec2 locate(vec2) const { return {}; } // not needed
    void check() const {}
};
static_assert(transducer<own_probe>);

/// Pressed so that the point of the face that is least deep is 3 mm deep in flat skin: how deep the skin is behind the
/// face, and lines that start in air.
template <transducer Probe>
void check_skin_behind_face(const std::string& name, const Probe& of) {
    scene body{air};
    body.add(make_box({-60_mm, -40_mm, 0}, {60_mm, 40_mm, 80_mm}, 7), tissue::muscle);
    body.build(exec::par);
    const auto last = static_cast<float>(of.lines) - 0.5F;
    float highest = 0;
    for (float line = -0.5F; line <= last; line += 0.01F * static_cast<float>(of.lines))
        highest = std::min(highest, of.beam(line).origin.z);
    const pose at{.translation = {0, 0, 3_mm - highest}};
    const contact touch = press(body, of, at, {.decay = 60_mm});
    CHECK(touch.touching == of.lines);
    float smallest = 1, maximum = -1;
    for (float line = -0.5F; line <= last; line += 0.003F * static_cast<float>(of.lines)) {
        const vec3 face = at.point(of.beam(line).origin);
        const float behind = face.z - touch.deformation({face.x, 1_mm, 0}).z;
        smallest = std::min(smallest, behind);
        maximum = std::max(maximum, behind);
    }
    body.deform(exec::par, touch.deformation);
    int in_air = 0;
    for (std::uint32_t line = 0; line < of.lines; ++line)
        in_air += object_at(body, at.point(of.beam(static_cast<float>(line)).origin)) ? 0 : 1;
    MESSAGE(name, ", ", of.lines, " lines: skin is ", smallest / 1_mm, " to ", maximum / 1_mm,
            " mm behind the face, expected 0.05; ", in_air, " lines start in air");
    CHECK(smallest > 0.03_mm);
    CHECK(maximum < 0.07_mm);
    CHECK(in_air == 0);
}

} // namespace
} // namespace press_test

TEST_CASE("press: skin lies behind all of the face, whatever its shape and the spacing of its lines") {
    using press_test::check_skin_behind_face;
    for (const std::uint32_t lines : {16U, 64U, 192U}) {
        check_skin_behind_face("linear", linear_array{.lines = lines});
        check_skin_behind_face("convex", convex_array{.lines = lines});
        check_skin_behind_face("convex of 15 mm", convex_array{.lines = lines, .radius = 15_mm});
        check_skin_behind_face("phased", phased_array{.lines = lines});
    }
    check_skin_behind_face("of a user", press_test::own_probe{});
    // What is symmetric stays so.
    scene body{press_test::air};
    body.add(make_box({-60_mm, -40_mm, 0}, {60_mm, 40_mm, 80_mm}, 7), tissue::muscle);
    body.build(exec::par);
    const pressed_face face = press(body, convex_array{.lines = 16}, {.translation = {0, 0, 6_mm}}).deformation;
    for (const float x : {2_mm, 9_mm, 14_mm, 21_mm, 29_mm})
        CHECK(face({x, 0, 0}).z == doctest::Approx(face({-x, 0, 0}).z).scale(1e-30).epsilon(1e-4));
}

TEST_CASE("press: depth, force and lines of a flat face on flat skin") {
    const scene body = press_test::layers();
    for (const float depth : {-2_mm, 1_mm, 5_mm}) { // 5 mm is past the first layer
        const contact touch = press(body, press_test::probe, {.translation = {0, 0, depth}}, {.stiffness = 400});
        MESSAGE("face at ", depth * 1e3F, " mm: ", touch.depth * 1e3F, " mm deep, ", touch.force, " N, ",
                touch.touching, " lines of 96 touch");
        CHECK(std::fabs(touch.depth - max(depth, 0)) < 1_um);
        CHECK(std::fabs(touch.force - 400 * max(depth, 0)) < 1e-3F);
        CHECK(touch.pressure == doctest::Approx(400 * max(depth, 0) / (30_mm * press_test::probe.elevation_height))
                                    .scale(1e-30)
                                    .epsilon(1e-3));
        CHECK(touch.touching == (depth > 0 ? 96 : 0));
    }
    // Within the gel, lines touch though nothing is pressed.
    const contact on_gel = press(body, press_test::probe, {.translation = {0, 0, -0.3_mm}});
    CHECK(on_gel.depth == 0);
    CHECK(on_gel.touching == 96);
    // A face that lies exactly on the skin touches it.
    CHECK(press(body, press_test::probe, pose{}).touching == 96);
    CHECK_THROWS_AS(press(body, press_test::probe, {.translation = {0, 0, 25_mm}}), usage_error);
}

TEST_CASE("press on a limb: the skin lies on the face where it is pressed, and only there") {
    scene body = press_test::limb(40_mm);
    const float depth = 1.5_mm;
    const contact touch = press(body, press_test::probe, {.translation = {0, 0, depth}});
    // Where the circle is above the face: |x| < sqrt(R^2 - (R - d)^2).
    const float half = std::sqrt(40_mm * 40_mm - 38.5_mm * 38.5_mm);
    int expected = 0;
    for (int i = 0; i < 96; ++i) expected += std::fabs(30_mm * ((static_cast<float>(i) + 0.5F) / 96 - 0.5F)) < half;
    MESSAGE(touch.touching, " lines touch, expected ", expected, " and those within the gel; depth ",
            touch.depth * 1e3F, " mm, expected 1.5");
    CHECK(std::fabs(touch.depth - depth) < 0.02_mm);
    CHECK(touch.touching >= static_cast<std::uint32_t>(expected));
    CHECK(touch.touching <= 96U);
    CHECK(std::equal(touch.lines.begin(), touch.lines.end(), touch.lines.rbegin())); // left and right
    body.deform(exec::par, touch.deformation);
    const object_id skin = *body.find("skin");
    float worst = 0;
    for (float x = -11_mm; x <= 11_mm; x += 0.5_mm) {
        // From outside the body along the lines: where is the skin now?
        const auto met = first_surface(body, {.origin = {x, 0.3_mm, -20_mm}}, [&](object_id id) { return id == skin; });
        REQUIRE(met.has_value());
        const float z = met->point.z - depth; // above the face where below 0
        if (std::fabs(x) > 10_mm) continue;
        worst = max(worst, std::fabs(z));
        CHECK(z < 0); // behind the face: lines start in tissue
        CHECK(object_at(body, {x, 0.3_mm, depth}) == skin);
    }
    MESSAGE("pressed skin is within ", worst * 1e3F, " mm of the face, expected below 0.1");
    CHECK(worst < 0.1_mm);
    const auto beside = first_surface(body, {.origin = {20_mm, 0, -20_mm}}, [&](object_id id) { return id == skin; });
    CHECK(std::fabs(beside->point.z - depth) > 1_mm);
    // The next frame presses the body at rest, not the one that is pressed already.
    const contact again = press(body, press_test::probe, {.translation = {0, 0, depth}});
    CHECK(again.deformation == touch.deformation);
}

TEST_CASE("press: a curved face, and objects that do not belong to the body") {
    scene body = press_test::layers();
    const object_id needle = body.add(make_cylinder({0, 0, -30_mm}, {0, 0, 20_mm}, 0.5_mm, 16), tissue::steel);
    body.build(exec::par);
    const convex_array probe{};
    const contact touch =
        press(body, probe, {.translation = {0, 0, 2_mm}}, {}, [&](object_id id) { return id != needle; });
    MESSAGE("a curved face 2 mm deep: ", touch.touching, " of ", probe.lines, " lines touch");
    CHECK(std::fabs(touch.depth - 2_mm) < 0.05_mm);
    CHECK(touch.touching < probe.lines);
    CHECK(touch.lines[probe.lines / 2] == 1);
    CHECK(touch.lines[0] == 0);
    CHECK_THROWS_AS(press(body, probe, {}, {.decay = 0}), usage_error);
    CHECK_THROWS_AS(press(body, probe, {}, {.recovery = std::numeric_limits<float>::infinity()}), usage_error);
}

TEST_CASE("what a probe touches stays in touch, whatever else deforms and in whatever order") {
    using namespace press_test;
    const scene bodies[] = {layers(), limb(60_mm)};
    for (const scene& at_rest : bodies) {
        scene body = at_rest;
        for (const float beside : {1_mm, 3_mm, 6_mm}) {
            const pose at{.translation = {0, 0, 4_mm}};
            const contact touch = press(body, probe, at);
            CHECK(touch.touching == probe.lines);
            const vec3 entry{-0.5F * probe.width - beside, 0, at_rest.box().lower.z + 1_mm};
            const needle_drag drag{.entry = entry, .tip = entry + vec3{20_mm, 0, 15_mm}};
            const breathing chest{.amplitude = 5_mm, .time = 1};
            const auto in_air = [&](const auto& map) {
                body.deform(exec::par, map);
                int lines = 0;
                for (std::uint32_t line = 0; line < probe.lines; ++line)
                    lines += object_at(body, at.point(probe.beam(static_cast<float>(line)).origin)) ? 0 : 1;
                return lines;
            };
            const auto own = [&](vec3 rest) { return drag(touch.deformation(rest)); };
            const int found[] = {in_air(touch.deformation),
                                 in_air(compose(drag, touch.deformation)),
                                 in_air(compose(touch.deformation, drag)),
                                 in_air(compose(chest, drag, touch.deformation)),
                                 in_air(compose(touch.deformation, chest, drag)),
                                 in_air(keep_contact(own, touch.deformation))};
            for (const int lines : found) {
                MESSAGE((beside * 1e3F), " mm beside the face: ", lines, " of 96 lines start in air, expected 0");
                CHECK(lines == 0);
            }
        }
    }
}

TEST_CASE("what a probe touches stays in touch where tissue moves along the face") {
    using namespace press_test;
    constexpr float radius = 40_mm;
    scene bodies[] = {scene{air}, scene{air}, scene{air}};
    bodies[0].add(make_box({-60_mm, -40_mm, 0}, {60_mm, 40_mm, 60_mm}, 7), tissue::muscle);
    bodies[1].add(make_cylinder({0, -60_mm, radius}, {0, 60_mm, radius}, radius, 512, 128), tissue::muscle);
    bodies[2].add(make_sphere({0, 0, radius}, radius, 7), tissue::muscle);
    const vec3 ways[] = {{1, 0, 0}, {1, 0, 1}, {-1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {-1, 0.5F, 0.3F}};
    float front = -1, behind = -1;
    for (int k = 0; k < 3; ++k) {
        scene& body = bodies[k].build(exec::par);
        const pose at{.translation = {0, 0, 5_mm}};
        const contact touch = press(body, probe, at);
        for (const vec3 way : ways)
            for (const float amplitude : {2_mm, 5_mm, 8_mm}) {
                const auto map =
                    compose(touch.deformation, breathing{.direction = way, .amplitude = amplitude, .time = 2});
                for (float x = -25_mm; x < 25_mm; x += 0.1_mm)
                    for (float y = -8_mm; y < 8_mm; y += 0.5_mm) {
                        const float away = k == 0 ? 0 : k == 1 ? x * x : x * x + y * y;
                        const vec3 now = map({x, y, k == 0 ? 0 : radius - std::sqrt(radius * radius - away)});
                        if (std::fabs(now.x) > 0.5F * probe.width || std::fabs(now.y) > 1_mm) continue;
                        front = std::max(front, now.z - at.translation.z);
                        behind = std::max(behind, at.translation.z - now.z);
                    }
                body.deform(exec::par, map);
                int in_air = 0;
                for (std::uint32_t line = 0; line < probe.lines; ++line)
                    in_air += object_at(body, at.point(probe.beam(static_cast<float>(line)).origin)) ? 0 : 1;
                CAPTURE(k);
                CAPTURE(way.x);
                CAPTURE(way.y);
                CAPTURE(amplitude);
                CHECK(in_air == 0);
            }
    }
    MESSAGE("skin is ", -front / 1_mm, " to ", behind / 1_mm, " mm behind the face, expected 0 to 0.4");
    CHECK(front < 0);
    CHECK(behind < 0.4_mm);
}

TEST_CASE("the plane face of a phased array presses as that of a linear one of its width; a probe that looks around "
          "does not") {
    scene body{tissue::air};
    body.add(make_box({-60_mm, -60_mm, -4_mm}, {60_mm, 60_mm, 80_mm}, 4), tissue::muscle);
    body.build(exec::par);
    const phased_array sector{.lines = 64, .width = 20_mm, .elevation_height = 6_mm};
    const linear_array wide{.lines = 64, .width = 20_mm, .elevation_height = 6_mm};
    const contact of_sector = press(body, sector, pose{}), of_wide = press(body, wide, pose{});
    CHECK(of_sector.depth == doctest::Approx(4e-3).scale(1e-30));
    CHECK(of_sector.deformation.right - of_sector.deformation.left == doctest::Approx(20e-3).scale(1e-30));
    CHECK(of_sector.touching == 64);
    CHECK(of_sector.pressure > 0);
    CHECK(of_sector.pressure == doctest::Approx(static_cast<double>(of_wide.pressure)).epsilon(0.02).scale(1e-30));
    CHECK_THROWS_WITH_AS(
        press(body, radial_array{}, pose{}),
        "press: the lines of the probe run all around it, so it has no face that presses; use a linear, "
        "convex or phased array",
        usage_error);
}

TEST_CASE("press: what is stiff does not move; the tissue above it gives way without folding over") {
    scene body{press_test::air};
    body.add(make_box({-60_mm, -30_mm, 0}, {60_mm, 30_mm, 60_mm}, 6), tissue::muscle);
    const object_id bone = body.add(make_cylinder({0, -40_mm, 22_mm}, {0, 40_mm, 22_mm}, 10_mm, 96, 32), tissue::bone,
                                    {.priority = 1}); // its top is 12 mm below the skin
    body.build(exec::par);
    const auto is_bone = [&](object_id id) { return id == bone; };
    const auto pressed = [&](float depth) {
        return press(body, press_test::probe, {.translation = {0, 0, depth}}, {}, any_object{}, is_bone);
    };
    const pressed_face face = pressed(5_mm).deformation;
    face.check();
    CHECK(face({0, 0, 0}).z == doctest::Approx(4.95_mm).scale(1e-30)); // the skin, 0.05 mm behind the face
    float largest = 0;
    for (int i = -40; i <= 40; ++i) {
        const float x = 0.25_mm * static_cast<float>(i), top = 22_mm - std::sqrt(std::max(100_mm * 1_mm - x * x, 0.0F));
        const float moved = face({x, 0, top}).z - top;
        largest = std::max(largest, moved);
        for (float z = top; z < 45_mm; z += 1_mm) CHECK(face({x, 0, z}).z - z <= moved + 1_um);
        float before = -1;
        for (float z = 0; z < 45_mm; z += 0.2_mm) {
            const vec3 now = face({x, 0.5_mm, z});
            CHECK(now.z > before);
            before = now.z;
            CHECK(length(face.rest_of(now) - vec3{x, 0.5_mm, z}) < 1_um);
        }
    }
    MESSAGE("the surface of the bone moves by up to ", largest * 1e6F, " um");
    CHECK(largest < 1_um);
    // Beside the bone it holds the tissue less and less: S grows by 2 mm a mm from where the cylinder falls off as steeply,
    // within a cell of the grid, which is 1 mm wide.
    const auto stop = [](float x) {
        const float steep = 10_mm * 2 / std::sqrt(5.0F), top = 22_mm - 10_mm / std::sqrt(5.0F);
        return std::exp(-(top + 2 * (x - steep)) / 20_mm);
    };
    const auto beside = [&](float x) { return 4.95_mm * (std::exp(-1.0F) - stop(x)) / (1 - stop(x)); };
    for (const float x : {11_mm, 12.5_mm, 14_mm}) {
        const float moved = face({x, 0, 20_mm}).z - 20_mm;
        CHECK(moved > beside(x - 1.2_mm));
        CHECK(moved < beside(x + 0.2_mm));
    }
    CHECK_NOTHROW(pressed(8_mm)); // 20 mm (1 - exp(-12 / 20)) = 9.02 mm
    CHECK_THROWS_AS(pressed(10_mm), usage_error);
    CHECK_NOTHROW(press(body, press_test::probe, {.translation = {0, 0, 10_mm}}));
    // Or it gives way as far as it can, above the bone and beside it.
    const contact deep =
        press(body, press_test::probe, {.translation = {0, 0, 25_mm}}, {.yields = true}, any_object{}, is_bone);
    CHECK_NOTHROW(deep.deformation.check());
    CHECK(deep.depth == doctest::Approx(25_mm).scale(1e-30));
    CHECK(deep.deformation.depth_at({0, 0}) == doctest::Approx(0.75F * 9.02_mm).scale(1e-30).epsilon(1e-3));
    CHECK(deep.deformation.depth_at({14_mm, 0}) == doctest::Approx(15_mm).scale(1e-30));

    // A bare bone below the face: it stays, and nothing is pressed.
    scene bare{press_test::air};
    const object_id ball = bare.add(make_sphere({0, 0, 22_mm}, 10_mm, 5), tissue::bone);
    bare.build(exec::par);
    bare.deform(exec::par,
                press(bare, press_test::probe, {.translation = {0, 0, 11_mm}}, {}, any_object{}, [&](object_id id) {
                    return id == ball;
                }).deformation);
    CHECK(bare.box(ball).lower.z == doctest::Approx(12_mm).scale(1e-30));
}

TEST_CASE("press: beside the edge of a bone tissue is sheared, and does not tear") {
    scene body{press_test::air};
    body.add(make_box({-60_mm, -30_mm, 0}, {60_mm, 30_mm, 60_mm}, 6), tissue::muscle);
    const object_id bone =
        body.add(make_box({-50_mm, -25_mm, 20_mm}, {0, 25_mm, 50_mm}), tissue::bone, {.priority = 1});
    body.build(exec::par);
    const pressed_face face =
        press(body, press_test::probe, {.translation = {0, 0, 2.5_mm}}, {}, any_object{}, [&](object_id id) {
            return id == bone;
        }).deformation;
    constexpr float z = 15_mm, step = 0.25_mm;
    const auto moved = [&](float x) { return face({x, 0, z}).z - z; };
    float steepest = 0;
    for (float x = -14_mm; x < 14_mm; x += step)
        steepest = std::max(steepest, std::fabs(moved(x + step) - moved(x)) / step);
    // The slope of d (exp(-z / D) - s) / (1 - s), s = exp(-S / D), where S begins to grow by 2.
    const float stop = std::exp(-1.0F),
                expected = 2.45_mm * 2 / 20_mm * stop * (1 - std::exp(-0.75F)) / ((1 - stop) * (1 - stop));
    CHECK(steepest < 1.05F * expected);
    CHECK(steepest > 0.8F * expected);
    CHECK(moved(-10_mm) ==
          doctest::Approx(2.45_mm * (std::exp(-0.75F) - stop) / (1 - stop)).scale(1e-30).epsilon(1e-3));
    CHECK(moved(14_mm) > 2 * moved(-10_mm));
    // Nothing folds over, and nothing is refused, where bone lies beside the face.
    for (const float gap : {0.5_mm, 2_mm, 4_mm}) {
        scene near{press_test::air};
        near.add(make_box({-60_mm, -30_mm, 0}, {60_mm, 30_mm, 60_mm}, 6), tissue::muscle);
        const object_id rib = near.add(make_box({15_mm + gap + 1.2_mm, -20_mm, 1_mm}, {40_mm, 20_mm, 10_mm}),
                                       tissue::bone, {.priority = 1});
        near.build(exec::par);
        const pressed_face deep =
            press(near, press_test::probe, {.translation = {0, 0, 6_mm}}, {}, any_object{}, [&](object_id id) {
                return id == rib;
            }).deformation;
        deep.check();
        float thinnest = 1;
        for (float x = -30_mm; x <= 40_mm; x += 0.7_mm)
            for (float depth = 0; depth < 40_mm; depth += 0.5_mm)
                thinnest = std::min(thinnest, (deep({x, 0, depth + 0.5_mm}).z - deep({x, 0, depth}).z) / 0.5_mm);
        CHECK(thinnest > 0.02F);
        CHECK(deep.depth_at({0, 0}) == doctest::Approx(5.95_mm).scale(1e-30));
    }
}

TEST_CASE("press: nothing stiff moves, wherever it lies under the face and beside it, and the skin stays on the face") {
    mesh slope = make_box({-40_mm, -20_mm, -2_mm}, {40_mm, 20_mm, 2_mm}, 5);
    for (vec3& p : slope.positions) p.z += 22_mm + 0.3F * p.x;
    const struct {
        const char* name;
        mesh bone;
    } cases[] = {
        {"sphere", make_sphere({0, 0, 25_mm}, 10_mm, 5)},
        {"beside the face", make_box({21_mm, -20_mm, 5_mm}, {35_mm, 20_mm, 15_mm}, 5)},
        {"large, beside the face", make_box({21_mm, -60_mm, 5_mm}, {90_mm, 60_mm, 15_mm})},
        {"under half of the face", make_box({0, -20_mm, 10_mm}, {35_mm, 20_mm, 20_mm}, 5)},
        {"along, in front of the face", make_box({-30_mm, 6_mm, 8_mm}, {30_mm, 12_mm, 18_mm}, 5)},
        {"across the face", make_cylinder({-0.5_mm, -25_mm, 14_mm}, {-0.5_mm, 25_mm, 14_mm}, 5_mm, 48, 20)},
        {"thinner than the columns", make_cylinder({0.6_mm, -25_mm, 8_mm}, {0.6_mm, 25_mm, 8_mm}, 0.2_mm, 12, 20)},
        {"slope", slope}};
    for (const auto& one : cases) {
        scene body{press_test::air};
        body.add(make_box({-100_mm, -80_mm, 0}, {100_mm, 80_mm, 60_mm}, 5), tissue::muscle);
        const object_id bone = body.add(one.bone, tissue::bone, {.priority = 1});
        body.build(exec::par);
        const linear_array probe{};
        const pose at{.translation = {0, 0, 5_mm}};
        const pressed_face face =
            press(body, probe, at, {}, any_object{}, [&](object_id id) { return id == bone; }).deformation;
        face.check();
        body.deform(exec::par, face);
        float largest = 0;
        for (std::size_t i = 0; i < one.bone.positions.size(); ++i)
            largest = std::max(largest, length(std::as_const(body).positions(bone)[i] - one.bone.positions[i]));
        MESSAGE(std::string{one.name}, ": moves by up to ", largest / 1_um, " um, expected 0");
        CHECK(largest < 1_um);
        float off = 0, thinnest = 1;
        for (float x = -19_mm; x < 19_mm; x += 0.1_mm) off = std::max(off, std::fabs(face({x, 0, 0}).z - 4.95_mm));
        CHECK(off < 1_um);
        for (float x = -30_mm; x <= 30_mm; x += 1.1_mm)
            for (float y = -20_mm; y <= 20_mm; y += 1.3_mm)
                for (float z = 0; z < 40_mm; z += 0.5_mm)
                    thinnest = std::min(thinnest, (face({x, y, z + 0.5_mm}).z - face({x, y, z}).z) / 0.5_mm);
        CHECK(thinnest > 0.02F); // nothing folds over
    }
    // 3 mm beside bone tissue sinks as if it lay 6 mm deeper, or a cell of the grid less.
    scene body{press_test::air};
    body.add(make_box({-100_mm, -80_mm, 0}, {100_mm, 80_mm, 60_mm}, 5), tissue::muscle);
    const object_id bone = body.add(make_box({3_mm, -20_mm, 8_mm}, {35_mm, 20_mm, 20_mm}), tissue::bone);
    body.build(exec::par);
    const pressed_face face =
        press(body, linear_array{}, {.translation = {0, 0, 5_mm}}, {}, any_object{}, [&](object_id id) {
            return id == bone;
        }).deformation;
    const auto above = [](float below) {
        const float stop = std::exp(-below / 20_mm);
        return 4.95_mm * (std::exp(-0.5F) - stop) / (1 - stop);
    };
    const float moved = face({0, 0, 10_mm}).z - 10_mm;
    CHECK(moved < above(14.1_mm));
    CHECK(moved > above(14_mm - 2 * 1.2_mm));
    CHECK(face({3_mm, 0, 8_mm}).z == doctest::Approx(8_mm).scale(1e-30));
}
