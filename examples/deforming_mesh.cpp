// Deforming tissue: the program moves the vertices in place and updates the scene. A rigid tool is placed by its pose.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <chrono>
#include <cstdio>

int main() {
    using namespace insonify;
    constexpr vec3 centre{0, 0, 50_mm};

    scene body{tissue::blood};
    const object_id heart = body.add(make_sphere(centre, 25_mm, 6), tissue::muscle, {.name = "heart"});
    const object_id needle =
        body.add(make_cylinder({0, 0, 0}, {0, 0, 15_mm}, 0.5_mm, 24), tissue::steel, {.priority = 1, .name = "needle"});
    body.build(exec::par);
    const std::vector<vec3> rest(body.positions(heart).begin(), body.positions(heart).end());
    const convex_array probe{.lines = 193};
    const law2011 echoes{.incident = law2011::incident::backscattered, .texture = 0}; // of interfaces only

    float worst = 0;
    std::chrono::duration<double, std::milli> moving{}, drawing{};
    for (int frame = 0; frame < 60; ++frame) {
        const auto begin = std::chrono::steady_clock::now();
        const float beat = 1 + 0.1F * std::sin(2 * pi * static_cast<float>(frame) / 60);
        const std::span<vec3> now = body.positions(heart); // call this again each frame
        for (std::size_t i = 0; i < now.size(); ++i) now[i] = centre + beat * (rest[i] - centre);
        const float x = -30_mm + 0.5_mm * static_cast<float>(frame);
        body.place(needle, look_at({x, 0, 10_mm}, {x + 10_mm, 0, 20_mm}, {0, 1, 0}));
        body.update(exec::par); // trees are refitted when rays need them

        const auto moved = std::chrono::steady_clock::now();
        const scan_lines lines = trace(exec::par_unseq, body, probe, pose{}, echoes, {.depth = 90_mm, .samples = 900});
        moving += moved - begin;
        drawing += std::chrono::steady_clock::now() - moved;
        if (frame % 20 == 0) // as B-mode images, to look at
            write_png("deforming_mesh_" + std::to_string(frame) + ".png",
                      b_mode(exec::par_unseq, body, probe, pose{}, {.depth = 90_mm}));

        // The deepest echo on the middle line ends at the far wall.
        std::uint32_t end = lines.samples;
        while (end > 0 && lines(96, end - 1) == 0) --end;
        worst = max(worst, std::fabs(static_cast<float>(end) * 0.1_mm - (centre.z + beat * 25_mm)));
    }
    std::printf("per frame: %.2f ms to move and update, %.2f ms to trace; error of the wall's depth at most %.2f mm\n",
                moving.count() / 60, drawing.count() / 60, worst / 1_mm);
    return worst < 0.15_mm ? 0 : 1;
}
