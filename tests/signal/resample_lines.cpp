#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/signal/resample_lines.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

namespace resample_lines_test {
namespace {

constexpr float depth = 20_mm;
constexpr std::uint32_t samples = 280;

template <class Probe>
using traced_probe = steered<refined<Probe>>;

template <class Probe>
traced_probe<Probe> with_lines(const Probe& probe, std::uint32_t lines, float angle = 0) {
    return traced_probe<Probe>{refined<Probe>{probe, static_cast<float>(lines) / static_cast<float>(probe.lines)},
                               angle};
}

/// Echoes of scatterers in the middle of the field of view, in double precision: a Gaussian beam, a Gaussian pulse, and a wave
/// front across the lines.
/// @param sigma  of the beam
template <class Probe>
iq_lines echoes_of(const Probe& probe, double sigma, double carrier) {
    iq_lines made;
    made.reshape(probe.lines, samples, depth);
    const double per_line = static_cast<double>(line_spacing(probe, 0.5F * depth)),
                 advance = static_cast<double>(line_advance(probe)), per_sample = static_cast<double>(depth) / samples,
                 pulse = 2.2 * per_sample, middle = 0.5 * probe.lines - 0.5, pi_ = std::acos(-1.0);
    std::uint64_t drawn = 0;
    const auto uniform = [&] { return static_cast<double>(hash_uniform(5, drawn++)); };
    for (int n = 0; n < 400; ++n) {
        const double x = (uniform() - 0.5) * 0.6 * per_line * probe.lines, z = (0.1 + 0.8 * uniform()) * 20e-3,
                     amplitude = uniform() - 0.5;
        for (std::uint32_t line = 0; line < probe.lines; ++line) {
            const double away = (line - middle) * per_line - x;
            if (std::fabs(away) > 6 * sigma) continue;
            const double here = z - away / per_line * advance;
            for (std::uint32_t k = 0; k < samples; ++k) {
                const double from = (k + 0.5) * per_sample - here;
                if (std::fabs(from) > 6 * pulse) continue;
                const double size =
                    amplitude * std::exp(-0.5 * away * away / (sigma * sigma) - 0.5 * from * from / (pulse * pulse));
                const auto value =
                    size * std::polar(1.0, -4 * pi_ * carrier * here / static_cast<double>(display_speed));
                made(line, k) += vec2{static_cast<float>(value.real()), static_cast<float>(value.imag())};
            }
        }
    }
    return made;
}

/// Root mean square of the difference, of that of the values.
double error_of(const iq_lines& a, const iq_lines& b) {
    double difference = 0, all = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        const vec2 apart = a.values[i] - b.values[i];
        difference += static_cast<double>(dot(apart, apart));
        all += static_cast<double>(dot(b.values[i], b.values[i]));
    }
    return std::sqrt(difference / all);
}

template <class Probe>
Probe probe_with(Probe probe, std::uint32_t lines) {
    probe.lines = lines;
    return probe;
}

} // namespace

TEST_CASE("resample_lines: lines half a beam width apart say what is between them, at any angle") {
    const linear_array plane{.lines = 200, .width = 40_mm, .frequency = 7_MHz};
    const convex_array round{.lines = 200, .radius = 60_mm, .field_of_view = 40_deg, .frequency = 4_MHz};
    const auto measure = [](const std::string& name, const auto& probe, float angle, double expected) {
        const auto sparse = with_lines(probe, 125, angle), dense = with_lines(probe, 200, angle);
        // Half of the width at -6 dB is 1.18 standard deviations.
        const double sigma = static_cast<double>(line_spacing(sparse, 0.5F * depth)) / 1.18;
        const auto carrier = static_cast<double>(probe.frequency);
        const double error = error_of(resample_lines(exec::par_unseq, echoes_of(sparse, sigma, carrier), sparse, dense),
                                      echoes_of(dense, sigma, carrier));
        MESSAGE(name, ", ", angle * 180 / pi, " degrees: error ", 20 * std::log10(error), " dB, allowed ", expected);
        CHECK(20 * std::log10(error) < expected);
    };
    const auto to_fewer = [](const std::string& name, const auto& probe, float angle, double expected) {
        const auto traced = with_lines(probe, 200, angle), wanted = with_lines(probe, 125, angle);
        const double sigma = static_cast<double>(line_spacing(traced, 0.5F * depth)) / 1.18;
        const auto carrier = static_cast<double>(probe.frequency);
        const steered own{probe_with(probe, 125), angle};
        const double error = error_of(resample_lines(exec::par_unseq, echoes_of(traced, sigma, carrier), traced, own),
                                      echoes_of(wanted, sigma, carrier));
        MESSAGE(name, " to fewer lines: error ", 20 * std::log10(error), " dB, allowed ", expected);
        CHECK(20 * std::log10(error) < expected);
    };
    to_fewer("linear", plane, 0, -30);
    to_fewer("convex", round, 0, -30);
    to_fewer("linear", plane, 3_deg, -28);
    measure("linear", plane, 0, -30);
    measure("convex", round, 0, -30);
    for (const float angle : {3_deg, -3_deg}) measure("linear", plane, angle, -28);
    for (const float angle : {10_deg, -10_deg}) measure("linear", plane, angle, -20);
    measure("convex", round, 3_deg, -26);
}

TEST_CASE(
    "resample_lines: as many lines stay as they are, a plate keeps its amplitude to the sides, a circle has none") {
    const auto sparse = with_lines(linear_array{.lines = 40}, 25), dense = with_lines(linear_array{.lines = 40}, 40);
    const iq_lines echoes = echoes_of(sparse, 0.5e-3, 5e6);
    CHECK(error_of(resample_lines(exec::seq, echoes, sparse, sparse), echoes) < 1e-6);

    iq_lines plate;
    plate.reshape(25, samples, depth);
    for (vec2& value : plate.values) value = {0.5F, -0.25F};
    float worst = 0;
    for (const vec2 value : resample_lines(exec::seq, plate, sparse, dense).values)
        worst = std::max(worst, length(value - vec2{0.5F, -0.25F}));
    CHECK(worst < 1e-6F);

    const auto few = with_lines(radial_array{.lines = 64}, 48), all = with_lines(radial_array{.lines = 64}, 64);
    iq_lines turning; // two cycles in a circle
    turning.reshape(48, samples, depth);
    const auto cycles = [](std::uint32_t line, std::uint32_t lines) {
        const float turn = 4 * pi * (static_cast<float>(line) + 0.5F) / static_cast<float>(lines);
        return vec2{std::cos(turn), std::sin(turn)};
    };
    for (std::uint32_t line = 0; line < 48; ++line)
        for (std::uint32_t k = 0; k < samples; ++k) turning(line, k) = cycles(line, 48);
    const iq_lines seen = resample_lines(exec::par, turning, few, all);
    worst = 0;
    for (std::uint32_t line = 0; line < 64; ++line) worst = std::max(worst, length(seen(line, 7) - cycles(line, 64)));
    CHECK(worst < 0.02F);
}

TEST_CASE("resample_lines: every policy gives the same to the bit, and lines of another probe are refused") {
    const auto sparse = with_lines(linear_array{.lines = 40}, 25, 5_deg),
               dense = with_lines(linear_array{.lines = 40}, 40, 5_deg);
    const iq_lines echoes = echoes_of(sparse, 0.5e-3, 5e6), seen = resample_lines(exec::seq, echoes, sparse, dense);
    for (const iq_lines& other : {resample_lines(exec::unseq, echoes, sparse, dense),
                                  resample_lines(exec::par_unseq.threads(3), echoes, sparse, dense)})
        CHECK(std::memcmp(seen.values.data(), other.values.data(), seen.values.size() * sizeof(vec2)) == 0);
    CHECK_THROWS_WITH_AS(
        resample_lines(exec::seq, echoes, dense, sparse),
        "resample_lines: the echoes must have as many lines as the probe, and a value for every sample", usage_error);
    CHECK_THROWS_WITH_AS(resample_lines(exec::seq, echoes, sparse, linear_array{.lines = 40}),
                         "resample_lines: the probes are steered differently; both must have the same `steering`",
                         usage_error);
}

} // namespace resample_lines_test
