// Covers tracing/find/line_layers.hpp.
#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/scanner.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <insonify/tracing/paths.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace find_layers_test {
namespace {

constexpr float radius = 8_mm, depth = 30_mm; // of a ball

scene ball() {
    scene body{tissue::muscle};
    body.add(make_sphere({0, 0, depth}, radius, 6), tissue::liver, {.name = "ball"});
    body.build(exec::par);
    return body;
}

// Length of a straight line in the ball: of its chord.
float chord(const line_frame& line) {
    const vec3 along = line.path(), to_middle = vec3{0, 0, depth} - line.origin;
    const float length_squared = dot(along, along), nearest = dot(to_middle, along) / length_squared;
    const float apart_squared = dot(to_middle - nearest * along, to_middle - nearest * along);
    return nearest > 0 && apart_squared < radius * radius
               ? 2 * std::sqrt((radius * radius - apart_squared) / length_squared)
               : 0;
}

bool same(view<const layer> a, view<const layer> b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i].begin != b[i].begin || a[i].end != b[i].end || a[i].object != b[i].object ||
            a[i].medium != b[i].medium)
            return false;
    return true;
}

template <class Probe>
void check_chords(const scene& body, const Probe& probe, std::uint32_t planes) {
    const line_layers found = find_layers(exec::par_unseq, body, probe, pose{}, {.depth = 50_mm, .planes = planes});
    REQUIRE(found.lines == probe.lines);
    REQUIRE(found.planes == planes);
    REQUIRE(found.media.size() == 2);
    float worst = 0, adjacent = 0;
    std::uint32_t met = 0;
    for (std::uint32_t line = 0; line < found.lines; ++line)
        for (std::uint32_t plane = 0; plane < planes; ++plane) {
            float inside = 0, last = 0;
            for (const layer& one : found(line, plane)) {
                adjacent = std::max(adjacent, std::fabs(one.begin - last));
                last = one.end;
                if (one.object == 0) inside += one.end - one.begin;
                CHECK(one.medium == (one.object == 0 ? 1 : 0));
            }
            CHECK(last == 50_mm);
            const float expected = chord(found.frame(line, plane));
            met += expected > 0;
            // The mesh lies up to 20 um within the sphere; near its edge chords change fast.
            if (expected > 4_mm) worst = std::max(worst, std::fabs(inside - expected));
        }
    CHECK(adjacent == 0);
    CHECK(met >= 7);
    CHECK(worst < 0.1_mm);
}

// A model that throws where it is told to.
struct throwing_model {
    using sample_type = vec2;
    bool fails = false;
    std::uint32_t samples(float, float) const { return 64; }
    void operator()(const auto&, const traced_line&, float, view<vec2>) const {
        if (fails) throw usage_error{"a model that throws"};
    }
};

} // namespace
} // namespace find_layers_test

TEST_CASE("what lies along every line of every plane: the chords of a ball, for all probes") {
    using namespace find_layers_test;
    const scene body = ball();
    for (const std::uint32_t planes : {1U, 3U, 7U}) {
        check_chords(body, linear_array{.lines = 65, .width = 38_mm, .frequency = 7.5_MHz}, planes);
        check_chords(body, convex_array{.lines = 64}, planes);
        check_chords(body, radial_array{.lines = 90, .radius = 1_mm}, planes);
    }
}

TEST_CASE("a frame and a pulse train are made from the layers that find_layers returns") {
    using namespace find_layers_test;
    const scene body = ball();
    const linear_array probe{.lines = 40, .width = 30_mm};
    const acquisition scan{.depth = 45_mm, .samples = 512, .planes = 3};
    const line_layers found = find_layers(exec::seq, body, probe, pose{}, scan);
    for (const line_search how : {line_search::best, line_search::rays, line_search::slices})
        for (const std::uint32_t directions : {1U, 16U}) {
            line_tracer<> tracer;
            tracer.trace(exec::par, body, probe, pose{}, physical<>{.timing = timing::uniform}, scan,
                         {how, directions});
            REQUIRE(tracer.layers().lines == probe.lines);
            REQUIRE(tracer.layers().planes == 3);
            for (std::uint32_t line = 0; line < probe.lines; ++line)
                for (std::uint32_t plane = 0; plane < 3; ++plane) {
                    const view<const layer> own = tracer.layers()(line, plane), one = found(line, plane);
                    REQUIRE(own.size() == one.size()); // those of a frame end a little deeper
                    for (std::size_t i = 0; i < own.size(); ++i) CHECK(std::fabs(own[i].begin - one[i].begin) < 1e-6F);
                }
        }
    line_tracer<physical<>, paths> bent;
    bent.trace(exec::par, body, probe, pose{}, physical{}, scan);
    CHECK(bent.layers().lines == 0);
}

TEST_CASE("layers are a value: they stay when the scene changes, and are the same for any number of threads") {
    using namespace find_layers_test;
    scene body = ball();
    const linear_array probe{.lines = 33};
    const acquisition scan{.depth = 50_mm, .planes = 5};
    const line_layers before = find_layers(exec::seq, body, probe, pose{}, scan), copy = before;
    for (const std::uint32_t threads : {2U, 5U}) {
        const line_layers again = find_layers(exec::par.threads(threads), body, probe, pose{}, scan);
        for (std::uint32_t line = 0; line < 33; ++line)
            for (std::uint32_t plane = 0; plane < 5; ++plane) CHECK(same(again(line, plane), before(line, plane)));
    }
    body.place(*body.find("ball"), {.translation = {0, 0, 40_mm}});
    body.update(exec::par);
    body.set_medium(*body.find("ball"), tissue::bone);
    for (std::uint32_t line = 0; line < 33; ++line) CHECK(same(copy(line), before(line)));
    CHECK(before.media[1] == tissue::liver);
    CHECK_FALSE(same(find_layers(exec::seq, body, probe, pose{}, scan)(16), before(16)));
}

TEST_CASE("a scanner's layers are those of its last look, and its labels those of its straight one") {
    using namespace find_layers_test;
    scene body = ball();
    scanner machine{linear_array{.lines = 64, .width = 38_mm}, b_mode_settings{.depth = 45_mm, .size = {128, 0}}};
    CHECK_THROWS_AS(machine.layers(), usage_error);
    CHECK_THROWS_AS(machine.layers_probe(), usage_error);
    for (const std::uint32_t looks : {1U, 2U, 3U}) {
        machine.settings.compound = {.angles = looks, .spread = 10_deg};
        machine.scan(exec::par_unseq, body, pose{});
        const line_layers& found = machine.layers();
        REQUIRE(found.lines == machine.layers_probe().lines);
        CHECK(machine.layers_probe().steering == doctest::Approx(looks == 1 ? 0 : 5_deg).scale(1e-30));
        for (std::uint32_t line = 0; line < found.lines; line += 7) {
            const ray beam = machine.layers_probe().beam(static_cast<float>(line));
            CHECK(length(found.frame(line).along - beam.direction) < 1e-6F);
            CHECK(length(found.frame(line).origin - beam.origin) < 1e-9F);
        }
        const label_image labels = machine.labels(exec::par, body);
        scene moved = ball();
        moved.place(object_id{0}, {.translation = {0, 0, 60_mm}});
        moved.update(exec::par);
        // An odd number of looks has a straight one, whose layers are those of the picture; else the scene is asked as it is now.
        CHECK((machine.labels(exec::par, moved).pixels == labels.pixels) == (looks % 2 == 1));
    }
}

TEST_CASE("near field and automatic gain of layers are those of the scene that they were found in") {
    using namespace find_layers_test;
    scene body{tissue::fat};
    body.add(make_box({-5_mm, -30_mm, -5_mm}, {60_mm, 30_mm, 60_mm}), tissue::air);
    body.build(exec::par);
    const linear_array probe{.lines = 48, .width = 30_mm};
    const line_layers found = find_layers(exec::par, body, probe, pose{}, {.depth = 30_mm});
    const iq_lines silence{48, 512, 30_mm};
    const near_field_settings all{.shown = near_field_settings::lines::all};
    CHECK(add_near_field(exec::par, silence, found, probe, all) ==
          add_near_field(exec::par, silence, body, probe, pose{}, all));
    CHECK(automatic_tgc(found, 30_mm) == automatic_tgc(exec::par, body, probe, pose{}, 30_mm));
    CHECK_THROWS_AS(add_near_field(exec::par, silence, found, linear_array{.lines = 47}), usage_error);
}

TEST_CASE("what has no layers is refused with a sentence") {
    scene body{tissue::water};
    CHECK_THROWS_WITH_AS(find_layers(exec::par, body, linear_array{}, pose{}, {}),
                         "scene: call build(policy) after the last add or remove, before tracing or update",
                         usage_error);
    body.build(exec::par);
    CHECK_THROWS_AS(find_layers(exec::par, body, linear_array{}, pose{}, {.depth = 80}), usage_error);
    CHECK_THROWS_WITH_AS(
        find_layers(exec::par, body, linear_array{}, pose{}, {.depth = 30_mm, .planes = 4}),
        "find_layers: `planes` is 4; it must be 1, 3, 5 or 7: the slice plane, and pairs to both sides of it",
        usage_error);
    CHECK_THROWS_AS(find_layers(exec::par, body, linear_array{.lines = 0}, pose{}, {}), usage_error);
    CHECK_THROWS_AS(find_layers(exec::par, body, linear_array{}, {.rotation = mat3{2}}, {}), geometry_error);
    const line_layers found = find_layers(exec::par, body, linear_array{.lines = 4}, pose{}, {.depth = 30_mm});
    REQUIRE(found(3).size() == 1); // nothing but water
    CHECK(found(3)[0].object == background_label);

    CHECK_THROWS_AS(automatic_tgc(line_layers{}, 30_mm), usage_error);
    CHECK_THROWS_AS(label(exec::par, found, {.depth = 30_mm, .samples = 0}), usage_error);
    CHECK_THROWS_AS(label(exec::par, found, {.depth = -1, .samples = 10}), usage_error);
    line_layers from = found;
    const line_layers to = std::move(from);
    CHECK(from.lines == 0); // NOLINT(bugprone-use-after-move): it is left without lines
    CHECK(to.lines == 4);
    CHECK(to(3).size() == 1);
}

TEST_CASE("a frame that throws leaves no layers, and the next one all of its own") {
    using namespace find_layers_test;
    const scene body = ball();
    const linear_array probe{.lines = 40};
    line_tracer<throwing_model> tracer;
    tracer.trace(exec::seq, body, probe, pose{}, throwing_model{}, {.depth = 45_mm});
    CHECK(tracer.layers().lines == 40);
    CHECK_THROWS_AS(tracer.trace(exec::seq, body, probe, pose{}, throwing_model{true}, {.depth = 45_mm}), usage_error);
    CHECK(tracer.layers().lines == 0);
    tracer.trace(exec::seq, body, probe, pose{}, throwing_model{}, {.depth = 45_mm});
    REQUIRE(tracer.layers().lines == 40);
    CHECK(tracer.layers()(20).size() == 3);
}

TEST_CASE(
    "after a scan that threw, a scanner has the picture before it and no layers, and then those of the next scan") {
    using namespace find_layers_test;
    const scene body = ball();
    scanner<linear_array, throwing_model> machine{linear_array{.lines = 40}, {.depth = 45_mm, .size = {40, 0}}};
    CHECK_THROWS_AS(machine.layers(), usage_error);
    CHECK_THROWS_AS(machine.map(), usage_error);
    const image before = machine.scan(exec::seq, body, pose{});
    REQUIRE(machine.layers().lines == machine.layers_probe().lines);
    machine.model = throwing_model{true};
    CHECK_THROWS_AS(machine.scan(exec::seq, body, pose{}), usage_error);
    CHECK(machine.picture() == before);
    CHECK(machine.echoes().values.empty());
    CHECK_THROWS_AS(machine.echo_probe(), usage_error);
    CHECK_THROWS_AS(machine.layers(), usage_error);
    CHECK_THROWS_AS(machine.layers_probe(), usage_error);
    machine.model = throwing_model{};
    machine.scan(exec::seq, body, pose{});
    CHECK(machine.layers().lines == machine.layers_probe().lines);
    CHECK(machine.layers().lines > 0);
}

TEST_CASE("a scan that threw may have taken the memory of the frame that is shown, whose labels are then an error") {
    using namespace find_layers_test;
    const scene body = ball();
    scanner<linear_array, throwing_model> machine{linear_array{.lines = 40}, {.depth = 45_mm, .size = {40, 0}}};
    machine.cine_length = 3;
    for (int i = 0; i < 3; ++i) machine.scan(exec::seq, body, pose{});
    machine.show(exec::seq, 2);
    CHECK(machine.labels(exec::seq, body).size == machine.picture().size);
    machine.model = throwing_model{true};
    CHECK_THROWS_AS(machine.scan(exec::seq, body, pose{}), usage_error);
    CHECK_THROWS_AS(machine.labels(exec::seq, body), usage_error);
    machine.freeze();
    CHECK_THROWS_WITH_AS(machine.scan(exec::seq, body, pose{}),
                         "scanner: the frame of the picture is no longer stored; call `scan`, or `show` another",
                         usage_error);
    machine.settings.tgc = -1;
    CHECK_THROWS_AS(machine.show(exec::seq, 1), usage_error);
    machine.settings.tgc = 0;
    machine.show(exec::seq, 1);
    CHECK(machine.labels(exec::seq, body).size == machine.picture().size);
}

TEST_CASE("after a scan whose display threw, labels are those of the picture, and the frame can be shown") {
    using namespace find_layers_test;
    const scene body = ball();
    scanner<linear_array> machine{linear_array{.lines = 40}, {.depth = 45_mm, .size = {40, 0}}};
    machine.cine_length = 3;
    machine.settings.dynamic_range_db = 0;
    const pose aside{.translation = {6_mm, 0, 0}};
    CHECK_THROWS_AS(machine.scan(exec::seq, body, aside), usage_error);
    CHECK_THROWS_AS(machine.labels(exec::seq, body), usage_error); // there is no picture
    machine.settings.dynamic_range_db = 60;
    CHECK_FALSE(machine.show(exec::seq).pixels.empty());
    machine.scan(exec::seq, body, pose{});
    const label_image labels = machine.labels(exec::seq, body);
    machine.settings.dynamic_range_db = 0;
    CHECK_THROWS_AS(machine.scan(exec::seq, body, aside), usage_error);
    CHECK(machine.at() == pose{});
    CHECK(machine.labels(exec::seq, body) == labels);
}

TEST_CASE(
    "a scan whose display throws leaves neither its layers nor its pose nor its labels, nor a map without pixels") {
    using namespace find_layers_test;
    const scene body = ball();
    scanner<linear_array, throwing_model> machine{linear_array{.lines = 40}, {.depth = 45_mm, .size = {40, 0}}};
    machine.scan(exec::seq, body, pose{});
    const pose moved{.translation = {1_mm, 0, 0}};
    machine.settings.dynamic_range_db = 0;
    CHECK_THROWS_AS(machine.scan(exec::seq, body, moved), usage_error);
    CHECK_THROWS_AS(machine.layers(), usage_error);
    CHECK(machine.at() == pose{});
    machine.settings.dynamic_range_db = 60;
    machine.settings.size = {1U << 30U, 1U << 30U};
    CHECK_THROWS_AS(machine.scan(exec::seq, body, moved), usage_error);
    CHECK_THROWS_AS(machine.labels(exec::seq, body), usage_error);
    CHECK_THROWS_AS(machine.map(), usage_error);
    CHECK_THROWS_AS(machine.point({1, 1}), usage_error);
    machine.settings.size = {40, 0};
    machine.scan(exec::seq, body, moved);
    CHECK(machine.at() == moved);
    CHECK(machine.layers().lines > 0);
    CHECK_FALSE(machine.labels(exec::seq, body).pixels.empty());

    const image last = machine.picture();
    scanner<linear_array, throwing_model> other = std::move(machine);
    CHECK(other.scan(exec::seq, body, moved) == last);
    CHECK(machine.scan(exec::seq, body, moved).size == last.size); // NOLINT(bugprone-use-after-move): it begins anew
}

TEST_CASE(
    "labels of a scanner are those of the scene, though its model follows lines less deep than they are displayed") {
    using namespace find_layers_test;
    scene body{tissue::muscle};
    body.add(make_box({-40_mm, -40_mm, 5_mm}, {40_mm, 40_mm, 60_mm}), tissue::bone);
    body.add(make_box({-40_mm, -40_mm, 50_mm}, {40_mm, 40_mm, 58_mm}), tissue::liver); // within it, displayed at 26 mm
    body.build(exec::par);
    const linear_array probe{.lines = 32, .width = 30_mm};
    scanner machine{probe, b_mode_settings{.depth = 30_mm, .size = {32, 120}}, physical<>{.timing = timing::uniform}};
    scanner usual{probe, b_mode_settings{.depth = 30_mm, .size = {32, 120}}};
    machine.scan(exec::par_unseq, body, pose{});
    usual.scan(exec::par_unseq, body, pose{});
    const label_image labels = usual.labels(exec::par, body);
    CHECK(std::count(labels.pixels.begin(), labels.pixels.end(), label_id{1}) > 100);
    CHECK(machine.labels(exec::par, body).pixels == labels.pixels);
}
