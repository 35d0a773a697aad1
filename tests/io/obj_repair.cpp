#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/io/obj.hpp>
#include "obj_errors.hpp"
#include "temporary_folder.hpp"
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
