#include <insonify/acoustics/tissue.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/core/error.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/emit/tracer.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/label.hpp>
#include <insonify/tracing/trace.hpp>
#include <atomic>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace tracer_test {
namespace {

// Straight lines, but only in scratch that has grown. What it writes before is to be forgotten.
struct greedy {
    std::size_t crossings = 1000;
    std::atomic<int>* refusals = nullptr;

    template <class Policy, acoustic_model Model>
    bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                    view<typename Model::sample_type> out) const {
        const std::size_t smallest =
            std::min({scratch.found.room.size(), 10 * scratch.layers.size(), 100 * scratch.branches.size(),
                      10 * scratch.branch_objects.size(), 100 * scratch.found.inside.ranks.size()});
        if (smallest < crossings) {
            for (auto& sample : out) sample = typename Model::sample_type(17);
            if (refusals != nullptr) ++*refusals;
            return false;
        }
        return straight_lines{line_search::rays}(policy, task, model, scratch, out);
    }
};

// A ball as a formula: no mesh, no tree. Media 0 and 1 of the scene.
struct formula_ball {
    vec3 centre{0, 0, 20_mm};
    float radius = 8_mm;

    template <class Policy, acoustic_model Model>
    bool operator()(const Policy& policy, const line_task& task, const Model& model, line_scratch& scratch,
                    view<typename Model::sample_type> out) const {
        const ray beam = task.beam();
        const vec3 to_centre = centre - beam.origin;
        const float stretch = dot(beam.direction, beam.direction), along = dot(to_centre, beam.direction) / stretch;
        const float squared = (radius * radius - dot(to_centre, to_centre)) / stretch + along * along;
        const float half = squared > 0 ? std::sqrt(squared) : 0.0F;
        const float ends[] = {0, along - half, along + half, task.max_depth};
        if (half == 0) {
            scratch.layers[0] = {.end = task.max_depth};
            task.apply(policy, model, {scratch.layers.data(), 1}, out);
            return true;
        }
        for (std::uint32_t i = 0; i < 3; ++i)
            scratch.layers[i] = {.begin = ends[i], .end = ends[i + 1], .medium = i % 2, .object = i == 1 ? 0 : ~0U};
        task.apply(policy, model, {scratch.layers.data(), 3}, out);
        return true;
    }
};

// The square of how far out of the slice a point of a plane lies, mm^2: once as a model, once as a tracer.
struct offset_model {
    using sample_type = float;
    std::uint32_t samples(float, float) const { return 100; }
    template <class Policy>
    void operator()(const Policy&, const traced_line& line, float spacing, view<float> out) const {
        for (std::size_t k = 0; k < out.size(); ++k) {
            const float y = 1e3F * line.frame.at((static_cast<float>(k) + 0.5F) * spacing).y;
            out[k] += y * y;
        }
    }
};
struct offset_tracer {
    template <class Policy>
    bool operator()(const Policy&, const line_task& task, const law2011&, line_scratch&, view<float> out) const {
        offset_model{}(exec::seq, task.line, task.spacing, out);
        return true;
    }
};
struct ones {
    template <class Policy>
    bool operator()(const Policy&, const line_task&, const law2011&, line_scratch&, view<float> out) const {
        for (float& sample : out) sample += 1;
        return true;
    }
};

// Samples are numbers of the line, the layers of it and the medium.
struct counting_model {
    using sample_type = std::int64_t;
    std::uint32_t samples(float, float) const { return 80; }
    template <class Policy>
    void operator()(const Policy&, const traced_line& line, float spacing, view<std::int64_t> out) const {
        for (std::size_t k = 0; k < out.size(); ++k)
            for (const layer& one : line.layers)
                if (one.begin <= (static_cast<float>(k) + 0.5F) * spacing) ++out[k];
    }
};

struct returns_nothing {
    template <class Policy, acoustic_model Model>
    void operator()(const Policy&, const line_task&, const Model&, line_scratch&,
                    view<typename Model::sample_type>) const {}
};
struct not_const {
    template <class Policy, acoustic_model Model>
    bool operator()(const Policy&, const line_task&, const Model&, line_scratch&, view<typename Model::sample_type>) {
        return true;
    }
};

static_assert(tracer<straight_lines> && tracer<straight_lines, law2011> && tracer<straight_lines, counting_model>);
static_assert(tracer<paths> && !tracer<paths, law2011> && !tracer<paths, counting_model>);
static_assert(tracer<greedy> && tracer<greedy, law2011> && tracer<greedy, counting_model>);
static_assert(tracer<ones, law2011> && !tracer<ones, physical<>>); // it takes no other model
static_assert(!tracer<returns_nothing> && !tracer<not_const> && !tracer<int> && !tracer<greedy, int>);

scene ball(const medium& background, const medium& inside, std::uint32_t subdivisions = 6) {
    scene body{background};
    body.add(make_sphere({0, 0, 20_mm}, 8_mm, subdivisions), inside);
    body.build(exec::par);
    return body;
}

// Equal but for rounding: compilers contract a * b + c differently from one instantiation to the next.
bool similar(const auto& a, const auto& b, double tolerance = 1e-5) {
    const auto size = [](auto value) { return std::sqrt(static_cast<double>(glm::dot(value, value))); };
    double largest = 0, worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, size(b[i]));
        worst = std::max(worst, size(a[i] - b[i]));
    }
    return a.size() == b.size() && worst <= tolerance * largest;
}

const linear_array probe{.lines = 40, .width = 30_mm, .frequency = 5_MHz};

} // namespace
} // namespace tracer_test

TEST_CASE("a tracer that finds its scratch too small gets more of everything, and what it wrote before is forgotten") {
    using namespace tracer_test;
    const scene body = ball(tissue::muscle, tissue::liver, 3);
    for (const std::uint32_t planes : {1U, 3U}) {
        const acquisition scan{.depth = 40_mm, .samples = 800, .planes = planes};
        std::atomic<int> refusals{0};
        CHECK(
            similar(trace(exec::par.threads(3), body, probe, pose{}, law2011{}, scan, greedy{1000, &refusals}).values,
                    trace(exec::seq, body, probe, pose{}, law2011{}, scan, straight_lines{line_search::rays}).values));
        CHECK(refusals >= 3); // 128, 256, 512 crossings were too few
        CHECK(similar(trace(exec::par, body, probe, pose{}, physical{}, scan, greedy{}).values,
                      trace(exec::seq, body, probe, pose{}, physical{}, scan, straight_lines{.directions = 1}).values));
    }
    line_tracer<law2011, greedy> own;
    std::atomic<int> refusals{0};
    const auto frame = [&] {
        own.trace(exec::seq, body, probe, pose{}, law2011{}, {.depth = 40_mm}, greedy{1000, &refusals});
    };
    frame();
    const int at_first = refusals;
    frame();
    CHECK(refusals == at_first); // the memory has been kept
}

TEST_CASE("a tracer of formulas has the intensities of law2011's closed form") {
    using namespace tracer_test;
    const medium outside{.density = 1000, .sound_speed = 1500, .attenuation = 40};
    const medium inside{.density = 1300, .sound_speed = 1500, .attenuation = 120};
    const scan_lines lines = trace(exec::par_unseq, ball(outside, inside, 0), probe, pose{}, law2011{},
                                   {.depth = 40_mm, .samples = 1000}, formula_ball{});
    const double r2 = 9.0 / 23 / 23, t = 1 - r2; // r = 3 / 23
    double worst = 0;
    for (std::uint32_t i = 0; i < probe.lines; ++i) {
        const double x = ((i + 0.5) / 40 - 0.5) * 30e-3, squared = 64e-6 - x * x;
        const double half = squared > 0 ? std::sqrt(squared) : 0, in = 20e-3 - half, out = 20e-3 + half;
        for (std::uint32_t k = 0; k < 1000; ++k) {
            const double z = (k + 0.5) * 40e-6;
            bool in_doubt = false;
            for (const double end : {in, out, in - 1e-3, out - 1e-3}) in_doubt = in_doubt || std::fabs(z - end) < 2e-6;
            if (in_doubt) continue;
            double expected = std::pow(10, -40 * 5 * z / 20);
            if (half > 0 && z < in) expected += z > in - 1e-3 ? r2 : 0;
            if (half > 0 && z > in)
                expected = t * std::pow(10, -(40 * 5 * in + 120 * 5 * (std::min(z, out) - in)) / 20);
            if (half > 0 && z > in && z < out) expected += z > out - 1e-3 ? t * r2 : 0;
            if (half > 0 && z > out) expected *= t * std::pow(10, -40 * 5 * (z - out) / 20);
            worst = std::max(worst, std::fabs(static_cast<double>(lines(i, k)) / expected - 1));
        }
    }
    CHECK(worst < 1e-4);
}

TEST_CASE("a tracer of formulas and straight lines through a fine mesh draw one picture") {
    using namespace tracer_test;
    const scene body = ball(tissue::muscle, tissue::liver, 7);
    const b_mode_settings settings{.depth = 40_mm, .size = {64, 64}};
    const image mesh = b_mode(exec::par, body, probe, pose{}, settings);
    const image formula = b_mode(exec::par, body, probe, pose{}, physical{}, settings, formula_ball{});
    // Speckle is that of the object in the one case, and of the background's coordinates in the other: means are equal.
    double sum[2] = {0, 0};
    for (std::size_t i = 0; i < mesh.pixels.size(); ++i) {
        sum[0] += static_cast<double>(mesh.pixels[i]);
        sum[1] += static_cast<double>(formula.pixels[i]);
    }
    CHECK(sum[0] / 4096 > 0.1);
    CHECK(std::fabs(sum[1] / sum[0] - 1) < 0.03);
    const straight_lines rays{.search = line_search::rays, .directions = 1};
    CHECK(similar(b_mode(exec::par, body, probe, pose{}, physical{}, settings, greedy{}).pixels,
                  b_mode(exec::par, body, probe, pose{}, physical{}, settings, rays).pixels, 1e-3));
    scanner machine{probe, settings, physical{}, formula_ball{}};
    for (int i = 0; i < 2; ++i) CHECK(machine.scan(exec::par, body, pose{}) == formula);
}

TEST_CASE("planes of a user's tracer are weighted as those of straight lines: by the beam's height, in sum 1") {
    using namespace tracer_test;
    const scene body = scene{medium{}}.build(exec::seq);
    for (const std::uint32_t planes : {1U, 3U, 5U, 7U}) {
        const acquisition scan{.depth = 60_mm, .samples = 100, .planes = planes};
        const scan_lines own = trace(exec::par, body, probe, pose{}, law2011{}, scan, offset_tracer{});
        const scan_lines straight = trace(exec::par, body, probe, pose{}, offset_model{}, scan);
        const scan_lines sum = trace(exec::par, body, probe, pose{}, law2011{}, scan, ones{});
        CHECK((planes == 1 || similar(own.values, straight.values)));
        for (const float one : sum.values) REQUIRE(one == doctest::Approx(1).epsilon(1e-6).scale(1e-30));
        if (planes == 1) {
            for (const float one : own.values) REQUIRE(one == 0);
            continue;
        }
        // The beam is thinnest at its focus, 20 mm deep, and so is what the planes represent.
        CHECK(own(0, 33) > 0);
        CHECK(own(0, 33) < own(0, 5));
        CHECK(own(0, 33) < own(0, 95));
    }
}

TEST_CASE("a user's tracer with a model of whole numbers: one plane is traced, several are refused") {
    using namespace tracer_test;
    const scene body = ball(tissue::muscle, tissue::liver, 3);
    const auto lines = trace(exec::par, body, probe, pose{}, counting_model{}, {.depth = 40_mm}, greedy{});
    CHECK(lines ==
          trace(exec::seq, body, probe, pose{}, counting_model{}, {.depth = 40_mm}, straight_lines{line_search::rays}));
    CHECK(lines(20, 10) == 1);
    CHECK(lines(20, 40) == 2);
    CHECK(lines(20, 70) == 3);
    CHECK(lines(0, 70) == 1);
    CHECK(trace(exec::par, body, probe, pose{}, counting_model{}, {.depth = 40_mm}, formula_ball{})(20, 70) == 3);
    CHECK_THROWS_AS(trace(exec::par, body, probe, pose{}, counting_model{}, {.depth = 40_mm, .planes = 3}, greedy{}),
                    usage_error);
}
