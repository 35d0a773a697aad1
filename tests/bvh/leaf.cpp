#include <insonify/bvh/leaf.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/mesh.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace leaf_triangles_test {

using namespace insonify::detail;

namespace {

mesh random_triangles(std::uint64_t seed) {
    mesh m;
    for (std::uint64_t i = 0; i < 3 * 40; ++i)
        m.positions.emplace_back(hash_uniform(seed, 3 * i), hash_uniform(seed, 3 * i + 1),
                                 hash_uniform(seed, 3 * i + 2));
    for (std::uint32_t i = 0; i < 40; ++i) m.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    return m;
}

// A leaf holds the corners of the triangles in its slots, and which of them can be hit.
template <int Width>
std::size_t wrong_leaves() {
    std::size_t wrong = 0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        mesh m = random_triangles(seed);
        std::uint32_t slots[Width];
        for (std::uint32_t i = 0; i < Width; ++i)
            slots[i] = i > 0 && hash_uniform(seed + 1000, i) < 0.4F
                           ? no_primitive
                           : static_cast<std::uint32_t>(40 * hash_uniform(seed + 2000, i));
        for (std::uint32_t face = 0; face < 40; ++face)
            if (hash_uniform(seed + 3000, face) < 0.3F) {
                const auto corner = static_cast<std::uint32_t>(3 * hash_uniform(seed + 4000, face));
                m.positions[3 * face + corner][static_cast<int>(seed % 3)] = seed % 2 == 0 ? NAN : -INFINITY;
            }
        leaf<mesh_view, Width> filled;
        const aabb box = filled.fill(mesh_view{m}, slots);
        aabb expected;
        for (int i = 0; i < Width; ++i) {
            if (slots[i] == no_primitive || !is_finite(bounds(mesh_view{m}[slots[i]]))) {
                wrong += filled.primitive[i] != no_primitive;
                continue;
            }
            const triangle t = mesh_view{m}[slots[i]], held = filled.corners(static_cast<std::uint32_t>(i));
            wrong += filled.primitive[i] != slots[i] || held.a != t.a || held.b != t.b || held.c != t.c;
            expected = merged(expected, bounds(t));
        }
        wrong += box.empty() != expected.empty() ||
                 (!box.empty() && (box.lower != expected.lower || box.upper != expected.upper));
    }
    return wrong;
}

} // namespace

TEST_CASE("a leaf stores its triangles, leaves out those that are not finite, and returns the box around the others") {
    CHECK(leaf_triangles_test::wrong_leaves<4>() == 0);
    CHECK(leaf_triangles_test::wrong_leaves<8>() == 0);
}

} // namespace leaf_triangles_test
