#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <map>
#include <string>

#include "echoes.hpp"

using namespace insonify;

namespace path_pairs_test {
namespace {

// Plane layers under the face of a probe, in double precision: every sequence of reflections and transmissions is followed
// until it is back at the face, so sound returns along any way whatever, not only along the one by which it went out.
struct stack {
    struct layer {
        medium inside;
        double thickness; // metres
    };
    std::vector<layer> layers;
    double face = 0;                   // reflection of the probe's face
    double depth = 0;                  // displayed, metres
    std::map<long, double> received{}; // amplitude by displayed depth in micrometres

    static double impedance(const medium& m) {
        return static_cast<double>(m.density) * static_cast<double>(m.sound_speed);
    }
    // A wave travels through layer i, downwards or upwards, and has needed `shown` so far.
    void follow(std::size_t i, bool down, double shown, double amplitude) {
        const layer& here = layers[i];
        shown +=
            here.thickness / static_cast<double>(here.inside.sound_speed) * 1540 / 2; // there and back are 2 depths
        if (shown > depth || std::fabs(amplitude) < 1e-6) return;
        if (!down && i == 0) {
            received[std::lround(shown * 1e6)] += amplitude;
            return follow(0, true, shown, amplitude * face);
        }
        const std::size_t next = down ? i + 1 : i - 1;
        if (next == layers.size()) return;
        const double before = impedance(here.inside), after = impedance(layers[next].inside);
        const double r = (after - before) / (after + before);
        follow(i, !down, shown, amplitude * r);
        follow(next, down, shown, amplitude * (1 + r));
    }
    // Echoes a few nanometres apart, by different ways of the same length, count as one.
    std::vector<echoes_test::echo> echoes() const {
        std::vector<echoes_test::echo> all;
        for (const auto& [micrometres, amplitude] : received) {
            const double metres = static_cast<double>(micrometres) * 1e-6;
            if (!all.empty() && metres - all.back().depth < 3e-6)
                all.back().amplitude += amplitude;
            else
                all.push_back({amplitude, metres});
        }
        for (echoes_test::echo& one : all) one.amplitude = std::fabs(one.amplitude);
        return all;
    }

    scene body() const {
        scene made{layers[0].inside};
        double from = layers[0].thickness;
        for (std::size_t i = 1; i < layers.size(); ++i) {
            const auto begin = static_cast<float>(from), end = static_cast<float>(from + layers[i].thickness);
            made.add(make_box({-60_mm, -60_mm, begin}, {60_mm, 60_mm, end}), layers[i].inside);
            from += layers[i].thickness;
        }
        made.build(exec::par);
        return made;
    }
};

// Compares every echo above a level. @return their number
int compare(const std::string& title, stack expected, double lowest_db) {
    expected.follow(0, true, 0, 1);
    const iq_lines lines =
        trace(exec::par, expected.body(), linear_array{.lines = 1, .width = 1_mm, .frequency = 5_MHz}, pose{},
              physical<>{}, {.depth = static_cast<float>(expected.depth), .samples = 8000},
              paths{{.bounces = 64, .min_amplitude = 1e-8F, .face_reflection = static_cast<float>(expected.face)}});
    const std::vector<echoes_test::echo> found = echoes_test::echoes_of(lines, 0);
    int compared = 0;
    double worst = 0;
    for (const echoes_test::echo& one : expected.echoes()) {
        if (one.decibels() < lowest_db || one.depth > 0.999 * expected.depth) continue;
        double sum = 0;
        for (const echoes_test::echo& other : found)
            if (std::fabs(other.depth - one.depth) < 6e-6) sum += other.amplitude;
        const double measured = 20 * std::log10(sum);
        if (compared < 12)
            MESSAGE(title, ", ", one.depth * 1e3, " mm: ", measured, " dB (expected ", one.decibels(), ")");
        CHECK(std::fabs(measured - one.decibels()) < 0.1);
        worst = std::max(worst, std::fabs(measured - one.decibels()));
        ++compared;
    }
    MESSAGE(title, ": ", compared, " echoes above ", lowest_db, " dB, largest difference ", worst, " dB");
    for (const echoes_test::echo& one : found) { // and there are no others
        if (one.decibels() < lowest_db || one.depth > 0.999 * expected.depth) continue;
        double nearest = 1;
        for (const echoes_test::echo& other : expected.echoes())
            nearest = std::min(nearest, std::fabs(other.depth - one.depth));
        CHECK(nearest < 6e-6);
    }
    return compared;
}

medium quiet(medium m) {
    m.attenuation = m.backscatter = m.roughness = 0;
    return m;
}

} // namespace
} // namespace path_pairs_test

TEST_CASE("every sequence of reflections has its echo: sound also returns along a different path") {
    using namespace path_pairs_test;
    const medium muscle = quiet(tissue::muscle), bone = quiet(tissue::bone), steel = quiet(tissue::steel);
    CHECK(compare("bone 2 mm, then bone", {{{muscle, 10e-3}, {bone, 2e-3}, {muscle, 8e-3}, {bone, 0.1}}, 0, 40e-3},
                  -50) > 12);
    CHECK(compare("bone behind 1 mm of steel",
                  {{{muscle, 10e-3}, {steel, 1e-3}, {muscle, 9e-3}, {bone, 0.1}}, 0, 23e-3}, -50) > 20);
    CHECK(compare("fat, muscle, air, face 0.3",
                  {{{quiet(tissue::fat), 10e-3}, {muscle, 5e-3}, {quiet(tissue::air), 0.1}}, 0.3, 50e-3}, -50) > 8);
}

TEST_CASE("surfaces that touch the face of the probe do not reverberate with what lies deeper") {
    using namespace path_pairs_test;
    for (const float shift : {-0.3_um, 0.0F, 0.3_um}) {
        const pose turned = look_at({10_mm, 20_mm, 5_mm}, {13_mm, 26_mm, 11_mm}, {1, 0, 0});
        scene body{quiet(tissue::air)};
        body.add(make_box({-60_mm, -60_mm, shift}, {60_mm, 60_mm, 60_mm}), quiet(tissue::muscle), {.at = turned});
        body.add(make_box({-50_mm, -50_mm, 10_mm}, {50_mm, 50_mm, 40_mm}), quiet(tissue::bone), {.at = turned});
        body.build(exec::par);
        const auto found =
            echoes_test::echoes_of(trace(exec::par, body, linear_array{.lines = 1, .width = 1_mm, .frequency = 5_MHz},
                                         turned, physical<>{}, {.depth = 19_mm, .samples = 1900}, paths{}),
                                   0);
        CHECK(found.size() == 1); // the near side of the bone
    }
}

TEST_CASE("a path that reaches the face of the probe ends there") {
    using namespace path_pairs_test;
    const medium muscle = quiet(tissue::muscle);
    scene body{muscle};
    body.add(make_box({-20_mm, -20_mm, 20_mm}, {20_mm, 20_mm, 25_mm}), quiet(tissue::bone));
    const auto lines = [&] {
        body.build(exec::par);
        return trace(exec::par, body, linear_array{.lines = 16}, pose{}, physical<>{},
                     {.depth = 50_mm, .samples = 2000}, paths{});
    };
    const iq_lines alone = lines();
    body.add(make_box({-20_mm, -20_mm, -12_mm}, {20_mm, 20_mm, -8_mm}), quiet(tissue::bone)); // behind the probe
    const iq_lines with_block = lines();
    CHECK(alone.values == with_block.values);
}
