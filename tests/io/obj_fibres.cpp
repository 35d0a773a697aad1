#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/io/obj.hpp>
#include "obj_errors.hpp"
#include "temporary_folder.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace obj_test {
namespace {

/// A box of 10 x 20 x 100 mm, turned and moved, as text with one object.
std::string turned_box(const pose& at, const std::string& material) {
    std::string text = "mtllib a.mtl\nusemtl " + material + "\n";
    const mesh box = make_box({-5, -10, -50}, {5, 10, 50}, 1);
    for (const vec3 corner : box.positions) {
        const vec3 p = at.point(corner);
        text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    }
    for (const uvec3 f : box.faces)
        text += "f " + std::to_string(f.x + 1) + " " + std::to_string(f.y + 1) + " " + std::to_string(f.z + 1) + "\n";
    return text;
}

struct loaded_box {
    vec3 fibres{0, 0, 0};
    std::vector<std::string> notes{};
};
loaded_box load(const std::string& text, const std::string& library, float pennation = 0) {
    const temporary_folder folder;
    folder.write("a.mtl", library);
    loaded_box found;
    const scene body = load_obj_scene(folder.write("a.obj", text), {.unit = 1_mm, .pennation = pennation}, found.notes);
    found.fibres = body.objects().at(0).fibres({0, 0, 0});
    const std::string place = folder.path("");
    for (std::string& note : found.notes)
        for (std::size_t i = note.find(place); i != std::string::npos; i = note.find(place))
            note.erase(i, place.size());
    return found;
}

void check_direction(vec3 found, vec3 expected) {
    CAPTURE(found.x);
    CAPTURE(found.y);
    CAPTURE(found.z);
    CHECK(length(normalize(found) - normalize(expected)) < 1e-3F);
}

} // namespace

TEST_CASE("a material library gives the fibres of its objects, in the coordinates of the file") {
    const std::string text = turned_box(pose{}, "muscle");
    const loaded_box given = load(text, "newmtl muscle\nfibres -0.2 1.5e-1 0.9 # of a leg\n");
    CHECK(given.fibres == vec3{-0.2F, 0.15F, 0.9F});
    CHECK(given.notes.empty());
    CHECK(load(text, "newmtl muscle\nKd 1 0 0\n").fibres == vec3{0, 0, 0}); // the long axis
}

TEST_CASE("pennation turns fibres from the long axis to the flattest direction, of positive largest components") {
    const float c = std::cos(20_deg), s = std::sin(20_deg);
    const std::string text = turned_box(pose{}, "muscle");
    check_direction(load(text, "newmtl muscle\npennation 20\n").fibres, {s, 0, c});
    check_direction(load(text, "newmtl muscle\npennation -20\n").fibres, {-s, 0, c});
    check_direction(load(text, "newmtl muscle\npennation 90\n").fibres, {1, 0, 0});
    CHECK(load(text, "newmtl muscle\npennation 0\n").fibres == vec3{0, 0, 0});

    // Turned about y so that the long axis is -(0.8, 0, 0.6) and the flattest direction is (-0.6, 0, 0.8).
    const pose at{.rotation = mat3{{-0.6F, 0, 0.8F}, {0, 1, 0}, {-0.8F, 0, -0.6F}}, .translation = {30, -20, 400}};
    check_direction(load(turned_box(at, "muscle"), "newmtl muscle\npennation 20\n").fibres,
                    c * vec3{0.8F, 0, 0.6F} + s * vec3{-0.6F, 0, 0.8F});
}

TEST_CASE("the pennation of the settings is that of muscles whose material says nothing") {
    const float c = std::cos(15_deg), s = std::sin(15_deg);
    const std::string text = turned_box(pose{}, "muscle");
    const loaded_box turned = load(text, "", 15_deg);
    check_direction(turned.fibres, {s, 0, c});
    CHECK(turned.notes.empty());
    for (const char* own : {"fibres 0 1 0", "pennation -30"}) {
        const loaded_box same = load(text, std::string{"newmtl muscle\n"} + own + "\n", 15_deg);
        CHECK(same.fibres == load(text, std::string{"newmtl muscle\n"} + own + "\n").fibres);
        REQUIRE(same.notes.size() == 1);
        has(same.notes[0], "a.obj: `pennation` has turned nothing: there is no muscle");
    }
    for (const char* other : {"tendon", "fat", "liver", "heart"}) {
        const loaded_box same = load(turned_box(pose{}, other), "", 15_deg);
        CHECK(same.fibres == vec3{0, 0, 0});
        CHECK(same.notes.size() == 1);
    }
    const temporary_folder folder;
    for (const float wrong : {20.0F, -2.0F, std::nanf("")})
        has(sentence<usage_error>([&] { load_obj_scene(folder.path("no.obj"), {.unit = 1_mm, .pennation = wrong}); }),
            " radians; it must be from -pi/2 to pi/2; write it as in 20_deg");
}

TEST_CASE("fibres and pennation of the wrong form are errors with the line") {
    const std::string text = "mtllib a.mtl\n" + tetrahedron + "usemtl muscle\nf 1 2 3\n",
                      head = "newmtl muscle\nKd 1 0 0\n";
    for (const char* value : {"", "1 0", "1 0 0 0", "0 0 0", "x y z", "nan 0 0", "1,0,0", "1e39 0 0"})
        has(complaint(text, head + "fibres " + value + "\n"),
            std::string{"a.mtl:3: newmtl muscle: fibres is '"} + value + "'; give three numbers that are not all 0");
    for (const char* value : {"", "20deg", "x", "nan", "1 2"})
        has(complaint(text, head + "pennation " + value + "\n"), "a.mtl:3: newmtl muscle: pennation is '");
    for (const char* value : {"90.5", "-91"})
        has(complaint(text, head + "pennation " + value + "\n"),
            "a.mtl:3: newmtl muscle: pennation must be from -90 to 90 degrees");
    has(complaint(text, head + "fibres 1 0 0\npennation 20\n"), "a.mtl:4: newmtl muscle: it has fibres and pennation");
    has(complaint(text, head + "fibers 1 0 0\n"),
        "a.mtl:3: newmtl muscle: there is no key 'fibers'; did you mean fibres?");
    has(complaint(text, head + "penation 10\n"), "did you mean pennation?");
}

TEST_CASE("each unknown key of a material library is reported once, and none of those that are known") {
    std::string library =
        "newmtl muscle\ndensity 1050\nsound_speed 1580\nattenuation 0.6\nattenuation_power 1\n"
        "backscatter_db -6\nroughness_um 0\nscatterers_per_mm3 40\nstructure muscle\npriority 1\npennation 9\n";
    for (const char* key :
         {"Ka",   "Kd",   "Ks",    "Ke",   "Tf",   "illum", "Ns", "Ni", "d",  "Tr",  "sharpness", "map_Kd", "map_Bump",
          "bump", "disp", "decal", "refl", "norm", "Pr",    "Pm", "Ps", "Pc", "Pcr", "aniso",     "anisor"})
        library += std::string{key} + " 1\n";
    const std::string text = turned_box(pose{}, "muscle");
    CHECK(load(text, library).notes.empty());
    const loaded_box odd =
        load(text, library + "youngs_modulus 5\nnewmtl other\nyoungs_modulus 7\ncolour red\ndensty 3\n");
    const std::string first = std::to_string(std::count(library.begin(), library.end(), '\n') + 1);
    REQUIRE(odd.notes.size() == 3);
    CHECK(odd.notes[0] ==
          "a.mtl:" + std::to_string(std::stoi(first) + 3) + ": the key 'colour' is unknown and is ignored");
    has(odd.notes[1], "the key 'densty' is unknown"); // of a medium that no object has
    CHECK(odd.notes[2] == "a.mtl:" + first + ": the key 'youngs_modulus' is unknown and is ignored");
}

} // namespace obj_test
