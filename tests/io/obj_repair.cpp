#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/io/obj.hpp>
#include "obj_errors.hpp"
#include "temporary_folder.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace obj_test {

TEST_CASE("with `repair`, the objects of a file are mended, each with notes of its name") {
    const temporary_folder folder;
    const std::string text = tetrahedron + "o whole\nusemtl bone\n" + its_faces + "o open\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
    const std::string path = folder.write("a.obj", text);
    std::vector<std::string> notes;
    const scene as_it_is = load_obj_scene(path, {.unit = 1_cm}, notes);
    CHECK(notes.empty());
    CHECK_FALSE(validate(as_it_is.objects().at(1).surface).closed());

    const scene mended = load_obj_scene(path, {.unit = 1_cm, .repair = repair_settings{}}, notes);
    for (const object& one : mended.objects()) {
        const mesh_report report = validate(one.surface);
        CHECK(report.closed());
        CHECK(report.volume == doctest::Approx(1e-6 / 6).scale(1e-30));
    }
    REQUIRE(notes.size() == 1);
    CHECK(notes[0] == path + ":12: object 'open': Closed 1 hole along 3 edges with 1 face; the hole is 17.32 mm wide.");

    // Alike in one mesh, where vertices of both are those of the file.
    const mesh all = load_obj(path, {.unit = 1_cm, .repair = repair_settings{}}, notes);
    CHECK(validate(all).closed());
    REQUIRE(!notes.empty());
    CHECK(notes[0].starts_with(path + ": "));
    CHECK(load_obj(path, {.unit = 1_cm}).faces.size() == 7);
}

TEST_CASE("with `repair`, groups whose open edges become whole together are one object, also where a face is missing") {
    mesh ball = make_sphere({0, 0, 15_mm}, 10_mm, 3);
    std::stable_sort(ball.faces.begin(), ball.faces.end(), [&](uvec3 a, uvec3 b) {
        const auto height = [&](uvec3 f) {
            return ball.positions[f.x].z + ball.positions[f.y].z + ball.positions[f.z].z;
        };
        return height(a) < height(b);
    });
    ball.faces.erase(ball.faces.begin() + 3);
    std::string text;
    for (const vec3 p : ball.positions)
        text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    text += "o ball\nusemtl muscle\ng top\n";
    for (std::size_t i = 0; i < ball.faces.size(); ++i) {
        if (i == ball.faces.size() / 2) text += "g bottom\n";
        const uvec3 f = ball.faces[i] + 1U;
        text += "f " + std::to_string(f.x) + " " + std::to_string(f.y) + " " + std::to_string(f.z) + "\n";
    }
    const temporary_folder folder;
    std::vector<std::string> notes;
    const std::string path = folder.write("a.obj", text);
    const scene whole = load_obj_scene(path, {.unit = 1_m, .repair = repair_settings{}}, notes);
    REQUIRE(whole.objects().size() == 1);
    REQUIRE(notes.size() == 2);
    CHECK(notes[0].ends_with(": the groups 'top' and 'bottom' belong to one surface, and are joined"));
    CHECK(notes[1].find("Closed 1 hole along 3 edges") != std::string::npos);
    CHECK(validate(whole.objects()[0].surface).closed());
    CHECK(whole.objects()[0].surface.faces.size() == ball.faces.size() + 1);
    CHECK(load_obj_scene(path, {.unit = 1_m}).objects().size() == 2); // each open by itself
}

TEST_CASE("with `repair`, an object of which no face remains is left out, with a note") {
    const temporary_folder folder;
    std::vector<std::string> notes;
    const std::string path =
        folder.write("a.obj", tetrahedron + "usemtl bone\no whole\n" + its_faces + "o nothing\nf 1 2 2\n");
    CHECK(load_obj_scene(path, {.unit = 1_m, .repair = repair_settings{}}, notes).objects().size() == 1);
    REQUIRE(!notes.empty());
    CHECK(notes.back() == path + ":12: object 'nothing': Left out: no face remains.");
}

TEST_CASE("the distance within which vertices are merged is a setting, and is checked") {
    const temporary_folder folder;
    std::string text = "usemtl bone\n"; // three vertices for each face, up to 0.05 mm apart
    const char* corners[] = {"0 0 0", "0 10 0", "10 0 0", "0.05 0 0", "10 0 0.05", "0 0 10",
                             "0 0 0", "0 0 10", "0 10 0", "10 0 0",   "0 10 0",    "0 0 10"};
    for (const char* corner : corners) text += std::string{"v "} + corner + "\n";
    text += "f 1 2 3\nf 4 5 6\nf 7 8 9\nf 10 11 12\n";
    const std::string path = folder.write("a.obj", text);
    std::vector<std::string> notes;
    const mesh sewn = load_obj(path, {.unit = 1_mm, .repair = repair_settings{.weld_distance = 0.1_mm}}, notes);
    CHECK(sewn.positions.size() == 4);
    CHECK(validate(sewn).closed());
    REQUIRE(notes.size() == 2);
    CHECK(notes[0] == path + ": Merged 6 vertices with another one at the same point.");
    CHECK(notes[1] == path + ": Merged 2 vertices of open edges with another one within 0.1 mm.");
    has(sentence<usage_error>(
            [&] { load_obj_scene(path, {.unit = 1_mm, .repair = repair_settings{.weld_distance = -1}}); }),
        "repair: `weld_distance` is -1 m; it must be from 0 to 0.01 m");
}

} // namespace obj_test
