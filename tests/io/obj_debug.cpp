#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/io/obj.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/scene/scene.hpp>
#include "temporary_folder.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <filesystem>
#include <string>
#include <vector>

// The program's own tinyobjloader, in whatever translation unit this is: the library's copy must not meet it.
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

using namespace insonify;

namespace debug_obj_test {
namespace {

struct drawing {
    tinyobj::ObjReader reader{};

    explicit drawing(const std::string& path) { REQUIRE(reader.ParseFromFile(path)); }
    const tinyobj::shape_t& shape(std::size_t i) const {
        REQUIRE(i < reader.GetShapes().size());
        return reader.GetShapes()[i];
    }
    vec3 position(const tinyobj::index_t& corner) const {
        const auto i = static_cast<std::size_t>(3 * corner.vertex_index);
        const std::vector<float>& all = reader.GetAttrib().vertices;
        return {all[i], all[i + 1], all[i + 2]};
    }
};

bool close_to(vec3 a, vec3 b) { return length(a - b) < 1e-6F; }

template <class Error, class Call>
std::string sentence(const Call& call) {
    try {
        call();
    } catch (const Error& e) {
        return e.what();
    }
    return "no such error";
}

} // namespace

TEST_CASE("the debug OBJ has the field of view, the lines and the placed meshes in metres") {
    const temporary_folder folder;
    scene body{tissue::muscle};
    const pose aside{mat3{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, {10_mm, 0, 0}}; // a quarter turn about z, then along x
    body.add(make_box({0, 0, 20_mm}, {30_mm, 10_mm, 40_mm}), tissue::bone, {.at = aside, .name = "rib"});
    body.add(make_sphere({0, 0, 30_mm}, 5_mm, 1), tissue::fat);
    const linear_array probe{.lines = 4, .width = 40_mm};
    const pose at = look_at({0, 0, 100_mm}, {0, 0, 0}, {1, 0, 0});
    write_debug_obj(folder.path("a.obj"), body, probe, at, 50_mm);

    const drawing read{folder.path("a.obj")};
    REQUIRE(read.reader.GetShapes().size() == 4);
    CHECK(read.shape(0).name == "probe");
    CHECK(read.shape(1).name == "lines");
    CHECK(read.shape(2).name == "rib");
    CHECK(read.shape(3).name == "object_3");

    // The outline goes along the face, and back along the far end: corners at x = -+20 mm, z = 100 and 50 mm.
    const auto& outline = read.shape(0).lines;
    REQUIRE(outline.num_line_vertices == std::vector<int>{11});
    CHECK(close_to(read.position(outline.indices[0]), {-20_mm, 0, 100_mm}));
    CHECK(close_to(read.position(outline.indices[4]), {20_mm, 0, 100_mm}));
    CHECK(close_to(read.position(outline.indices[5]), {20_mm, 0, 50_mm}));
    CHECK(close_to(read.position(outline.indices[9]), {-20_mm, 0, 50_mm}));
    CHECK(close_to(read.position(outline.indices[10]), {-20_mm, 0, 100_mm}));

    const auto& lines = read.shape(1).lines;
    REQUIRE(lines.num_line_vertices == std::vector<int>(4, 2));
    for (std::size_t i = 0; i < 4; ++i) {
        const float x = -15_mm + 10_mm * static_cast<float>(i);
        CHECK(close_to(read.position(lines.indices[2 * i]), {x, 0, 100_mm}));
        CHECK(close_to(read.position(lines.indices[2 * i + 1]), {x, 0, 50_mm}));
    }

    const auto& rib = read.shape(2).mesh.indices;
    REQUIRE(rib.size() == 36);
    vec3 lower{1, 1, 1}, upper{-1, -1, -1};
    for (const tinyobj::index_t& corner : rib) {
        lower = min(lower, read.position(corner));
        upper = max(upper, read.position(corner));
    }
    CHECK(close_to(lower, {0, 0, 20_mm})); // x and y changed places by the turn, then 10 mm along x
    CHECK(close_to(upper, {10_mm, 30_mm, 40_mm}));
    CHECK(read.shape(3).mesh.num_face_vertices.size() == 80);
}

TEST_CASE("the debug OBJ of a sector ends on a circle, and an empty scene is legal") {
    const temporary_folder folder;
    const convex_array convex{.lines = 32, .radius = 60_mm, .field_of_view = 60_deg};
    write_debug_obj(folder.path("a.obj"), scene{}, convex, pose{}, 80_mm);
    const drawing read{folder.path("a.obj")};
    REQUIRE(read.reader.GetShapes().size() == 2);
    const auto& outline = read.shape(0).lines.indices;
    REQUIRE(outline.size() == 67);
    for (std::size_t i = 0; i < 66; ++i) {
        const vec3 p = read.position(outline[i]);
        CHECK(std::hypot(p.x, p.z + 60_mm) == doctest::Approx(i < 33 ? 0.06 : 0.14).scale(1e-30));
    }
    const phased_array phased{.lines = 16};
    write_debug_obj(folder.path("b.obj"), scene{}, phased, pose{}, 80_mm);
    const drawing narrow{folder.path("b.obj")};
    for (std::size_t i = 0; i < 16; ++i) {
        CHECK(close_to(narrow.position(narrow.shape(1).lines.indices[2 * i]), {0, 0, 0}));
        CHECK(length(narrow.position(narrow.shape(1).lines.indices[2 * i + 1])) == doctest::Approx(0.08).scale(1e-30));
    }
}

TEST_CASE("line breaks in the names of a drawing are replaced") {
    const temporary_folder folder;
    write_drawing(folder.path("a.obj"), {{.name = "two\nlines", .positions = {{0, 0, 0}}}});
    CHECK(folder.read("a.obj").find("o two lines\nv ") != std::string::npos);
}

TEST_CASE("a drawing with vertex indices out of range is refused before anything is written") {
    const temporary_folder folder;
    const std::string path = folder.path("a.obj");
    const std::vector<vec3> three{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (const drawn_object& wrong : {drawn_object{.name = "rib", .positions = three, .faces = {{0, 1, 3}}},
                                      drawn_object{.name = "rib", .positions = three, .polylines = {2, 2}}})
        CHECK(sentence<usage_error>([&] { write_drawing(path, {wrong}); }) ==
              "write_drawing: object 'rib' has a face or polyline with a vertex index out of range");
    CHECK(!std::filesystem::exists(path));
    write_drawing(path, {{.name = "rib", .positions = three, .faces = {{0, 1, 2}}, .polylines = {2, 1}}});
    CHECK(folder.read("a.obj").find("f 1 2 3\nl 1 2\nl 3\n") != std::string::npos);
}

TEST_CASE("write_debug_obj refuses settings out of range with a sentence") {
    const temporary_folder folder;
    const std::string path = folder.path("a.obj");
    const linear_array probe{};
    for (const float depth : {0.0F, -1.0F, std::nanf(""), INFINITY})
        CHECK(sentence<usage_error>([&] {
                  write_debug_obj(path, scene{}, probe, pose{}, depth);
              }).find(" m; it must be from 1 nm to 10 m") != std::string::npos);
    CHECK(sentence<usage_error>([&] { write_debug_obj(path, scene{}, probe, pose{}, 80); }) ==
          "write_debug_obj: depth is 80 m: did you mean 80_mm?");
    CHECK(sentence<geometry_error>([&] { write_debug_obj(path, scene{}, probe, {.rotation = mat3{2}}, 1); }) ==
          "write_debug_obj: the pose of the probe is not a rigid transform; make it with look_at, or mend it with "
          "orthonormalised");
    CHECK(sentence<usage_error>([&] { write_debug_obj(path, scene{}, linear_array{.lines = ~0U}, pose{}, 1); }) ==
          "write_debug_obj: 4294967295 lines are more than 65536; draw fewer");
    CHECK(sentence<usage_error>([&] { write_debug_obj(path, scene{}, linear_array{.lines = 0}, pose{}, 1); }) ==
          "probe: lines is 0; it must be at least 1");
    CHECK(!std::filesystem::exists(path));
    const std::string nowhere = folder.path("no/such/folder.obj");
    CHECK(sentence<io_error>([&] { write_debug_obj(nowhere, scene{}, probe, pose{}, 1); }) ==
          nowhere + ": the file cannot be created; check that its folder exists and is writable");
}

} // namespace debug_obj_test
