#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/io/obj.hpp>
#include "temporary_folder.hpp"
#include <cmath>
#include <cstdint>
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace obj_test {
namespace {

/// A tetrahedron of volume 1/6, its faces outward.
const std::string tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
const std::string its_faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

template <class Error, class Call>
std::string sentence(const Call& call) {
    try {
        call();
    } catch (const Error& e) {
        return e.what();
    }
    return "no such error";
}

/// What load_obj says about a file, after its path.
std::string complaint(const std::string& text) {
    const temporary_folder folder;
    const std::string path = folder.write("a.obj", text);
    const std::string said = sentence<io_error>([&] { load_obj(path, {.unit = 1_m}); });
    return said.starts_with(path) ? said.substr(path.size()) : said;
}

/// What load_obj_scene says about a file beside a library a.mtl, with the folder left out.
std::string complaint(const std::string& text, const std::string& library) {
    const temporary_folder folder;
    const std::string path = folder.write("a.obj", text);
    if (!library.empty()) folder.write("a.mtl", library);
    std::string said = sentence<io_error>([&] { load_obj_scene(path, {.unit = 1_m}); });
    const std::string place = folder.path("");
    for (std::size_t i = said.find(place); i != std::string::npos; i = said.find(place)) said.erase(i, place.size());
    return said;
}

bool has(const std::string& text, const std::string& part) {
    INFO(text << " <- " << part);
    CHECK(text.find(part) != std::string::npos);
    return text.find(part) != std::string::npos;
}

/// Twice the signed area in the plane z = 0.
double doubled_area(const mesh& m) {
    double sum = 0;
    for (const uvec3 f : m.faces) {
        const vec3 u = m.positions[f.y] - m.positions[f.x], v = m.positions[f.z] - m.positions[f.x];
        const double area = static_cast<double>(u.x) * v.y - static_cast<double>(u.y) * v.x;
        CHECK(area >= 0);
        sum += area;
    }
    return sum;
}

} // namespace

TEST_CASE("an OBJ file is loaded as one mesh in metres") {
    const temporary_folder folder;
    const mesh m = load_obj(folder.write("a.obj", tetrahedron + its_faces), {.unit = 1_mm});
    CHECK(m.positions == std::vector<vec3>{{0, 0, 0}, {1_mm, 0, 0}, {0, 1_mm, 0}, {0, 0, 1_mm}});
    CHECK(m.faces == std::vector<uvec3>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
    CHECK(validate(m).volume == doctest::Approx(1e-9 / 6));
}

TEST_CASE("all notations of an OBJ file give the same mesh") {
    const temporary_folder folder;
    const mesh plain = load_obj(folder.write("a.obj", tetrahedron + its_faces), {.unit = 1_m});
    const auto same = [&](const std::string& text) {
        const mesh m = load_obj(folder.write("b.obj", text), {.unit = 1_m});
        return m.positions == plain.positions && m.faces == plain.faces;
    };
    CHECK(same("# a comment\n\n" + tetrahedron + "o thing\ng part\ns off\nusemtl no_such\nmtllib no_such.mtl\n" +
               its_faces));
    CHECK(same(tetrahedron + "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1"));
    CHECK(same(tetrahedron +
               "vn 0 0 1\nvt 0 0\nf 1/1/1 3/1/1 2/1/1\nf 1//1 2//1 4//1\nf 1/1 4/1 3/1\nf 2 3 4\nl 1 2\np 1\n"));
    CHECK(same("\xEF\xBB\xBFv 0 0 0 # the origin\n  v\t1.0\t0\t0\t\nv 0 +1.e0 0 1.0\nv -0 .0 10E-1 0.5 0.5 0.5\n" +
               its_faces));
    std::string text = tetrahedron + its_faces;
    std::string windows, old_mac = text;
    for (char& c : old_mac) {
        windows += c == '\n' ? std::string{"\r\n"} : std::string{c};
        if (c == '\n') c = '\r';
    }
    CHECK(same(windows));
    CHECK(same(old_mac));
}

TEST_CASE("unused vertices are removed, the others keep their order") {
    const temporary_folder folder;
    const std::string path = folder.write("a.obj", "v 9 9 9\n" + tetrahedron + "v 8 8 8\nf 5 4 2\nf 2 4 3\n");
    const mesh m = load_obj(path, {.unit = 1_m});
    CHECK(m.positions == std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    CHECK(m.faces == std::vector<uvec3>{{3, 2, 0}, {0, 2, 1}});
}

TEST_CASE("polygons are triangulated with the same orientation and area") {
    const temporary_folder folder;
    const auto area_of = [&](const std::string& text, std::size_t triangles) {
        const mesh m = load_obj(folder.write("a.obj", text), {.unit = 1_m});
        CHECK(m.faces.size() == triangles);
        return doubled_area(m) / 2;
    };
    CHECK(area_of("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n", 2) == doctest::Approx(2));
    // An L and a comb: concave, so that a fan of triangles would be wrong.
    CHECK(area_of("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n", 4) == doctest::Approx(3));
    std::string comb = "v 0 0 0\nv 5 0 0\nv 5 3 0\nv 4 3 0\nv 4 1 0\nv 3 1 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\n";
    comb += "v 1 3 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8 9 10 11 12\n";
    CHECK(area_of(comb, 10) == doctest::Approx(15 - 4));
    std::string circle, face = "f";
    for (int i = 0; i < 300; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / 300;
        circle.append("v ").append(std::to_string(std::cos(angle)));
        circle.append(" ").append(std::to_string(std::sin(angle))).append(" 0\n");
        face.append(" ").append(std::to_string(i + 1));
    }
    CHECK(area_of(circle + face + "\n", 298) ==
          doctest::Approx(150 * std::sin(2 * 3.14159265358979323846 / 300)).epsilon(1e-4));
}

TEST_CASE("a face of n corners becomes n - 2 triangles, or an error") {
    const temporary_folder folder; // five corners on a line, and all at one point
    for (const char* vertices :
         {"v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 4 0 0\n", "v 1 1 1\nv 1 1 1\nv 1 1 1\nv 1 1 1\nv 1 1 1\n"}) {
        const std::string path = folder.write("a.obj", std::string{vertices} + "f 1 2 3\nf 1 2 3 4 5\n");
        try {
            CHECK(load_obj(path, {.unit = 1_m}).faces.size() == 4);
        } catch (const io_error& e) {
            CHECK(e.what() ==
                  path + ":7: this polygon cannot be triangulated; triangulate the mesh before exporting it");
        }
    }
}

TEST_CASE("the unit of an OBJ file is required") {
    const temporary_folder folder;
    const std::string path = folder.write("a.obj", tetrahedron + its_faces);
    has(sentence<usage_error>([&] { load_obj(path, {}); }),
        "OBJ files have no unit of length; give it: {.unit = 1_mm}");
    has(sentence<usage_error>([&] { load_obj_scene(path, {.background = tissue::fat}); }),
        "OBJ files have no unit of length; give it: {.unit = 1_mm}");
    for (const float unit : {-1.0F, std::nanf(""), INFINITY})
        has(sentence<usage_error>([&] { load_obj(path, {.unit = unit}); }), "the unit must be finite and above 0");
    has(sentence<usage_error>([&] { load_obj_scene(path, {.unit = 1_m, .background = {.density = -1}}); }),
        "background");
}

TEST_CASE("errors in an OBJ file are reported with its name, the line and a remedy") {
    const std::string t = tetrahedron + its_faces;
    CHECK(complaint("") == ": the file is empty");
    has(complaint("# nothing\n"), ": the file has no faces (lines starting with 'f')");
    has(complaint(tetrahedron), ": the file has no faces");
    has(complaint(std::string{"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16}), ": the file has no faces");
    has(complaint("v 0 0 0\nv 1 nan 0\n"), ":2: the coordinate 'nan' is not a finite number");
    has(complaint("v 0 0 0\nv 1 0 -inf\n"), ":2: the coordinate '-inf' is not a finite number");
    for (const char* word : {"x", "1,5", "1.5.2", "1e", "e5", "-", ".", "0x10", "1d3", "1e99999"})
        has(complaint(t + "\n\nv 0 " + word + " 0\n"), ":11: the coordinate '" + std::string{word} + "' is not");
    has(complaint("v 0 0\n" + t), ":1: a vertex needs three coordinates");
    has(complaint("v 0 0 0\nv 0 1e39 0\n" + t), ":2: a coordinate of this vertex is too large");
    has(complaint(tetrahedron + "f 1 2\n"), ":5: a face needs at least three corners");
    has(complaint(tetrahedron + "f\n"), ":5: a face needs at least three corners");
    has(complaint(tetrahedron + "f 1 2 3\r\nf 1 2 5\r\n"),
        ":6: a face names vertex 5, but the file has 4 up to this line");
    has(complaint(tetrahedron + "f 1 2 -5\n"), ":5: a face names vertex -5, but the file has 4 up to this line");
    has(complaint(tetrahedron + "f 1 2 99999999999999999999\n"), ":5: a face names vertex 99999999999999999999");
    has(complaint(tetrahedron + "f 0 1 2\n"), ":5: a face names vertex 0, but indices start at 1 in OBJ");
    for (const char* word : {"x", "1.5", "2x", "--1", "/1"})
        has(complaint(tetrahedron + "f 1 2 " + word + "\n"), " is not a vertex index");
    std::string endless = "f"; // to cut it would take hours
    for (int i = 0; i < 100'000; ++i) endless += " 1 2 3 4";
    has(complaint(tetrahedron + endless + "\n"), ":5: this face has 400000 corners, more than 10000; triangulate");
    has(complaint(std::string{"v 0 0 \0\x1b[2J\n", 12}), ":1: the coordinate '??[2J' is not"); // safe to print
    has(complaint("v 0 0 " + std::string(1000, 'x') + "\n"), std::string(60, 'x') + "...' is not");

    const temporary_folder folder;
    has(sentence<io_error>([&] { load_obj(folder.path("no.obj"), {.unit = 1_m}); }),
        "no.obj: the file cannot be opened");
    has(sentence<io_error>([&] { load_obj(folder.path(""), {.unit = 1_m}); }),
        "this is a folder; give the path of a file");
}

TEST_CASE("each object or group and medium of an OBJ file becomes a named object of the scene") {
    const temporary_folder folder;
    folder.write("a.mtl", "newmtl tumour\nKd 1 0 0\ndensity 1100\nsound_speed\t1600 # m/s\nattenuation 0.7\n"
                          "attenuation_power 1.2\nbackscatter_db -20\nroughness_um 5\npriority 3\n"
                          "newmtl hard_stone\ndensity 2000\nsound_speed 4000\n"
                          "newmtl muscle\nKd 1 1 1\nattenuation 2\n"
                          "newmtl bone\ndensity 1500\nsound_speed 3000\n");
    std::string text = "mtllib a.mtl\n" + tetrahedron;
    text += "o first\nusemtl tumour\nf 1 3 2\nusemtl hard_stone\nf 1 2 4\n";
    text += "g second\nusemtl muscle\nf 1 4 3\ng first\nusemtl tumour\nf 2 3 4\n";
    text += "g third part\nusemtl bone\nf 1 2 3\no\nusemtl fat\nf 4 3 2\n";
    const scene loaded = load_obj_scene(folder.write("a.obj", text), {.unit = 1_mm, .background = tissue::gel});

    CHECK(loaded.background() == tissue::gel);
    const std::vector<object>& objects = loaded.objects();
    REQUIRE(objects.size() == 5);
    CHECK(objects[0].name == "first");
    CHECK(objects[0].surface.faces.size() == 2); // continued after another group
    CHECK(objects[0].surface.positions.size() == 4);
    CHECK(objects[0].priority == 3);
    const medium& tumour = objects[0].inside;
    CHECK(tumour.density == 1100);
    CHECK(tumour.sound_speed == 1600);
    CHECK(tumour.attenuation == doctest::Approx(70));
    CHECK(tumour.attenuation_power == 1.2F);
    CHECK(tumour.backscatter == doctest::Approx(0.1));
    CHECK(tumour.roughness == doctest::Approx(5e-6));

    CHECK(objects[1].name == "first");
    CHECK(objects[1].surface.faces == std::vector<uvec3>{{0, 1, 2}});
    CHECK(objects[1].surface.positions == std::vector<vec3>{{0, 0, 0}, {1_mm, 0, 0}, {0, 0, 1_mm}});
    CHECK(objects[1].inside == medium{.density = 2000, .sound_speed = 4000}); // specular, anechoic
    CHECK(objects[1].priority == 0);

    CHECK(objects[2].name == "second");
    medium tough = tissue::muscle;
    tough.attenuation = 200;
    CHECK(objects[2].inside == tough); // one key changes the tissue
    CHECK(objects[3].name == "third part");
    CHECK(objects[3].inside == medium{.density = 1500, .sound_speed = 3000}); // two keys replace it
    CHECK(objects[4].name == "fat");
    CHECK(objects[4].inside == tissue::fat); // by name alone
}

TEST_CASE("tissue names need no material library, and names may contain spaces") {
    const temporary_folder folder;
    std::string text =
        "mtllib lost.mtl\n" + tetrahedron + "o a\nusemtl bone\nf 1 3 2\no b\nusemtl liver # soft\nf 1 2 4\n";
    const scene loaded = load_obj_scene(folder.write("a.obj", text), {.unit = 1_m});
    REQUIRE(loaded.objects().size() == 2);
    CHECK(loaded.objects()[0].inside == tissue::bone);
    CHECK(loaded.objects()[1].inside == tissue::liver);
    CHECK(loaded.background() == tissue::water);

    folder.write("my media.mtl", "newmtl soft plastic\r\ndensity 1000\r\nsound_speed 1400\r\n");
    folder.write("sub/b.mtl", "newmtl hard plastic\ndensity 1001\nsound_speed 1401\n");
    text = "mtllib my media.mtl\r\nmtllib lost.mtl sub/b.mtl\r\n" + tetrahedron;
    text += "usemtl soft plastic\r\nf 1 3 2\r\nusemtl hard plastic\r\nf 1 2 4\r\n";
    const scene plastic = load_obj_scene(folder.write("b.obj", text), {.unit = 1_m});
    REQUIRE(plastic.objects().size() == 2);
    CHECK(plastic.objects()[0].name == "soft plastic");
    CHECK(plastic.objects()[0].inside == medium{.density = 1000, .sound_speed = 1400});
    CHECK(plastic.objects()[1].inside == medium{.density = 1001, .sound_speed = 1401});
}

TEST_CASE("a scene from an OBJ file has to be built, and then has the geometry of the file") {
    const temporary_folder folder;
    const std::string path = folder.write("a.obj", tetrahedron + "usemtl bone\n" + its_faces);
    scene loaded = load_obj_scene(path, {.unit = 1_cm});
    CHECK_THROWS_AS(loaded.require_built(), usage_error);
    loaded.build(exec::seq);
    CHECK(enclosed_volume(loaded.objects()[0].surface) == doctest::Approx(1e-6 / 6));
}

TEST_CASE("errors in media are reported with the file, and the line or the medium") {
    const std::string head = "mtllib a.mtl\n" + tetrahedron, tail = "usemtl stuff\nf 1 2 3\n", t = head + tail;
    CHECK(complaint(t, "") == "a.obj:6: the medium 'stuff' is unknown: use the name of a tissue (`tissue::all` lists "
                              "them), or give density and sound_speed under 'newmtl stuff' in the material library "
                              "(a.mtl was not found)");
    has(complaint(t, "newmtl other\ndensity 1\n"), "a.obj:6: the medium 'stuff' is unknown");
    has(complaint(t, "newmtl stuff\ndensity 1000\n"), "a.obj:6: the medium 'stuff' is unknown");
    has(complaint(t, "newmtl Bone\n"), "a.obj:6: the medium 'stuff' is unknown");
    has(complaint(head + "o thing\nf 1 2 3\n" + tail, ""), "a.obj:7: the face of object 'thing' has no medium");
    has(complaint(head + "usemtl\nf 1 2 3\n", ""), "a.obj:6: the medium '' is unknown");

    const std::string stuff = "newmtl stuff\ndensity 1000\nsound_speed 1500\n";
    CHECK(complaint(t, stuff + "attenuation 0.5 dB\n") ==
          "a.mtl: newmtl stuff: attenuation is '0.5 dB', which is not a number; give the number without a unit");
    for (const char* value : {"x", "nan", "inf", "1e39", "1,5"})
        has(complaint(t, stuff + "roughness_um " + value + "\n"), "a.mtl: newmtl stuff: roughness_um is '");
    has(complaint(t, "newmtl stuff\ndensity 0\nsound_speed 1500\n"), "density and sound_speed must be above 0");
    has(complaint(t, "newmtl stuff\ndensity 1000\nsound_speed -1\n"), "density and sound_speed must be above 0");
    has(complaint(t, stuff + "attenuation -1\n"), "the other values not negative");
    has(complaint(t, stuff + "backscatter_db 2000\n"), "and all in range");
    has(complaint(t, stuff + "priority 1.5\n"), "a.mtl: newmtl stuff: priority must be a whole number");
    has(complaint(t, stuff + "priority 1e9\n"), "priority must be a whole number from -1000000 to 1000000");
}

TEST_CASE("a material library outside the folder of the file is not opened") {
    const temporary_folder folder;
    folder.write("secret.mtl", "newmtl stuff\ndensity 1000\nsound_speed 1500\n");
    const std::string rest = tetrahedron + "usemtl stuff\nf 1 2 3\n";
    for (const std::string& name : {std::string{"../secret.mtl"}, std::string{"x/../../secret.mtl"}, std::string{".."},
                                    std::string{"..\\secret.mtl"}, folder.path("secret.mtl"),
                                    std::string{"C:\\secret.mtl"}, std::string{"fine.mtl ../secret.mtl"}}) {
        const std::string path = folder.write("inner/a.obj", "# one\nmtllib " + name + "\n" + rest);
        const std::string said = sentence<io_error>([&] { load_obj_scene(path, {.unit = 1_m}); });
        has(said, path + ":2: the material library '");
        has(said, "is outside the folder of the file and is not opened; move it there");
        CHECK(load_obj(path, {.unit = 1_m}).faces.size() == 1); // which opens none
    }
    const std::string path = folder.write("inner/a.obj", "mtllib a..b.mtl\n" + rest);
    folder.write("inner/a..b.mtl", "newmtl stuff\ndensity 1000\nsound_speed 1500\n");
    CHECK(load_obj_scene(path, {.unit = 1_m}).objects().size() == 1);
}

TEST_CASE("a symbolic link out of the folder of the file is not followed, one within it is") {
    const temporary_folder folder;
    folder.write("secret.mtl", "newmtl stuff\ndensity 1000\nsound_speed 1500\n");
    const std::string path = folder.write("inner/a.obj", "mtllib link.mtl\n" + tetrahedron + "usemtl stuff\nf 1 2 3\n");
    std::error_code impossible; // where links cannot be made, there is none to follow
    std::filesystem::create_symlink(folder.path("secret.mtl"), folder.path("inner/link.mtl"), impossible);
    if (impossible) return;
    has(sentence<io_error>([&] { load_obj_scene(path, {.unit = 1_m}); }), "is outside the folder of the file");
    std::filesystem::remove(folder.path("inner/link.mtl"));
    folder.write("inner/real.mtl", "newmtl stuff\ndensity 1000\nsound_speed 1500\n");
    std::filesystem::create_symlink("real.mtl", folder.path("inner/link.mtl"));
    CHECK(load_obj_scene(path, {.unit = 1_m}).objects().size() == 1);
}

TEST_CASE("a material library elsewhere is opened if the caller allows it") {
    const temporary_folder folder;
    folder.write("common.mtl", "newmtl stuff\ndensity 1000\nsound_speed 1500\n");
    for (const std::string& name : {std::string{"../common.mtl"}, folder.path("common.mtl")}) {
        const std::string path =
            folder.write("inner/a.obj", "mtllib " + name + "\n" + tetrahedron + "usemtl stuff\nf 1 2 3\n");
        const scene body = load_obj_scene(path, {.unit = 1_m, .libraries = obj_settings::library_access::anywhere});
        CHECK(body.objects().at(0).inside.density == 1000);
    }
}

TEST_CASE("a file name with a null character, or an empty one, is refused") {
    const std::string cut{"a.obj\0b", 7};
    has(sentence<io_error>([&] { load_obj(cut, {.unit = 1_m}); }), "a.obj: the file name contains a null character");
    has(sentence<io_error>([&] { load_obj("", {.unit = 1_m}); }), "the file name is empty");
}

} // namespace obj_test
