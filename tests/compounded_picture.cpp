#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include "plain.hpp"
#include <doctest/doctest.h>

using namespace insonify;

namespace compounded_picture_test {
namespace {

scene phantom() {
    scene body{plain(tissue::muscle)};
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 4), tissue::blood);
    body.add(make_sphere({8_mm, 0, 20_mm}, 5_mm, 4), tissue::bone);
    return std::move(body).build(exec::par);
}

const linear_array probe{.lines = 96, .width = 40_mm, .frequency = 5_MHz};
const b_mode_settings settings{.depth = 40_mm, .size = {200, 200}, .planes = 3};

b_mode_settings with(compound_settings compound) {
    b_mode_settings changed = settings;
    changed.compound = compound;
    return changed;
}

// Mean over a rectangle of the picture, as fractions of its sides.
double mean(const image& picture, vec2 from, vec2 to) {
    double sum = 0, n = 0;
    for (std::uint32_t y = 0; y < picture.size.y; ++y)
        for (std::uint32_t x = 0; x < picture.size.x; ++x) {
            const vec2 at = vec2{static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F} /
                            vec2{static_cast<float>(picture.size.x), static_cast<float>(picture.size.y)};
            if (at.x < from.x || at.x > to.x || at.y < from.y || at.y > to.y) continue;
            sum += static_cast<double>(picture(x, y)), ++n;
        }
    return sum / n;
}

// Standard deviation of brightness over its mean, in the middle of the picture.
double contrast(const image& picture) {
    double sum = 0, squares = 0, n = 0;
    for (std::uint32_t y = picture.size.y / 3; y < picture.size.y * 2 / 3; ++y)
        for (std::uint32_t x = picture.size.x / 4; x < picture.size.x * 3 / 4; ++x) {
            const auto p = static_cast<double>(picture(x, y));
            sum += p, squares += p * p, ++n;
        }
    return std::sqrt(squares / n - sum / n * (sum / n)) / (sum / n);
}

} // namespace

TEST_CASE("compounding: five angles over 20 degrees leave less than 0.75 of the contrast of speckle") {
    const scene muscle = scene{plain(tissue::muscle)}.build(exec::par);
    const linear_array fine{.lines = 256, .width = 38_mm, .frequency = 9_MHz};
    b_mode_settings of{.depth = 40_mm, .size = {380, 400}};
    const image one = b_mode(exec::par_unseq, muscle, fine, pose{}, of);
    of.compound = {.angles = 5, .spread = 20_deg};
    const image five = b_mode(exec::par_unseq, muscle, fine, pose{}, of);
    MESSAGE("contrast ", contrast(one), ", compounded ", contrast(five));
    CHECK(contrast(five) < 0.75 * contrast(one));
    CHECK(five.size == one.size);
    // Brightness is the mean of decibels: the mean of more looks is up to 2.5 dB of 60 higher, by nothing else.
    for (const auto& [from, to] : {std::pair{vec2{0, 0.1F}, vec2{0.1F, 0.7F}},
                                   {vec2{0.9F, 0.1F}, vec2{1, 0.7F}},
                                   {vec2{0.3F, 0.1F}, vec2{0.7F, 0.7F}}}) {
        const double brighter = mean(five, from, to) - mean(one, from, to);
        MESSAGE("brighter by ", brighter, ", from ", from.x, " to ", to.x, " of the width");
        CHECK(brighter > -0.01);
        CHECK(brighter < 2.5 / 60);
    }
}

TEST_CASE("compounding: a vessel and a bone stay where they are, dark and bright") {
    const scene body = phantom();
    for (const compound_settings compound : {compound_settings{}, compound_settings{.angles = 5}}) {
        const image picture = b_mode(exec::par_unseq, body, probe, pose{}, with(compound));
        const double vessel = mean(picture, {0.28F, 0.35F}, {0.32F, 0.4F}),
                     muscle = mean(picture, {0.44F, 0.35F}, {0.56F, 0.4F}),
                     bone = mean(picture, {0.6875F, 0.3637F}, {0.7125F, 0.3688F});
        MESSAGE(compound.angles, " angles: vessel ", vessel, ", muscle ", muscle, ", bone ", bone);
        CHECK(vessel < 0.6 * muscle);
        CHECK(bone > 1.5 * muscle);
    }
}

TEST_CASE("compounding: the same picture on any number of threads, one look at a time as all at once") {
    const scene body = phantom();
    const compound_settings all{.angles = 4, .spread = 16_deg},
        one{.angles = 4, .spread = 16_deg, .update = compound_settings::update_mode::one};
    const image expected = b_mode(exec::seq, body, probe, pose{}, with(all));
    for (const std::uint32_t threads : {2U, 5U})
        CHECK(b_mode(exec::par.threads(threads), body, probe, pose{}, with(all)) == expected);
    scanner<linear_array> machine{probe, with(one)};
    const auto next = [&](const physical<>& model) -> const image& {
        machine.model = model;
        return machine.scan(exec::par.threads(2), body, pose{});
    };
    for (int frame = 0; frame < 3; ++frame) CHECK(next(physical{}) != expected);
    CHECK(next(physical{}) == expected);
    CHECK(next(physical{}) == expected);
    const physical<> louder{.texture_db = -50}; // starts anew
    const image again = b_mode(exec::seq, body, probe, pose{}, louder, with(all));
    for (int frame = 0; frame < 3; ++frame) CHECK(next(louder) != again);
    CHECK(next(louder) == again);
}

TEST_CASE("compounding: convex and phased arrays are compounded, a full circle is refused") {
    const scene body = phantom();
    const auto changed = [&](const auto& of) {
        const image straight = b_mode(exec::par_unseq, body, of, pose{}, with({}));
        const image compounded = b_mode(exec::par_unseq, body, of, pose{}, with({.angles = 3, .spread = 16_deg}));
        CHECK(straight.size == compounded.size);
        MESSAGE("contrast ", contrast(straight), ", compounded ", contrast(compounded));
        return contrast(compounded) / contrast(straight);
    };
    CHECK(changed(convex_array{.lines = 96, .radius = 40_mm, .frequency = 5_MHz}) < 0.9);
    CHECK(changed(phased_array{.lines = 96, .frequency = 3.5_MHz}) < 0.95);
    CHECK_THROWS_AS(b_mode(exec::seq, body, radial_array{}, pose{}, with({.angles = 3})), usage_error);
}

} // namespace compounded_picture_test
