// Covers io/implementation_file.hpp, io/implementation_obj.hpp: what differs between systems and users.
#include <insonify/core/math.hpp>
#include <insonify/io/obj.hpp>
#include <insonify/io/png.hpp>
#include <insonify/probe/linear_array.hpp>
#include "obj_errors.hpp"
#include "temporary_folder.hpp"
#include <clocale>
#include <doctest/doctest.h>
#include <filesystem>
#include <locale>
#include <string>
#include <vector>

using namespace insonify;

namespace obj_test {
namespace {

struct decimal_comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
};

/// The locale of a German user, in C++ and, where it is installed, in C.
class german {
  public:
    german() {
        for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "German_Germany.1252"})
            if (std::setlocale(LC_ALL, name) != nullptr) break;
    }
    german(const german&) = delete;
    german& operator=(const german&) = delete;
    ~german() {
        std::locale::global(cpp_);
        std::setlocale(LC_ALL, c_.c_str());
    }
    static bool is_in_c() { return std::string{std::localeconv()->decimal_point} == ","; }

  private:
    std::string c_ = std::setlocale(LC_ALL, nullptr);
    std::locale cpp_ = std::locale::global(std::locale{std::locale::classic(), new decimal_comma});
};

/// All that is read and written in a folder: density and volume, a drawing, a picture, an error.
std::vector<std::string> round_trip(const temporary_folder& folder) {
    const std::string library = "newmtl stuff\ndensity 1234.5\nsound_speed 1500.25\n";
    folder.write("a.mtl", library);
    const std::string rest = "usemtl stuff\n" + its_faces;
    const std::string path = folder.write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1.5 0 0\nv 0 1e3 0\nv 0 0 1\n" + rest);
    const scene body = load_obj_scene(path, {.unit = 1_mm});
    CHECK(body.objects().at(0).inside.density == 1234.5F);
    CHECK(body.objects().at(0).inside.sound_speed == 1500.25F);
    CHECK(body.objects().at(0).surface.positions ==
          std::vector<vec3>{{0, 0, 0}, {1_mm * 1.5F, 0, 0}, {0, 1_mm * 1000, 0}, {0, 0, 1_mm}});
    write_debug_obj(folder.path("drawn.obj"), body, linear_array{.lines = 3}, pose{}, 12.3455_mm);
    write_png(folder.path("a.png"), image{{1234, 2}});
    folder.write("a.mtl", "newmtl stuff\ndensity 1000\nsound_speed 3.5\n");
    return {folder.read("drawn.obj"), folder.read("a.png"),
            sentence<io_error>([&] { load_obj_scene(path, {.unit = 1_mm}); })};
}

} // namespace

TEST_CASE("files and errors are the same in a locale with a decimal comma") {
    const temporary_folder folder;
    const std::vector<std::string> expected = round_trip(folder);
    has(expected[2], "sound_speed is 3.5 m/s; did you mean 3500?");
    CHECK(expected[0].find(',') == expected[0].find(", in metres")); // of the comment in the first line
    const german now;
#if defined(_WIN32)
    CHECK(german::is_in_c());
#endif
    CHECK(round_trip(folder) == expected);
}

TEST_CASE("the names of files, folders and material libraries are in UTF-8") {
    const temporary_folder folder;
    const std::string name = "Wirbels\xC3\xA4ule \xE8\x84\x8A\xE6\xA4\x8E"; // a vertebral column in German and Japanese
    folder.write(name + "/" + name + ".mtl", "newmtl stuff\ndensity 1000\nsound_speed 1500\n");
    const std::string path = folder.write(name + "/a " + name + ".obj",
                                          "mtllib " + name + ".mtl\n" + tetrahedron + "usemtl stuff\nf 1 2 3\n");
    CHECK(load_obj(path, {.unit = 1_m}).faces.size() == 1);
    const scene body = load_obj_scene(path, {.unit = 1_m});
    CHECK(body.objects().at(0).inside.density == 1000);

    write_png(folder.path(name + ".png"), image{{2, 2}});
    CHECK(folder.read(name + ".png").starts_with("\x89PNG"));
    write_debug_obj(folder.path(name + ".obj"), body, linear_array{.lines = 3}, pose{}, 10_mm);
    CHECK(folder.read(name + ".obj").starts_with("# drawn by insonify"));

    const std::string missing = folder.path(name + "/no.obj");
    CHECK(sentence<io_error>([&] { load_obj(missing, {.unit = 1_m}); }) ==
          missing + ": the file cannot be opened; check its name, its folder and its permissions");
    const std::string wrong = folder.write("b.obj", "mtllib ../\xC3\xA4.mtl\n" + tetrahedron + "usemtl a\nf 1 2 3\n");
    has(sentence<io_error>([&] { load_obj_scene(wrong, {.unit = 1_m}); }),
        "the material library '../\xC3\xA4.mtl' is outside the folder of the file");
    folder.write("c.obj", "mtllib " + name + "/" + name + ".mtl\n" + tetrahedron + "usemtl stuff\nf 1 2 3\n");
    folder.write(name + "/" + name + ".mtl", "newmtl stuff\ndensity 0\nsound_speed 1500\n");
    has(sentence<io_error>([&] { load_obj_scene(folder.path("c.obj"), {.unit = 1_m}); }),
        name + ".mtl:1: newmtl stuff");
}

TEST_CASE("a file name in another encoding than UTF-8 is refused by Windows, whose names are in UTF-16") {
    const temporary_folder folder;
    const std::string name = "Wirbels\xE4ule"; // Latin-1
    const std::string text = "mtllib " + name + ".mtl\n" + tetrahedron + "usemtl bone\nf 1 2 3\n";
#if defined(_WIN32)
    const std::string path = folder.write("a.obj", text);
    const std::string expected = name + ".mtl: the file name is not in UTF-8; encode it so";
    CHECK(sentence<io_error>([&] { load_obj_scene(path, {.unit = 1_m}); }) == expected);
    CHECK(sentence<io_error>([&] { write_png(name + ".mtl", image{{2, 2}}); }) == expected);
    CHECK(sentence<io_error>([&] { load_obj(name + ".mtl", {.unit = 1_m}); }) == expected);
#else
    folder.write(name + ".mtl", "newmtl bone\ndensity 1000\nsound_speed 1500\n");
    CHECK(load_obj_scene(folder.write(name + ".obj", text), {.unit = 1_m}).objects().at(0).inside.density == 1000);
#endif
}

} // namespace obj_test
