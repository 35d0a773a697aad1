#include <insonify/acoustics/physical.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include "speckle_frames.hpp"
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("an anechoic cyst is told from its surroundings as well as speckle allows") { // V15
    // Inside nothing echoes, so all that limits the contrast-to-noise ratio is the speckle outside: 1.91.
    std::vector<double> inside, outside;
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        scene body{speckle_test::silent};
        medium cyst = speckle_test::silent;
        cyst.backscatter = 0;
        body.add(make_cylinder({0, -20_mm, 15_mm}, {0, 20_mm, 15_mm}, 2.5_mm, 128), cyst);
        body.build(exec::par);
        const linear_array probe{.lines = 192, .width = 30_mm, .frequency = 5_MHz};
        const std::vector<double> e = speckle_test::envelope_of(body, probe, pose{}, {.depth = 30_mm, .samples = 1500},
                                                                physical<>{.scattering = {.seed = seed}});
        for (std::uint32_t l = 0; l < 192; ++l)
            for (std::uint32_t k = 0; k < 1500; ++k) {
                const double x = (l + 0.5) / 192 * 30 - 15, z = (k + 0.5) / 1500 * 30 - 15;
                if (std::hypot(x, z) < 1.9) inside.push_back(e[std::size_t{l} * 1500 + k]);
                if (std::fabs(x) > 5 && std::fabs(x) < 13 && std::fabs(z) < 1.9)
                    outside.push_back(e[std::size_t{l} * 1500 + k]);
            }
    }
    const auto mean_and_variance = [](const std::vector<double>& values) {
        double sum = 0, squares = 0;
        for (const double v : values) sum += v, squares += v * v;
        const auto n = static_cast<double>(values.size());
        return std::pair{sum / n, squares / n - sum * sum / n / n};
    };
    const auto [mean_in, variance_in] = mean_and_variance(inside);
    const auto [mean_out, variance_out] = mean_and_variance(outside);
    const double contrast = (mean_out - mean_in) / std::sqrt(variance_in + variance_out);
    const double decibels = 20 * std::log10(speckle_test::rms(inside) / speckle_test::rms(outside));
    double min_error = 1; // generalised CNR: 1 minus the overlap of the two distributions, here at one threshold
    for (double threshold = 0; threshold < mean_out; threshold += mean_out / 200) {
        double wrong = 0;
        for (const double v : inside) wrong += v > threshold ? 1.0 / static_cast<double>(inside.size()) : 0;
        for (const double v : outside) wrong += v <= threshold ? 1.0 / static_cast<double>(outside.size()) : 0;
        min_error = std::min(min_error, wrong);
    }
    MESSAGE("V15, anechoic: contrast ", decibels, " dB (a wave simulation: -28.2), CNR ", contrast,
            " (1.69; limit 1.91), gCNR ", 1 - min_error, " (0.986)");
    CHECK(decibels < -28.2);
    CHECK(contrast == doctest::Approx(1.91).epsilon(0.05).scale(1e-30));
    CHECK(1 - min_error >= 0.986);
}

TEST_CASE("grey targets stand out by their backscatter") { // V15
    double inside = 0, outside = 0;
    for (const float contrast : {6.02F, -6.02F}) {
        inside = outside = 0;
        for (std::uint32_t seed = 1; seed <= 10; ++seed) {
            scene body{speckle_test::silent};
            medium target = speckle_test::silent;
            target.backscatter = std::pow(10.0F, contrast / 20);
            body.add(make_cylinder({0, -20_mm, 15_mm}, {0, 20_mm, 15_mm}, 2.5_mm, 128), target);
            body.build(exec::par);
            const linear_array probe{.lines = 192, .width = 30_mm, .frequency = 5_MHz};
            const std::vector<double> e = speckle_test::envelope_of(
                body, probe, pose{}, {.depth = 30_mm, .samples = 1500}, physical<>{.scattering = {.seed = seed}});
            for (std::uint32_t l = 0; l < 192; ++l)
                for (std::uint32_t k = 0; k < 1500; ++k) {
                    const double x = (l + 0.5) / 192 * 30 - 15, z = (k + 0.5) / 1500 * 30 - 15,
                                 power = std::pow(e[std::size_t{l} * 1500 + k], 2);
                    if (std::hypot(x, z) < 1.9) inside += power;
                    if (std::fabs(x) > 5 && std::fabs(x) < 13 && std::fabs(z) < 1.9)
                        outside += power * 3.14159 * 1.9 * 1.9 / (2 * 8 * 3.8);
                }
        }
        const double found = 10 * std::log10(inside / outside);
        const double cells = 10 * 3.14159 * 1.9 * 1.9 / (0.57 * 0.23);
        MESSAGE("V15: contrast ", found, " dB, expected ", contrast, " within ", 13 / std::sqrt(cells));
        CHECK(std::fabs(found - static_cast<double>(contrast)) < 13 / std::sqrt(cells));
    }
}
