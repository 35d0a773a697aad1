#include <insonify/bvh/build_morton.hpp>
#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <algorithm>
#include <cfenv>
#include <doctest/doctest.h>
#include <limits>
#include <utility>

using namespace insonify;

namespace build_morton_test {

using namespace insonify::detail;

namespace {

using morton_tree = bvh<mesh_view, simd_width, build_morton>;

vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

mesh random_triangles(std::uint64_t seed, std::uint32_t count, float size) {
    mesh m;
    for (std::uint32_t i = 0; i < count; ++i) {
        const vec3 centre = random_point(seed, 4 * std::uint64_t{i});
        for (std::uint64_t corner = 1; corner <= 3; ++corner)
            m.positions.push_back(centre + size * random_point(seed, 4 * std::uint64_t{i} + corner));
        m.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return m;
}

// A user primitive.
struct ball {
    vec3 centre{0, 0, 0};
    float radius = 0;

    friend aabb bounds(const ball& b) { return {b.centre - vec3{b.radius}, b.centre + vec3{b.radius}}; }
    friend hit intersect(const ray&, const ball&) { return {}; }
};

int missed_or_invented(const mesh& m, std::uint64_t seed) {
    const morton_tree tree{exec::par, mesh_view{m}};
    int wrong = 0;
    std::vector<hit> hits;
    for (std::uint64_t i = 0; i < 500; ++i) {
        const ray r{.origin = 1.5F * random_point(seed, 2 * i), .direction = random_point(seed, 2 * i + 1)};
        std::vector<std::uint32_t> found, expected;
        tree.all(r, hits);
        for (const hit& h : hits) found.push_back(h.primitive);
        const sheared_ray sheared{r};
        for (std::uint32_t p = 0; p < m.faces.size(); ++p)
            if (const hit h = intersect(sheared, mesh_view{m}[p]); h && h.distance >= 0) expected.push_back(p);
        std::sort(found.begin(), found.end());
        wrong += found != expected;
    }
    return wrong;
}

} // namespace

TEST_CASE("a Morton tree finds the same hits as brute force") {
    for (const std::uint32_t count : {0U, 1U, 2U, 7U, 8U, 9U, 24U, 25U, 64U, 65U, 300U, 6000U})
        CHECK(build_morton_test::missed_or_invented(build_morton_test::random_triangles(count, count, 0.3F), 7) == 0);
}

TEST_CASE("a Morton tree holds all user primitives except those that are empty or not finite") {
    using build_morton_test::ball;
    const float odd[] = {-1, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
    for (std::uint32_t count = 1; count <= 24; ++count)
        for (std::uint32_t left_out = 0; left_out < count; ++left_out) {
            std::vector<ball> balls;
            std::vector<std::uint32_t> expected, found;
            for (std::uint32_t i = 0; i < count; ++i) {
                balls.push_back({build_morton_test::random_point(3, i), i == left_out ? odd[count % 3] : 0.1F});
                if (i != left_out) expected.push_back(i);
            }
            const bvh<view<const ball>, simd_width, build_morton> tree{exec::seq, view<const ball>{balls}};
            tree.overlapping(aabb{vec3{-2}, vec3{2}}, found);
            CHECK(found == expected);
        }
}

TEST_CASE("a Morton tree holds every primitive once, with any policy") {
    const mesh m = make_sphere({0, 0, 0}, 1, 6); // 81,920: several parts
    const build_morton_test::morton_tree one{exec::seq, mesh_view{m}}, many{exec::par.threads(3), mesh_view{m}};
    const auto leaves = one.view_of().leaves, same = many.view_of().leaves;
    REQUIRE(leaves.size() == same.size());
    CHECK(std::equal(leaves.begin(), leaves.end(), same.begin(), [](const auto& a, const auto& b) {
        return std::equal(std::begin(a.primitive), std::end(a.primitive), std::begin(b.primitive));
    }));
    CHECK(one.statistics().cost == many.statistics().cost);
    std::vector<int> times(m.faces.size());
    for (const auto& leaf : leaves)
        for (const std::uint32_t primitive : leaf.primitive)
            if (primitive != no_primitive) ++times[primitive];
    CHECK(std::all_of(times.begin(), times.end(), [](int n) { return n == 1; }));
}

TEST_CASE("primitives that are not finite are kept in the Morton order, in the cell of the one before them") {
    mesh m = build_morton_test::random_triangles(5, 40'001, 0.01F); // several blocks
    const auto broken = [](std::size_t i) { return i % 3 == 1 || (i > 8000 && i < 17'000) || i == 40'000; };
    for (std::size_t i = 0; i < m.faces.size(); ++i)
        if (broken(i)) m.positions[m.faces[i].y].z = NAN;
    const morton_order order{exec::par.threads(2), mesh_view{m}};
    std::vector<int> times(m.faces.size());
    std::vector<std::uint32_t> cells(m.faces.size());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        ++times[order.primitive(i)];
        cells[order.primitive(i)] = order.cell(i);
        wrong += i > 0 && order.cell(i) < order.cell(i - 1);
    }
    constexpr std::size_t block = 8192; // whose first primitives have none before them
    for (std::size_t i = 0; i < times.size(); ++i)
        wrong += times[i] != 1 || (broken(i) && i % block > 0 && cells[i] != cells[i - 1]);
    CHECK(wrong == 0);
}

TEST_CASE("a primitive that is not finite does not change the grid of a Morton tree") {
    mesh m = make_sphere({1000, 0, 0}, 1, 5);
    const morton_order expected{exec::seq, mesh_view{m}};
    m.positions[m.faces[0].x].x = std::numeric_limits<float>::quiet_NaN(); // and so its neighbours
    const morton_order found{exec::seq, mesh_view{m}};
    std::size_t cells = 1, expected_cells = 1;
    for (std::size_t i = 1; i < found.size(); ++i) {
        cells += found.cell(i) != found.cell(i - 1);
        expected_cells += expected.cell(i) != expected.cell(i - 1);
    }
    CHECK(cells > 0.99 * static_cast<double>(expected_cells));
}

TEST_CASE("primitives are in the order of their cells, then in their own, and the place where a cell's highest bit "
          "changes is found") {
    // Less than 1024 are sorted at once; of more, those with one highest digit, each way: less than 64, than 512, and more.
    for (const std::uint32_t count : {10U, 900U, 20'000U, 300'000U}) {
        mesh m = build_morton_test::random_triangles(count, count, 0.01F);
        for (std::size_t i = 0; i < m.positions.size() / 2; ++i) m.positions[i] *= 0.1F; // half of them in the middle
        const morton_order order{exec::par, mesh_view{m}};
        REQUIRE(order.size() == count);
        std::size_t wrong = 0;
        for (std::size_t i = 1; i < count; ++i)
            wrong += order.cell(i) < order.cell(i - 1) ||
                     (order.cell(i) == order.cell(i - 1) && order.primitive(i) <= order.primitive(i - 1));
        CHECK(wrong == 0);
        for (std::uint64_t k = 0; k < 300; ++k) {
            const auto at = [&](std::uint64_t seed) {
                return static_cast<std::size_t>(hash_uniform(seed, k) * static_cast<float>(count - 1));
            };
            const std::size_t begin = std::min(at(1), at(2)), end = std::max(at(1), at(2)) + 1;
            const std::uint32_t step = order.highest_step(begin, end);
            if (step == 0) continue;
            std::size_t place = begin; // the first cell that has the bit, the lower ones lacking it
            while ((order.cell(place) >> (step - 1) & 1U) == 0) ++place;
            wrong += order.place_of_step(begin, end, step) != place;
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("Morton codes separate primitives up to the largest floats") {
    mesh m;
    for (const float x : {3.3e38F, -3.3e38F, 1e38F, -1e38F}) {
        m.faces.push_back(uvec3{static_cast<std::uint32_t>(m.positions.size())});
        m.positions.push_back({x, 0, 0});
    }
    std::feclearexcept(FE_ALL_EXCEPT);
    const morton_order order{exec::seq, mesh_view{m}};
#if defined(FE_INVALID) // not by Emscripten
    CHECK(std::fetestexcept(FE_INVALID) == 0);
#endif
    REQUIRE(order.size() == 4);
    CHECK(order.primitive(0) == 1);
    CHECK(order.primitive(1) == 3);
    CHECK(order.primitive(2) == 2);
    CHECK(order.primitive(3) == 0);
    for (std::size_t i = 1; i < 4; ++i) CHECK(order.cell(i - 1) < order.cell(i));
}

TEST_CASE("a Morton tree costs at most a quarter more than one by SAH") {
    const mesh m = make_sphere({0, 0, 0}, 1, 6);
    const build_morton_test::morton_tree quick{exec::par, mesh_view{m}};
    const bvh best{exec::par, m};
    CHECK(quick.statistics().cost < 1.25 * best.statistics().cost);
    CHECK(quick.statistics().leaves < m.faces.size() * 3 / (2 * std::size_t{simd_width}));
}

TEST_CASE("identical and non-finite primitives make Morton trees") {
    mesh m{.positions = {{-1, -1, 1}, {1, -1, 1}, {0, 1, 1}}, .faces = {}};
    m.faces.assign(50'000, {0, 1, 2});
    m.positions.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
    m.faces[3] = {0, 1, 3};
    m.positions.push_back({FLT_MAX, -FLT_MAX, FLT_MAX});
    m.faces[9] = {0, 1, 4};
    const build_morton_test::morton_tree tree{exec::par, mesh_view{m}};
    CHECK(tree.statistics().primitives == 49'999);
    CHECK(tree.statistics().levels <= max_levels<simd_width>);
    std::vector<hit> hits;
    tree.all({}, hits);
    CHECK(hits.size() == 49'998);
}

TEST_CASE("one distant primitive degrades a Morton tree equally little where it is not sampled first") {
    mesh m = build_morton_test::random_triangles(5, 40'000, 0.01F);
    for (const std::uint32_t corner : {0U, 1U, 2U}) m.positions[corner].z += 20;
    const double cost = build_morton_test::morton_tree{exec::par, mesh_view{m}}.statistics().cost;
    std::swap(m.faces[0], m.faces[1]);
    CHECK(build_morton_test::morton_tree{exec::par, mesh_view{m}}.statistics().cost < 1.05 * cost);
    CHECK(build_morton_test::missed_or_invented(m, 9) == 0);
}

} // namespace build_morton_test
