#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <algorithm>
#include <cstring>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace scanner_knobs_test {
namespace {

bool same_bits(const image& a, const image& b) {
    return a.size == b.size && a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0;
}

// A box of muscle with a vessel, air beside it.
scene phantom(object_id& vessel) {
    scene body{tissue::fat};
    body.add(make_box({-30_mm, -20_mm, 3_mm}, {30_mm, 20_mm, 60_mm}), tissue::muscle);
    vessel = body.add(make_sphere({1_mm, 0, 8_mm}, 2_mm, 3), tissue::blood);
    body.add(make_box({4_mm, -20_mm, -10_mm}, {30_mm, 20_mm, 1_mm}), tissue::air, {.priority = 1});
    body.build(exec::par);
    return body;
}

// Random numbers, in order.
struct dice {
    std::uint64_t seed = 1, next = 0;
    float operator()(float from, float to) { return from + (to - from) * hash_uniform(seed, next++); }
    std::uint32_t below(std::uint32_t count) {
        return std::min(static_cast<std::uint32_t>((*this)(0, static_cast<float>(count))), count - 1);
    }
};

constexpr std::uint32_t knobs = 36;

// Turns one knob to a random place.
template <class Probe>
void turn(std::uint32_t knob, dice& random, scanner<Probe>& machine, pose& at, scene& body, object_id vessel) {
    b_mode_settings& s = machine.settings;
    Probe& p = machine.probe;
    switch (knob) {
    case 0:
        s.depth = random(8_mm, 18_mm);
        break;
    case 1:
        s.samples = random.below(2) == 0 ? 0 : 384 + 64 * random.below(4);
        break;
    case 2:
        s.size = {random.below(2) * (30 + random.below(20)), 30 + random.below(20)};
        break;
    case 3:
        s.dynamic_range_db = random(40, 80);
        break;
    case 4:
        s.reference_db = random(-40, -10);
        break;
    case 5:
        s.gain_db = random(-10, 10);
        break;
    case 6:
        s.tgc = random.below(3) == 0 ? 0 : random(20, 100);
        break;
    case 7:
        s.planes = 1 + 2 * random.below(3);
        break;
    case 8:
        s.background = random(0, 1);
        break;
    case 9:
        s.time_gain.max_db = random(10, 80);
        break;
    case 10:
        for (float& slider : s.time_gain.sliders) slider = random(-6, 6);
        break;
    case 11:
        s.time_gain.curve.clear();
        for (std::uint32_t i = random.below(4); i > 0; --i)
            s.time_gain.curve.push_back({20_mm / static_cast<float>(i), random(0, 30)});
        break;
    case 12:
        s.reject_db = random.below(2) == 0 ? no_level_db : random(-90, -60);
        break;
    case 13:
        s.grey = {.gamma = random(0.7F, 1.3F), .contrast = random(0, 0.3F)};
        break;
    case 14:
        s.noise = {.level_db = random(-140, -100), .seed = random.below(9)};
        break;
    case 15:
        s.frame = random.below(1000);
        break;
    case 16:
        s.near_field = {.shown = random.below(2) == 0 ? near_field_settings::lines::all
                                                      : near_field_settings::lines::in_gas};
        break;
    case 17:
        s.compound.angles = 1 + random.below(3);
        break;
    case 18:
        s.compound.spread = random(4_deg, 20_deg);
        break;
    case 19:
        s.max_motion = random(0, 5_mm);
        break;
    case 20:
        p.lines = 16 + random.below(20);
        break;
    case 21:
        p.frequency = random(5_MHz, 8_MHz);
        break;
    case 22:
        p.fnumber = random(2, 4);
        break;
    case 23:
        p.focus = random.below(3) == 0 ? 0 : random(5_mm, 15_mm);
        break;
    case 24:
        p.elevation_height = random(3_mm, 6_mm);
        break;
    case 25:
        p.elevation_focus = random(8_mm, 20_mm);
        break;
    case 26:
        p.bandwidth = random(0.5F, 0.8F);
        break;
    case 27:
        p.side_lobes = random.below(2) == 0 ? 0 : random(0, 0.06F);
        break;
    case 28:
        machine.model.texture_db = random(-10, 0) + physical<>{}.texture_db;
        break;
    case 29:
        machine.how.directions = 1 + random.below(16);
        break;
    case 30:
        at.translation = {random(-2_mm, 2_mm), random(-2_mm, 2_mm), 0};
        break;
    case 31:
        at = look_at({0, 0, 0}, {random(-0.3F, 0.3F), random(-0.3F, 0.3F), 1}, {1, 0, 0});
        break;
    case 32:
        body.place(vessel, {.translation = {random(-3_mm, 3_mm), 0, random(0, 3_mm)}});
        body.update(exec::par);
        break;
    case 33:
        s.interpolates_lines = !s.interpolates_lines;
        break;
    case 34:
        s.quality = static_cast<b_mode_settings::quality_level>(random.below(3));
        break;
    default:
        if constexpr (requires { p.width; })
            p.width = random(8_mm, 14_mm);
        else
            p.radius = random(20_mm, 50_mm);
    }
}

template <class Probe>
void compare_with_fresh(const Probe& probe, std::uint64_t seed, int rounds) {
    object_id vessel{};
    scene body = phantom(vessel);
    scanner machine{probe, b_mode_settings{.depth = 12_mm, .size = {40, 0}, .planes = 1}};
    machine.settings.time_gain.chosen = b_mode_settings::time_gain_settings::choice::every_frame;
    pose at{};
    dice random{seed};
    int different = 0, changed = 0;
    image before;
    std::vector<int> turned(knobs);
    for (int round = 0; round < rounds; ++round) {
        // Every knob in turn, and up to two more.
        const auto own = static_cast<std::uint32_t>(round) % knobs;
        turn(own, random, machine, at, body, vessel);
        for (std::uint32_t more = random.below(3); more > 0; --more)
            turn(random.below(knobs), random, machine, at, body, vessel);
        const image fresh = b_mode(exec::par_unseq.threads(1 + random.below(3)), body, machine.probe, at, machine.model,
                                   machine.settings, machine.how);
        if (!same_bits(machine.scan(exec::par_unseq.threads(2), body, at), fresh)) {
            ++different;
            ++turned[own];
        }
        changed += same_bits(fresh, before) ? 0 : 1;
        before = fresh;
    }
    for (std::uint32_t knob = 0; knob < knobs; ++knob)
        if (turned[knob] > 0) MESSAGE("knob ", knob, ": ", turned[knob], " pictures differ");
    MESSAGE("pictures that differ from those of a fresh b_mode: ", different, " of ", rounds, ", expected 0");
    MESSAGE("pictures that differ from the one before: ", changed);
    CHECK(different == 0);
    CHECK(changed > rounds * 3 / 4);
}

} // namespace

TEST_CASE("scanner: whatever knobs are turned, in any order, each picture is that of a fresh b_mode to the bit") {
    compare_with_fresh(linear_array{.lines = 24, .width = 12_mm, .frequency = 6_MHz}, 1, 132);
    compare_with_fresh(convex_array{.lines = 24, .radius = 30_mm, .field_of_view = 30_deg, .frequency = 6_MHz}, 2, 66);
}

TEST_CASE("scanner: before the first picture there is none to show, to label or to measure") {
    object_id vessel;
    const scene body = phantom(vessel);
    scanner<linear_array> empty;
    CHECK_THROWS_AS(empty.show(exec::seq), usage_error);
    CHECK_THROWS_AS(empty.labels(exec::seq, body), usage_error);
    CHECK_THROWS_AS(empty.point({0, 0}), usage_error);
    CHECK_THROWS_AS(empty.pixel({0, 0, 0}), usage_error);
    empty.freeze();
    CHECK_THROWS_WITH_AS(empty.scan(exec::seq, body, pose{}),
                         "scanner: there is no picture yet; call `scan`, and `unfreeze` where it is frozen",
                         usage_error);
}

TEST_CASE("scanner: a setting that is refused loses no stored frame") {
    object_id vessel;
    const scene body = phantom(vessel);
    const b_mode_settings usual{.depth = 30_mm, .size = {128, 0}};
    scanner machine{linear_array{.lines = 32, .width = 20_mm}, usual};
    const image seen = machine.scan(exec::par_unseq, body, pose{});
    machine.settings.depth = 80;
    CHECK_THROWS_AS(machine.scan(exec::par_unseq, body, pose{}), usage_error);
    machine.settings.depth = usual.depth;
    machine.freeze();
    CHECK(same_bits(machine.scan(exec::par_unseq, body, pose{}), seen));
}

} // namespace scanner_knobs_test
