#include <insonify/b_mode.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/paths.hpp>
#include <atomic>
#include <doctest/doctest.h>
#include <stdexcept>

using namespace insonify;

namespace frame_plan_test {
namespace {

std::atomic<int> covariances{0}; // how often a model was asked: only while tables are computed
std::atomic<bool> broken{false}; // whether it throws then

// A silent model that counts, and cannot be compared.
struct counted {
    using sample_type = vec2;
    float width = 1_mm;

    std::uint32_t samples(float, float) const { return 128; }
    template <class Policy>
    void operator()(const Policy&, const traced_line&, float, view<vec2>) const {}
    template <class Echoes>
    void emit(const traced_line&, const Echoes&) const {}
    static constexpr bool sharp_shadows = true;
    float covariance(float apart, float) const {
        ++covariances;
        if (broken) throw std::runtime_error{"covariance"};
        return std::exp(-apart * apart / (width * width));
    }
};
struct comparable_model : counted {
    friend bool operator==(const comparable_model& a, const comparable_model& b) { return a.width == b.width; }
};

// A probe that holds another one, and cannot be compared.
struct incomparable_probe {
    std::uint32_t lines = 16;
    float frequency = 5_MHz;

    linear_array array() const { return {.lines = lines, .width = 20_mm, .frequency = frequency}; }
    ray beam(float line) const { return array().beam(line); }
    vec2 locate(vec2 point) const { return array().locate(point); }
    void check() const {}
};
static_assert(transducer<incomparable_probe>);
static_assert(!std::equality_comparable<incomparable_probe> && !std::equality_comparable<counted>);

const linear_array probe{.lines = 16, .width = 20_mm, .frequency = 5_MHz};

bool computes(const auto& frame) {
    const int before = covariances;
    frame();
    return covariances != before;
}

} // namespace
} // namespace frame_plan_test

TEST_CASE("tables are computed when probe, model, depth, samples or planes change, not when pose or scene do") {
    using namespace frame_plan_test;
    scene body{medium{}};
    const object_id ball = body.add(make_sphere({0, 0, 10_mm}, 4_mm, 2), medium{.density = 1200});
    body.build(exec::seq);
    linear_array now = probe;
    comparable_model model{};
    acquisition scan{.depth = 20_mm};
    pose at{};
    line_tracer<comparable_model> own;
    const auto frame = [&] { return computes([&] { own.trace(exec::par.threads(2), body, now, at, model, scan); }); };
    CHECK(frame());
    CHECK_FALSE(frame());
    at.translation.y = 1_mm;
    CHECK_FALSE(frame());
    at = look_at({0, 0, 0}, {0.1F, 0, 1}, {1, 0, 0});
    CHECK_FALSE(frame());
    body.place(ball, {.translation = {1_mm, 0, 0}});
    CHECK_FALSE(frame());
    for (vec3& p : body.positions(ball)) p *= 0.9F;
    body.update(exec::seq);
    CHECK_FALSE(frame());
    body.set_medium(ball, medium{.density = 1300, .sound_speed = 3000});
    CHECK_FALSE(frame());
    body.add(make_sphere({0, 0, 10_mm}, 4_mm, 2), medium{.density = 1400});
    body.build(exec::seq);
    CHECK_FALSE(frame());
    CHECK_FALSE(computes([&] { own.trace(exec::unseq, body, now, at, model, scan); })); // nor for another policy

    const auto once = [&] {
        CHECK(frame());
        CHECK_FALSE(frame());
    };
    scan.depth = 25_mm;
    once();
    scan.samples = 200;
    once();
    scan.planes = 3;
    once();
    now.lines = 20;
    once();
    now.elevation_focus = 15_mm;
    once();
    model.width = 2_mm;
    once();
    now = probe; // back again: only the last tables are kept
    once();
    scan.samples = 0; // chosen: 128
    once();
    scan.samples = 128; // the same number
    CHECK_FALSE(frame());
}

TEST_CASE("another tracer, and another setting of it, has the same tables") {
    using namespace frame_plan_test;
    const scene body = scene{medium{}}.build(exec::seq);
    line_tracer<comparable_model> own;
    const auto frame = [&](straight_lines how) {
        return computes([&] { own.trace(exec::seq, body, probe, pose{}, comparable_model{}, {.depth = 20_mm}, how); });
    };
    CHECK(frame({}));
    CHECK_FALSE(frame({line_search::rays}));
    CHECK_FALSE(frame({line_search::slices}));
}

TEST_CASE("gain, dynamic range, size and background of a picture leave the tables alone, its depth does not") {
    using namespace frame_plan_test;
    const scene body = scene{medium{}}.build(exec::seq);
    scanner<linear_array, comparable_model> machine{probe, {.depth = 20_mm, .size = {32, 32}, .planes = 3}};
    b_mode_settings& settings = machine.settings;
    const auto frame = [&] { return computes([&] { machine.scan(exec::seq, body, pose{}); }); };
    CHECK(frame());
    CHECK_FALSE(frame());
    settings.gain_db = 6;
    settings.tgc = 70;
    settings.dynamic_range_db = 50;
    settings.reference_db = -20;
    settings.size = {40, 30};
    settings.background = 0.5F;
    CHECK_FALSE(frame());
    settings.depth = 30_mm;
    CHECK(frame());
    settings.planes = 5;
    CHECK(frame());
    CHECK_FALSE(frame());
}

TEST_CASE("a model without operator== has its tables computed each time; of a probe, lines and settings are compared") {
    using namespace frame_plan_test;
    const scene body = scene{medium{}}.build(exec::seq);
    line_tracer<counted> of_model;
    line_tracer<comparable_model> of_probe;
    for (int i = 0; i < 3; ++i) {
        CHECK(computes([&] { of_model.trace(exec::seq, body, probe, pose{}, counted{}, {.depth = 20_mm}); }));
        CHECK((i == 0) == computes([&] {
                  of_probe.trace(exec::seq, body, incomparable_probe{}, pose{}, comparable_model{}, {.depth = 20_mm});
              }));
    }
}

TEST_CASE("an exception while tables are computed leaves none behind: neither for these settings nor the former") {
    using namespace frame_plan_test;
    const scene body = scene{medium{}}.build(exec::seq);
    line_tracer<comparable_model> own;
    const auto frame = [&](float depth) {
        return own.trace(exec::par.threads(2), body, probe, pose{}, comparable_model{}, {.depth = depth});
    };
    frame(20_mm);
    broken = true;
    CHECK_THROWS_AS(frame(30_mm), std::runtime_error);
    broken = false;
    CHECK(computes([&] { frame(20_mm); }));
    broken = true;
    CHECK_THROWS_AS(frame(30_mm), std::runtime_error);
    broken = false;
    CHECK(computes([&] { CHECK(frame(30_mm).depth == 30_mm); }));
    CHECK_THROWS_AS(own.trace(exec::seq, body, probe, pose{}, comparable_model{}, {.depth = 30_mm, .planes = 2}),
                    usage_error);
    CHECK(computes([&] { frame(30_mm); }));
}
