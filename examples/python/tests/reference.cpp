// Pictures of three probes, as raw floats: what the module must give bit for bit.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <cstdio>

using namespace insonify;

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    std::FILE* file = std::fopen(argv[1], "wb");
    if (file == nullptr) return 1;
    scene body{tissue::muscle};
    body.add(make_sphere({6_mm, 0, 30_mm}, 8_mm, 4), tissue::bone);
    body.add(make_cylinder({-9_mm, -30_mm, 17_mm}, {-9_mm, 30_mm, 17_mm}, 4_mm, 64), tissue::blood);
    body.build(exec::par);
    const auto draw = [&](const auto& probe) {
        const image seen = b_mode(exec::par_unseq, body, probe, pose{}, {.depth = 50_mm, .size = {160, 0}});
        std::fwrite(seen.pixels.data(), sizeof(float), seen.pixels.size(), file);
    };
    draw(linear_array{.lines = 96});
    draw(convex_array{.lines = 96});
    draw(phased_array{.lines = 96});
    return std::fclose(file);
}
