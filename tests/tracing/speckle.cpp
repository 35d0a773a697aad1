#include <insonify/acoustics/physical.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include "speckle_frames.hpp"
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("homogeneous tissue has its level, -55 dB times backscatter, whatever the lines, samples, depth and border") {
    struct {
        std::uint32_t lines, samples, planes;
    } const rows[] = {{64, 1344, 1},  {192, 1344, 1}, {384, 1344, 1}, {192, 2048, 1},
                      {192, 4096, 1}, {192, 1344, 5}, {256, 2048, 7}};
    for (const auto& row : rows) {
        double all = 0, shallow = 0, deep = 0, border = 0;
        constexpr int seeds = 24;
        for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
            const scene body = scene{speckle_test::silent}.build(exec::seq);
            const linear_array probe{.lines = row.lines, .width = 38_mm, .frequency = 7.5_MHz};
            const auto model = physical<>{.scattering = {.seed = seed}};
            const std::vector<double> e = speckle_test::envelope_of(
                body, probe, pose{}, {.depth = 40_mm, .samples = row.samples, .planes = row.planes}, model);
            const auto part = [&](std::uint32_t first_line, std::uint32_t lines, std::uint32_t first,
                                  std::uint32_t count) {
                double sum = 0;
                for (std::uint32_t l = first_line; l < first_line + lines; ++l)
                    for (std::uint32_t k = first; k < first + count; ++k)
                        sum += e[std::size_t{l} * row.samples + k] * e[std::size_t{l} * row.samples + k];
                return sum / lines / count / seeds;
            };
            const std::uint32_t tenth = row.samples / 10;
            all += part(0, row.lines, tenth, 8 * tenth);
            shallow += part(0, row.lines, tenth, 2 * tenth);
            deep += part(0, row.lines, 7 * tenth, 2 * tenth);
            border += 0.5 * (part(0, 2, tenth, 8 * tenth) + part(row.lines - 2, 2, tenth, 8 * tenth));
        }
        const auto level = [](double power) { return 10 * std::log10(power); };
        MESSAGE(row.lines, " lines of ", row.samples, ", ", row.planes, " planes: ", level(all), " dB, shallow ",
                level(shallow), ", deep ", level(deep), ", border ", level(border), "; expected -55");
        CHECK(std::fabs(level(all) + 55) < 0.3);
        CHECK(std::fabs(level(shallow) + 55) < 0.3);
        CHECK(std::fabs(level(deep) + 55) < 0.3);
        CHECK(std::fabs(level(border) + 55) < 0.3);
    }
}

TEST_CASE("the level is the same for a convex probe, and follows backscatter and texture_db") {
    double power = 0;
    for (std::uint32_t seed = 1; seed <= 24; ++seed) {
        const scene body = scene{medium{.density = 1000, .sound_speed = 1580, .backscatter = 0.5F}}.build(exec::seq);
        const std::vector<double> e = speckle_test::envelope_of(
            body, convex_array{.lines = 192, .frequency = 3.5_MHz}, pose{}, {.depth = 80_mm, .samples = 1344},
            physical<>{.scattering = {.seed = seed}, .texture_db = -50});
        power += std::pow(speckle_test::rms(e), 2) / 24;
    }
    CHECK(std::fabs(10 * std::log10(power) - (-50 + speckle_test::decibels(0.5))) < 0.3);
}

TEST_CASE("the level is the same from every direction, in plane and out of it, and at every frequency") {
    struct {
        float frequency;
        std::uint32_t lines, planes;
        vec3 towards;
    } const rows[] = {{3.5_MHz, 192, 1, {0.063F, 0, 1}}, {7.5_MHz, 64, 1, {0.063F, 0, 1}},
                      {7.5_MHz, 384, 1, {0.063F, 0, 1}}, {7.5_MHz, 192, 1, {1, 0.3F, 1}},
                      {12_MHz, 384, 1, {0.07F, 0, 1}},   {12_MHz, 192, 5, {0, 0.063F, 1}},
                      {12_MHz, 192, 5, {0.4F, 0.6F, 1}}};
    for (const auto& row : rows) {
        double power = 0;
        for (std::uint32_t seed = 1; seed <= 12; ++seed) {
            const scene body = scene{speckle_test::silent}.build(exec::seq);
            const linear_array probe{.lines = row.lines, .width = 38_mm, .frequency = row.frequency};
            const std::vector<double> e = speckle_test::envelope_of(
                body, probe, look_at({0, 0, 0}, row.towards, {1, 0, 0}),
                {.depth = 40_mm, .samples = 2048, .planes = row.planes}, physical<>{.scattering = {.seed = seed}});
            power += std::pow(speckle_test::rms(e), 2) / 12;
        }
        MESSAGE((row.frequency / 1e6F), " MHz, ", row.lines, " lines, towards ", row.towards.x, " ", row.towards.y, " ",
                row.towards.z, ": ", 10 * std::log10(power), " dB, expected -55");
        CHECK(std::fabs(10 * std::log10(power) + 55) < 0.3);
    }
}

TEST_CASE("fully developed speckle has the statistics of Rayleigh's distribution") { // V9
    std::vector<double> all;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        const scene body = scene{speckle_test::silent}.build(exec::seq);
        const linear_array probe{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz};
        const std::vector<double> e = speckle_test::envelope_of(body, probe, pose{}, {.depth = 40_mm, .samples = 2048},
                                                                physical<>{.scattering = {.seed = seed}});
        for (std::uint32_t l = 10; l < 246; ++l)
            for (std::uint32_t k = 100; k < 1948; ++k) all.push_back(e[std::size_t{l} * 2048 + k]);
    }
    const auto n = static_cast<double>(all.size());
    double m1 = 0, m2 = 0, m4 = 0, db1 = 0, db2 = 0;
    for (const double v : all) {
        const double i = v * v, db = 10 * std::log10(i);
        m1 += v / n, m2 += i / n, m4 += i * i / n, db1 += db / n, db2 += db * db / n;
    }
    const double snr = m1 / std::sqrt(m2 - m1 * m1), intensity_snr = m2 / std::sqrt(m4 - m2 * m2);
    const double spread = std::sqrt(db2 - db1 * db1), mean = db1 - 10 * std::log10(m2);
    MESSAGE("V9: envelope SNR ", snr, " (1.913), intensity SNR ", intensity_snr, " (1.000), spread ", spread,
            " dB (5.570), mean ", mean, " dB (-2.507)");
    CHECK(snr == doctest::Approx(1.913).epsilon(0.02).scale(1e-30));
    CHECK(intensity_snr == doctest::Approx(1).epsilon(0.02).scale(1e-30));
    CHECK(spread == doctest::Approx(5.570).epsilon(0.02).scale(1e-30));
    CHECK(mean == doctest::Approx(-2.507).epsilon(0.02).scale(1e-30));
}

TEST_CASE("sparse scatterers show: the envelope's SNR is that of so many to a resolution cell") { // V10
    struct {
        double per_cell, snr;
    } const rows[] = {{5, 1.70}, {10, 1.81}};
    for (const auto& row : rows) {
        // The -6 dB ellipse of this pulse and beam; one plane mixes two rows of cells, in the fourth moment as many
        // scatterers as 1.273 rows: the inverse of the mean of ((1-f)^4 + f^4) / ((1-f)^2 + f^2)^2 over f. A row is half
        // the aperture's height, 5 mm.
        const double area = 3.14159265 / 4 * 0.567e-3 * 0.2109e-3, thickness = 1.273 * 5e-3 / 2;
        double n = 0, m1 = 0, m2 = 0;
        for (std::uint32_t seed = 1; seed <= 8; ++seed) {
            const scene body = scene{speckle_test::silent}.build(exec::seq);
            const linear_array probe{.lines = 256, .width = 40_mm, .frequency = 5_MHz, .fnumber = 2, .focus = 30_mm};
            const physical<fresnel, poisson_scatterers> model{
                .scattering = {.seed = seed,
                               .numbers = {.density = static_cast<float>(row.per_cell / area / thickness)}}};
            const std::vector<double> e =
                speckle_test::envelope_of(body, probe, pose{}, {.depth = 36_mm, .samples = 2048}, model);
            for (std::uint32_t l = 10; l < 246; ++l)
                for (std::uint32_t k = 1536; k < 1878; ++k) { // 27 to 33 mm: about the focus
                    const double v = e[std::size_t{l} * 2048 + k];
                    n += 1, m1 += v, m2 += v * v;
                }
        }
        const double snr = m1 / n / std::sqrt(m2 / n - m1 * m1 / n / n);
        MESSAGE("V10: ", row.per_cell, " scatterers per cell: SNR ", snr, ", expected ", row.snr);
        CHECK(snr == doctest::Approx(row.snr).epsilon(0.03).scale(1e-30));
    }
}

TEST_CASE("mean level falls with depth by the attenuation there and back") { // V6
    struct {
        float frequency, slope;
        medium tissue;
    } const rows[] = {{2.5_MHz, -2.5F, {1000, 1540, 50, 1, 1}},  {5_MHz, -5, {1000, 1540, 50, 1, 1}},
                      {7.5_MHz, -7.5F, {1000, 1540, 50, 1, 1}},  {2.5_MHz, -5.13F, {1000, 1580, 100, 1, 1}},
                      {5_MHz, -10.26F, {1000, 1580, 100, 1, 1}}, {7.5_MHz, -15.39F, {1000, 1580, 100, 1, 1}}};
    for (const auto& row : rows) {
        std::vector<double> power(2048, 0.0);
        for (std::uint32_t seed = 1; seed <= 12; ++seed) {
            const scene body = scene{row.tissue}.build(exec::seq);
            const linear_array probe{.lines = 192, .width = 60_mm, .frequency = row.frequency};
            const std::vector<double> e = speckle_test::envelope_of(
                body, probe, pose{}, {.depth = 60_mm, .samples = 2048},
                physical<>{.scattering = {.seed = seed}, .bandwidth = pulse_bandwidth::narrow});
            for (std::size_t i = 0; i < e.size(); ++i) power[i % 2048] += e[i] * e[i];
        }
        double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
        for (std::size_t k = 100; k < 1950; ++k) {
            const double x = (static_cast<double>(k) + 0.5) / 2048 * 6, y = 10 * std::log10(power[k]); // cm, dB
            n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
        }
        const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
        MESSAGE("V6 at ", row.frequency / 1e6F, " MHz: ", slope, " dB/cm, expected ", row.slope);
        CHECK(slope == doctest::Approx(static_cast<double>(row.slope)).epsilon(0.02).scale(1e-30));
    }
}
