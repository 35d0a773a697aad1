// A first image: meshes and media in, a B-mode image out. `first_image mesh.obj` draws a file in millimetres; without a
// file it draws the built-in phantom.
#define INSONIFY_IMPLEMENTATION // in exactly one file of a program: compiles the OBJ reader and the PNG writer there
#include <insonify/insonify.hpp>
#include "nerve_block_phantom.hpp"
#include <cstdio>

using namespace insonify;

image draw_file(const char* path) {
    const scene body = load_obj_scene(path, {.unit = 1_mm, .background = tissue::fat}).build(exec::par);
    const convex_array probe{.lines = 192, .radius = 60_mm, .field_of_view = 60_deg, .frequency = 5_MHz};
    const vec3 middle = body.box().centre(), front{middle.x, body.box().lower.y - 10_mm, middle.z};
    return b_mode(exec::par_unseq, body, probe, look_at(front, middle, {1, 0, 0}), {.depth = 80_mm});
}

image draw_phantom() {
    const scene body = nerve_block_phantom().build(exec::par);
    return b_mode(exec::par_unseq, body, nerve_block::probe, pose{}, nerve_block::settings);
}

int main(int argc, char** argv) {
    try {
        const image picture = argc > 1 ? draw_file(argv[1]) : draw_phantom();
        write_png("first_image.png", picture);
        if (argc > 1) return 0;

        // The image must show a bright bone surface with a shadow below, and blood darker than muscle.
        const auto grey_at = [&](float x, float z) { // mean of 9 x 3 pixels
            const float pitch = nerve_block::probe.width / static_cast<float>(picture.size.x);
            const auto column = static_cast<std::uint32_t>(x / pitch + 0.5F * static_cast<float>(picture.size.x));
            const auto row = static_cast<std::uint32_t>(z / pitch);
            float sum = 0;
            for (std::uint32_t i = 0; i < 27; ++i) sum += picture(column - 4 + i % 9, row - 1 + i / 9) / 27;
            return sum;
        };
        float bone = 0;                               // at a displayed depth of 28 mm
        for (float x = 10_mm; x < 12_mm; x += 0.2_mm) // a rough surface has speckle, too
            for (float z = 27_mm; z < 29_mm; z += 0.1_mm) bone = std::max(bone, grey_at(x, z));
        const float shadow = grey_at(11_mm, 35_mm);
        const float blood = grey_at(-9_mm, 17_mm), muscle = grey_at(9_mm, 26_mm);
        std::printf("bone %.2f, its shadow %.2f, muscle %.2f, blood %.2f\n", bone, shadow, muscle, blood);
        return bone > 0.8F && shadow < 0.1F && muscle > 0.3F && blood < 0.7F * muscle ? 0 : 1;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "first_image: %s\n", e.what());
        return 2;
    }
}
