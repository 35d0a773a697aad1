#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/motion/body_motion.hpp>
#include <insonify/scene/scene.hpp>
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <utility>
#include <vector>

using namespace insonify;

namespace tetrahedra_test {
namespace {

using cells_of_nodes = std::vector<std::array<std::uint32_t, 4>>;

struct block {
    std::vector<vec3> nodes;
    cells_of_nodes cells;
};
/// A box of n x n x n cubes of six tetrahedra each.
block block_of(vec3 lower, vec3 upper, std::uint32_t n) {
    block made;
    const auto index = [n](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        return (z * (n + 1) + y) * (n + 1) + x;
    };
    for (std::uint32_t z = 0; z <= n; ++z)
        for (std::uint32_t y = 0; y <= n; ++y)
            for (std::uint32_t x = 0; x <= n; ++x)
                made.nodes.push_back(lower + (upper - lower) * vec3{x, y, z} / static_cast<float>(n));
    constexpr int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (std::uint32_t z = 0; z < n; ++z)
        for (std::uint32_t y = 0; y < n; ++y)
            for (std::uint32_t x = 0; x < n; ++x)
                for (const auto& order : orders) { // from one corner of the cube to the opposite one
                    uvec3 at{x, y, z};
                    std::array<std::uint32_t, 4> cell{index(at.x, at.y, at.z)};
                    for (std::size_t k = 0; k < 3; ++k) {
                        at[order[k]] += 1;
                        cell[k + 1] = index(at.x, at.y, at.z);
                    }
                    made.cells.push_back(cell);
                }
    return made;
}

vec3 sheared(vec3 p) { return {1.02F * p.x + 0.1F * p.z, p.y - 0.03F * p.x, 0.93F * p.z + 1_mm}; }

template <class Call>
std::string message_of(const Call& call) {
    try {
        call();
    } catch (const geometry_error& e) {
        return e.what();
    }
    return "nothing was thrown";
}

} // namespace
} // namespace tetrahedra_test

TEST_CASE("tetrahedra interpolate linearly inside, and outside as at the nearest point of their surface") {
    using namespace tetrahedra_test;
    const block of = block_of({-20_mm, -20_mm, 0}, {20_mm, 20_mm, 40_mm}, 5);
    tetrahedra map{of.nodes, of.cells};
    for (vec3& node : map.nodes()) node = sheared(node);
    float worst = 0;
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const vec3 rest = vec3{-20_mm, -20_mm, 0} +
                          40_mm * vec3{hash_uniform(1, 3 * i), hash_uniform(1, 3 * i + 1), hash_uniform(1, 3 * i + 2)};
        worst = max(worst, length(map(rest) - sheared(rest))); // an affine map is interpolated exactly
    }
    MESSAGE("error of an affine map ", worst * 1e6F, " um");
    CHECK(worst < 0.05_um);
    const vec3 outside{25_mm, 3_mm, 10_mm}, nearest{20_mm, 3_mm, 10_mm};
    CHECK(length(map(outside) - outside - (sheared(nearest) - nearest)) < 0.05_um);
}

TEST_CASE("deform by tetrahedra: vertices follow, in whatever pose, and rest_of inverts") {
    using namespace tetrahedra_test;
    const block of = block_of({-30_mm, -30_mm, 0}, {30_mm, 30_mm, 60_mm}, 6);
    tetrahedra map{of.nodes, of.cells};
    scene body{tissue::muscle};
    const object_id ball =
        body.add(make_sphere({0, 0, 0}, 8_mm, 3), tissue::liver, {.at = {.translation = {0, 0, 30_mm}}});
    body.build(exec::par);
    const std::vector<vec3> rest(body.rest_positions(ball).begin(), body.rest_positions(ball).end());
    body.deform(exec::par, map);
    CHECK(std::as_const(body)[ball].surface.positions == rest); // nodes at rest: nothing moves
    for (vec3& node : map.nodes()) node = sheared(node);
    for (const vec3 aside : {vec3{0, 0, 30_mm}, vec3{5_mm, -3_mm, 25_mm}}) { // placed elsewhere: located again
        body.place(ball, {.translation = aside});
        body.deform(exec::par, map);
        float worst = 0;
        for (std::size_t i = 0; i < rest.size(); ++i)
            worst =
                max(worst, length(std::as_const(body)[ball].surface.positions[i] + aside - sheared(rest[i] + aside)));
        CHECK(worst < 0.05_um);
    }
    CHECK(length(body.rest_of(sheared({3_mm, 4_mm, 20_mm}), ball) - vec3{3_mm, 4_mm, 20_mm}) < 0.1_um);
    CHECK(length(body.rest_of({60_mm, 0, 20_mm})) > 1_mm); // outside: as the nearest point, and finite
}

TEST_CASE("tetrahedra: what is wrong with them is named") {
    using namespace tetrahedra_test;
    const block of = block_of({0, 0, 0}, {1, 1, 1}, 1);
    CHECK(message_of([&] { tetrahedra{of.nodes, {}}; }).find("tetrahedra: there are none") == 0);
    CHECK(message_of([&] {
              tetrahedra{of.nodes, {{0, 1, 2, 8}}};
          }) == "tetrahedra: tetrahedron 0 names node 8, but there are 8; indices start at 0");
    CHECK(message_of([&] {
              tetrahedra{of.nodes, {{0, 1, 2, 2}}};
          }) == "tetrahedra: tetrahedron 0 has no volume at rest; remove it");
    CHECK(message_of([&] { tetrahedra{{{0, 0, NAN}}, {{0, 0, 0, 0}}}; }) == "tetrahedra: a node at rest is not finite");
    tetrahedra map{of.nodes, of.cells};
    scene body;
    body.build(exec::par);
    map.nodes()[0].z = 3; // above the others
    const std::string inside_out = message_of([&] { body.deform(exec::par, map); });
    MESSAGE(inside_out);
    CHECK(inside_out.find(" is turned inside out; take a smaller step in the engine") != std::string::npos);
    map.nodes()[0].z = NAN;
    CHECK(message_of([&] { body.deform(exec::par, map); }) == "deform: node 0 of the tetrahedra is not finite");
}

TEST_CASE("displacements on a grid: trilinear, and as at the border beyond it") {
    displacement_grid grid{.origin = {-10_mm, 0, 5_mm}, .spacing = {5_mm, 10_mm, 2_mm}, .size = {5, 2, 11}};
    const auto trilinear = [](vec3 p) { return vec3{0.1F * p.z, 0.05F * p.x, 2 * p.x * p.z + 1_mm}; };
    for (std::uint32_t z = 0; z < 11; ++z)
        for (std::uint32_t y = 0; y < 2; ++y)
            for (std::uint32_t x = 0; x < 5; ++x)
                grid.displacements.push_back(trilinear(grid.origin + grid.spacing * vec3{x, y, z}));
    for (const vec3 p : {vec3{0, 3_mm, 10_mm}, vec3{-7_mm, 9_mm, 24.9_mm}, vec3{10_mm, 10_mm, 25_mm}})
        CHECK(length(grid(p) - p - trilinear(p)) < 0.01_um);
    CHECK(length(grid({0, 0, 80_mm}) - vec3{0, 0, 80_mm} - trilinear({0, 0, 25_mm})) < 0.02_um);
    scene body{tissue::muscle};
    body.build(exec::par);
    body.deform(exec::par, grid);
    CHECK(length(body.rest_of(grid({3_mm, 4_mm, 20_mm})) - vec3{3_mm, 4_mm, 20_mm}) < 0.5_um);
    grid.displacements.pop_back();
    CHECK_THROWS_AS(body.deform(exec::par, grid), usage_error);
    CHECK_THROWS_AS(displacement_grid{.spacing = {}}.check(), usage_error);
}
