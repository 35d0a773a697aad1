#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/doppler/slow_time.hpp>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <numbers>

using namespace insonify;

namespace slow_time_test {
namespace {

/// Pulses of one phasor: `cycles` of turn from pulse to pulse.
iq_ensemble phasor(std::size_t pulses, double cycles, std::uint32_t samples = 40) {
    iq_ensemble echoes{.prf = 4_kHz, .pulses = {}};
    for (std::size_t k = 0; k < pulses; ++k) {
        iq_lines lines{2, samples, 40_mm};
        const double turn = 2 * 3.14159265358979 * cycles * static_cast<double>(k);
        for (vec2& value : lines.values)
            value = {static_cast<float>(std::cos(turn)), static_cast<float>(std::sin(turn))};
        echoes.pulses.push_back(lines);
    }
    return echoes;
}

double decibels_of(const iq_ensemble& echoes) {
    double power = 0, count = 0;
    for (const iq_lines& each : echoes.pulses)
        for (const vec2 value : each.values) {
            power += static_cast<double>(dot(value, value));
            ++count;
        }
    return 10 * std::log10(power / count + 1e-30);
}

} // namespace

TEST_CASE("wall filter: a polynomial of its degree is removed, a fast phasor stays") {
    for (const std::uint32_t order : {0U, 1U, 2U, 3U}) {
        iq_ensemble walls = phasor(12, 0);
        for (std::size_t k = 0; k < 12; ++k)
            for (vec2& value : walls.pulses[k].values) {
                const auto x = static_cast<float>(k) / 11;
                value = {std::pow(x, static_cast<float>(order)), 1 - x * static_cast<float>(order > 0)};
            }
        const wall_filter filter{.order = order};
        const double left = decibels_of(filter_walls(exec::par_unseq, walls, filter)),
                     blood = decibels_of(filter_walls(exec::par_unseq, phasor(12, 0.3), filter));
        MESSAGE("order ", order, ": walls ", left, " dB, expected below -120; blood ", blood, " dB, expected about ",
                10 * std::log10(1 - (order + 1) / 12.0), " to 0");
        CHECK(left < -120);
        CHECK(blood > -1.5);
        CHECK(blood < 0.01);
    }
}

TEST_CASE("wall filter: FIR has the response of its taps, and no gain at 0 Hz") {
    const wall_filter filter{.type = wall_filter::kind::fir, .order = 8, .cutoff = 0.1F};
    CHECK(filter_walls(exec::seq, phasor(12, 0), filter).pulses.size() == 4);
    CHECK(decibels_of(filter_walls(exec::seq, phasor(12, 0), filter)) < -120);
    // The windowed sinc by the book, in double precision.
    std::vector<double> low(9);
    double sum = 0;
    for (int i = 0; i < 9; ++i) {
        const double x = i - 4;
        low[static_cast<std::size_t>(i)] =
            (x == 0 ? 0.2 : std::sin(0.2 * std::numbers::pi * x) / (std::numbers::pi * x)) *
            (0.54 - 0.46 * std::cos(2 * std::numbers::pi * i / 8));
        sum += low[static_cast<std::size_t>(i)];
    }
    for (const double cycles : {0.02, 0.1, 0.25, 0.5}) {
        std::complex<double> response = 0;
        for (int i = 0; i < 9; ++i)
            response += ((i == 4 ? 1.0 : 0.0) - low[static_cast<std::size_t>(i)] / sum) *
                        std::polar(1.0, 2 * std::numbers::pi * cycles * i);
        const double expected = 20 * std::log10(std::abs(response)),
                     found = decibels_of(filter_walls(exec::unseq, phasor(12, cycles), filter));
        MESSAGE("at ", cycles, " of the prf: ", found, " dB, expected ", expected);
        CHECK(found == doctest::Approx(expected).scale(1e-30).epsilon(1e-3));
    }
}

TEST_CASE("wall filter: SIMD agrees with scalar, threads do not matter, none keeps all") {
    const iq_ensemble echoes = phasor(10, 0.13, 37);
    const iq_ensemble plain = filter_walls(exec::seq, echoes, {.order = 2}),
                      vector = filter_walls(exec::par_unseq, echoes, {.order = 2});
    for (std::size_t k = 0; k < 10; ++k) {
        CHECK(plain.pulses[k] == filter_walls(exec::par.threads(3), echoes, {.order = 2}).pulses[k]);
        for (std::size_t i = 0; i < plain.pulses[k].values.size(); ++i)
            CHECK(length(plain.pulses[k].values[i] - vector.pulses[k].values[i]) < 1e-6F);
        CHECK(filter_walls(exec::seq, echoes, {.type = wall_filter::kind::none}).pulses[k] == echoes.pulses[k]);
    }
}

TEST_CASE("autocorrelation: the velocity of a phasor, and its alias") {
    const float largest = max_doppler_velocity(4_kHz, 5_MHz); // 0.308 m/s
    CHECK(largest == doctest::Approx(1540.0 * 4000 / (4 * 5e6)).scale(1e-30));
    for (const double cycles : {0.1, -0.37, 0.499, 0.501, 0.8}) {
        const autocorrelation_lines found = autocorrelate(exec::par, phasor(8, cycles), 5, 8);
        const flow_sample flow = flow_of(found(1, 2), largest);
        const double expected = 2 * (cycles - std::round(cycles)) * static_cast<double>(largest);
        MESSAGE(cycles, " cycles a pulse: ", flow.velocity, " m/s, expected ", expected);
        CHECK(found.samples == 5);
        CHECK(flow.velocity == doctest::Approx(expected).epsilon(1e-4).scale(1e-30));
        CHECK(flow.power == doctest::Approx(1).scale(1e-30).epsilon(1e-5));
        CHECK(flow.variance < 1e-6F);
    }
    CHECK(flow_of({}, largest) == flow_sample{});
}

TEST_CASE("autocorrelation: the variance is that of the velocities") {
    // Many phasors of random phase, whose velocities have a standard deviation of 0.02 m/s.
    const double largest = 0.308, sigma = 0.02, mean = 0.1;
    iq_ensemble echoes = phasor(16, 0, 4096);
    for (std::uint32_t i = 0; i < 4096; ++i) {
        std::vector<std::complex<double>> sum(16);
        for (std::uint32_t n = 0; n < 12; ++n) {
            const vec2 random = hash_normal(7, i * 12 + n);
            const double velocity = mean + sigma * static_cast<double>(random.x),
                         phase = 2 * std::numbers::pi * static_cast<double>(hash_uniform(8, i * 12 + n));
            for (std::size_t k = 0; k < 16; ++k)
                sum[k] += std::polar(1.0, phase + std::numbers::pi * velocity / largest * static_cast<double>(k));
        }
        for (std::size_t k = 0; k < 16; ++k)
            echoes.pulses[k](0, i) =
                echoes.pulses[k](1, i) = {static_cast<float>(sum[k].real()), static_cast<float>(sum[k].imag())};
    }
    const flow_sample flow = flow_of(autocorrelate(exec::par, echoes, 4096, 4096)(0, 0), static_cast<float>(largest));
    MESSAGE("mean ", flow.velocity, " m/s, expected ", mean, "; deviation ", std::sqrt(flow.variance), ", expected ",
            sigma);
    CHECK(flow.velocity == doctest::Approx(mean).epsilon(0.02).scale(1e-30));
    CHECK(std::sqrt(flow.variance) == doctest::Approx(sigma).epsilon(0.05).scale(1e-30));
}

TEST_CASE("slow time: settings out of range are refused") {
    const iq_ensemble echoes = phasor(4, 0.1);
    CHECK_THROWS_WITH(filter_walls(exec::seq, echoes, {.order = 3}),
                      "wall_filter: order 3 needs at least 5 pulses, not 4; lower it or raise the ensemble");
    CHECK_THROWS_AS(filter_walls(exec::seq, phasor(20, 0), {.order = 9}), usage_error);
    CHECK_THROWS_AS(filter_walls(exec::seq, echoes, {.type = wall_filter::kind::fir, .order = 4294967294U}),
                    usage_error);
    CHECK_THROWS_AS(filter_walls(exec::seq, echoes, {.type = wall_filter::kind::fir, .order = 1}), usage_error);
    CHECK_THROWS_AS(filter_walls(exec::seq, echoes, {.type = wall_filter::kind::fir, .order = 2, .cutoff = 0.5F}),
                    usage_error);
    CHECK_THROWS_AS(autocorrelate(exec::seq, phasor(1, 0)), usage_error);
    CHECK_THROWS_AS(autocorrelate(exec::seq, echoes, 1, 7), usage_error);
    CHECK_THROWS_AS(autocorrelate(exec::seq, echoes, 0, 1), usage_error);
    iq_ensemble uneven = echoes;
    uneven.pulses[1].depth = 1;
    CHECK_THROWS_WITH(autocorrelate(exec::seq, uneven),
                      "autocorrelate: all pulses must have the same lines, samples and depth");
    uneven = echoes;
    uneven.prf = 0;
    CHECK_THROWS_WITH(filter_walls(exec::seq, uneven, {}),
                      "filter_walls: the prf must be a frequency above 0, such as 4_kHz");
}

} // namespace slow_time_test
