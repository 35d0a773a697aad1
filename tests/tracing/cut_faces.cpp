#include <insonify/bvh/bvh.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <algorithm>
#include <bit>
#include <cmath>
#include <doctest/doctest.h>
#include <glm/glm.hpp>
#include <map>

using namespace insonify;

namespace cut_faces_test {

using namespace insonify::detail;

namespace {

slice_frame random_frame(std::uint64_t seed, view<const detail::elevation_plane> planes) {
    const auto at = [&](std::uint64_t k) {
        return vec3{hash_uniform(seed, k) - 0.5F, hash_uniform(seed, k + 1) - 0.5F, hash_uniform(seed, k + 2) - 0.5F};
    };
    return {look_at(0.2F * at(0), at(3), at(6)), planes};
}

// Calls visit(slice, face, from, to) for all cuts of a mesh, its faces taken a few at a time.
template <class Visit>
void cut_all(const slice_frame& frame, const mesh_view& surface, const Visit& visit) {
    constexpr std::uint32_t width = simd_width;
    for (std::uint32_t first = 0; first < surface.size(); first += width) {
        std::uint32_t slots[width];
        for (std::uint32_t i = 0; i < width; ++i) slots[i] = first + i < surface.size() ? first + i : no_primitive;
        leaf<mesh_view, simd_width> faces;
        faces.fill(surface, slots);
        cut_faces(frame, faces, [&](std::uint32_t slice, std::uint32_t cut, const auto& from, const auto& to) {
            for (; cut != 0; cut &= cut - 1) {
                const std::uint32_t i = detail::lowest_bit(cut);
                const auto end = [&](const auto& of) {
                    float across[width], along[width];
                    store(of.across, across);
                    store(of.along, along);
                    return vec2{across[i], along[i]};
                };
                visit(slice, faces.primitive[i], end(from), end(to));
            }
        });
    }
}

} // namespace

TEST_CASE("the cut of a closed surface is closed: each of its points ends two segments, bit for bit") {
    std::size_t segments = 0;
    const detail::elevation_plane planes[] = {{0, 0.2F}, {0.1F}, {-0.3F, -0.1F}};
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        mesh ball = make_sphere({0, 0, 0}, 1, 3);
        for (uvec3& face : ball.faces) // whichever corner a face begins with
            for (std::uint64_t i = hash_bits(seed, face.x) % 3; i > 0; --i) face = {face.y, face.z, face.x};
        const slice_frame frame = cut_faces_test::random_frame(seed, planes);
        std::map<std::pair<float, float>, int> ends[3];
        cut_faces_test::cut_all(frame, ball, [&](std::uint32_t slice, std::uint32_t, vec2 from, vec2 to) {
            ++ends[slice][{from.x, from.y}];
            ++ends[slice][{to.x, to.y}];
            ++segments;
        });
        for (const auto& slice : ends)
            for (const auto& [place, count] : slice) REQUIRE(count % 2 == 0);
    }
    CHECK(segments > 3000);
}

TEST_CASE("a face is cut where the plane meets its edges, to double precision's rounding in floats") {
    const detail::elevation_plane planes[] = {{0.02F}, {-0.05F, 0.3F}};
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        const slice_frame frame = cut_faces_test::random_frame(seed, planes);
        triangle t;
        for (vec3* corner : {&t.a, &t.b, &t.c}) {
            const auto k = static_cast<std::uint64_t>(100 + 3 * (corner - &t.a));
            *corner = {hash_uniform(seed, k) - 0.5F, hash_uniform(seed, k + 1) - 0.5F,
                       hash_uniform(seed, k + 2) - 0.5F};
        }
        const glm::dvec3 across{frame.across}, along{frame.along}, origin{frame.origin}, up = glm::cross(along, across);
        const auto height_in = [](const detail::elevation_plane& plane, double depth) {
            return static_cast<double>(plane.offset) + static_cast<double>(plane.slope) * depth;
        };
        std::size_t expected = 0, found = 0;
        for (const detail::elevation_plane& plane : planes) {
            const auto height = [&](vec3 corner) {
                const glm::dvec3 p = glm::dvec3{corner} - origin;
                return glm::dot(up, p) - height_in(plane, glm::dot(along, p));
            };
            const bool a = height(t.a) > 0, b = height(t.b) > 0, c = height(t.c) > 0;
            expected += a != b || b != c;
        }
        const mesh one{{t.a, t.b, t.c}, {{0, 1, 2}}};
        cut_faces_test::cut_all(frame, one, [&](std::uint32_t slice, std::uint32_t, vec2 from, vec2 to) {
            ++found;
            for (const vec2 end : {from, to}) { // in the plane, and on one of the edges
                const auto depth = static_cast<double>(end.y);
                const glm::dvec3 p =
                    origin + height_in(planes[slice], depth) * up + static_cast<double>(end.x) * across + depth * along;
                double nearest = 1;
                const glm::dvec3 corner[3] = {glm::dvec3{t.a}, glm::dvec3{t.b}, glm::dvec3{t.c}};
                for (int i = 0; i < 3; ++i) {
                    const glm::dvec3 from_corner = p - corner[i], edge = corner[(i + 1) % 3] - corner[i];
                    const double fraction = glm::clamp(glm::dot(from_corner, edge) / glm::dot(edge, edge), 0.0, 1.0);
                    nearest = std::min(nearest, glm::length(from_corner - fraction * edge));
                }
                REQUIRE(nearest < 3e-6);
            }
        });
        REQUIRE(found == expected);
    }
}

TEST_CASE("faces whose corners differ in level are those that are cut, asked by vertices or by leaves of a tree") {
    const detail::elevation_plane planes[] = {{0},    {0.1F, 0.1F},  {0.11F, -0.2F}, {-0.3F},
                                              {0.7F}, {-0.9F, 0.3F}, {0.5F}};
    for (std::size_t slices = 1; slices <= 7; ++slices) {
        const mesh ball = make_sphere({0.1F, 0, 0}, 1, 4);
        const slice_frame frame = cut_faces_test::random_frame(slices, {planes, slices});
        std::vector<std::uint32_t> expected, by_vertices, by_leaves;
        const auto level = [&](std::uint32_t vertex) {
            unsigned below = 0;
            for (std::uint32_t i = 0; i < slices; ++i)
                if (frame.height_of(i, ball.positions[vertex]) > frame.height[i]) below |= 1U << i;
            return below;
        };
        for (std::uint32_t i = 0; i < ball.faces.size(); ++i) {
            const uvec3 face = ball.faces[i];
            if (level(face.x) != level(face.y) || level(face.x) != level(face.z)) expected.push_back(i);
        }
        std::vector<std::uint8_t> levels(ball.positions.size());
        find_levels(frame, ball.positions, levels.data());
        for (std::uint32_t i = 0; i < levels.size(); ++i) REQUIRE(levels[i] == level(i));
        const face_groups owner{ball};
        const detail::face_groups_view groups = owner.view_of();
        for_each_mixed(ball.faces, groups, 0, groups.count(), levels.data(),
                       [&](std::uint32_t face) { by_vertices.push_back(face); });
        CHECK(by_vertices == expected);

        const bvh tree{exec::seq, ball};
        slice_region everywhere;
        everywhere.frame = frame;
        for_each_leaf(tree.view_of(), 0, everywhere, [&](const auto& leaf) {
            cut_faces(frame, leaf, [&](std::uint32_t, std::uint32_t cut, const auto&, const auto&) {
                for (; cut != 0; cut &= cut - 1) by_leaves.push_back(leaf.primitive[detail::lowest_bit(cut)]);
            });
        });
        std::sort(by_leaves.begin(), by_leaves.end());
        by_leaves.erase(std::unique(by_leaves.begin(), by_leaves.end()), by_leaves.end()); // by several slices
        CHECK(by_leaves == expected);
    }
}

TEST_CASE("a slice through faces that shrink and shrink towards some corners finds them all, however deep the tree") {
    mesh shrinking;
    for (std::uint32_t corner = 0; corner < 64; ++corner)
        for (int step = 0; step < 110; ++step)
            for (std::uint32_t k = 0; k < 9; ++k) { // nine faces at a time: more than a leaf holds
                const float size = std::ldexp(1.0F, -step);
                const vec3 at = vec3{static_cast<float>(corner % 8), 0, static_cast<float>(corner / 8)} +
                                size * vec3{0.5F + 0.01F * static_cast<float>(k), 0, 0.5F};
                const auto first = static_cast<std::uint32_t>(shrinking.positions.size());
                for (const vec3 way : {vec3{0, -0.1F, 0}, vec3{0.05F, 0.1F, 0}, vec3{0, 0.1F, 0.05F}})
                    shrinking.positions.push_back(at + size * way);
                shrinking.faces.push_back({first, first + 1, first + 2});
            }
    const detail::elevation_plane middle{};
    slice_region everywhere;
    everywhere.frame = slice_frame{pose{}, {&middle, 1}};
    const auto find_all = [&](const auto& tree) {
        std::size_t found = 0;
        for_each_leaf(tree.view_of(), 0, everywhere, [&](const auto& leaf) {
            cut_faces(everywhere.frame, leaf, [&](std::uint32_t, std::uint32_t cut, const auto&, const auto&) {
                found += static_cast<std::size_t>(std::popcount(cut));
            });
        });
        return found;
    };
    CHECK(find_all(bvh{exec::seq, shrinking}) == shrinking.faces.size());
    CHECK(find_all(bvh<mesh_view, simd_width, build_morton>{exec::seq, mesh_view{shrinking}}) ==
          shrinking.faces.size());
}

} // namespace cut_faces_test
