#include <insonify/acoustics/physical.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

/// Elevation planes beside the Gaussian beam that they sample.
namespace elevation_focus_test {
namespace {

constexpr medium scatterers{.density = 1050, .sound_speed = 1540, .backscatter = 1},
    anechoic{.density = 1050, .sound_speed = 1540};
constexpr std::uint32_t samples = 1024;
constexpr straight_lines alone{.directions = 1};

iq_lines received(iq_lines echoes, const linear_array& probe) {
    return convolve(exec::par_unseq, std::move(echoes), nominal_pulse(probe), probe);
}

// Speckle by parallel slices 0.1 mm apart, each with scatterers of its own, weighted by the beam's amplitude exp(-y^2 / 2 sigma^2).
iq_lines by_slices(const scene& body, const linear_array& probe, float depth, std::uint32_t seed) {
    const beam_model beam = beam_of(probe, depth);
    iq_lines sum{probe.lines, samples, depth};
    std::vector<float> power(samples, 0.0F);
    for (int i = -30; i <= 30; ++i) {
        const float y = static_cast<float>(i) * 0.1_mm;
        const physical<> model{.scattering = {.seed = 1000 * seed + static_cast<std::uint32_t>(i + 30)}};
        const iq_lines slice = trace(exec::par_unseq, body, probe, {.translation = {0, y, 0}}, model,
                                     {.depth = depth, .samples = samples}, alone);
        for (std::uint32_t k = 0; k < samples; ++k) {
            const float z = (static_cast<float>(k) + 0.5F) * depth / samples, u = y / beam.elevation_sigma(z),
                        weight = std::exp(-0.5F * u * u);
            power[k] += weight * weight;
            for (std::uint32_t line = 0; line < sum.count; ++line) sum(line, k) += weight * slice(line, k);
        }
    }
    for (std::uint32_t k = 0; k < samples; ++k)
        for (std::uint32_t line = 0; line < sum.count; ++line) sum(line, k) /= std::sqrt(power[k]);
    return sum;
}

} // namespace
} // namespace elevation_focus_test

TEST_CASE("an anechoic sphere of 3 mm at the elevation focus fills as it does in a Gaussian beam, within 2 dB") {
    using namespace elevation_focus_test;
    const linear_array probe{
        .lines = 192, .width = 30_mm, .frequency = 5_MHz, .elevation_height = 5_mm, .elevation_focus = 30_mm};
    constexpr float depth = 42_mm, radius = 1.5_mm, apart = 6_mm;
    scene body{scatterers};
    for (int i = -2; i <= 2; ++i) body.add(make_sphere({static_cast<float>(i) * apart, 0, 30_mm}, radius, 5), anechoic);
    body.build(exec::par);
    const float discs[] = {0.67F, 0.75F, 0.83F}; // of the radius
    struct levels {
        double power[3] = {}, count[3] = {};
    };
    const auto add = [&](const iq_lines& seen, levels& to) {
        for (std::uint32_t line = 0; line < seen.count; ++line)
            for (std::uint32_t k = 0; k < samples; ++k) {
                const float x = probe.beam(static_cast<float>(line)).origin.x,
                            z = (static_cast<float>(k) + 0.5F) * depth / samples - 30_mm,
                            beside = x - apart * std::round(x / apart);
                for (int i = 0; i < 3; ++i)
                    if (std::hypot(beside, z) < discs[i] * radius) {
                        to.power[i] += static_cast<double>(dot(seen(line, k), seen(line, k)));
                        ++to.count[i];
                    }
            }
    };
    levels beam;
    for (std::uint32_t seed = 1; seed <= 3; ++seed) add(received(by_slices(body, probe, depth, seed), probe), beam);
    for (const std::uint32_t planes : {5U, 7U}) {
        levels found;
        for (std::uint32_t seed = 1; seed <= 8; ++seed)
            add(received(trace(exec::par_unseq, body, probe, pose{}, physical<>{.scattering = {.seed = seed}},
                               {.depth = depth, .samples = samples, .planes = planes}, alone),
                         probe),
                found);
        for (int i = 0; i < 3; ++i) {
            const double level = 10 * std::log10(found.power[i] / found.count[i]) + 55,
                         expected = 10 * std::log10(beam.power[i] / beam.count[i]) + 55;
            MESSAGE(planes, " planes, within ", discs[i], " of the radius: ", level, " dB, Gaussian beam ", expected);
            CHECK(std::fabs(level - expected) < 2);
        }
    }
}

TEST_CASE("out of the slice, speckle decorrelates as the beam says at every depth: exp(-d^2 / (4 sigma^2))") {
    using namespace elevation_focus_test;
    const scene body = scene{scatterers}.build(exec::par);
    for (const float frequency : {5_MHz, 7.5_MHz})
        for (const std::uint32_t planes : {3U, 5U, 7U}) {
            const linear_array probe{.lines = 128, .width = 30_mm, .frequency = frequency}; // focused at 20 mm
            constexpr float depth = 42_mm;
            const beam_model beam = beam_of(probe, depth);
            const auto seen = [&](float slide, std::uint32_t seed) {
                return received(trace(exec::par_unseq, body, probe, {.translation = {0, slide, 0}},
                                      physical<>{.scattering = {.seed = seed}},
                                      {.depth = depth, .samples = 1536, .planes = planes}, alone),
                                probe);
            };
            double worst = 0;
            const float slides[] = {0.1_mm, 0.2_mm, 0.4_mm, 0.6_mm, 0.8_mm};
            double product[7][5] = {}, power[7] = {};
            for (std::uint32_t seed = 1; seed <= 4; ++seed) {
                const iq_lines before = seen(0, seed);
                for (int i = 0; i < 5; ++i) {
                    const iq_lines after = seen(slides[i], seed);
                    for (std::uint32_t line = 0; line < before.count; ++line)
                        for (std::uint32_t k = 0; k < before.samples; ++k) {
                            const float z = (static_cast<float>(k) + 0.5F) * depth / 1536;
                            const auto row = static_cast<int>(std::lround(z / 5_mm)) - 2;
                            if (row < 0 || row > 6 || std::fabs(z - static_cast<float>(row + 2) * 5_mm) > 1_mm)
                                continue;
                            product[row][i] += static_cast<double>(dot(before(line, k), after(line, k)));
                            if (i == 0) power[row] += static_cast<double>(dot(before(line, k), before(line, k)));
                        }
                }
            }
            for (int row = 0; row < 7; ++row)
                for (int i = 0; i < 5; ++i) {
                    const auto sigma = static_cast<double>(beam.elevation_sigma(static_cast<float>(row + 2) * 5_mm));
                    const double expected = std::exp(-std::pow(static_cast<double>(slides[i]) / sigma, 2) / 4);
                    worst = std::max(worst, std::fabs(product[row][i] / power[row] - expected));
                }
            MESSAGE((frequency / 1e6F), " MHz, ", planes, " planes, 10 to 40 mm deep, 0.1 to 0.8 mm: off by ", worst);
            CHECK(worst < 0.05);
        }
}
