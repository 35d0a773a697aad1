#include <insonify/motion/body_motion.hpp>
#include "deformed_frames.hpp"
#include <array>
#include <doctest/doctest.h>

using namespace insonify;

/// Tetrahedra and grids that sample a map give the speckle of the map itself.
namespace deformed_test {
namespace {

double correlation_of(const frame& a, const frame& b) {
    correlation sum;
    for (int line = 0; line < 192; ++line)
        for (float z = 2_mm; z < 30_mm; z += 0.05_mm) sum.add(a.at(line, z), b.at(line, z));
    return sum.value();
}
template <class Map>
frame deformed_by(const Map& map) {
    scene body = calf();
    body.deform(exec::par, map);
    return frame_of(body);
}

} // namespace
} // namespace deformed_test

TEST_CASE("tetrahedra and grids that sample a map give its speckle") {
    using namespace deformed_test;
    const pressed map{.depth = 3_mm};
    const frame analytic = deformed_by(map);
    // Nodes 2 mm apart, in cubes of six tetrahedra.
    const uvec3 size{47, 15, 30};
    const vec3 origin{-46_mm, -14_mm, -6_mm};
    displacement_grid grid{.origin = origin, .spacing = vec3{2_mm}, .size = size};
    std::vector<vec3> nodes, now;
    std::vector<std::array<std::uint32_t, 4>> cells;
    const auto index = [&](uvec3 p) { return (p.z * size.y + p.y) * size.x + p.x; };
    for (std::uint32_t z = 0; z < size.z; ++z)
        for (std::uint32_t y = 0; y < size.y; ++y)
            for (std::uint32_t x = 0; x < size.x; ++x) {
                const vec3 rest = origin + 2_mm * vec3{x, y, z};
                nodes.push_back(rest);
                now.push_back(map(rest));
                grid.displacements.push_back(map(rest) - rest);
                if (x + 1 == size.x || y + 1 == size.y || z + 1 == size.z) continue;
                for (const uvec3 order :
                     {uvec3{0, 1, 2}, uvec3{0, 2, 1}, uvec3{1, 0, 2}, uvec3{1, 2, 0}, uvec3{2, 0, 1}, uvec3{2, 1, 0}}) {
                    uvec3 at{x, y, z};
                    std::array<std::uint32_t, 4> cell{index(at)};
                    for (int k = 0; k < 3; ++k) {
                        at[static_cast<int>(order[k])] += 1;
                        cell[static_cast<std::size_t>(k) + 1] = index(at);
                    }
                    cells.push_back(cell);
                }
            }
    tetrahedra divided{nodes, cells};
    std::copy(now.begin(), now.end(), divided.nodes().begin());
    const double by_tetrahedra = correlation_of(analytic, deformed_by(divided)),
                 by_grid = correlation_of(analytic, deformed_by(grid)),
                 at_rest = correlation_of(analytic, frame_of(calf()));
    MESSAGE(cells.size(), " tetrahedra: correlation with the map ", by_tetrahedra,
            ", expected above 0.97; grid of 2 mm ", by_grid, "; at rest ", at_rest);
    CHECK(by_tetrahedra > 0.97);
    CHECK(by_grid > 0.97);
    CHECK(at_rest < 0.5);
}
