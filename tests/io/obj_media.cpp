#include <insonify/core/error.hpp>
#include <insonify/core/units.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/io/obj.hpp>
#include "obj_errors.hpp"
#include "temporary_folder.hpp"
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace insonify;

namespace obj_test {
TEST_CASE("each object or group and medium of an OBJ file becomes a named object of the scene") {
    const temporary_folder folder;
    folder.write("a.mtl", "newmtl tumour\nKd 1 0 0\ndensity 1100\nsound_speed\t1600 # m/s\nattenuation 0.7\n"
                          "attenuation_power 1.2\nbackscatter_db -20\nroughness_um 5\npriority 3\n"
                          "newmtl hard_stone\ndensity 2000\nsound_speed 4000\n"
                          "newmtl muscle\nKd 1 1 1\nattenuation 2\n"
                          "newmtl bone\ndensity 1500\nsound_speed 3000\n");
    std::string text = "mtllib a.mtl\n" + tetrahedron;
    text += "o first\ng first\nusemtl tumour\nf 1 3 2\nusemtl hard_stone\nf 1 2 4\n";
    text += "g second\nusemtl muscle\nf 1 4 3\ng first\nusemtl tumour\nf 2 3 4\n";
    text += "g third part\nusemtl bone\nf 1 2 3\no\nusemtl fat\nf 4 3 2\n";
    const scene loaded = load_obj_scene(folder.write("a.obj", text), {.unit = 1_mm, .background = tissue::gel});

    CHECK(loaded.background() == tissue::gel);
    const std::vector<object>& objects = loaded.objects();
    REQUIRE(objects.size() == 5);
    CHECK(objects[0].name == "first/first");
    CHECK(objects[0].surface.faces.size() == 2); // continued after another group
    CHECK(objects[0].surface.positions.size() == 4);
    CHECK(objects[0].priority == 3);
    const medium& tumour = objects[0].inside;
    CHECK(tumour.density == 1100);
    CHECK(tumour.sound_speed == 1600);
    CHECK(tumour.attenuation == doctest::Approx(70).scale(1e-30));
    CHECK(tumour.attenuation_power == 1.2F);
    CHECK(tumour.backscatter == doctest::Approx(0.1).scale(1e-30));
    CHECK(tumour.roughness == doctest::Approx(5e-6).scale(1e-30));

    CHECK(objects[1].name == "first/first.2");
    CHECK(objects[1].surface.faces == std::vector<uvec3>{{0, 1, 2}});
    CHECK(objects[1].surface.positions == std::vector<vec3>{{0, 0, 0}, {1_mm, 0, 0}, {0, 0, 1_mm}});
    CHECK(objects[1].inside == medium{.density = 2000, .sound_speed = 4000}); // specular, anechoic
    CHECK(objects[1].priority == 0);

    CHECK(objects[2].name == "first/second");
    medium tough = tissue::muscle;
    tough.attenuation = 200;
    CHECK(objects[2].inside == tough); // one key changes the tissue
    CHECK(objects[3].name == "first/third part");
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
    CHECK(enclosed_volume(loaded.objects()[0].surface) == doctest::Approx(1e-6 / 6).scale(1e-30));
}

TEST_CASE("errors in media are reported with the file, and the line or the medium") {
    const std::string head = "mtllib a.mtl\n" + tetrahedron, tail = "usemtl stuff\nf 1 2 3\n", t = head + tail;
    CHECK(complaint(t, "") == "a.obj:6: the medium 'stuff' is unknown: use the name of a tissue (`tissue::all` lists "
                              "them), or give density and sound_speed under 'newmtl stuff' in the material library "
                              "(a.mtl was not found)");
    has(complaint(t, "newmtl other\ndensity 1\n"), "a.obj:6: the medium 'stuff' is unknown");
    has(complaint(t, "newmtl stuff\ndensity 1000\n"), "a.obj:6: the medium 'stuff' is unknown");
    has(complaint(t, "newmtl Bone\n"), "a.obj:6: the medium 'stuff' is unknown");
    has(complaint(t, "newmtl stuff\ndensitiy 1000\nsound_speed 1500\n"),
        "a.mtl:2: newmtl stuff: there is no key 'densitiy'; did you mean density?");
    has(complaint(t, "newmtl stuff\natenuation 9\ndensity 1000\nsound_speed 1500\n"), "did you mean attenuation?");
    has(complaint(t, "newmtl stuff\ndensity 1.9\nsound_speed 3500\n"), "density is 1.9 kg/m^3; did you mean 1900?");
    has(complaint(t, "newmtl stuff\ndensity 1900\nsound_speed 3.5\n"), "sound_speed is 3.5 m/s; did you mean 3500?");
    CHECK(complaint(t, "newmtl stuff\nKd 1 1 1\nillum 2\nPr 0.5\naniso 1\ndensity 1.2\nsound_speed 343\n") ==
          "no such error");
    has(complaint(head + "o thing\nf 1 2 3\n" + tail, ""), "a.obj:7: the face of object 'thing' has no medium");
    has(complaint(head + "usemtl\nf 1 2 3\n", ""), "a.obj:6: the medium '' is unknown");

    const std::string stuff = "newmtl stuff\ndensity 1000\nsound_speed 1500\n";
    CHECK(complaint(t, stuff + "attenuation 0.5 dB\n") ==
          "a.mtl:4: newmtl stuff: attenuation is '0.5 dB', which is not a number; give the number without a unit");
    for (const char* value : {"x", "nan", "inf", "1e39", "1,5"})
        has(complaint(t, stuff + "roughness_um " + value + "\n"), "a.mtl:4: newmtl stuff: roughness_um is '");
    has(complaint(t, "newmtl stuff\ndensity 0\nsound_speed 1500\n"), "density and sound_speed must be above 0");
    has(complaint(t, "newmtl stuff\ndensity 1000\nsound_speed -1\n"), "density and sound_speed must be above 0");
    has(complaint(t, stuff + "attenuation -1\n"), "the other values not negative");
    has(complaint(t, stuff + "backscatter_db 2000\n"), "and all in range");
    has(complaint(t, stuff + "priority 1.5\n"), "a.mtl:4: newmtl stuff: priority must be a whole number");
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

} // namespace obj_test
