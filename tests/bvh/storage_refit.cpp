#include <insonify/bvh/build_sah.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/bvh/storage.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/shapes.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace refit_test {

using namespace insonify::detail;

namespace {

constexpr int width = simd_width;

bool same(const aabb& a, const aabb& b) { return a.lower == b.lower && a.upper == b.upper; }

// The box below a child reference from the triangles themselves; checks the boxes in the tree.
aabb box_below(const topology<width>& tree, const tree_shape<mesh_view, width>& shape, const mesh_view& surface,
               std::uint32_t code, double& all, double& leaves) {
    aabb whole;
    if ((code & leaf_bit) != 0) {
        for (int k = 0; k < width; ++k)
            if (const std::uint32_t slot =
                    tree.slots[(code ^ leaf_bit) * std::size_t{width} + static_cast<unsigned>(k)];
                slot != no_primitive)
                whole = merged(whole, bounds(surface[slot]));
        leaves += static_cast<double>(whole.half_area());
        CHECK(same(shape.boxes[tree.nodes.size() + (code ^ leaf_bit)], whole));
        return whole;
    }
    const tree_node<width>& node = tree.nodes[code];
    for (int k = 0; k < width; ++k) {
        if (node.child[k] == no_child) {
            CHECK(node.box(k).empty());
            continue;
        }
        const aabb below = box_below(tree, shape, surface, node.child[k], all, leaves);
        CHECK(same(node.box(k), below));
        all += static_cast<double>(below.half_area());
        whole = merged(whole, below);
    }
    CHECK(same(shape.boxes[code], whole));
    return whole;
}

} // namespace

TEST_CASE("after a refit every box is tight, and so are the statistics of the tree") {
    using refit_test::width;
    for (const std::uint32_t subdivisions : {0U, 1U, 3U, 5U, 6U})
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
            mesh m = make_sphere({0, 0, 0}, 1, subdivisions);
            if (seed == 1) { // one far away: a leaf below the root
                const auto first = static_cast<std::uint32_t>(m.positions.size());
                for (const vec3& p : {vec3{900, 0, 0}, vec3{901, 0, 0}, vec3{900, 1, 0}}) m.positions.push_back(p);
                m.faces.push_back({first, first + 1, first + 2});
            }
            topology<width> tree = build_sah{}.operator()<width>(exec::par, mesh_view{m});
            tree_shape<mesh_view, width> shape;
            for (std::size_t i = 0; i < m.positions.size(); ++i)
                m.positions[i] +=
                    vec3{hash_uniform(seed, 3 * i), 3 * hash_uniform(seed, 3 * i + 1), -hash_uniform(seed, 3 * i + 2)};
            refit(exec::par, tree, mesh_view{m}, shape);
            double all = 0, leaves = 0;
            const aabb box = refit_test::box_below(tree, shape, mesh_view{m}, 0, all, leaves);
            CHECK(refit_test::same(shape.box, box));
            CHECK(shape.cost == doctest::Approx(all / static_cast<double>(box.half_area())).scale(1e-30).epsilon(1e-5));
            const double leaf_area = leaves / static_cast<double>(tree.leaves());
            CHECK(static_cast<double>(shape.leaf_size) ==
                  doctest::Approx(std::sqrt(leaf_area)).scale(1e-30).epsilon(1e-5));
            float farthest = 0;
            for (const vec3& p : m.positions)
                for (int axis = 0; axis < 3; ++axis) farthest = max(farthest, std::fabs(p[axis]));
            CHECK(shape.max_abs_coordinate == farthest);
        }
}

TEST_CASE("an empty tree has no size and no cost") {
    const mesh nothing;
    topology<simd_width> tree = build_sah{}.operator()<simd_width>(exec::seq, mesh_view{nothing});
    tree_shape<mesh_view, simd_width> shape;
    refit(exec::seq, tree, mesh_view{nothing}, shape);
    CHECK(shape.box.empty());
    CHECK(shape.max_abs_coordinate == 0);
    CHECK(shape.leaf_size == 0);
    CHECK(shape.cost == 0);
}

TEST_CASE("the cost of a tree does not depend on scale, and is 0 for a point") {
    mesh ball = make_sphere({0, 0, 0}, 1, 3);
    const double cost = bvh{exec::seq, ball}.statistics().cost;
    for (vec3& p : ball.positions) p *= 1e-3F;
    CHECK(bvh{exec::seq, ball}.statistics().cost == doctest::Approx(cost).scale(1e-30).epsilon(1e-3));
    for (vec3& p : ball.positions) p = {1, 2, 3};
    CHECK(bvh{exec::seq, ball}.statistics().cost == 0);
}

} // namespace refit_test
