#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/tissue/fibres.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace fibres_axes_test {
namespace {

float parallel(vec3 a, vec3 b) { return std::fabs(dot(normalize(a), normalize(b))); }

mat3 axes_of_mesh(const mesh& surface, vec3 fibres = {0, 0, 0}) {
    aabb box;
    for (const vec3& p : surface.positions) box = merged(box, p);
    return detail::aligned(detail::axes_of(mesh_view{surface}, box), fibres);
}

} // namespace

TEST_CASE("structure axes: fibres run along a cylinder, whatever its direction and place") {
    for (const vec3 direction : {vec3{1, 0, 0}, vec3{0, 0, 1}, vec3{1, 2, -3}}) {
        const vec3 from{0.3F, -0.2F, 0.5F};
        const mat3 axes = axes_of_mesh(make_cylinder(from, from + 80_mm * normalize(direction), 10_mm, 32));
        CHECK(parallel(axes[0], direction) > 0.9999F);
        CHECK(determinant(axes) * determinant(axes) == doctest::Approx(1.0F).scale(1e-30).epsilon(1e-4));
    }
}

TEST_CASE("structure axes: a box is flattest along its shortest side") {
    const mat3 axes = axes_of_mesh(make_box({0, 0, 0}, {60_mm, 90_mm, 20_mm}));
    CHECK(parallel(axes[0], {0, 1, 0}) > 0.9999F);
    CHECK(parallel(axes[1], {1, 0, 0}) > 0.9999F);
    CHECK(parallel(axes[2], {0, 0, 1}) > 0.9999F);
    SUBCASE("given fibres replace the longest axis") {
        const mat3 given = axes_of_mesh(make_box({0, 0, 0}, {60_mm, 90_mm, 20_mm}), {3, 0, 0});
        CHECK(parallel(given[0], {1, 0, 0}) > 0.9999F);
        CHECK(parallel(given[2], {0, 0, 1}) > 0.9999F);
    }
    SUBCASE("given fibres along the shortest axis") {
        const mat3 given = axes_of_mesh(make_box({0, 0, 0}, {60_mm, 90_mm, 20_mm}), {0, 0, 1});
        CHECK(parallel(given[0], {0, 0, 1}) > 0.9999F);
        CHECK(std::fabs(dot(given[0], given[2])) < 1e-5F);
    }
}

TEST_CASE("structure axes: where moments are equal, the axes are those of the coordinates, in their order") {
    for (const vec3 place : {vec3{0, 0, 0}, vec3{0.3137F, -0.2011F, 0.5173F}, vec3{-0.481F, 0.352F, 0.4F}}) {
        const auto axes_are = [](const mesh& surface, vec3 first, vec3 second) {
            const mat3 axes = axes_of_mesh(surface);
            CHECK(parallel(axes[0], first) > 0.999999F);
            CHECK(parallel(axes[1], second) > 0.999999F);
        };
        axes_are(make_box(place, place + vec3{24_mm, 24_mm, 24_mm}), {1, 0, 0}, {0, 1, 0});
        axes_are(make_box(place, place + vec3{24_mm, 24_mm, 200_mm}), {0, 0, 1}, {1, 0, 0});
        axes_are(make_box(place, place + vec3{24_mm, 200_mm, 24_mm}), {0, 1, 0}, {1, 0, 0});
        axes_are(make_sphere(place, 8_mm, 4), {1, 0, 0}, {0, 1, 0});
        axes_are(make_cylinder(place, place + vec3{0, 120_mm, 0}, 4_mm, 64), {0, 1, 0}, {1, 0, 0});
    }
}

TEST_CASE("structure axes: an open or empty mesh still has axes") {
    mesh open = make_box({0, 0, 0}, {60_mm, 90_mm, 20_mm});
    open.faces.resize(1);
    for (const mesh& each : {open, mesh{}}) {
        const mat3 axes = axes_of_mesh(each);
        for (int i = 0; i < 3; ++i) CHECK(is_finite(axes[i]));
        CHECK(std::fabs(determinant(axes)) == doctest::Approx(1.0F).scale(1e-30).epsilon(1e-4));
    }
}

TEST_CASE("scene: the structure of an object and of the background follow the fibres that are set") {
    scene body{tissue::fat};
    const object_id calf = body.add(make_box({0, 0, 0}, {60_mm, 90_mm, 20_mm}), tissue::muscle, {.fibres = {1, 0, 0}});
    const object_id plain = body.add(make_box({0, 0, 30_mm}, {60_mm, 90_mm, 50_mm}), tissue::bone);
    body.build(exec::seq);
    body.set_background_fibres({0, 0, 2}, {0, 3, 0});
    const auto of = [&](object_id id) {
        const scene_view flat = body.view_for_rays(exec::seq);
        std::size_t place = 1;
        while (flat.objects[place - 1].id != static_cast<std::uint32_t>(id)) ++place;
        return flat.structures[place];
    };
    CHECK(parallel(of(calf).axes[0], {1, 0, 0}) > 0.9999F);
    CHECK(of(calf).of == tissue::muscle.structure);
    CHECK(of(plain).of.empty());
    CHECK(parallel(body.view_for_rays(exec::seq).structures[0].axes[0], {0, 0, 1}) > 0.9999F);
    body.set_medium(plain, tissue::tendon);
    CHECK(of(plain).of == tissue::tendon.structure);
    CHECK(parallel(of(plain).axes[0], {0, 1, 0}) > 0.9999F);
    CHECK(parallel(body.view_for_rays(exec::seq).structures[0].axes[2], {0, 1, 0}) > 0.9999F);
    CHECK_THROWS_AS(body.set_background_fibres({0, 0, 0}), usage_error);
    CHECK_THROWS_AS(body.set_background_fibres({0, 0, 1}), usage_error); // parallel to z
    CHECK_THROWS_AS(body.add(make_box({0, 0, 0}, {1, 1, 1}), tissue::muscle, {.fibres = {NAN, 0, 0}}), geometry_error);
}

} // namespace fibres_axes_test
