// Covers tracing/plan/frame_plan.hpp.
#include <insonify/b_mode.hpp>
#include "deformed_frames.hpp"
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

namespace deformed_test {
namespace {

double difference_db(const iq_lines& a, const iq_lines& b) {
    double error = 0, power = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        error += static_cast<double>(dot(a.values[i] - b.values[i], a.values[i] - b.values[i]));
        power += static_cast<double>(dot(a.values[i], a.values[i]));
    }
    return 10 * std::log10(error / power + 1e-30);
}
iq_lines echoes_of(const scene& body, const pose& at = {}) {
    return trace(exec::par_unseq, body, probe, at, physical{}, scan);
}

} // namespace
} // namespace deformed_test

TEST_CASE("deform there and back: the picture is the same to the last bit") {
    using namespace deformed_test;
    scene body = calf();
    const auto picture = [&] { return b_mode(exec::par_unseq, body, probe, pose{}, {.depth = 40_mm}); };
    const image before = picture();
    body.deform(exec::par, pressed{.depth = 3_mm});
    const image pressed_picture = picture();
    CHECK(pressed_picture.pixels != before.pixels);
    body.deform(exec::par, pressed{});
    CHECK(picture().pixels == before.pixels);
}

TEST_CASE("a rigid map of tissue gives the echoes of an object that is placed there") {
    using namespace deformed_test;
    const auto body_at = [](const pose& at) {
        scene body{medium{.density = 1000, .sound_speed = 1540}};
        body.add(make_sphere({0, 0, 20_mm}, 18_mm, 5), tissue::muscle, {.at = at, .fibres = {1, 0, 0}});
        body.build(exec::par);
        return body;
    };
    const pose moves[] = {{.translation = {1.3_mm, -2.1_mm, 1.7_mm}},
                          look_at({2_mm, 1_mm, 1_mm}, {6_mm, 3_mm, 30_mm}, {1, 0.3F, 0})};
    for (const pose& moved : moves) {
        scene placed = body_at(pose{}), deformed = body_at(pose{});
        placed.place(object_id{0}, moved);
        deformed.deform(exec::par, [&moved](vec3 p) { return moved.point(p); });
        // Echoes of speckle alone: a layout of scatterers is chosen at random for each slab, by rounded numbers.
        const frame a{echoes_of(placed)}, b{echoes_of(deformed)}, rest{echoes_of(body_at(pose{}))};
        correlation same, other;
        for (int line = 0; line < 192; ++line)
            for (float z = 6_mm; z < 34_mm; z += 0.1_mm) {
                same.add(a.at(line, z), b.at(line, z));
                other.add(a.at(line, z), rest.at(line, z));
            }
        MESSAGE("rigid map against place: correlation of envelopes ", same.value(), ", expected 1; at rest ",
                other.value());
        CHECK(same.value() > 0.995);
        CHECK(other.value() < 0.5);
    }
}

TEST_CASE("a rigid map of a rough surface gives the echoes of one that is placed there, in every elevation plane") {
    using namespace deformed_test;
    const medium rough{.density = 2000, .sound_speed = 1540, .roughness = 300e-6F};
    const pose moved{.translation = {1.03_mm, 0.77_mm, 0.31_mm}};
    scene placed{medium{.density = 1000, .sound_speed = 1540}};
    placed.add(make_box({-60_mm, -60_mm, 20_mm}, {60_mm, 60_mm, 60_mm}, 3), rough);
    scene deformed = placed.build(exec::par);
    placed.place(object_id{0}, moved);
    deformed.deform(exec::par, [&moved](vec3 p) { return moved.point(p); });
    for (const std::uint32_t planes : {1U, 3U, 7U}) {
        acquisition several = scan;
        several.planes = planes;
        const auto echoes = [&](const scene& body) {
            return trace(exec::par_unseq, body, probe, pose{}, physical{}, several);
        };
        const double difference = difference_db(echoes(placed), echoes(deformed));
        MESSAGE(planes, " planes: the difference has ", difference, " dB of the echoes");
        CHECK(difference < -80);
    }
}

TEST_CASE("a probe that moves with a rough plate receives the same echoes, also from where its lines leave the plate") {
    using namespace deformed_test;
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    const object_id plate = body.add(make_box({-60_mm, -60_mm, 15_mm}, {60_mm, 60_mm, 20_mm}, 3),
                                     medium{.density = 1300, .sound_speed = 1540, .roughness = 300e-6F});
    body.build(exec::par);
    acquisition several = scan;
    several.planes = 3;
    const auto echoes = [&](const pose& at) { return trace(exec::par_unseq, body, probe, at, physical{}, several); };
    const iq_lines resting = echoes(pose{});
    const pose moves[] = {{.translation = {1.03_mm, 0.77_mm, 0.31_mm}},
                          look_at({2_mm, 1_mm, 1_mm}, {6_mm, 3_mm, 30_mm}, {1, 0.3F, 0})}; // parallel only by rounding
    for (const pose& moved : moves) {
        body.place(plate, moved);
        const double difference = difference_db(resting, echoes(moved));
        MESSAGE("the difference has ", difference, " dB of the echoes");
        CHECK(difference < -60);
    }
}

TEST_CASE("deformed tissue: the same echoes on any number of threads, and scalar and SIMD agree") {
    using namespace deformed_test;
    scene body = calf();
    body.deform(exec::par, pressed{.depth = 3_mm});
    const auto by = [&](const auto& policy) { return trace(policy, body, probe, pose{}, physical{}, scan); };
    const iq_lines one = by(exec::par.threads(1));
    CHECK(by(exec::par.threads(3)) == one);
    CHECK(by(exec::seq) == one);
    CHECK(difference_db(one, by(exec::par_unseq)) < -80);
}

TEST_CASE("every tracer draws deformed tissue") {
    using namespace deformed_test;
    scene body = calf();
    body.deform(exec::par, pressed{.depth = 3_mm});
    const iq_lines straight = echoes_of(body);
    const iq_lines along_rays =
        trace(exec::par_unseq, body, probe, pose{}, physical{}, scan, straight_lines{line_search::rays});
    CHECK(difference_db(straight, along_rays) < -60);
}

TEST_CASE("a map that folds over where nothing but background is: an error when it is drawn") {
    using namespace deformed_test;
    scene body{tissue::muscle};
    body.build(exec::par);
    body.deform(exec::par, [](vec3 p) { return vec3{p.x, p.y, p.z + 2_mm * std::sin(p.z / 1_mm)}; });
    std::string message = "nothing was thrown";
    try {
        echoes_of(body);
    } catch (const geometry_error& e) {
        message = e.what();
    }
    MESSAGE(message);
    CHECK(message.find("deform: the map folds over near (") == 0);
    // Outside of the field of view, here below it, a map is not looked at.
    body.deform(exec::par, [](vec3 p) { return p + vec3{0, 0, p.z > 41.5_mm ? NAN : 1_mm}; });
    CHECK_NOTHROW(echoes_of(body));
}
