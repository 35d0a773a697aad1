#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/read/near_field.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <utility>

using namespace insonify;

namespace near_field_test {
namespace {

using lines = near_field_settings::lines;
const linear_array probe{.lines = 96, .width = 30_mm, .frequency = 7.5_MHz};
const acquisition scan{.depth = 20_mm, .samples = 1024};

/// Muscle under the left half of the face, air under the right.
scene half_in_air() {
    scene body{tissue::air};
    body.add(make_box({-60_mm, -30_mm, -10_mm}, {0, 30_mm, 60_mm}), tissue::muscle);
    body.build(exec::par);
    return body;
}

scan_lines amplitudes(const scene& body, const near_field_settings& settings, bool silent = false) {
    iq_lines echoes = trace(exec::par_unseq, body, probe, pose{}, physical{}, scan);
    if (silent)
        for (vec2& v : echoes.values) v = {0, 0};
    echoes = add_near_field(exec::par_unseq, std::move(echoes), body, probe, pose{}, settings);
    return envelope(exec::par_unseq, convolve(exec::par_unseq, std::move(echoes), nominal_pulse(probe), probe));
}

double level(const scan_lines& seen, std::uint32_t line, float depth) { // largest within 0.1 mm, dB
    float largest = 1e-9F;
    for (std::uint32_t k = 0; k < seen.samples; ++k)
        if (std::fabs((static_cast<float>(k) + 0.5F) * seen.depth / static_cast<float>(seen.samples) - depth) < 0.1_mm)
            largest = max(largest, seen(line, k));
    return 20 * std::log10(static_cast<double>(largest));
}

} // namespace

TEST_CASE("near field: in air the face reverberates in parallel lines, and nothing lies below") {
    // d = 0.6 mm of silicone (1020 m/s, 4 dB/cm f^1.3) with a back that reflects 0.5: lines 0.6 * 1540 / 1020 = 0.906 mm
    // apart, each 6.02 + 2 * 0.06 cm * 4 dB/cm * 7.5^1.3 dB below the one before; air reflects all.
    const scan_lines seen = amplitudes(half_in_air(), {});
    const double loss = 6.0206 + 2 * 0.06 * 4 * std::pow(7.5, 1.3);
    for (int k = 1; k <= 6; ++k) {
        const double measured = level(seen, 80, static_cast<float>(k) * 0.90588_mm);
        MESSAGE("line ", k, ": ", measured, " dB, expected ", -k * loss);
        CHECK(std::fabs(measured + k * loss) < 0.3);
        CHECK(level(seen, 80, (static_cast<float>(k) - 0.5F) * 0.90588_mm) < -k * loss - 12); // dark between
    }
    CHECK(level(seen, 80, 15_mm) < -120);
}

TEST_CASE("near field: decided line by line, and tissue in contact is as without") {
    const scan_lines seen = amplitudes(half_in_air(), {}), without = amplitudes(half_in_air(), {.shown = lines::none});
    for (const float depth : {1_mm, 5_mm, 15_mm}) CHECK(level(seen, 15, depth) == level(without, 15, depth));
    CHECK(level(seen, 47, 15_mm) < -50); // next to the edge: half of a beam is in contact
    CHECK(level(seen, 80, 0.1_mm) > level(without, 80, 0.1_mm) + 20);
}

TEST_CASE("near field: ringing and the echo of the skin where the face touches, on request") {
    const scene body = scene{tissue::fat}.build(exec::par);
    const scan_lines seen = amplitudes(body, {.shown = lines::all}, true);
    const scan_lines quiet = amplitudes(body, {.shown = lines::all, .ring_down_db = no_level_db}, true);
    // Ringing: -30 dB at the face, 60 dB less at 1.5 mm. An exponential exp(-z/d) convolved with a Gaussian is
    // exp(sigma^2 / 2 d^2) times as much. Between the skin (at 0) and its repetition (at 0.91 mm):
    for (const float depth : {0.4_mm, 0.5_mm}) {
        const auto k = static_cast<std::uint32_t>(depth / 20_mm * 1024);
        const double measured = 20 * std::log10(static_cast<double>(seen(48, k)));
        const double ratio = 0.1874 * 1.54 / (0.644 * 7.5) * 3 * std::log(10.0) / 1.5; // sigma / d
        const double expected = -30 - 60 * (k + 0.5) / 1024 * 20 / 1.5 + 20 * std::log10(std::exp(ratio * ratio / 2));
        MESSAGE("ringing at ", depth, " m: ", measured, " dB, expected ", expected);
        CHECK(std::fabs(measured - expected) < 0.2);
    }
    // Fat, 930 * 1455, against the lens, 1200 * 1020: r = 0.0502.
    const double r = (930.0 * 1455 - 1200 * 1020) / (930.0 * 1455 + 1200 * 1020);
    const double loss = 6.0206 + 2 * 0.06 * 4 * std::pow(7.5, 1.3);
    const double repeated = level(quiet, 48, 0.90588_mm), expected = 40 * std::log10(r) - loss;
    MESSAGE("skin, repeated once: ", repeated, " dB, expected ", expected);
    CHECK(std::fabs(repeated - expected) < 1);
    const scan_lines by_default = amplitudes(body, {}, true);
    for (const float value : by_default.values) REQUIRE(value == 0);
}

TEST_CASE("near field: follows surfaces that move, without their trees") {
    scene moving{tissue::air}, built{tissue::air};
    const object_id id = moving.add(make_box({-60_mm, -30_mm, -10_mm}, {-5_mm, 30_mm, 60_mm}), tissue::muscle);
    moving.build(exec::par);
    for (vec3& vertex : moving.positions(id))
        if (vertex.x > -6_mm) vertex.x = 5_mm;
    moving.update(exec::par);
    built.add(make_box({-60_mm, -30_mm, -10_mm}, {5_mm, 30_mm, 60_mm}), tissue::muscle);
    built.build(exec::par);
    iq_lines silence{probe.lines, scan.samples, scan.depth};
    const near_field_settings all{.shown = lines::all};
    const iq_lines seen = add_near_field(exec::par, silence, moving, probe, pose{}, all);
    CHECK(seen == add_near_field(exec::par, silence, built, probe, pose{}, all));
    CHECK_FALSE(moving.view_for_slices(exec::par).objects[0].tree_is_current);
    const auto starts_in_gas = [&](std::uint32_t line) { return length(seen(line, 0)) > 0.3F; }; // 0.5; muscle: 0.09
    CHECK_FALSE(starts_in_gas(63)); // 4.8 mm beside the middle
    CHECK(starts_in_gas(64));
}

TEST_CASE("near field: the same on any number of threads; wrong use is refused") {
    const scene body = half_in_air();
    const iq_lines echoes = trace(exec::par, body, probe, pose{}, physical{}, scan);
    const near_field_settings all{.shown = lines::all};
    const iq_lines expected = add_near_field(exec::seq, echoes, body, probe, pose{}, all);
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
        CHECK(add_near_field(exec::par_unseq.threads(threads), echoes, body, probe, pose{}, all) == expected);
    CHECK_THROWS_AS(add_near_field(exec::seq, iq_lines{3, 10, 0.02F}, body, probe, pose{}), usage_error);
    for (const near_field_settings& bad :
         {near_field_settings{.lens_thickness = 0}, near_field_settings{.back_reflection = 1},
          near_field_settings{.back_reflection = -1}, near_field_settings{.ring_down_db = NAN},
          near_field_settings{.ring_down = -1}})
        CHECK_THROWS_AS(add_near_field(exec::seq, echoes, body, probe, pose{}, bad), usage_error);
}

} // namespace near_field_test
