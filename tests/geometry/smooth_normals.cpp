#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/geometry/smooth_normals.hpp>
#include <insonify/geometry/validate.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;
using detail::face_normals;

namespace smooth_normals_test {
namespace {

/// A mesh with its groups, whose normals are computed as they are needed.
struct smooth {
    mesh surface;
    detail::vertex_groups groups;
    smooth(mesh shape, float crease_angle) : surface{std::move(shape)}, groups{mesh_view{surface}, crease_angle} {}
    face_normals of_face(std::uint32_t face) const {
        return detail::smooth_normals_view{groups.corners, groups.ends, groups.slots, {}}.of_face(mesh_view{surface},
                                                                                                  face, {0, 0, 1});
    }
    vec3 middle(std::uint32_t face) const {
        const triangle t = mesh_view{surface}[face];
        return (t.a + t.b + t.c) / 3.0F;
    }
};
float degrees_between(vec3 a, vec3 b) {
    return std::asin(std::min(length(cross(a, b)) / (length(a) * length(b)), 1.0F)) / 1_deg;
}

} // namespace
} // namespace smooth_normals_test

TEST_CASE("the normals of a ball point from its centre, and have its curvature, within what its faces allow") {
    using namespace smooth_normals_test;
    const smooth ball{make_sphere({1_mm, 2_mm, 3_mm}, 5_mm, 4), 30_deg};
    float of_faces = 0, of_normals = 0, curvature = 0;
    for (std::uint32_t i = 0; i < ball.surface.faces.size(); ++i) {
        const face_normals found = ball.of_face(i);
        REQUIRE(found.curved);
        const triangle t = mesh_view{ball.surface}[i];
        for (const vec3 at : {t.a, 0.5F * (t.a + t.b), ball.middle(i), 0.1F * t.a + 0.9F * t.c}) {
            const vec3 outwards = normalize(at - vec3{1_mm, 2_mm, 3_mm});
            of_faces = std::max(of_faces, degrees_between(found.flat, outwards));
            of_normals = std::max(of_normals, degrees_between(found.at(at), outwards));
        }
        const vec3 along = normalize(t.b - t.a);
        curvature = std::max(curvature, std::fabs(dot(found.change(along), along) * 5e-3F - 1));
    }
    MESSAGE("largest error: of faces ", of_faces, " degrees, of interpolated normals ", of_normals, ", of curvature ",
            100 * curvature, " %");
    CHECK(of_normals < 0.1F * of_faces);
    CHECK(curvature < 0.05F);
}

TEST_CASE("the corners of a prism's sides have the bisectors of the sides, those of its ends the ends' normals") {
    using namespace smooth_normals_test;
    const smooth prism{make_cylinder({0, 0, 0}, {0, 0, 40_mm}, 0.36_mm, 24), 30_deg};
    for (std::uint32_t i = 0; i < prism.surface.faces.size(); ++i) {
        const face_normals found = prism.of_face(i);
        const triangle t = mesh_view{prism.surface}[i];
        if (std::fabs(found.flat.z) > 0.5F) {
            CHECK_FALSE(found.curved);
            continue;
        }
        const vec3 corner[] = {t.a, t.b, t.c};
        for (int k = 0; k < 3; ++k) CHECK(degrees_between(found.corner[k], {corner[k].x, corner[k].y, 0}) < 0.02F);
    }
}

TEST_CASE("edges steeper than the crease angle are creases, others are smooth, and 0 makes every face flat") {
    using namespace smooth_normals_test;
    const auto curved_sides = [](std::uint32_t sides, float crease_angle) {
        const smooth prism{make_cylinder({0, 0, 0}, {0, 0, 1_mm}, 1_mm, sides), crease_angle};
        return prism.of_face(2).curved;
    };
    CHECK(curved_sides(12, 30_deg)); // sides meet at exactly 30 degrees
    CHECK_FALSE(curved_sides(11, 30_deg));
    CHECK(curved_sides(11, 35_deg));
    CHECK_FALSE(curved_sides(24, 10_deg));
    const smooth box{subdivide(subdivide(make_box({-1_mm, 2_mm, 3_mm}, {4_mm, 5_mm, 7_mm}))), 30_deg};
    for (std::uint32_t i = 0; i < box.surface.faces.size(); ++i) {
        CHECK_FALSE(box.of_face(i).curved);
        CHECK(box.of_face(i).at(box.middle(i)) == unit_normal(mesh_view{box.surface}[i], {0, 0, 0}));
    }
}

TEST_CASE("two surfaces that touch in a vertex have a normal each, and what is degenerate does not disturb") {
    using namespace smooth_normals_test;
    mesh roofs; // two pyramids, tip to tip
    roofs.positions = {{0, 0, 0}, {1, 0, 4}, {-1, 1, 4}, {-1, -1, 4}, {1, 0, -4}, {-1, 1, -4}, {-1, -1, -4}, {0, 0, 0}};
    roofs.faces = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {0, 4, 5}, {0, 5, 6}, {0, 6, 4}, {1, 2, 3}, {4, 6, 5}, {0, 7, 0}};
    const smooth both{roofs, 180_deg};
    for (const std::uint32_t upper : {0U, 1U, 2U}) CHECK(both.of_face(upper).corner[0].z < -0.9F);
    for (const std::uint32_t lower : {3U, 4U, 5U}) CHECK(both.of_face(lower).corner[0].z > 0.9F);
    CHECK(both.of_face(8).flat == vec3{0, 0, 1});
    CHECK_FALSE(both.of_face(8).curved);
    const smooth none{mesh{}, 30_deg};
    CHECK(none.groups.ends.empty());
}

TEST_CASE("vertices that are repeated for each face, or along a seam, are smooth as those that faces share") {
    using namespace smooth_normals_test;
    const mesh shared = make_sphere({1_mm, 2_mm, 3_mm}, 5_mm, 3);
    mesh of_each_face, with_seam = shared;
    for (const uvec3& face : shared.faces) {
        const auto first = static_cast<std::uint32_t>(of_each_face.positions.size());
        for (const std::uint32_t corner : {face.x, face.y, face.z})
            of_each_face.positions.push_back(shared.positions[corner]);
        of_each_face.faces.push_back({first, first + 1, first + 2});
    }
    const auto count = static_cast<std::uint32_t>(shared.positions.size());
    with_seam.positions.insert(with_seam.positions.end(), shared.positions.begin(), shared.positions.end());
    for (uvec3& face : with_seam.faces) {
        const vec3 middle = (shared.positions[face.x] + shared.positions[face.y] + shared.positions[face.z]) / 3.0F;
        if (middle.x > 1_mm) face += uvec3{count}; // that half has vertices of its own
    }
    const smooth expected{shared, 30_deg};
    for (const mesh& repeated : {of_each_face, with_seam}) {
        const smooth ball{repeated, 30_deg};
        for (std::uint32_t i = 0; i < shared.faces.size(); ++i)
            for (int k = 0; k < 3; ++k) CHECK(ball.of_face(i).corner[k] == expected.of_face(i).corner[k]);
    }
}

TEST_CASE("closed surfaces that touch along an edge do not smooth one another") {
    using namespace smooth_normals_test;
    mesh wedges; // whose upper faces meet at 10 degrees
    for (const float side : {-1_mm, 1_mm}) {
        const auto first = static_cast<std::uint32_t>(wedges.positions.size());
        for (const float y : {-1_mm, 1_mm})
            for (const vec2 at :
                 {vec2{0, 0}, vec2{2 * side, side < 0 ? -2_mm : -0.17_mm}, vec2{2 * side, side < 0 ? -0.17_mm : -2_mm}})
                wedges.positions.push_back({at.x, y, at.y});
        const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            wedges.faces.push_back(first + uvec3{a, c, b});
        };
        add(0, 1, 2);
        add(3, 5, 4);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t j = (i + 1) % 3;
            add(j, i, i + 3);
            add(j, i + 3, j + 3);
        }
    }
    REQUIRE(validate(wedges).closed());
    REQUIRE(validate(wedges).inside_out_components == 0);
    const smooth both{wedges, 30_deg};
    for (std::uint32_t i = 0; i < wedges.faces.size(); ++i) CHECK_FALSE(both.of_face(i).curved);
}
