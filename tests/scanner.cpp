#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <doctest/doctest.h>
#include <limits>
#include <string>
#include <vector>

using namespace insonify;

namespace scanner_test {
namespace {

bool same_bits(const image& a, const image& b) {
    return a.size == b.size && a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0;
}
double max_difference(const image& a, const image& b) {
    REQUIRE(a.size == b.size);
    double worst = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        worst = std::max(worst, std::fabs(static_cast<double>(a.pixels[i]) - static_cast<double>(b.pixels[i])));
    return worst;
}

scene phantom() {
    scene body{tissue::fat};
    body.add(make_box({-60_mm, -30_mm, 6_mm}, {60_mm, 30_mm, 90_mm}), tissue::muscle);
    body.add(make_sphere({4_mm, 0, 15_mm}, 3_mm, 4), tissue::blood, {.name = "vessel"});
    body.build(exec::par);
    return body;
}

const linear_array probe{.lines = 40, .width = 30_mm, .frequency = 5_MHz};
const b_mode_settings usual{.depth = 30_mm, .size = {80, 0}, .planes = 1};

} // namespace

TEST_CASE("scanner: a frozen picture with another gain is that which b_mode draws with this gain") {
    const scene body = phantom();
    scanner machine{probe, usual};
    machine.scan(exec::par_unseq, body, pose{});
    machine.freeze();
    REQUIRE(machine.frozen());
    const pose elsewhere{.translation = {5_mm, 0, 0}};
    CHECK(
        same_bits(machine.scan(exec::par_unseq, body, elsewhere), b_mode(exec::par_unseq, body, probe, pose{}, usual)));
    const auto compare = [&](const std::string& knob, const auto& turn, double within) {
        machine.settings = usual;
        turn(machine.settings);
        const image fresh = b_mode(exec::par_unseq, body, probe, pose{}, machine.settings);
        const image& frozen = machine.scan(exec::par_unseq, body, elsewhere);
        const double apart = max_difference(frozen, fresh);
        MESSAGE(knob, ": largest difference of brightness ", apart, ", expected at most ", within);
        CHECK(apart <= within);
        CHECK_FALSE(same_bits(fresh, b_mode(exec::par_unseq, body, probe, pose{}, usual)));
    };
    compare(
        "gain", [](b_mode_settings& s) { s.gain_db = 7; }, 0);
    compare(
        "dynamic range", [](b_mode_settings& s) { s.dynamic_range_db = 45; }, 0);
    compare(
        "reference", [](b_mode_settings& s) { s.reference_db = -35; }, 0);
    compare(
        "reject", [](b_mode_settings& s) { s.reject_db = -70; }, 0);
    compare(
        "gray map", [](b_mode_settings& s) { s.grey.contrast = 0.4F; }, 0);
    compare(
        "size",
        [](b_mode_settings& s) {
            s.size = {120, 0};
        },
        0);
    // The stored amplitudes have had a time gain: the ratio of two is rounded, by 1e-6 of an amplitude or 1e-5 dB.
    compare(
        "tgc", [](b_mode_settings& s) { s.tgc = 80; }, 1e-5);
    compare(
        "tgc limit", [](b_mode_settings& s) { s.time_gain.max_db = 12; }, 1e-5);
    compare(
        "sliders", [](b_mode_settings& s) { s.time_gain.sliders = {-6, 0, 3, 3, 0, -3, 0, 6}; }, 1e-5);
    compare(
        "curve",
        [](b_mode_settings& s) {
            s.time_gain.curve = {{0, 6}, {20_mm, 20}};
        },
        1e-5);
    machine.settings = usual;
    CHECK(
        same_bits(machine.scan(exec::par_unseq, body, elsewhere), b_mode(exec::par_unseq, body, probe, pose{}, usual)));
    machine.unfreeze();
    CHECK(
        same_bits(machine.scan(exec::par_unseq, body, elsewhere), b_mode(exec::par_unseq, body, probe, elsewhere, [&] {
                      b_mode_settings same = usual;
                      same.tgc = automatic_tgc(exec::seq, body, probe, pose{}, usual.depth);
                      return same;
                  }())));
}

TEST_CASE("scanner: a frozen compounded picture is regained along its lines") {
    const scene body = phantom();
    scanner machine{probe, usual};
    machine.settings.compound = {.angles = 3, .spread = 10_deg};
    machine.scan(exec::par_unseq, body, pose{});
    machine.freeze();
    const auto compare = [&](double within) {
        const image fresh = b_mode(exec::par_unseq, body, probe, pose{}, machine.settings);
        const double apart = max_difference(machine.scan(exec::par_unseq, body, pose{}), fresh);
        MESSAGE("compounded: largest difference of brightness ", apart, ", expected at most ", within);
        CHECK(apart <= within);
    };
    machine.settings.gain_db = -5;
    compare(0);
    // A look at 5 degrees is 1 / cos(5 deg) - 1 = 0.4 % longer: of a time gain that grows by 10 dB, 0.04 dB.
    machine.settings.tgc = machine.cine()[0].gain.attenuation + 10 * 1e3F / (2 * 5 * 30);
    compare(0.04 / 60 * 1.1);
}

TEST_CASE("scanner: the cine loop has the last frames, the newest first, with their poses and times") {
    const scene body = phantom();
    scanner machine{probe, usual};
    machine.cine_length = 4;
    machine.settings.tgc = 60;
    std::vector<image> seen;
    for (int i = 0; i < 7; ++i) {
        machine.time = 0.04 * i;
        machine.settings.frame = static_cast<std::uint32_t>(i);
        machine.settings.depth = i < 6 ? 30_mm : 25_mm;
        seen.push_back(machine.scan(exec::par_unseq, body, {.translation = {0.2_mm * static_cast<float>(i), 0, 0}}));
        CHECK(machine.cine().size() == std::min(i + 1, 4));
    }
    machine.freeze();
    for (std::uint32_t back = 0; back < 4; ++back) {
        const std::size_t i = 6 - back;
        const stored_frame<linear_array>& frame = machine.cine()[back];
        CHECK(frame.time == 0.04 * static_cast<double>(i));
        CHECK(frame.at.translation.x == 0.2_mm * static_cast<float>(i));
        CHECK(same_bits(machine.show(exec::par_unseq, back), seen[i]));
        CHECK(machine.map().depth == (i < 6 ? 30_mm : 25_mm));
        CHECK(machine.at().translation.x == frame.at.translation.x);
        CHECK(same_bits(machine.scan(exec::par_unseq, body, pose{}), seen[i])); // frozen: still the one that is shown
    }
    CHECK_THROWS_AS(machine.show(exec::seq, 4), usage_error);
    machine.unfreeze();
    machine.cine_length = 2;
    seen.push_back(machine.scan(exec::par_unseq, body, pose{}));
    CHECK(machine.cine().size() == 2);
    CHECK(same_bits(machine.show(exec::par_unseq, 1), seen[6]));
    CHECK(same_bits(machine.show(exec::par_unseq), seen[7]));
}

TEST_CASE("scanner: with persistence, a stored frame with another gain is that of a clip with this gain") {
    const scene body = phantom();
    b_mode_settings fading = usual;
    fading.persistence = 0.6F;
    fading.noise.level_db = -100;
    scanner quiet{probe, fading}, loud{probe, fading};
    quiet.cine_length = 8;
    loud.settings.gain_db = 9;
    std::vector<image> expected;
    for (std::uint32_t i = 0; i < 6; ++i) {
        quiet.settings.frame = loud.settings.frame = i;
        quiet.scan(exec::par_unseq, body, pose{});
        expected.push_back(loud.scan(exec::par_unseq, body, pose{}));
    }
    quiet.freeze();
    quiet.settings.gain_db = 9;
    for (std::uint32_t back = 0; back < 6; ++back)
        CHECK(same_bits(quiet.show(exec::par_unseq, back), expected[5 - back]));
    CHECK_FALSE(same_bits(expected[5], b_mode(exec::par_unseq, body, probe, pose{}, loud.settings)));
}

TEST_CASE(
    "scanner: persistence and rolling compounding start anew where the probe moves fast, and go on where it is slow") {
    const scene body = phantom();
    // The corners at the end of the lines turn by 30 mm times the angle, the others shift with the probe.
    const auto moved = [](float metres) { return pose{.translation = {0, metres, 0}}; };
    const auto tilted = [](float metres) { return look_at({0, 0, 0}, {0, metres, 30_mm}, {1, 0, 0}); };
    const auto starts = [&](const b_mode_settings& settings, const pose& to) {
        scanner machine{probe, settings};
        machine.settings.tgc = 60;
        for (int i = 0; i < 3; ++i, ++machine.settings.frame) machine.scan(exec::par_unseq, body, pose{});
        const image& seen = machine.scan(exec::par_unseq, body, to);
        return same_bits(seen, b_mode(exec::par_unseq, body, probe, to, machine.settings));
    };
    b_mode_settings fading = usual, rolling = usual, strict = usual;
    fading.persistence = strict.persistence = 0.5F;
    rolling.compound = {.angles = 3, .spread = 10_deg, .update = compound_settings::update_mode::one};
    strict.max_motion = 0;
    CHECK_FALSE(starts(fading, pose{}));
    CHECK_FALSE(starts(fading, moved(0.9_mm)));
    CHECK(starts(fading, moved(1.1_mm)));
    CHECK_FALSE(starts(fading, tilted(0.9_mm)));
    CHECK(starts(fading, tilted(1.1_mm)));
    CHECK_FALSE(starts(rolling, moved(0.9_mm)));
    CHECK(starts(rolling, moved(1.1_mm)));
    CHECK_FALSE(starts(strict, pose{}));
    CHECK(starts(strict, moved(0.01_mm)));
    b_mode_settings bad = usual;
    bad.max_motion = -1;
    CHECK_THROWS_AS(b_mode(exec::seq, body, probe, pose{}, bad), usage_error);
}

TEST_CASE("scanner: pixels, points of the probe and points of the world are there and back the same") {
    const scene body = phantom();
    const auto check = [&](const auto& of, const std::string& name) {
        scanner machine{of, usual};
        const pose at = look_at({3_mm, -2_mm, 1_mm}, {5_mm, 4_mm, 31_mm}, {1, 0.1F, 0});
        machine.scan(exec::par_unseq, body, at);
        double pixels = 0, metres = 0, in_plane = 0;
        for (float x = 0; x <= 80; x += 8)
            for (float y = 0; y <= 60; y += 7) {
                const vec3 world = machine.point({x, y});
                const vec2 back = machine.pixel(world), slice = machine.map().point({x, y});
                pixels = std::max(pixels, static_cast<double>(length(back - vec2{x, y})));
                const vec3 local = at.local_point(world);
                metres = std::max(metres, static_cast<double>(length(vec2{local.x, local.z} - slice)));
                in_plane = std::max(in_plane, static_cast<double>(std::fabs(local.y)));
            }
        MESSAGE(name, ": ", pixels, " pixels, ", metres, " m, out of the plane ", in_plane, " m; expected 0");
        CHECK(pixels < 1e-3);
        CHECK(metres < 1e-7);
        CHECK(in_plane < 1e-7);
    };
    check(probe, "linear");
    check(convex_array{.lines = 40, .radius = 40_mm, .frequency = 5_MHz}, "convex");
    // The middle of the upper edge is the middle of the face, and the lower edge is at the depth.
    scanner machine{probe, usual};
    const image& seen = machine.scan(exec::par_unseq, body, pose{});
    const auto columns = static_cast<float>(seen.size.x), rows = static_cast<float>(seen.size.y);
    CHECK(length(machine.map().point({columns / 2, 0})) < 1e-6F);
    CHECK(machine.map().point({0, rows}).y == doctest::Approx(30e-3).scale(1e-30).epsilon(1e-5));
    CHECK(machine.map().point({0, rows}).x == doctest::Approx(-15e-3).scale(1e-30).epsilon(1e-5));
}

TEST_CASE("scanner: labels are those of the objects where the picture shows them") {
    scene body = phantom();
    scanner machine{probe, usual};
    machine.scan(exec::par_unseq, body, pose{});
    const label_image& labels = machine.labels(exec::par_unseq, body);
    REQUIRE(labels.size == machine.picture().size);
    const auto at = [&](vec3 point) {
        const vec2 pixel = machine.pixel(point);
        return labels(static_cast<std::uint32_t>(pixel.x), static_cast<std::uint32_t>(pixel.y));
    };
    // Muscle is faster than 1540 m/s and fat slower: the vessel is displayed within 0.5 mm of its place.
    CHECK(at({4_mm, 0, 15_mm}) == 1);
    CHECK(at({4_mm, 0, 13_mm}) == 1);
    CHECK(at({-8_mm, 0, 15_mm}) == 0);
    CHECK(at({4_mm, 0, 2_mm}) == background_label);
    const label_lines alone =
        label(exec::seq, body, refined{probe, rays_per_line(probe, usual.depth)}, pose{},
              {.depth = 30_mm, .samples = machine.map().samples, .grid = label_settings::depth_grid::displayed});
    CHECK(labels == scan_convert(exec::seq, alone, machine.map()));
}

TEST_CASE("scanner: a copy goes on by itself; times of the stages add up") {
    const scene body = phantom();
    scanner machine{probe, usual};
    machine.settings.persistence = 0.5F;
    machine.scan(exec::par_unseq, body, pose{});
    scanner copy = machine;
    copy.settings.frame = machine.settings.frame = 1;
    const image expected = machine.scan(exec::par_unseq, body, pose{});
    machine.settings.gain_db = 20;
    machine.scan(exec::par_unseq, body, pose{});
    CHECK(same_bits(copy.scan(exec::par_unseq, body, pose{}), expected));

    const stage_times& took = machine.times();
    const double sum = took.trace + took.convolve + took.detect + took.display;
    MESSAGE("trace ", 1e3 * took.trace, " ms, convolve ", 1e3 * took.convolve, ", detect ", 1e3 * took.detect,
            ", display ", 1e3 * took.display, "; sum ", 1e3 * sum, " of ", 1e3 * took.total);
    for (const double each : {took.trace, took.convolve, took.detect, took.display}) CHECK(each > 0);
    CHECK(sum <= took.total);
    CHECK(machine.lines().count == machine.map().count);
    CHECK(machine.echoes().count == machine.lines().count);
    CHECK(machine.echoes().depth == 30_mm);
}

// Where the strongest echo lies, on the lines that are said to be its own.
template <class Scanner>
static vec2 place_of_strongest(const Scanner& machine, const iq_lines& echoes, float& loudest) {
    std::size_t at = 0;
    for (std::size_t i = 0; i < echoes.values.size(); ++i)
        if (length(echoes.values[i]) > length(echoes.values[at])) at = i;
    loudest = length(echoes.values[at]);
    const float depth =
        (static_cast<float>(at % echoes.samples) + 0.5F) * echoes.depth / static_cast<float>(echoes.samples);
    const vec3 place = machine.beam(static_cast<float>(at / echoes.samples)).at(depth);
    return {place.x, place.z};
}

TEST_CASE("scanner: the echoes lie on the lines of their probe, whatever the number of lines and looks") {
    medium water = tissue::water;
    water.sound_speed = display_speed; // depth is displayed as it is
    const auto check = [&](const auto& array, std::uint32_t angles, bool interpolates,
                           compound_settings::update_mode update) {
        b_mode_settings how{.depth = 40_mm, .planes = 1, .compound = {.angles = angles, .update = update}};
        how.interpolates_lines = interpolates;
        const vec3 centre = array.beam(static_cast<float>(array.lines / 3)).at(22_mm); // on a line of the probe
        const vec2 target{centre.x, centre.z};
        scene body{water};
        body.add(make_sphere(centre, 0.3_mm, 3), tissue::steel);
        body.build(exec::par);
        scanner machine{array, how};
        CHECK_THROWS_WITH_AS(machine.echo_probe(), doctest::Contains("there is no picture yet"), usage_error);
        for (std::uint32_t frame = 0; frame < (update == compound_settings::update_mode::one ? angles : 1); ++frame) {
            machine.scan(exec::par_unseq, body, pose{});
            const auto& on = machine.echo_probe();
            CHECK(on.lines == machine.echoes().count);
            if (update == compound_settings::update_mode::all && angles % 2 == 1) {
                CHECK(on.steering == 0);
                CHECK(machine.echoes().depth == 40_mm);
            }
            float loudest = 0, own_loudest = 0;
            const vec2 found = place_of_strongest(on, machine.echoes(), loudest);
            CHECK(length(found - target) < 0.6_mm); // the radius of the ball, and a line
            const steered own{array, on.steering};
            const iq_lines resampled = resample_lines(exec::par_unseq, machine.echoes(), on, own);
            CHECK(resampled.count == array.lines);
            CHECK(length(place_of_strongest(own, resampled, own_loudest) - target) < 0.6_mm);
            if (on.steering == 0) CHECK(std::fabs(own_loudest / loudest - 1) < 0.02F); // the ball is on a line of both
        }
    };
    const linear_array few{.lines = 64, .width = 38_mm}, many{.lines = 300, .width = 38_mm};
    const convex_array round{.lines = 96, .radius = 40_mm};
    using update = compound_settings::update_mode;
    for (const std::uint32_t angles : {1U, 2U, 3U, 4U, 5U}) {
        check(few, angles, false, update::all);
        check(many, angles, true, update::all);
        check(round, angles, false, update::all);
    }
    check(few, 3, false, update::one);
}

TEST_CASE("scanner: the echoes of a compounded frame are those of its straight look, to the bit") {
    const scene body = phantom();
    b_mode_settings how = usual;
    how.noise.level_db = no_level_db; // each look has its own
    scanner alone{probe, how};
    alone.scan(exec::par_unseq, body, pose{});
    for (const std::uint32_t angles : {3U, 7U}) {
        how.compound.angles = angles;
        scanner machine{probe, how};
        for (int frame = 0; frame < 2; ++frame) machine.scan(exec::par_unseq, body, pose{});
        CHECK(machine.echoes() == alone.echoes());
    }
}

TEST_CASE("scanner: the echoes of a frame of which one look is acquired for its quality are those of that look") {
    const scene body = phantom();
    using quality = b_mode_settings::quality_level;
    using update = compound_settings::update_mode;
    for (const quality level : {quality::fast, quality::draft})
        for (const update mode : {update::all, update::one}) {
            b_mode_settings how = usual;
            how.quality = level;
            scanner alone{probe, how};
            alone.scan(exec::par_unseq, body, pose{});
            how.compound = {.angles = 3, .update = mode};
            scanner machine{probe, how};
            CHECK(machine.echoes().values.empty());
            for (int frame = 0; frame < 2; ++frame) machine.scan(exec::par_unseq, body, pose{});
            CHECK(machine.echo_probe().steering == 0);
            CHECK(machine.echo_probe().lines == machine.echoes().count);
            CHECK(machine.echoes().count > 0);
            CHECK(machine.echoes() == alone.echoes());
        }
}

} // namespace scanner_test

TEST_CASE("scanner: a scan that is refused leaves the stored picture, its layers and its Doppler") {
    scene body{tissue::muscle};
    const object_id vessel = body.add(make_cylinder({-20_mm, 0, 10_mm}, {20_mm, 0, 20_mm}, 3_mm, 32), tissue::blood);
    body.build(exec::par);
    const poiseuille stream{
        .object = vessel, .from = {-20_mm, 0, 10_mm}, .to = {20_mm, 0, 20_mm}, .radius = 3_mm, .peak_velocity = 0.3F};
    scanner machine{linear_array{.lines = 48, .width = 30_mm}, b_mode_settings{.depth = 30_mm, .size = {64, 0}}};
    const image first = machine.scan(exec::par_unseq, body, pose{});
    const flow_lines flow = machine.colour(exec::par_unseq, body, stream, {.ensemble = 4});
    CHECK(flow.count == 48);
    CHECK(flow.depth == 30_mm);
    CHECK(flow ==
          colour_doppler(exec::par_unseq, body, machine.probe, pose{}, stream, {.depth = 30_mm, .ensemble = 4}));
    const scene not_built{tissue::muscle};
    pose bad{};
    bad.translation.x = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH_AS(
        machine.scan(exec::par_unseq, body, bad),
        "scanner: the pose of the probe is not a rigid transform; make it with look_at, or mend it with "
        "orthonormalised",
        geometry_error);
    CHECK_THROWS_AS(machine.scan(exec::par_unseq, not_built, pose{}), usage_error);
    machine.model.texture_db = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_AS(machine.scan(exec::par_unseq, body, pose{}), usage_error);
    machine.model = {};
    machine.how.directions = 0;
    CHECK_THROWS_AS(machine.scan(exec::par_unseq, body, pose{}), usage_error);
    machine.how = {};
    CHECK(machine.cine().size() == 1);
    CHECK(machine.layers().lines > 0);
    CHECK(machine.show(exec::par_unseq) == first);

    // Doppler is that of the picture, whatever has been set since.
    machine.probe.lines = 24;
    machine.settings.depth = 50_mm;
    CHECK(machine.colour(exec::par_unseq, body, stream, {.ensemble = 4}) == flow);
    CHECK_THROWS_AS(machine.spectrum(exec::par_unseq, body, stream, {.line = 10, .gate = 40_mm}), usage_error);
    CHECK(machine.spectrum(exec::par_unseq, body, stream, {.line = 24, .gate = 15_mm, .duration = 0.05F}).windows > 0);
}

namespace scanner_test {
namespace {

// Checks nothing itself, and cannot be compared.
struct plain_probe {
    std::uint32_t lines = 32;
    float frequency = 5_MHz, fnumber = 2;

    ray beam(float line) const { return {.origin = {aperture_fraction(line, lines) * 30_mm, 0, 0}}; }
    vec2 locate(vec2 point) const { return {line_at_fraction(point.x / 30_mm, lines), point.y}; }
    void check() const {}
};

} // namespace
} // namespace scanner_test

TEST_CASE("scanner: a probe that does not check its settings is refused before the stored picture is lost") {
    using scanner_test::plain_probe;
    scene body{tissue::muscle};
    body.build(exec::par);
    scanner<plain_probe> machine{plain_probe{}, {.depth = 30_mm, .size = {64, 0}}};
    const image first = machine.scan(exec::seq, body, pose{});
    machine.probe.fnumber = -1;
    CHECK_THROWS_AS(machine.scan(exec::seq, body, pose{}), usage_error);
    CHECK(machine.cine().size() == 1);
    CHECK(machine.layers().lines > 0);
    CHECK(machine.show(exec::seq) == first);

    const scanner<plain_probe> other = std::move(machine);
    CHECK(other.echoes().count > 0);
    CHECK(machine.echoes().count == 0); // NOLINT(bugprone-use-after-move): it is left without echoes
}

TEST_CASE("scanner: looks of earlier frames are averaged for probes that cannot be compared, too") {
    using scanner_test::plain_probe;
    scene body{tissue::muscle};
    body.build(exec::par);
    b_mode_settings settings{.depth = 30_mm, .size = {64, 0}, .compound = {.angles = 3, .spread = 16_deg}};
    scanner<plain_probe> whole{plain_probe{}, settings};
    const image expected = whole.scan(exec::seq, body, pose{});
    settings.compound.update = compound_settings::update_mode::one;
    scanner<plain_probe> rolling{plain_probe{}, settings};
    CHECK(rolling.scan(exec::seq, body, pose{}) != expected);
    rolling.scan(exec::seq, body, pose{});
    CHECK(rolling.scan(exec::seq, body, pose{}) == expected);
    rolling.probe.frequency = 4_MHz; // of the same lines: it starts anew all the same
    scanner<plain_probe> fresh{rolling.probe, settings};
    CHECK(rolling.scan(exec::seq, body, pose{}) == fresh.scan(exec::seq, body, pose{}));
}

TEST_CASE("a picture of a deformed body does not depend on how many frames were drawn since it was deformed") {
    // Trees are brought up to date after 16 slices. Small obstacles reach beyond the lines of steered looks.
    scene body{tissue::fat};
    body.add(make_box({-60_mm, -30_mm, 6_mm}, {60_mm, 30_mm, 60_mm}, 4), tissue::muscle);
    for (int i = 0; i < 24; ++i) {
        const auto k = static_cast<float>(i);
        body.add(make_sphere({-24_mm + 2_mm * k, 0, 10_mm + 0.3_mm * k}, 0.8_mm, 3), tissue::bone);
    }
    body.build(exec::par);
    body.deform(exec::par, [](vec3 rest) { return rest + vec3{0, 0, 1_mm * std::exp(-std::fabs(rest.z) / 20_mm)}; });
    scanner<linear_array> machine{linear_array{.lines = 64, .width = 30_mm},
                                  {.depth = 35_mm, .size = {120, 0}, .planes = 3, .compound = {.angles = 3}}};
    const image first = machine.scan(exec::par_unseq, body, pose{});
    for (int frame = 1; frame < 12; ++frame) CHECK(machine.scan(exec::par_unseq, body, pose{}) == first);
}
