#include <insonify/acoustics/tissue.hpp>
#include <insonify/channels/tissue_maps.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("map_tissue: media, labels, displacement and strain of what lies at each pixel") {
    scene body{tissue::fat};
    const object_id ball = body.add(make_sphere({0, 0, 20_mm}, 8_mm, 4), tissue::muscle);
    body.build(exec::par);
    const map_grid grid{.from = {-10_mm, 5_mm}, .spacing = 0.5_mm, .size = {41, 61}};
    const pose at = look_at({0, 0, 0}, {0, 0, 1}, {1, 0, 0});
    const tissue_maps rest = map_tissue(exec::par, body, at, grid);
    CHECK(rest == map_tissue(exec::seq, body, at, grid));
    const std::size_t middle = 30 * 41 + 20, outside = 0; // (0, 20) mm; (-10, 5) mm
    CHECK(rest.labels[middle] == static_cast<label_id>(ball));
    CHECK(rest.labels[outside] == background_label);
    CHECK(rest.sound_speed[middle] == tissue::muscle.sound_speed);
    CHECK(rest.sound_speed[outside] == tissue::fat.sound_speed);
    CHECK(rest.attenuation[middle] == tissue::muscle.attenuation);
    CHECK(rest.density[outside] == tissue::fat.density);
    CHECK(rest.displacement[middle] == vec2{0, 0});
    CHECK(rest.strain[middle] == slice_strain{});

    // Compressed by 2 % along z, half a per cent wider, sheared by 1 %.
    body.deform(exec::par, [](vec3 p) { return vec3{1.005F * p.x + 0.01F * p.z, p.y, 0.98F * p.z}; });
    const tissue_maps pressed = map_tissue(exec::par, body, at, grid);
    for (const std::size_t i : {middle, std::size_t{10 * 41 + 25}}) {
        const vec3 now = grid.at(static_cast<std::uint32_t>(i % 41), static_cast<std::uint32_t>(i / 41));
        const float z = now.z / 0.98F, x = (now.x - 0.01F * z) / 1.005F;
        CHECK(pressed.displacement[i].x == doctest::Approx(now.x - x).scale(1e-30).epsilon(0.002));
        CHECK(pressed.displacement[i].y == doctest::Approx(now.z - z).scale(1e-30).epsilon(0.002));
        CHECK(pressed.strain[i].axial == doctest::Approx(-0.02).scale(1e-30).epsilon(0.01));
        CHECK(pressed.strain[i].lateral == doctest::Approx(0.005).scale(1e-30).epsilon(0.02));
        CHECK(pressed.strain[i].shear == doctest::Approx(0.005).scale(1e-30).epsilon(0.02));
    }
    CHECK_THROWS_AS(map_tissue(exec::par, body, at, {.size = {0, 5}}), usage_error);
    CHECK_THROWS_AS(map_tissue(exec::par, body, at, {.spacing = 0}), usage_error);
    CHECK_THROWS_AS(map_tissue(exec::par, scene{}, at, {}), usage_error);
}
