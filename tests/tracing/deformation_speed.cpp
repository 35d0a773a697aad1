#include <insonify/b_mode.hpp>
#include "deformed_frames.hpp"
#include <algorithm>
#include <array>
#include <chrono>
#include <doctest/doctest.h>

using namespace insonify;

/// What deformation costs. Printed, not checked: the machine may be busy.
namespace deformed_test {
namespace {

/// Median milliseconds of several contenders that take turns.
template <std::size_t Count, class Run>
std::array<double, Count> medians(const Run& run) {
    std::array<std::vector<double>, Count> all;
    for (int turn = 0; turn < 9; ++turn)
        for (std::size_t i = 0; i < Count; ++i) {
            const auto begin = std::chrono::steady_clock::now();
            run(i, turn);
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
            if (turn > 1) all[i].push_back(took.count());
        }
    std::array<double, Count> middle{};
    for (std::size_t i = 0; i < Count; ++i) {
        std::sort(all[i].begin(), all[i].end());
        middle[i] = all[i][all[i].size() / 2];
    }
    return middle;
}

/// Seven balls of 20,480 faces in muscle.
scene balls() {
    scene body{tissue::muscle};
    for (int i = 0; i < 7; ++i)
        body.add(make_sphere({5_mm * static_cast<float>(i - 3), 0, 15_mm + 3_mm * static_cast<float>(i % 3)}, 2_mm, 5),
                 tissue::liver);
    body.build(exec::par);
    return body;
}

/// A box of cubes of 2.5 mm, of six tetrahedra each.
tetrahedra divided_box() {
    const uvec3 size{41, 17, 27};
    std::vector<vec3> nodes;
    std::vector<std::array<std::uint32_t, 4>> cells;
    const auto index = [&](uvec3 p) { return (p.z * size.y + p.y) * size.x + p.x; };
    for (std::uint32_t i = 0; i < size.x * size.y * size.z; ++i) {
        const uvec3 p{i % size.x, i / size.x % size.y, i / size.x / size.y};
        nodes.push_back(vec3{-50_mm, -20_mm, -10_mm} + 2.5_mm * vec3{p});
        if (p.x + 1 == size.x || p.y + 1 == size.y || p.z + 1 == size.z) continue;
        for (const uvec3 order :
             {uvec3{0, 1, 2}, uvec3{0, 2, 1}, uvec3{1, 0, 2}, uvec3{1, 2, 0}, uvec3{2, 0, 1}, uvec3{2, 1, 0}}) {
            uvec3 at = p;
            std::array<std::uint32_t, 4> cell{index(at)};
            for (int k = 0; k < 3; ++k) {
                at[static_cast<int>(order[k])] += 1;
                cell[static_cast<std::size_t>(k) + 1] = index(at);
            }
            cells.push_back(cell);
        }
    }
    return {std::move(nodes), std::move(cells)};
}

} // namespace
} // namespace deformed_test

TEST_CASE("what a frame of deformed tissue costs") {
    using namespace deformed_test;
    const linear_array fine{.lines = 256, .width = 38_mm};
    scene scenes[3] = {balls(), balls(), balls()};
    const scanner<linear_array> resting{fine, {.depth = 40_mm}};
    scanner<linear_array> machines[3] = {resting, resting, resting};
    tetrahedra divided = divided_box();
    const std::vector<vec3> nodes(divided.nodes().begin(), divided.nodes().end());
    const std::array<double, 3> took = medians<3>([&](std::size_t i, int turn) {
        const pressed map{.depth = 1_mm + 0.1_mm * static_cast<float>(turn)};
        if (i == 1) scenes[i].deform(exec::par, map);
        if (i == 2) {
            for (std::size_t k = 0; k < nodes.size(); ++k) divided.nodes()[k] = map(nodes[k]);
            scenes[i].deform(exec::par, divided);
        }
        machines[i].scan(exec::par_unseq, scenes[i], pose{});
    });
    MESSAGE("256 lines, 143,360 faces: at rest ", took[0], " ms; a map that changes ", took[1], " ms, ",
            took[1] / took[0], " times, goal 1.3; 99,840 tetrahedra ", took[2], " ms, ", took[2] / took[0],
            " times, goal 1.5");
    CHECK(took[0] > 0);
}
