#include <insonify/acoustics/physical.hpp>
#include <insonify/b_mode.hpp>
#include <insonify/core/error.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/signal/kernel/kernel_table.hpp>
#include <insonify/tracing/trace.hpp>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace side_lobes_test {
namespace {

constexpr float rectangular = 0.047F; // of sinc^2: -26.5 dB
constexpr medium scatterers{.density = 1000, .sound_speed = 1540, .backscatter = 1},
    anechoic{.density = 1000, .sound_speed = 1540}, dense{.density = 1200, .sound_speed = 1540};
constexpr linear_array with_lobes{
    .lines = 384, .frequency = 7.5_MHz, .focus = 30_mm, .elevation_focus = 30_mm, .side_lobes = rectangular};
constexpr float image_depth = 60_mm;
constexpr std::uint32_t samples = 2048;
// Side lobes are finer than the main lobe, so cells are smaller than by default: midway, in ratio, between the limits of
// `cell_field::cell`, which are the spacing of the lines and two standard deviations of the beam.
constexpr float cell = 0.18_mm;

double decibels(double power) { return 10 * std::log10(std::max(power, 1e-10)); }

iq_lines seen(const scene& body, const auto& probe, std::uint32_t planes, std::uint32_t seed = 1) {
    return convolve(exec::par_unseq,
                    trace(exec::par_unseq, body, probe, pose{}, physical<>{.scattering = {.seed = seed, .cell = cell}},
                          {.depth = image_depth, .samples = samples, .planes = planes}),
                    pulse{}, probe);
}

/// Echo power that reaches the points of an anechoic sphere, over that of the same tissue without one: a sum of waves.
///
/// Two-way field at the focus of a rectangular aperture, (sum over elements of exp(-j k r))^2 in the slice times the Fresnel
/// sum in elevation, over the spectrum of a pulse; its energy over the points outside the sphere, and over all. Lengths in
/// mm, times in us.
struct wave_sum {
    static constexpr double speed = 1.54, carrier = 7.5, focus = 30, width = 15, height = 5, bandwidth = 0.644;
    static constexpr int across = 80, along = 61, out = 40, waves = 48, elements = 100, rows = 40;
    static constexpr double dx = 0.075, dz = 0.08, dy = 0.13;
    std::vector<double> energy = std::vector<double>(std::size_t{across} * along * out);

    explicit wave_sum(double elevation_focus) {
        using wave = std::complex<double>;
        const auto frequency = [](int i) { return 1.5 + 12.0 * (i + 0.5) / waves; };
        std::vector<wave> above(std::size_t{out} * waves);
        for (int k = 0; k < along; ++k) {
            const double z = focus + (k - along / 2) * dz;
            for (int j = 0; j < out; ++j)
                for (int i = 0; i < waves; ++i) {
                    wave sum = 0;
                    for (int row = 0; row < rows; ++row) {
                        const double y = (j + 0.5) * dy, from = ((row + 0.5) / rows - 0.5) * height;
                        const double further = (y - from) * (y - from) / (2 * z) - from * from / (2 * elevation_focus);
                        sum += std::polar(1.0, -2 * 3.14159265358979 * frequency(i) / speed * further);
                    }
                    above[static_cast<std::size_t>(j * waves + i)] = sum * sum;
                }
            for (int n = 0; n < across; ++n) {
                wave field[waves] = {};
                for (int e = 0; e < elements; ++e) {
                    const double from = ((e + 0.5) / elements - 0.5) * width;
                    const double turns = (std::hypot((n + 0.5) * dx - from, z) - std::hypot(from, focus)) / speed;
                    wave now = std::polar(1.0, -2 * 3.14159265358979 * frequency(0) * turns);
                    const wave step = std::polar(1.0, -2 * 3.14159265358979 * 12.0 / waves * turns);
                    for (wave& one : field) one += now, now *= step;
                }
                for (int j = 0; j < out; ++j) {
                    wave sum = 0;
                    for (int i = 0; i < waves; ++i) {
                        const double off = (frequency(i) - carrier) / (bandwidth * carrier / 2.3548);
                        sum += std::exp(-0.5 * off * off) * field[i] * field[i] *
                               above[static_cast<std::size_t>(j * waves + i)];
                    }
                    energy[static_cast<std::size_t>((n * along + k) * out + j)] = std::norm(sum);
                }
            }
        }
    }

    /// Mean over the points of the slice within a distance of the middle of the sphere.
    double fill(double radius, double within) const {
        double outside = 0, all = 0;
        for (double x = -within; x <= within + 1e-9; x += within / 3)
            for (double z = -within; z <= within + 1e-9; z += within / 3) {
                if (x * x + z * z > within * within) continue;
                for (int n = -across; n < across; ++n)
                    for (int k = 0; k < along; ++k)
                        for (int j = 0; j < out; ++j) {
                            const double e =
                                energy[static_cast<std::size_t>(((n < 0 ? -1 - n : n) * along + k) * out + j)];
                            const double px = (n + 0.5) * dx + x, pz = (k - along / 2) * dz + z, py = (j + 0.5) * dy;
                            all += e;
                            if (px * px + py * py + pz * pz > radius * radius) outside += e;
                        }
            }
        return outside / all;
    }
};

} // namespace
} // namespace side_lobes_test

TEST_CASE(
    "the first side lobe of a rectangular aperture is 26.5 dB below the main lobe, and there are none by default") {
    using namespace side_lobes_test;
    double highest = 0; // of sinc^2, behind its first zero
    for (double u = 1; u < 2; u += 1e-4)
        highest = std::max(highest, std::pow(std::sin(3.14159265358979 * u) / (3.14159265358979 * u), 2));
    const beam_model beam = beam_of(with_lobes, image_depth);
    const auto first = static_cast<double>(-beam.side_lobe(1.43F));
    MESSAGE("first side lobe: ", 2 * decibels(first), " dB, expected ", 2 * decibels(highest));
    CHECK(std::fabs(first / highest - 1) < 0.01);
    // In the weights: at the line that is nearest to it.
    const detail::lateral_kernel kernel =
        detail::make_lateral_kernel(with_lobes, {.depth = image_depth, .samples = samples});
    const detail::lateral_weights focus = detail::weights_at(kernel, samples / 2);
    const auto nearest = static_cast<std::size_t>(1.43F * beam.side_lobe_width(30_mm) / focus.spacing + 0.5F);
    const auto weight = static_cast<double>(std::fabs(focus.half[nearest] / focus.half[0]));
    MESSAGE("weight of the line there: ", 2 * decibels(weight), " dB");
    CHECK(std::fabs(2 * decibels(weight) - 2 * decibels(highest)) < 1);
    linear_array none = with_lobes;
    none.side_lobes = linear_array{}.side_lobes;
    CHECK(detail::make_lateral_kernel(none, {.depth = image_depth, .samples = samples}).half_width() < 12);
}

TEST_CASE("an anechoic sphere of 5 mm is filled by the side lobes as in a sum of waves") {
    using namespace side_lobes_test;
    const double radius = 2.5, within = 1.25; // mm
    scene cyst{scatterers};
    cyst.add(make_sphere({0, 0, 30_mm}, 2.5_mm, 5), anechoic);
    cyst.build(exec::par);
    const scene none = scene{scatterers}.build(exec::par);
    const double expected = decibels(wave_sum{30}.fill(radius, within));
    const auto measured = [&](const linear_array& probe) {
        double inside = 0, full = 0;
        for (std::uint32_t seed = 1; seed <= 40; ++seed) {
            const iq_lines dark = seen(cyst, probe, 5, seed), bright = seen(none, probe, 5, seed);
            for (std::uint32_t line = 0; line < probe.lines; ++line)
                for (std::uint32_t k = 0; k < samples; ++k) {
                    const double x = 1e3 * static_cast<double>(probe.beam(static_cast<float>(line)).origin.x),
                                 z = 60 * (k + 0.5) / samples - 30;
                    if (x * x + z * z > within * within) continue;
                    inside += static_cast<double>(dot(dark(line, k), dark(line, k)));
                    full += static_cast<double>(dot(bright(line, k), bright(line, k)));
                }
        }
        return decibels(inside / full);
    };
    linear_array smooth = with_lobes;
    smooth.side_lobes = 0;
    const double found = measured(with_lobes), without = measured(smooth);
    MESSAGE("sphere of 5 mm, 30 mm deep, 7.5 MHz, F/2: ", found, " dB, expected ", expected,
            " (other simulation: -28.2)", "; without side lobes ", without);
    CHECK(std::fabs(found - expected) < 0.6);
    CHECK(std::fabs(found + 28.2) < 0.5);
    CHECK(without < -40);
}

TEST_CASE("with side lobes, tissue and plates keep their levels on every probe") {
    using namespace side_lobes_test;
    const scene tissue = scene{scatterers}.build(exec::par);
    const auto check = [&](auto probe, std::uint32_t planes) {
        probe.side_lobes = rectangular;
        double worst = 0;
        constexpr std::uint32_t seeds = 12;
        double level[5] = {};
        for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
            const iq_lines lines = seen(tissue, probe, planes, seed);
            for (std::uint32_t i = 0; i < 5; ++i)
                for (std::uint32_t line = 0; line < lines.count; ++line)
                    for (std::uint32_t k = (i + 1) * samples / 6 - 80; k < (i + 1) * samples / 6 + 80; ++k)
                        level[i] += static_cast<double>(dot(lines(line, k), lines(line, k))) /
                                    (160.0 * static_cast<double>(lines.count) * seeds);
        }
        for (const double one : level) worst = std::max(worst, std::fabs(decibels(one) + 55));
        MESSAGE(probe.lines, " lines, ", planes, " planes: tissue within ", worst, " dB of its level");
        CHECK(worst < 0.4);
    };
    check(linear_array{}, 1);
    check(linear_array{}, 5);
    check(convex_array{.lines = 128}, 1);
    check(phased_array{}, 1);
    check(radial_array{.lines = 256, .radius = 5_mm, .frequency = 7.5_MHz}, 1);

    scene plate{anechoic};
    plate.add(make_box({-60_mm, -60_mm, 30_mm}, {60_mm, 60_mm, 90_mm}), dense);
    plate.build(exec::par);
    linear_array probe{.lines = 192};
    const iq_lines smooth = seen(plate, probe, 1);
    probe.side_lobes = rectangular;
    const iq_lines lobes = seen(plate, probe, 1);
    float worst = 0, largest = 0;
    for (std::size_t i = 0; i < smooth.values.size(); ++i) {
        worst = std::max(worst, length(lobes.values[i] - smooth.values[i]));
        largest = std::max(largest, length(smooth.values[i]));
    }
    MESSAGE("plate: ", largest, ", with side lobes the same within ", worst);
    CHECK(worst < 1e-5F * largest);
}

TEST_CASE("side lobes reach b_mode by the probe, and their amplitude is checked") {
    using namespace side_lobes_test;
    scene cyst{scatterers};
    cyst.add(make_sphere({0, 0, 20_mm}, 4_mm, 4), anechoic);
    cyst.build(exec::par);
    const b_mode_settings settings{.depth = 40_mm, .size = {128, 0}};
    const linear_array none{.lines = 128}, some{.lines = 128, .side_lobes = rectangular};
    CHECK_FALSE(b_mode(exec::par, cyst, some, pose{}, settings) == b_mode(exec::par, cyst, none, pose{}, settings));
    for (const float wrong : {-0.1F, 0.3F, std::nanf("")})
        CHECK_THROWS_AS(linear_array{.side_lobes = wrong}.check(), usage_error);
}
