#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/validate.hpp>
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
    CHECK(validate(m).volume == doctest::Approx(1e-9 / 6).scale(1e-30));
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
    CHECK(area_of("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n", 2) == doctest::Approx(2).scale(1e-30));
    // An L and a comb: concave, so that a fan of triangles would be wrong.
    CHECK(area_of("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n", 4) ==
          doctest::Approx(3).scale(1e-30));
    std::string comb = "v 0 0 0\nv 5 0 0\nv 5 3 0\nv 4 3 0\nv 4 1 0\nv 3 1 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\n";
    comb += "v 1 3 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8 9 10 11 12\n";
    CHECK(area_of(comb, 10) == doctest::Approx(15 - 4).scale(1e-30));
    std::string circle, face = "f";
    for (int i = 0; i < 300; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / 300;
        circle.append("v ").append(std::to_string(std::cos(angle)));
        circle.append(" ").append(std::to_string(std::sin(angle))).append(" 0\n");
        face.append(" ").append(std::to_string(i + 1));
    }
    CHECK(area_of(circle + face + "\n", 298) ==
          doctest::Approx(150 * std::sin(2 * 3.14159265358979323846 / 300)).scale(1e-30).epsilon(1e-4));
}

TEST_CASE("concave polygons in any plane are triangulated inside their outline, from whichever corner they begin") {
    const temporary_folder folder;
    const std::vector<std::vector<vec2>> outlines{
        {{0, 0}, {0, 3}, {1, 3}, {1, 1}, {2, 1}, {2, 3}, {3, 3}, {3, 0}}, // a U
        {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},                 // an L
        {{0, 0}, {10, 1}, {9, 0}, {10, -1}},                              // a dart
        {{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}},                         // a corner on a side
        {{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}}; // a comb
    for (const vec3 axis : {vec3{0, 0, 1}, vec3{1, 0, -1}, vec3{0.3F, 0.7F, -1}, vec3{-2, 1, 0.1F}, vec3{1, 1, 1}}) {
        const vec3 across = normalize(cross(axis, vec3{0.2F, -1, 0.1F})), up = normalize(cross(axis, across));
        for (const std::vector<vec2>& outline : outlines)
            for (std::size_t first = 0; first < outline.size(); ++first) {
                std::string text, face = "f";
                double expected = 0;
                for (std::size_t i = 0; i < outline.size(); ++i) {
                    const vec2 here = outline[(first + i) % outline.size()],
                               next = outline[(first + i + 1) % outline.size()];
                    expected += 0.5 * static_cast<double>(here.x * next.y - here.y * next.x);
                    const vec3 p = here.x * across + here.y * up;
                    text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
                    face += " " + std::to_string(i + 1);
                }
                const mesh m = load_obj(folder.write("a.obj", text + face + "\n"), {.unit = 1_m});
                CHECK(m.faces.size() == outline.size() - 2);
                double area = 0, turned = 0; // of the triangles, and of those that face the other way
                for (const uvec3& f : m.faces) {
                    const vec3 normal = cross(m.positions[f.y] - m.positions[f.x], m.positions[f.z] - m.positions[f.x]);
                    area += 0.5 * static_cast<double>(length(normal));
                    turned =
                        std::max(turned, (expected > 0 ? -1 : 1) * static_cast<double>(dot(normal, cross(across, up))));
                }
                CHECK(area == doctest::Approx(std::fabs(expected)).scale(1e-30).epsilon(1e-4));
                CHECK(turned < 1e-4);
            }
    }
}

TEST_CASE("polygons that intersect themselves are refused") {
    const temporary_folder folder;
    for (const char* vertices :
         {"v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n", "v 0 0 0\nv 3 2 1\nv 3 0 0\nv 0 1 0.5\nf 1 2 3 4\n",
          "v 0 3 0\nv 2 -2 0\nv -3 1 0\nv 3 1 0\nv -2 -2 0\nf 1 2 3 4 5\n"}) // a pentagram
        CHECK_THROWS_AS(load_obj(folder.write("a.obj", vertices), {.unit = 1_m}), io_error);
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

TEST_CASE("a file name with a null character, or an empty one, is refused") {
    const std::string cut{"a.obj\0b", 7};
    has(sentence<io_error>([&] { load_obj(cut, {.unit = 1_m}); }), "a.obj: the file name contains a null character");
    has(sentence<io_error>([&] { load_obj("", {.unit = 1_m}); }), "the file name is empty");
}

} // namespace obj_test
