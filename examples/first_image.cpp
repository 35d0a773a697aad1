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
        const float pitch = nerve_block::probe.width / static_cast<float>(picture.size.x);
        const auto mean_grey = [&](vec2 from, vec2 to) { // of a rectangle, in metres from the left and from the top
            float sum = 0, count = 0;
            for (auto y = static_cast<std::uint32_t>(from.y / pitch); static_cast<float>(y) * pitch < to.y; ++y)
                for (auto x = static_cast<std::uint32_t>(from.x / pitch); static_cast<float>(x) * pitch < to.x; ++x) {
                    sum += picture(x, y);
                    ++count;
                }
            return sum / count;
        };
        float bone = 0; // a rough surface has speckle, too: the brightest place near its top
        for (float x = 29_mm; x < 31_mm; x += pitch)
            for (float z = 27_mm; z < 29_mm; z += pitch)
                bone = std::max(bone, mean_grey({x - 0.3_mm, z - 0.1_mm}, {x + 0.3_mm, z + 0.1_mm}));
        const float shadow = mean_grey({28_mm, 34_mm}, {32_mm, 36_mm});
        const float blood = mean_grey({9_mm, 16_mm}, {11_mm, 18_mm});
        const float muscle = mean_grey({26_mm, 14_mm}, {36_mm, 22_mm}); // bundles, dark, and the sheets between them
        std::printf("bone %.2f, its shadow %.2f, muscle %.2f, blood %.2f\n", bone, shadow, muscle, blood);
        return bone > 0.8F && shadow < 0.1F && muscle > 0.15F && blood < 0.25F * muscle ? 0 : 1;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "first_image: %s\n", e.what());
        return 2;
    }
}
