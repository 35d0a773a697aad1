#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/diagnose.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <clocale>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;

namespace diagnose_test {
namespace {

const linear_array probe{.lines = 64, .width = 40_mm};

/// A bone of 10 mm radius in muscle.
scene bone_at(vec3 centre) {
    scene body{tissue::muscle};
    body.add(make_sphere(centre, 10_mm, 4), tissue::bone, {.name = "bone"});
    body.build(exec::seq);
    return body;
}

/// A cube so far down.
scene block(float depth, float edge) {
    scene body{tissue::muscle};
    body.add(make_box({0, 0, depth}, {edge, edge, depth + edge}), tissue::bone);
    body.build(exec::seq);
    return body;
}

void says(const diagnosis& found, diagnosis::problem expected, const std::string& sentence) {
    INFO(found.sentence);
    REQUIRE(found.problems.size() == 1);
    CHECK(found.problems[0] == expected);
    CHECK(found.sentence == sentence);
}

} // namespace

TEST_CASE("diagnose finds nothing wrong with a picture that shows something") {
    const diagnosis found = diagnose(bone_at({0, 0, 30_mm}), probe, pose{}, {.depth = 60_mm});
    CHECK(found.problems.empty());
    CHECK(found.sentence.empty());
}

TEST_CASE("diagnose gives the distance of objects beside the field of view") {
    // The field ends at x = 20 mm, the sphere begins at 73 - 10 mm.
    says(diagnose(bone_at({73_mm, 0, 30_mm}), probe, pose{}, {.depth = 60_mm}), diagnosis::problem::beside,
         "No line meets any object: the nearest surface is 43 mm outside the field of view; move the probe or the "
         "objects.");
    // Out of the slice plane.
    says(diagnose(bone_at({0, 35_mm, 30_mm}), probe, pose{}, {.depth = 60_mm}), diagnosis::problem::beside,
         "No line meets any object: the nearest surface is 25 mm outside the field of view; move the probe or the "
         "objects.");
    // A face of which all corners are far away: a wall beside the field.
    scene walled{tissue::muscle};
    walled.add(make_box({25_mm, -0.4F, -0.4F}, {35_mm, 0.4F, 0.4F}), tissue::bone);
    walled.build(exec::seq);
    says(diagnose(walled, probe, pose{}, {.depth = 60_mm}), diagnosis::problem::beside,
         "No line meets any object: the nearest surface is 5 mm outside the field of view; move the probe or the "
         "objects.");
}

TEST_CASE("diagnose states lengths with a decimal point, also in a locale with a decimal comma") {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "German_Germany.1252"}) // where one is installed
        if (std::setlocale(LC_ALL, name) != nullptr) break;
    if (std::string{std::localeconv()->decimal_point} != ",") MESSAGE("no locale with a comma: not tested");
    const std::pair<float, const char*> lengths[] = {
        {0.25e-6F, "0.25 um"}, {4.35e-3F, "4.35 mm"}, {43.5e-3F, "43.5 mm"}, {1.5F, "1.5 m"}, {43250, "43250 m"}};
    for (const auto& [length, text] : lengths) CHECK(detail::shown(length) == text);
    std::setlocale(LC_ALL, before.c_str());
}

TEST_CASE("diagnose reports lines that end before the first surface") {
    // The linear array's middle lines are 1/64 of 40 mm apart, so the first surface is 70 mm deep to a few micrometres.
    says(diagnose(bone_at({0, 0, 80_mm}), probe, pose{}, {.depth = 40_mm}), diagnosis::problem::too_shallow,
         "No line meets any object: the nearest surface on a line is 70 mm deep, the lines end at 40 mm; raise "
         "`depth`.");
}

TEST_CASE("diagnose reports a probe that looks away") {
    says(diagnose(bone_at({0, 0, -30_mm}), probe, pose{}, {.depth = 60_mm}), diagnosis::problem::behind,
         "No line meets any object: they are behind the probe, which looks away from them; turn it round "
         "(look_at(from, towards, lateral)).");
}

TEST_CASE("diagnose names the unit that was probably meant") {
    says(diagnose(block(30, 20), probe, pose{}, {.depth = 60_mm}), diagnosis::problem::unit,
         "The objects are 20 m across, but the lines 60 mm deep: check the unit of the mesh; it is probably 1_cm where "
         "1_mm was meant (2 m), or 1_m where 1_cm was meant (200 mm), or 1_m where 1_mm was meant (20 mm).");
    // A leg in millimetres, read in centimetres.
    says(diagnose(block(12, 8), probe, pose{}, {.depth = 60_mm}), diagnosis::problem::unit,
         "The objects are 8 m across, but the lines 60 mm deep: check the unit of the mesh; it is probably 1_cm where "
         "1_mm was meant (800 mm), or 1_m where 1_cm was meant (80 mm).");
    says(diagnose(block(0.1F, 100_um), probe, pose{}, {.depth = 60_mm}), diagnosis::problem::unit,
         "The objects are 100 um across, but the lines 60 mm deep: check the unit of the mesh; it is probably 1_mm "
         "where "
         "1_m was meant (100 mm).");
}

TEST_CASE("diagnose reports a probe in air or gas") {
    scene body{tissue::air};
    body.add(make_box({-50_mm, -50_mm, 5_mm}, {50_mm, 50_mm, 80_mm}), tissue::muscle);
    body.build(exec::seq);
    says(diagnose(body, probe, pose{}, {.depth = 60_mm}), diagnosis::problem::inside,
         "The probe is in the background, whose medium lets almost no sound out; put the face of the probe on tissue, "
         "gel "
         "or water.");
    CHECK(diagnose(body, probe, {.translation = {0, 0, 5_mm}}, {.depth = 80_mm}).problems.empty()); // on the skin
}

TEST_CASE("diagnose reports a depth of many metres, even where lines meet a surface") {
    const std::string sentence =
        "The objects are 20 mm across, but the lines 8 m deep: `depth` is in metres; write it as in 80_mm.";
    says(diagnose(block(10_mm, 20_mm), probe, pose{}, {.depth = 8}), diagnosis::problem::unit, sentence);
    const diagnosis behind = diagnose(block(-50_mm, 20_mm), probe, pose{}, {.depth = 8});
    CHECK(behind.problems == std::vector<diagnosis::problem>{diagnosis::problem::unit, diagnosis::problem::behind});
    CHECK(behind.sentence.find(sentence + " No line meets any object: they are behind the probe") == 0);
    CHECK(diagnose(block(10_mm, 20_mm), probe, pose{}, {.depth = 0.9F}).problems.empty()); // deep for tissue, but legal
}

TEST_CASE("diagnose reports a probe inside an object") {
    says(diagnose(bone_at({0, 0, 5_mm}), probe, pose{}, {.depth = 60_mm}), diagnosis::problem::inside,
         "The probe is in object 'bone', whose medium lets almost no sound out; put the face of the probe on tissue, "
         "gel or "
         "water.");
    scene room{tissue::water};
    room.add(make_sphere({0, 0, 0}, 0.5F, 4), tissue::muscle);
    room.build(exec::seq);
    const diagnosis found = diagnose(room, probe, pose{}, {.depth = 60_mm});
    REQUIRE(found.problems == std::vector<diagnosis::problem>{diagnosis::problem::inside});
    CHECK(found.sentence.find("The probe is inside object 0, whose surface is 49") == 0); // 0.5 m, less the facets
    CHECK(found.sentence.find("deeper than the 60 mm shown; raise `depth`.") != std::string::npos);
}

TEST_CASE("diagnose reports a scene without an interface") {
    scene body{tissue::water};
    body.add(make_sphere({0, 0, 30_mm}, 10_mm, 3), tissue::water);
    body.build(exec::seq);
    says(diagnose(body, probe, pose{}, {.depth = 60_mm}), diagnosis::problem::one_medium,
         "Every object has the medium of the background, so no surface echoes; give the objects, or the background, "
         "another one.");
}

TEST_CASE("diagnose reports a missing build or update") {
    scene body{tissue::muscle};
    const std::string nothing = "The scene has no object with faces; add one, or check the file it came from.";
    says(diagnose(body, probe, pose{}, {}), diagnosis::problem::no_objects, nothing);
    const object_id empty = body.add(mesh{}, tissue::bone);
    says(diagnose(body, probe, pose{}, {}), diagnosis::problem::no_objects, nothing);
    body.remove(empty);
    const object_id id = body.add(make_sphere({0, 0, 30_mm}, 10_mm, 3), tissue::bone, {.name = "bone"});
    says(diagnose(body, probe, pose{}, {}), diagnosis::problem::not_built,
         "The scene is not built; call build(policy) after the last add or remove.");
    body.build(exec::seq);
    body.positions(id)[0].x += 1_mm;
    says(diagnose(body, probe, pose{}, {}), diagnosis::problem::not_updated,
         "The positions of object 'bone' were handed out since the last update; call update(policy).");
}

TEST_CASE("diagnose names a setting or pose that is out of range") {
    const scene body = bone_at({0, 0, 30_mm});
    says(diagnose(body, probe, {.translation = {NAN, 0, 0}}, {}), diagnosis::problem::pose,
         "The pose of the probe is not a rigid transform, or not finite; make it with look_at, or mend it with "
         "orthonormalised.");
    says(diagnose(body, linear_array{.lines = 0}, pose{}, {}), diagnosis::problem::setting,
         "probe: lines is 0; it must be at least 1.");
    says(diagnose(body, probe, pose{}, {.depth = -1}), diagnosis::problem::setting,
         "acquisition: depth is -1 m; it must be from 1 nm to 10 m.");
    says(diagnose(body, probe, pose{}, {.planes = 2}), diagnosis::problem::setting,
         "acquisition: `planes` is 2; it must be 1, 3, 5 or 7: the slice plane, and pairs to both sides of it.");
    says(diagnose(body, probe, pose{}, {.samples = 4'000'000'000}), diagnosis::problem::setting,
         "acquisition: 64 lines of 4000000000 samples are more than 2^28; ask for fewer.");
    says(diagnose(body, probe, pose{}, {.depth = 80}), diagnosis::problem::setting,
         "acquisition: depth is 80 m: did you mean 80_mm?");
    says(diagnose(body, linear_array{.frequency = 5}, pose{}, {}), diagnosis::problem::setting,
         "probe: frequency is 5 Hz: did you mean 5_MHz?");
}

TEST_CASE("diagnose names open surfaces, even where the picture shows something") {
    mesh torn = make_sphere({0, 0, 30_mm}, 10_mm, 3);
    torn.faces.pop_back();
    scene body{tissue::muscle};
    body.add(torn, tissue::bone, {.name = "bone"});
    body.build(exec::seq);
    says(diagnose(body, probe, pose{}, {.depth = 60_mm}), diagnosis::problem::open_surface,
         "The surface of object 'bone' is not closed: The surface is open along 3 edges: fill the hole in a mesh "
         "editor, "
         "or the medium leaks out.");
}

TEST_CASE("diagnose reports an object that a frame has turned inside out") {
    scene body = bone_at({0, 0, 30_mm});
    const object_id bone = *body.find("bone");
    const auto mirror = [&] {
        for (vec3& p : body.positions(bone)) p.x = -p.x;
        body.update(exec::seq);
    };
    CHECK_FALSE(body.is_inside_out(bone));
    mirror();
    CHECK(body.is_inside_out(bone));
    const std::string sentence = "The vertices of object 'bone' were moved so that it is inside out: its faces point "
                                 "the other way than when it was "
                                 "added; check the simulation, or the formula, that moves it.";
    says(diagnose(body, probe, pose{}, {.depth = 60_mm}), diagnosis::problem::inside_out, sentence);
    body.build(exec::seq); // it is still
    says(diagnose(body, probe, pose{}, {.depth = 60_mm}), diagnosis::problem::inside_out, sentence);
    mirror();
    CHECK(diagnose(body, probe, pose{}, {.depth = 60_mm}).problems.empty());
    for (vec3& p : body.positions(bone)) p.z = 30_mm - 1e-6F * (p.z - 30_mm); // flat, as a vessel that has collapsed
    body.update(exec::seq);
    CHECK_FALSE(body.is_inside_out(bone));

    mesh inwards = make_sphere({0, 0, 30_mm}, 10_mm, 3); // as it was added, which changes no picture
    for (uvec3& face : inwards.faces) std::swap(face.x, face.y);
    body.remove(bone);
    const object_id other = body.add(inwards, tissue::bone);
    body.build(exec::seq);
    CHECK(diagnose(body, probe, pose{}, {.depth = 60_mm}).problems.empty());
    CHECK_FALSE(body.is_inside_out(other));
    CHECK_THROWS_AS(body.is_inside_out(bone), usage_error);
}

TEST_CASE("the distance to a sector is that to its edge") {
    // The edge of a fan of 90 degrees from one point stands at 45 degrees; a point at {d, 0} is d / sqrt(2) from it.
    const convex_array fan{.lines = 65, .radius = 1e-6F, .field_of_view = 90_deg};
    scene body{tissue::muscle};
    body.add(make_box({30_mm, -1_mm, -1_um}, {60_mm, 1_mm, 1_um}), tissue::bone);
    body.build(exec::seq);
    CHECK(detail::distance_beside(body, fan, pose{}, 1) ==
          doctest::Approx(30e-3 / std::sqrt(2.0)).epsilon(1e-3).scale(1e-30));
}

} // namespace diagnose_test
