#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/shapes.hpp>
#include <doctest/doctest.h>
#include <set>

using namespace insonify;
using detail::face_groups;

TEST_CASE("a group has each vertex of its 64 faces once, and no other") {
    for (const mesh& m : {make_box({0, 0, 0}, {1, 1, 1}), make_sphere({0, 0, 0}, 1, 4)}) {
        const face_groups owner{m};
        const detail::face_groups_view groups = owner.view_of();
        REQUIRE(groups.count() == (m.faces.size() + 63) / 64);
        for (std::size_t i = 0; i < groups.count(); ++i) {
            std::set<std::uint32_t> expected;
            for (std::size_t face = 64 * i; face < std::min(64 * i + 64, m.faces.size()); ++face)
                expected.insert({m.faces[face].x, m.faces[face].y, m.faces[face].z});
            CHECK(groups[i].size() == expected.size());
            CHECK(std::set<std::uint32_t>(groups[i].begin(), groups[i].end()) == expected);
        }
    }
    CHECK(face_groups{mesh_view{}}.empty());
}
