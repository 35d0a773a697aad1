#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

namespace ray_packet_test {

using namespace insonify::detail;

namespace {

constexpr int width = simd_width;

vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

mesh bumpy_sphere(vec3 centre) {
    mesh m = make_sphere({0, 0, 0}, 1, 4);
    for (std::size_t i = 0; i < m.positions.size(); ++i)
        m.positions[i] = m.positions[i] * (1 + 0.1F * hash_uniform(1, i)) + centre;
    return m;
}

// Rows of rays in every direction: diverging, parallel and converging, some with limits. Rows are longer than one group,
// and not always whole groups.
std::vector<ray> rows(std::uint64_t seed, std::size_t count, vec3 centre) {
    std::vector<ray> rays;
    for (std::uint64_t row = 0; rays.size() < count; ++row) {
        const vec3 from = centre + 2.0F * random_point(seed, 4 * row);
        vec3 along = normalize(random_point(seed, 4 * row + 1));
        if (row % 5 == 0) along = vec3{0, 0, row % 2 == 0 ? 1 : -1}; // along an axis
        const vec3 turn = 0.01F * random_point(seed, 4 * row + 3);
        const vec3 step = (row % 4 == 1 ? 0.0F : 0.01F) * random_point(seed, 4 * row + 2); // or all from one place
        const int length = width * (1 + static_cast<int>(row % 5)) + (row % 11 == 0 ? 3 : 0);
        for (int i = 0; i < length; ++i) {
            ray r{.origin = from + static_cast<float>(i) * step, .direction = along + static_cast<float>(i) * turn};
            if (row % 3 == 0) r.direction = along;
            if (row % 7 == 1) r.max_distance = 1.5F + 0.1F * static_cast<float>(i);
            if (row % 7 == 2) r.min_distance = 1 + 0.1F * static_cast<float>(i);
            rays.push_back(r);
        }
    }
    return rays;
}

// The number of packets by number of groups; 0: groups that are traced ray by ray.
std::vector<std::size_t> together(const std::vector<ray>& rays, const bvh_view<mesh_view>& tree) {
    std::vector<std::size_t> packets(ray_packet<width>::max_groups + 1);
    ray_packet<width> packet;
    for (std::size_t i = 0; i < rays.size();) {
        const std::size_t taken =
            packet.prepare(rays.data() + i, rays.size() - i, tree.box, tree.max_abs_coordinate, tree.leaf_size);
        ++packets[taken / width];
        i += taken > 0 ? taken : width;
    }
    return packets;
}

// Whether a point at z lies behind the box, seen along the packet.
bool beyond(const aabb& box, const ray_packet<width>& packet, float z) {
    const int axis = packet.axes[2];
    return packet.forward > 0 ? z > box.upper[axis] : z < box.lower[axis];
}

// A cube around the origin.
aabb cube(float half) { return {vec3{-half}, vec3{half}}; }

} // namespace

TEST_CASE("packets return bit for bit the hits of single rays, near the origin and far from it") {
    for (const float offset : {0.0F, 30.0F}) {
        const vec3 centre{offset, -offset, offset};
        const mesh m = ray_packet_test::bumpy_sphere(centre);
        const bvh tree{exec::par, m};
        const std::vector<ray> rays = ray_packet_test::rows(2, 100'000, centre);
        for (const std::size_t packets : ray_packet_test::together(rays, tree.view_of())) CHECK(packets > 20);
        std::vector<hit> hits(rays.size());
        std::vector<std::uint8_t> met(rays.size());
        std::vector<std::vector<hit>> all(rays.size());
        tree.closest(exec::par_unseq, rays, hits);
        tree.any(exec::par_unseq, rays, met);
        tree.all(exec::par_unseq, rays, all);
        int wrong = 0;
        std::vector<hit> alone;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            tree.all(rays[i], alone);
            wrong += hits[i] != tree.closest(rays[i]) || (met[i] != 0) != tree.any(rays[i]) || all[i] != alone;
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("every ray stays within the bounds of its group, and the groups of a fan do not overlap") {
    using namespace ray_packet_test;
    for (const float offset : {0.0F, 30.0F, 1000.0F}) {
        const vec3 centre{offset, -offset, offset};
        const mesh m = bumpy_sphere(centre);
        const bvh tree{exec::par, m};
        const bvh_view<mesh_view> view = tree.view_of();
        const std::vector<ray> rays = rows(3, 100'000, centre);
        ray_packet<width> packet;
        int told = 0, outside = 0;
        for (std::size_t i = 0; i < rays.size();) {
            const std::size_t taken =
                packet.prepare(rays.data() + i, rays.size() - i, view.box, view.max_abs_coordinate, view.leaf_size);
            for (std::size_t k = 0; k < taken; ++k) {
                const auto& group = packet.of[k / width];
                for (int step = 0; step <= 40; ++step) {
                    const ray& r = rays[i + k];
                    const vec3 p{dvec3{r.origin} + 0.1 * step * dvec3{r.direction}};
                    const float z = p[packet.axes[2]];
                    if (beyond(view.box, packet, z)) continue;
                    const float u = packet.row[0] * p[packet.axes[0]] + packet.row[1] * p[packet.axes[1]];
                    told += packet.groups > 1;
                    outside += !(group.along.low + group.along.min_slope * z <= u &&
                                 u <= group.along.high + group.along.max_slope * z);
                }
            }
            i += taken > 0 ? taken : width;
        }
        CHECK(told > 100'000);
        CHECK(outside == 0);
    }
    // Fans of four groups, either way along z: from one place within the mesh, from a row, and so near that all is one.
    for (const float forward : {1.0F, -1.0F})
        for (const float step : {0.0F, 0.01F}) {
            std::vector<ray> fan;
            for (int i = 0; i < 4 * width; ++i) {
                const auto along = static_cast<float>(i);
                fan.push_back(
                    {.origin = {0.1F + step * along, 0.2F, 0.3F}, .direction = {0.01F * along, 0.1F, forward}});
            }
            ray_packet<width> packet;
            REQUIRE(packet.prepare(fan.data(), fan.size(), cube(1), 1, 1) == fan.size());
            const float z = 0.3F + forward, gap = step + 0.01F; // from ray to ray, 1 m from the origins
            for (int g = 0; g < 4; ++g) {
                const packet_wedge& along = packet.of[g].along;
                const float first = along.low + along.min_slope * z, last = along.high + along.max_slope * z;
                CHECK(std::fabs(first - 0.1F - static_cast<float>(g * width) * gap) < 0.3F * gap);
                CHECK(std::fabs(last - 0.1F - static_cast<float>((g + 1) * width - 1) * gap) < 0.3F * gap);
            }
        }
}

TEST_CASE("packets of rays closer than rounding, far from the origin and behind large faces, return the hits of single "
          "rays") {
    using namespace ray_packet_test;
    for (const float offset : {0.0F, 30.0F, 1000.0F}) {
        const vec3 centre{offset, 2 * offset, -offset};
        mesh m = bumpy_sphere(centre); // in a box whose sides pass the beginnings of all rays
        const mesh box = make_box(centre - vec3{2.5F}, centre + vec3{2.5F});
        const auto first = static_cast<std::uint32_t>(m.positions.size());
        m.positions.insert(m.positions.end(), box.positions.begin(), box.positions.end());
        for (const uvec3 face : box.faces) m.faces.push_back(face + uvec3{first});
        const bvh tree{exec::par, m};
        std::vector<ray> rays;
        for (std::uint64_t row = 0; row < 500; ++row) {
            const vec3 from = centre + 2.0F * random_point(8, 3 * row);
            const vec3 along = normalize(random_point(8, 3 * row + 1));
            const float spread = 1e-6F * static_cast<float>(row % 3) * offset;
            for (int i = 0; i < 4 * width; ++i)
                rays.push_back({.origin = from,
                                .direction = along + spread * static_cast<float>(i) * random_point(8, 3 * row + 2)});
        }
        CHECK(together(rays, tree.view_of())[4] > 200);
        std::vector<std::vector<hit>> all(rays.size());
        tree.all(exec::par, rays, all);
        int wrong = 0;
        std::vector<hit> alone;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            tree.all(rays[i], alone);
            wrong += all[i] != alone || alone.empty();
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("a packet takes as many groups as make a row of four leaves halfway through the box") {
    const mesh m = ray_packet_test::bumpy_sphere({0, 0, 0});
    const bvh tree{exec::par, m};
    const auto packets_of_row = [&](float leaves) {
        std::vector<ray> rays;
        const float step = leaves * tree.view_of().leaf_size / static_cast<float>(4 * simd_width - 1);
        for (int i = 0; i < 4 * simd_width; ++i)
            rays.push_back({.origin = {step * static_cast<float>(i), 0, -2}, .direction = {0, 0, 1}});
        return ray_packet_test::together(rays, tree.view_of());
    };
    CHECK(packets_of_row(3.9F) == std::vector<std::size_t>{0, 0, 0, 0, 1});
    CHECK(packets_of_row(4.1F) == std::vector<std::size_t>{0, 0, 2, 0, 0});
    CHECK(packets_of_row(8.7F) == std::vector<std::size_t>{0, 4, 0, 0, 0});
    CHECK(packets_of_row(21) == std::vector<std::size_t>{4, 0, 0, 0, 0});
}

TEST_CASE("no packet leaks out of a closed surface, through faces, vertices or edges") {
    const mesh m = ray_packet_test::bumpy_sphere({0, 0, 0});
    const bvh tree{exec::par, m};
    std::vector<ray> rays;
    for (std::uint64_t row = 0; row < 20'000; ++row) { // a row from one place through a vertex, an edge, and beyond
        const vec3 from = 0.3F * ray_packet_test::random_point(5, row);
        const uvec3 face = m.faces[hash_bits(6, row) % m.faces.size()];
        const vec3 a = m.positions[face.x], b = m.positions[face.y];
        for (int i = 0; i < simd_width; ++i)
            rays.push_back({.origin = from, .direction = a + 0.25F * static_cast<float>(i) * (b - a) - from});
    }
    CHECK(ray_packet_test::together(rays, tree.view_of())[1] > 5000);
    std::vector<std::vector<hit>> hits(rays.size());
    std::vector<hit> closest(rays.size());
    tree.all(exec::par, rays, hits);
    tree.closest(exec::par, rays, closest);
    int leaks = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) leaks += hits[i].size() % 2 == 0 || !closest[i];
    CHECK(leaks == 0);
}

TEST_CASE("incoherent rays make no packet") {
    const mesh m = ray_packet_test::bumpy_sphere({0, 0, 0});
    const bvh tree{exec::par, m};
    const std::vector<ray> row(simd_width, ray{.origin = {0, 0, -3}});
    CHECK(ray_packet_test::together(row, tree.view_of())[1] == 1);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const ray& odd :
         {ray{.origin = {0, 0, 3}, .direction = {0, 0, -1}}, ray{.direction = {1, 0, 0.5F}}, ray{.origin = {nan, 0, 0}},
          ray{.direction = {0, 0, 0}}, ray{.direction = {0, nan, 1}}, ray{.min_distance = -1}, ray{.min_distance = nan},
          ray{.origin = {0.5F, 0.5F, -3}, .direction = {0.9F, -0.9F, 1}}}) {
        std::vector<ray> rays = row;
        rays[2] = odd;
        CHECK(ray_packet_test::together(rays, tree.view_of())[0] == 1);
        std::vector<hit> hits(rays.size());
        tree.closest(exec::seq, rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) CHECK(hits[i] == tree.closest(rays[i]));
    }
}

TEST_CASE("a packet enters the boxes that some of its rays may hit, and misses the others at FLT_MAX") {
    tree_node<simd_width> node{};
    for (int i = 0; i < simd_width; ++i) { // one behind the other, every second one to the side
        const vec3 place{i % 2 == 0 ? 0.0F : 10.0F, 0, static_cast<float>(i)};
        node.set_box(i, {place - vec3{1, 1, 0}, place + vec3{1, 1, 0.5F}});
    }
    std::vector<ray> rays;
    for (int i = 0; i < simd_width; ++i)
        rays.push_back({.origin = {0.01F * static_cast<float>(i), 0, -1}, .max_distance = 3.5F});
    ray_packet<simd_width> together;
    REQUIRE(together.prepare(rays.data(), rays.size(), ray_packet_test::cube(20), 20, 1) == simd_width);
    lanes<simd_width> entry(0.0F);
    CHECK(enter(node, together, entry) == 0b101U);
    float begins[simd_width];
    store(entry, begins);
    for (int i = 0; i < simd_width; ++i)
        CHECK(begins[i] == (i == 0   ? doctest::Approx(1).scale(1e-30).epsilon(1e-3)
                            : i == 2 ? doctest::Approx(3).scale(1e-30).epsilon(1e-3)
                                     : doctest::Approx(FLT_MAX).scale(1e-30)));
}

TEST_CASE("a limit that is NaN only stops its own ray of a packet") {
    const mesh m = ray_packet_test::bumpy_sphere({0, 0, 0});
    const bvh tree{exec::par, m};
    std::vector<ray> rays(simd_width, ray{.origin = {0, 0, -3}});
    rays[1].max_distance = std::numeric_limits<float>::quiet_NaN();
    rays[2].max_distance = 1;
    std::vector<hit> hits(rays.size());
    tree.closest(exec::seq, rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) CHECK(static_cast<bool>(hits[i]) == (i != 1 && i != 2));
}

TEST_CASE("of coincident faces a packet hits the first, as single rays do") {
    mesh twice = ray_packet_test::bumpy_sphere({0, 0, 0});
    const std::size_t once = twice.faces.size();
    for (std::size_t i = 0; i < once; ++i) twice.faces.push_back(twice.faces[i]);
    const bvh tree{exec::seq, twice};
    const std::vector<ray> rays = ray_packet_test::rows(3, 20000, {0, 0, 0});
    CHECK(ray_packet_test::together(rays, tree.view_of())[1] > 0);
    std::vector<hit> hits(rays.size());
    tree.closest(exec::unseq, rays, hits);
    std::size_t met = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        REQUIRE(hits[i] == tree.closest(rays[i]));
        if (!hits[i]) continue;
        ++met;
        REQUIRE(hits[i].primitive < once);
    }
    CHECK(met > 1000);
}

} // namespace ray_packet_test
