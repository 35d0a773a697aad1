#include <insonify/geometry/validate.hpp>
#include <insonify/io/obj.hpp>
#include "obj_errors.hpp"
#include "temporary_folder.hpp"
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace obj_test {
namespace {

/// A tetrahedron among the vertices of a file, after those that are there already.
std::string solid(int first) {
    const auto v = [&](int i) { return " " + std::to_string(first + i); };
    return tetrahedron + "f" + v(0) + v(2) + v(1) + "\nf" + v(0) + v(1) + v(3) + "\nf" + v(0) + v(3) + v(2) + "\nf" +
           v(1) + v(2) + v(3) + "\n";
}

struct loaded_scene {
    std::vector<std::string> names{};
    std::vector<std::size_t> faces{};
    std::vector<std::string> notes{"from before"};
    std::string path{};
};

loaded_scene load(const std::string& text) {
    const temporary_folder folder;
    loaded_scene found;
    found.path = folder.write("a.obj", text);
    const scene body = load_obj_scene(found.path, {.unit = 1_mm}, found.notes);
    for (const object& one : body.objects()) {
        found.names.push_back(one.name);
        found.faces.push_back(one.surface.faces.size());
    }
    return found;
}

using strings = std::vector<std::string>;

} // namespace

TEST_CASE("the name of an object is that of its `o`, whatever its groups are called") {
    for (const char* media : {"usemtl bone\n", ""}) { // with one medium, as with two
        const std::string text =
            "usemtl liver\no liver\ng default\n" + solid(1) + media + "o spleen\ng default\n" + solid(5);
        const loaded_scene found = load(text);
        CHECK(found.names == strings{"liver", "spleen"});
        CHECK(found.faces == std::vector<std::size_t>{4, 4});
        CHECK(found.notes.empty());
    }
    const loaded_scene maya = load("usemtl liver\ng default\n" + tetrahedron + "g liver\n" + its_faces + "g default\n" +
                                   "g spleen\n" + solid(5));
    CHECK(maya.names == strings{"liver", "spleen"}); // groups alone
    CHECK(maya.notes.empty());
    CHECK(load("o \ng\nusemtl liver\n" + solid(1)).names == strings{"liver"}); // no name at all
}

TEST_CASE("groups tell apart what one `o` has, and are continued") {
    const loaded_scene heart = load("usemtl blood\no heart\ng left\n" + solid(1) + "g right\n" + solid(5) + "g left\n" +
                                    solid(9) + "o lung\ng left\n" + solid(13));
    CHECK(heart.names == strings{"heart/left", "heart/right", "lung"});
    CHECK(heart.faces == std::vector<std::size_t>{8, 4, 4});
    CHECK(heart.notes.empty());
    CHECK(load("usemtl blood\no heart\n" + solid(1) + "g right\n" + solid(5)).names == strings{"heart", "heart/right"});
}

TEST_CASE("equal names are told apart and reported") {
    const std::string two = "usemtl bone\no rib\n" + solid(1) + "o rib\n" + solid(5);
    const loaded_scene ribs = load(two + "o rib\n" + solid(9));
    CHECK(ribs.names == strings{"rib", "rib.2", "rib.3"});
    CHECK(ribs.faces == std::vector<std::size_t>{4, 4, 4});
    CHECK(ribs.notes ==
          strings{ribs.path + ":16: there are several objects of the name 'rib'; this one is called 'rib.2'",
                  ribs.path + ":25: there are several objects of the name 'rib'; this one is called 'rib.3'"});
    CHECK(load(two + "o rib.2\n" + solid(9)).names == strings{"rib", "rib.3", "rib.2"}); // no name that the file gives
    const loaded_scene media = load("o leg\nusemtl bone\n" + solid(1) + "usemtl fat\n" + solid(5));
    CHECK(media.names == strings{"leg", "leg.2"}); // two bodies of one name
    CHECK(media.notes.size() == 1);
    CHECK(load("usemtl bone\n" + solid(1) + "o bone\n" + solid(5)).names == strings{"bone", "bone.2"});
}

TEST_CASE("one closed surface of two media is refused, and both are named") {
    for (const std::string& begin : {std::string{"o leg\n"}, std::string{"g leg\n"}, std::string{"o leg\ng a\n"}}) {
        const std::string front = "usemtl muscle\nf 1 3 2\nf 1 2 4\n", back = "usemtl fat\nf 1 4 3\nf 2 3 4\n";
        has(complaint(tetrahedron + begin + front + back, ""),
            ": the closed surface of object 'leg' has faces in two media, 'muscle' and 'fat', but a body has one; "
            "give all its faces the same medium, or export a closed surface for each");
        has(complaint(tetrahedron + "o leg\n" + front + back, ""), "a.obj:10: the closed surface");
    }
    has(complaint(tetrahedron + "o leg\ng front\nusemtl bone\nf 1 3 2\nf 1 2 4\ng back\nusemtl fat\nf 1 4 3\nf 2 3 4\n",
                  ""),
        "has faces in two media, 'bone' and 'fat', but a body has one");
    // A hole, and two bodies that are closed each, are other matters.
    CHECK(load(tetrahedron + "o leg\nusemtl muscle\nf 1 3 2\nusemtl fat\nf 1 4 3\nf 2 3 4\n").names.size() == 2);
    CHECK(load("o leg\nusemtl muscle\n" + solid(1) + "usemtl fat\n" + solid(5)).names.size() == 2);
}

TEST_CASE("a closed surface that groups divide is one object") {
    const std::string front = "g front\nf 1 3 2\nf 1 2 4\n", back = "g back\nf 1 4 3\nf 2 3 4\n";
    const loaded_scene leg = load(tetrahedron + "o leg\nusemtl muscle\n" + front + back);
    CHECK(leg.names == strings{"leg"});
    CHECK(leg.faces == std::vector<std::size_t>{4});
    CHECK(leg.notes == strings{leg.path + ":11: the groups 'front' and 'back' belong to one surface, and are joined"});
    // Beside another body, whose media and holes are its own.
    const std::string other = tetrahedron + "g stone\nusemtl bone\nf 5 7 6\nf 5 6 8\n";
    const loaded_scene both = load(tetrahedron + "usemtl muscle\n" + front + back + other);
    CHECK(both.names == strings{"front", "stone"});
    CHECK(both.faces == std::vector<std::size_t>{4, 2});
}

TEST_CASE("lines that end in a backslash go on, but comments do not") {
    const temporary_folder folder;
    const auto faces_of = [&](const std::string& text) {
        return load_obj(folder.write("a.obj", text), {.unit = 1_m}).faces;
    };
    const std::vector<uvec3> expected = faces_of(tetrahedron + its_faces);
    std::string one_word_a_line;
    for (const char c : tetrahedron + its_faces) one_word_a_line += c == ' ' ? std::string{" \\\n"} : std::string{c};
    CHECK(faces_of(one_word_a_line) == expected);
    CHECK(faces_of(tetrahedron + "f 1 3\\\r\n2\r\nf 1 2 \\  \r\n 4\r\nf 1 4 3\nf 2 \\ # two\n3 4\n") == expected);
    CHECK(faces_of("# from C:\\models\\\n" + tetrahedron + its_faces) == expected);
    has(complaint(tetrahedron + "f 1 2 \\\n3\nf 1 2 \\\n 9\n"),
        ":7: a face names vertex 9"); // lines are those of the file
    has(complaint(tetrahedron + "f 1 2 3 \\"), "no such error");
}

TEST_CASE("a file of another kind is told apart from a drawing without faces") {
    for (const char* other : {"solid a\nfacet normal 0 0 1\n", "ply\nformat ascii 1.0\n", "<html>404</html>\n"})
        has(complaint(other), "and no vertices ('v'): is it a Wavefront OBJ file? Export it as one");
    has(complaint(tetrahedron + "l 1 2 3\n"), ": the file has no faces (lines starting with 'f'); export it as a mesh");
}

TEST_CASE("a material library whose name has spaces is named whole where it is missing") {
    const std::string rest = "\n" + tetrahedron + "usemtl stuff\nf 1 2 3\n";
    has(complaint("mtllib my lib.mtl" + rest, ""), "in the material library (my lib.mtl was not found)");
    has(complaint("mtllib a.mtl lib.mtl" + rest, "newmtl other\n"), "in the material library (lib.mtl was not found)");
}

TEST_CASE("a text in UTF-16 is told apart from one without faces") {
    const std::string sentence = ": the text is in UTF-16; save it as UTF-8 (a text editor offers it as its encoding)";
    const std::string text = tetrahedron + its_faces;
    for (const bool mark : {true, false}) {
        std::string little = mark ? "\xFF\xFE" : "", big = mark ? "\xFE\xFF" : "";
        for (const char c : text) {
            little.append({c, '\0'});
            big.append({'\0', c});
        }
        CHECK(complaint(little) == sentence);
        CHECK(complaint(big) == sentence);
        CHECK(complaint(text + "usemtl stuff\nf 1 2 3\nmtllib a.mtl\n", little) == "a.mtl" + sentence);
    }
}

TEST_CASE("a medium that is written otherwise than it is called gets a suggestion") {
    const auto suggestion = [](const std::string& name, const std::string& library) {
        const std::string said = complaint("mtllib a.mtl\n" + tetrahedron + "usemtl " + name + "\nf 1 2 3\n", library);
        has(said, "a.obj:6: the medium '" + name + "' is unknown: use the name of a tissue");
        const std::size_t place = said.find("; did you mean ");
        return place == std::string::npos ? "none" : said.substr(place + 15);
    };
    const std::string library = "newmtl plastic\ndensity 1100\nsound_speed 2000\n";
    for (const char* name : {"bone.001", "Bone", "BONE_2", "bon", "bone 1"}) CHECK(suggestion(name, "") == "bone?");
    CHECK(suggestion("bone.001", "newmtl bone.001\nKd 1 1 1\n") == "bone?"); // as Blender writes it
    CHECK(suggestion("Soft Tissue", "") == "soft_tissue?");
    CHECK(suggestion("vessel-wall", "") == "vessel_wall?");
    CHECK(suggestion("mucsle", "") == "muscle?");
    CHECK(suggestion("Plastic.002", library) == "plastic?");
    for (const char* name : {"stuff", "cheese", "x", "12", "fad hip"}) CHECK(suggestion(name, library) == "none");
    has(complaint("mtllib a.mtl\n" + tetrahedron + "usemtl muscle\nf 1 2 3\n", "newmtl muscle\nstructure Nerve\n"),
        "lists them), or none; did you mean nerve?");
}

} // namespace obj_test
