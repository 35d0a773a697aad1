#include <insonify/acoustics/physical.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/doppler/doppler_ensemble.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/ground_truth.hpp>
#include <insonify/tracing/trace.hpp>
#include "physical_scenes.hpp"
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>

using namespace insonify;

// What attenuation takes off a pulse, beside a sum over its spectrum in which each frequency is attenuated by itself.
namespace pulse_loss_test {
namespace {

const medium soft = physical_test::of_impedance(1.70_MRayl, 1540, 1_dB_per_cm),
             hard = physical_test::of_impedance(6.69_MRayl, 1540, 5_dB_per_cm);

// Peak of a pulse, dB, of which a frequency f loses `loss_db` f / f0, over what it is without loss. Its envelope is a Gaussian of
// fractional bandwidth B, smoothed by a burst.
double peak(double loss_db, double bandwidth, double burst = 0) {
    constexpr int steps = 4000;
    const double sigma = bandwidth / 2.3548; // of the spectrum; frequencies in units of f0, times in cycles
    double largest = 0, whole = 0;
    for (double time = -1; time <= 1; time += 0.02) {
        std::complex<double> sum = 0;
        for (int i = 0; i < steps; ++i) {
            const double f = (i + 0.5) / steps * 2.5, off = f - 1, x = 3.14159265358979 * off * burst;
            const double amplitude =
                std::exp(-0.5 * off * off / sigma / sigma) * (std::fabs(x) > 1e-9 ? std::sin(x) / x : 1);
            if (time == -1) whole += amplitude;
            sum += amplitude * std::pow(10, -loss_db * f / 20) * std::polar(1.0, 6.28318530717959 * off * time);
        }
        largest = std::max(largest, std::abs(sum));
    }
    return 20 * std::log10(largest / whole);
}

double decibels(float amplitude) { return 20 * std::log10(static_cast<double>(amplitude)); }

float peak_near(const iq_lines& lines, float depth) {
    float largest = 0;
    for (std::uint32_t k = 0; k < lines.samples; ++k)
        if (std::fabs((static_cast<float>(k) + 0.5F) * lines.depth / static_cast<float>(lines.samples) - depth) < 1_mm)
            largest = std::max(largest, length(lines(lines.count / 2, k)));
    return largest;
}

} // namespace
} // namespace pulse_loss_test

TEST_CASE("by default the far face of a hard cube is as bright as the spectrum of the pulse says") {
    using namespace pulse_loss_test;
    const auto faces = [](float frequency, float side, const auto& model) {
        scene body{soft};
        body.add(make_box({-20_mm, -20_mm, 20_mm}, {20_mm, 20_mm, 20_mm + side}), hard);
        body.build(exec::par);
        const linear_array probe{.lines = 32, .width = 10_mm, .frequency = frequency};
        const iq_lines seen =
            convolve(exec::par, trace(exec::par, body, probe, pose{}, model, {.depth = 50_mm, .samples = 2500}),
                     nominal_pulse(probe), probe);
        return decibels(peak_near(seen, 20_mm + side) / peak_near(seen, 20_mm));
    };
    const auto silent = physical{}.with_scattering(no_scatterers{});
    const double crossed = 20 * std::log10(1 - std::pow((6.69 - 1.70) / (6.69 + 1.70), 2));
    // Beyond 58 dB the centre of the spectrum would be below f0 / 2, which `attenuated` excludes.
    for (const float frequency : {2.5_MHz, 5_MHz})
        for (const float side : {5_mm, 10_mm}) {
            if (frequency * side > 5_MHz * 6_mm) continue;
            const double above = 4 * static_cast<double>(frequency) * 1e-6,
                         inside = 10 * static_cast<double>(frequency) * 1e-6 * static_cast<double>(side) * 100; // dB
            const double expected = crossed + peak(above + inside, 0.644) - peak(above, 0.644);
            const double found = faces(frequency, side, silent);
            MESSAGE((frequency / 1e6F), " MHz, ", (side * 1e3F), " mm: ", found, " dB, expected ", expected,
                    ", a single frequency ", (crossed - inside));
            CHECK(std::fabs(found - expected) < 0.3);
        }
}

TEST_CASE("a long burst loses what its carrier does, a short pulse less: Doppler beside B-mode") {
    using namespace pulse_loss_test;
    scene body{medium{.density = 1000, .sound_speed = 1540, .attenuation = 1_dB_per_cm}};
    body.add(physical_test::slab(40_mm, 60_mm), medium{.density = 2000, .sound_speed = 1540});
    body.build(exec::par);
    const linear_array probe{.lines = 16, .width = 10_mm, .frequency = 5_MHz};
    const auto still = [](object_id, vec3, float) { return vec3{0, 0, 0}; };
    for (const float burst : {0.0F, 1.0F, 2.0F, 4.0F, 8.0F}) {
        const iq_ensemble seen =
            doppler_ensemble(exec::par, body, probe, pose{}, still,
                             {.depth = 50_mm, .samples = 2500, .pulses = 1, .burst = burst, .noise_db = no_level_db});
        const double found = decibels(3 * peak_near(seen.pulses[0], 40_mm)),
                     expected = peak(40, 0.644, static_cast<double>(burst));
        MESSAGE("burst of ", burst, " cycles: ", found, " dB, expected ", expected);
        // Attenuation also moves the peak of a burst that is not quite long; up to 2 cycles, fourth-order terms are left.
        CHECK(std::fabs(found - expected) < (burst == 0 || burst >= 8 ? 0.2 : 1.0));
    }
}

TEST_CASE("time gain, ground truth and paths follow what the pulse loses") {
    using namespace pulse_loss_test;
    medium tissue{.density = 1000, .sound_speed = 1540, .attenuation = 0.8_dB_per_cm, .backscatter = 1};
    const scene body = scene{tissue}.build(exec::par);
    const linear_array probe{.lines = 96, .width = 30_mm, .frequency = 7.5_MHz};
    for (const pulse_bandwidth bandwidth : {pulse_bandwidth::broad, pulse_bandwidth::narrow}) {
        // Tissue whose attenuation is known is equally bright at all depths.
        scanner machine{probe, b_mode_settings{.depth = 50_mm, .tgc = 80, .time_gain = {.max_db = 100}},
                        physical<>{.bandwidth = bandwidth}};
        machine.settings.noise.level_db = no_level_db;
        double level[2] = {};
        for (std::uint32_t seed = 1; seed <= 4; ++seed) {
            machine.model.scattering.seed = seed;
            machine.scan(exec::par_unseq, body, pose{});
            const scan_lines& grey = machine.lines();
            for (std::uint32_t line = 0; line < grey.count; ++line)
                for (std::uint32_t k = 0; k < grey.samples; ++k) {
                    const float z = (static_cast<float>(k) + 0.5F) / static_cast<float>(grey.samples);
                    if (z > 0.1F && z < 0.2F) level[0] += static_cast<double>(grey(line, k));
                    if (z > 0.8F && z < 0.9F) level[1] += static_cast<double>(grey(line, k));
                }
        }
        MESSAGE("brightness near and far: ratio ", (level[1] / level[0]));
        CHECK(std::fabs(level[1] / level[0] - 1) < 0.03);
    }
    const double expected = peak(2 * 0.8 * 7.5 * 4, 0.644); // from 40 mm
    const double truth =
        decibels(ground_truth(exec::par, body, probe, pose{}, {.depth = 80_mm, .samples = 800}).transmitted(48, 399));
    MESSAGE("40 mm deep: ", truth, " dB, expected ", expected);
    CHECK(std::fabs(truth - expected) < 0.2);

    tissue.backscatter = 0;
    scene plate{tissue};
    plate.add(physical_test::slab(40_mm, 60_mm), medium{.density = 2000, .sound_speed = 1540});
    plate.build(exec::par);
    const acquisition scan{.depth = 50_mm, .samples = 2500};
    const float straight = peak_near(trace(exec::par, plate, probe, pose{}, physical<>{}, scan), 40_mm),
                followed = peak_near(trace(exec::par, plate, probe, pose{}, physical<>{}, scan, paths{}), 40_mm);
    CHECK(followed == doctest::Approx(straight).epsilon(1e-3).scale(1e-30));
}
