#include <insonify/acoustics/tissue.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <doctest/doctest.h>

using namespace insonify;

namespace flowing_test {
namespace {

// Muscle, and blood from 10 mm on.
scene vessel() {
    scene body{tissue::muscle};
    body.add(make_box({-60_mm, -30_mm, 10_mm}, {60_mm, 30_mm, 40_mm}), tissue::blood);
    body.build(exec::par);
    return body;
}

iq_lines echoes_of(const scene& body, std::uint32_t frame, std::uint32_t planes) {
    return trace(exec::par_unseq, body, linear_array{.lines = 96}, pose{}, physical{},
                 {.depth = 20_mm, .samples = 1024, .planes = planes, .frame = frame});
}

/// Magnitude of the complex correlation, and the ratio of powers in dB, between two fractions of the depth.
struct comparison {
    double correlation, decibels;
};
comparison compare(const iq_lines& a, const iq_lines& b, double from, double to) {
    double real = 0, imaginary = 0, aa = 0, bb = 0;
    for (std::uint32_t line = 0; line < a.count; ++line)
        for (auto k = static_cast<std::uint32_t>(from * a.samples); k < static_cast<std::uint32_t>(to * a.samples);
             ++k) {
            const vec2 p = a(line, k), q = b(line, k);
            real += static_cast<double>(dot(p, q));
            imaginary += static_cast<double>(p.x * q.y - p.y * q.x);
            aa += static_cast<double>(dot(p, p));
            bb += static_cast<double>(dot(q, q));
        }
    return {std::hypot(real, imaginary) / std::sqrt(aa * bb), 10 * std::log10(bb / aa)};
}

} // namespace

TEST_CASE("flowing media: speckle is independent from frame to frame at the same level; other speckle stays") {
    const scene body = vessel();
    for (const std::uint32_t planes : {1U, 3U}) {
        const iq_lines first = echoes_of(body, 0, planes), second = echoes_of(body, 1, planes);
        const comparison blood = compare(first, second, 0.55, 0.95), muscle = compare(first, second, 0, 0.45);
        MESSAGE(planes, " planes: correlation in blood ", blood.correlation, ", expected 0; its level changes by ",
                blood.decibels, " dB, expected 0");
        CHECK(blood.correlation < 0.03); // some 10,000 independent values
        CHECK(std::fabs(blood.decibels) < 0.3);
        CHECK(muscle.correlation == doctest::Approx(1).scale(1e-30).epsilon(1e-6));
        CHECK(muscle.decibels == 0);
        CHECK(echoes_of(body, 1, planes) == second);
    }
}

} // namespace flowing_test
