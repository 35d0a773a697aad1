#include <insonify/geometry/validate.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/scene/skin.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include "../geometry/meshes.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <string>

using namespace insonify;

namespace skin_test {

/// Lengths in metres of what lies below the face, on average over the lines; all of it is met in this order.
struct cover {
    float gel = 0, skin = 0, fat = 0;
};

template <transducer Probe>
cover cover_of(const Probe& probe, const skin_settings& settings) {
    scene body{tissue::deep_fat};
    body.add(make_sphere({0, 0, 60_mm}, 5_mm, 3), tissue::liver, {.name = "liver"});
    const pose at = look_at({3_mm, 4_mm, 5_mm}, {0, 1_mm, 40_mm}, {1, 0.2F, 0});
    CHECK(add_skin(body, probe, at, settings) == skin_place::face);
    for (const object& one : body.objects()) CHECK(validate(one.surface).closed());
    body.build(exec::seq);
    const acquisition scan{.depth = 40_mm, .samples = 1024, .planes = 3};
    const line_layers found = find_layers(exec::seq, body, probe, at, scan);
    cover mean;
    for (std::uint32_t plane = 0; plane < found.planes; ++plane)
        for (std::uint32_t line = 0; line < found.lines; ++line) {
            const auto layers = found(line, plane);
            const std::vector<std::string> names{"gel", "skin", "subcutaneous fat"};
            for (std::size_t i = 0; i < (settings.fat > 0 ? 3U : 2U); ++i) {
                REQUIRE(layers.size() > i);
                CHECK(body[object_id{layers[i].object}].name == names[i]);
                float& sum = i == 0 ? mean.gel : i == 1 ? mean.skin : mean.fat;
                sum += (layers[i].end - layers[i].begin) / static_cast<float>(found.lines * found.planes);
            }
        }
    return mean;
}

} // namespace skin_test

TEST_CASE("add_skin: gel, skin and fat of the given thickness lie below the face of any probe") {
    const skin_settings settings{.thickness = 2_mm, .fat = 8_mm, .gel = 0.5_mm};
    for (const skin_test::cover& mean :
         {skin_test::cover_of(linear_array{}, settings), skin_test::cover_of(convex_array{}, settings)}) {
        CHECK(mean.gel == doctest::Approx(0.5e-3).epsilon(0.1).scale(1e-30));
        CHECK(mean.skin == doctest::Approx(2e-3).epsilon(0.1).scale(1e-30));
        CHECK(mean.fat == doctest::Approx(8e-3).epsilon(0.15).scale(1e-30));
    }
    const phased_array narrow{.lines = 33, .field_of_view = 20_deg}; // its face is small: less of an average
    CHECK(skin_test::cover_of(narrow, settings).skin == doctest::Approx(2e-3).epsilon(0.25).scale(1e-30));
    CHECK(skin_test::cover_of(linear_array{}, {.fat = 0}).fat == 0);
    const skin_test::cover thick = skin_test::cover_of(linear_array{}, {.thickness = 15_mm, .fat = 0, .gel = 4_mm});
    CHECK(thick.skin == doctest::Approx(15e-3).epsilon(0.1).scale(1e-30));
}

TEST_CASE("add_skin: of a body with an outer surface, the outer layer becomes skin") {
    scene body{tissue::air};
    body.add(make_sphere({0, 0, 50_mm}, 40_mm, 5), tissue::fat, {.name = "body"});
    body.add(make_sphere({0, 0, 50_mm}, 10_mm, 4), tissue::liver, {.name = "liver"});
    CHECK(add_skin(body, linear_array{}, pose{}, {.thickness = 2_mm}) == skin_place::surface);
    REQUIRE(body.objects().size() == 3);
    const object_id skin = *body.find("skin"), whole = *body.find("body");
    CHECK(body[skin].inside == tissue::skin);
    CHECK(body[whole].inside == tissue::fat);
    const auto radius = [&](object_id id) {
        return std::cbrt(double{enclosed_volume(body[id].surface)} * 3 / (4 * 3.14159265358979));
    };
    CHECK(radius(skin) - radius(whole) == doctest::Approx(2e-3).epsilon(0.03).scale(1e-30));
    CHECK(validate(body[whole].surface).closed());
    CHECK(add_skin(body, linear_array{}, pose{}) == skin_place::none); // it has skin now
    CHECK(body.objects().size() == 3);
}

TEST_CASE("add_skin: the outer layer lies inside, whatever way the faces point and however vertices are shared") {
    for (const mesh& limb : {mesh_test::turned_inside_out(make_sphere({0, 0, 50_mm}, 40_mm, 4)),
                             mesh_test::unwelded(make_sphere({0, 0, 50_mm}, 40_mm, 4))}) {
        scene body{tissue::air};
        body.add(limb, tissue::fat, {.name = "limb"});
        body.add(make_sphere({0, 0, 50_mm}, 15_mm, 3), tissue::bone);
        REQUIRE(add_skin(body, {.thickness = 2_mm}) == skin_place::surface);
        const mesh& inner = body[*body.find("limb")].surface;
        CHECK(validate(inner).closed());
        const double radius = std::cbrt(std::fabs(double{enclosed_volume(inner)}) * 3 / (4 * 3.14159265358979));
        CHECK(radius == doctest::Approx(38e-3).epsilon(0.01).scale(1e-30));
    }
}

TEST_CASE("add_skin: without a probe, what one object encloses is covered, and nothing else") {
    scene body{tissue::air};
    body.add(make_sphere({0, 0, 50_mm}, 40_mm, 5), tissue::muscle, {.name = "body"});
    CHECK(add_skin(body) == skin_place::none); // it encloses nothing
    body.add(make_sphere({0, 0, 50_mm}, 10_mm, 4), tissue::bone, {.name = "bone"});
    CHECK_THROWS_AS(add_skin(body, {.thickness = -1_mm}), usage_error);
    CHECK_THROWS_AS(add_skin(body, {.thickness = 20.1_mm}), usage_error);
    CHECK_NOTHROW(skin_settings{.thickness = 20 * 1_mm}.check()); // more than 0.02F by rounding
    CHECK(body.objects().size() == 2);
    CHECK(add_skin(body) == skin_place::surface);
    CHECK(body[*body.find("skin")].inside == tissue::skin);
    CHECK(add_skin(body) == skin_place::none);
    CHECK(body.objects().size() == 3);
}

TEST_CASE("add_skin: names that are taken get a number") {
    scene limb{tissue::air};
    limb.add(make_sphere({0, 0, 50_mm}, 40_mm, 5), tissue::muscle, {.name = "skin"});
    limb.add(make_sphere({0, 0, 50_mm}, 10_mm, 4), tissue::bone, {.name = "skin.2"});
    CHECK(add_skin(limb, linear_array{}, pose{}) == skin_place::surface);
    CHECK(limb[*limb.find("skin.3")].inside == tissue::skin);
    CHECK(limb[*limb.find("skin")].inside == tissue::muscle);

    scene organ{tissue::fat};
    organ.add(make_sphere({0, 0, 50_mm}, 10_mm, 4), tissue::liver, {.name = "gel"});
    CHECK(add_skin(organ, linear_array{}, pose{}) == skin_place::face);
    CHECK(organ[*organ.find("gel")].inside == tissue::liver);
    CHECK(organ[*organ.find("gel.2")].inside == tissue::gel);
}

TEST_CASE("add_skin: what cannot be covered is refused, and the body stays") {
    scene body{tissue::fat};
    CHECK_THROWS_WITH_AS(add_skin(body, radial_array{}, pose{}),
                         "add_skin: a probe that looks out of a full circle does not stand on skin", usage_error);
    CHECK_THROWS_WITH_AS(add_skin(body, linear_array{}, pose{}, {.thickness = 2}),
                         "add_skin: thickness is 2 m: did you mean 2_mm?", usage_error);
    CHECK_THROWS_AS(add_skin(body, linear_array{}, pose{}, {.gel = std::numeric_limits<float>::quiet_NaN()}),
                    usage_error);
    pose stretched;
    stretched.rotation[0] *= 2;
    CHECK_THROWS_AS(add_skin(body, linear_array{}, stretched), geometry_error);
    CHECK(body.objects().empty());

    body.add(make_sphere({0, 0, 50_mm}, 40_mm, 3), tissue::fat, {.priority = std::numeric_limits<int>::max()});
    CHECK_THROWS_AS(add_skin(body, linear_array{}, pose{}), usage_error);
    body.build(exec::seq).deform(exec::seq, [](vec3 rest) { return 0.5F * rest; });
    CHECK_THROWS_WITH_AS(add_skin(body), "add_skin: the body is deformed; cover it before `deform`", usage_error);
    CHECK_THROWS_AS(add_skin(body, linear_array{}, pose{}), usage_error);
    CHECK(body.objects().size() == 1);
}
