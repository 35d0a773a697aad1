// Any text as an OBJ file and its library of media: it is refused with a sentence, or makes meshes and scenes that are
// sound, in no more memory than a multiple of the text.
#define INSONIFY_IMPLEMENTATION
#include <insonify/core/units.hpp>
#include <insonify/geometry/validate.hpp>
#include <insonify/io.hpp>
#include "folder.hpp"
#include "input.hpp"
#include "memory.hpp"
#include <algorithm>
#include <cstring>

using namespace insonify;

namespace {

void check_mesh(const mesh& m) {
    for (const vec3& p : m.positions) fuzz::require(is_finite(p), "a vertex is finite");
    for (const uvec3& f : m.faces)
        fuzz::require(std::max({f.x, f.y, f.z}) < m.positions.size(), "a face names vertices that are there");
    fuzz::require(m.positions.size() <= 3 * m.faces.size() && !m.faces.empty(), "a mesh has no vertex to spare");
    validate(m);
}

template <class Call>
void check_call(const std::string& path, const Call& call) {
    try {
        call();
    } catch (const io_error& refused) {
        fuzz::require(std::strlen(refused.what()) > path.size() + 10, "a sentence says what is wrong");
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::folder scratch;
    static const std::string secret = [] { // which no file may reach
        scratch.write("secret.mtl", "newmtl secret\ndensity 1234.5\nsound_speed 1234.5\n");
        std::filesystem::create_directory(scratch.path("own"));
        return scratch.path("own/a.obj");
    }();
    const fuzz::allowance small{std::size_t{16} << 20U};
    // What follows a line of "%" is the library.
    const std::string all(reinterpret_cast<const char*>(data), size);
    const std::size_t border = std::min(all.find("\n%\n"), all.size());
    scratch.write("own/a.obj", all.substr(0, border));
    scratch.write("own/a.mtl", border < all.size() ? all.substr(border + 3) : "");

    check_call(secret, [&] {
        const std::size_t before = fuzz::start_measuring();
        const mesh m = load_obj(secret, {.unit = 1_mm});
        fuzz::require(fuzz::peak_bytes - before <= (std::size_t{256} << 10U) + 512 * size,
                      "reading takes at most 256 KiB and 512 bytes for each byte of the file");
        check_mesh(m);
    });
    check_call(secret, [&] {
        const std::size_t before = fuzz::start_measuring();
        scene body = load_obj_scene(secret, {.unit = 1_mm});
        fuzz::require(fuzz::peak_bytes - before <= (std::size_t{256} << 10U) + 2048 * size,
                      "reading a scene takes at most 256 KiB and 2048 bytes for each byte of the files");
        for (const object& one : body.objects()) {
            check_mesh(one.surface);
            fuzz::require(is_valid(one.inside), "a medium is one");
            fuzz::require(one.inside.density != 1234.5F, "no library outside of the folder is read");
        }
        body.build(exec::seq);
    });
    return 0;
}
