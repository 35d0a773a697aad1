#include <insonify/acoustics/physical.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/tracing/trace.hpp>
#include "speckle_frames.hpp"
#include <doctest/doctest.h>

using namespace insonify;

namespace speckle_test {
namespace {

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const auto n = static_cast<double>(a.size());
    double ma = 0, mb = 0, ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) ma += a[i] / n, mb += b[i] / n;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ab += (a[i] - ma) * (b[i] - mb);
        aa += (a[i] - ma) * (a[i] - ma);
        bb += (b[i] - mb) * (b[i] - mb);
    }
    return ab / std::sqrt(aa * bb);
}

// Values of a frame at another place: `lines` further along the array, `depth` metres deeper; only what stays inside.
struct frame {
    std::vector<double> values;
    std::uint32_t lines, samples;
    double depth;

    double at(std::uint32_t line, double sample) const { // linear along the line
        const auto below = static_cast<std::uint32_t>(sample);
        const double fraction = sample - below;
        const std::size_t i = std::size_t{line} * samples + below;
        return (1 - fraction) * values[i] + fraction * values[i + 1];
    }
};

double shifted_correlation(const frame& before, const frame& after, std::uint32_t line_shift, double depth_shift) {
    const double shift = depth_shift / before.depth * before.samples;
    std::vector<double> a, b;
    for (std::uint32_t line = 20; line + line_shift + 20 < before.lines; ++line)
        for (double sample = 200; sample + shift + 200 < before.samples; sample += 3) {
            a.push_back(before.at(line + line_shift, sample + shift));
            b.push_back(after.at(line, sample));
        }
    return correlation(a, b);
}

} // namespace
} // namespace speckle_test

TEST_CASE("speckle moves with the tissue: axially, laterally, near and far") {
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    const object_id tissue_id =
        body.add(make_box({-60_mm, -20_mm, -20_mm}, {60_mm, 20_mm, 80_mm}), speckle_test::silent);
    body.build(exec::par);
    constexpr float pitch = 5_mm / 71; // 70.4 um: a line a shift
    const linear_array probe{.lines = 256, .width = 256 * pitch, .frequency = 7.5_MHz};
    const acquisition scan{.depth = 30_mm, .samples = 3000};
    const auto seen = [&](vec3 moved) {
        body.place(tissue_id, {.translation = moved});
        return speckle_test::frame{speckle_test::envelope_of(body, probe, pose{}, scan), 256, 3000, 30e-3};
    };
    const speckle_test::frame rest = seen({0, 0, 0});
    for (const float axial : {13_um, 0.5_mm, 5_mm}) {
        const double found =
            speckle_test::shifted_correlation(rest, seen({0, 0, -axial}), 0, static_cast<double>(axial));
        MESSAGE("axial ", axial * 1e3F, " mm: correlation ", found);
        CHECK(found > 0.95);
    }
    for (const std::uint32_t lines : {1U, 71U}) {
        const double found =
            speckle_test::shifted_correlation(rest, seen({-static_cast<float>(lines) * pitch, 0, 0}), lines, 0);
        MESSAGE("lateral ", static_cast<float>(lines) * pitch * 1e3F, " mm: correlation ", found);
        CHECK(found > 0.95);
    }
    CHECK(speckle_test::shifted_correlation(rest, rest, 8, 0) < 0.5); // 0.56 mm aside is other tissue
    CHECK(seen({0, 0, 0}).values == rest.values);
}

TEST_CASE("lines half a beam apart: speckle moves with the tissue by whole lines") {
    scene body{medium{.density = 1000, .sound_speed = 1540}};
    const object_id tissue_id =
        body.add(make_box({-60_mm, -20_mm, -20_mm}, {60_mm, 20_mm, 80_mm}), speckle_test::silent);
    body.build(exec::par);
    const linear_array probe{.lines = 200, .width = 200 * 0.15_mm, .frequency = 7.5_MHz};
    const acquisition scan{.depth = 30_mm, .samples = 2048};
    const auto seen = [&](vec3 moved) {
        body.place(tissue_id, {.translation = moved});
        return speckle_test::frame{speckle_test::envelope_of(body, probe, pose{}, scan), 200, 2048, 30e-3};
    };
    const speckle_test::frame rest = seen({0, 0, 0});
    const double found = speckle_test::shifted_correlation(rest, seen({-20 * 0.15_mm, 0, 0}), 20, 0);
    MESSAGE("3 mm aside: correlation ", found);
    CHECK(found > 0.95);
}

TEST_CASE("speckle is as wide as the beam, and slides with it: across the lines and out of the slice") {
    // Speckle behind a Gaussian beam of standard deviation sigma: the correlation at a distance d is
    // exp(-d^2 / (4 sigma^2)), between lines of one frame and between frames of a probe that slid by d.
    const scene body = scene{speckle_test::silent}.build(exec::seq);
    struct {
        float frequency, spacing;
    } const rows[] = {{3.5_MHz, 0.2_mm}, {5_MHz, 0.2_mm},   {5_MHz, 0.1_mm}, {7.5_MHz, 0.198_mm},
                      {7.5_MHz, 0.1_mm}, {12_MHz, 0.15_mm}, {12_MHz, 0.1_mm}};
    for (const auto& row : rows) {
        constexpr std::uint32_t lines = 192, samples = 1024;
        const linear_array probe{
            .lines = lines, .width = lines * row.spacing, .frequency = row.frequency, .focus = 20_mm};
        constexpr float depth = 25_mm;
        const auto first = static_cast<std::uint32_t>(18_mm / depth * samples),
                   last = static_cast<std::uint32_t>(22_mm / depth * samples);
        const float sigma = beam_of(probe, depth).lateral_sigma(20_mm);
        const auto seen = [&](std::uint32_t seed, vec3 moved) {
            return convolve(exec::par_unseq,
                            trace(exec::par_unseq, body, probe, {.translation = moved},
                                  physical<>{.scattering = {.seed = seed}}, {.depth = depth, .samples = samples}),
                            pulse{}, probe);
        };
        double power = 0, slid[2] = {}, across[12] = {};
        const float slides[] = {1.1774F * sigma, 2.3548F * sigma}; // half a width and a width
        for (std::uint32_t seed = 1; seed <= 16; ++seed) {
            const iq_lines rest = seen(seed, {0, 0, 0});
            const iq_lines moved[] = {seen(seed, {slides[0], 0, 0}), seen(seed, {slides[1], 0, 0})};
            for (std::uint32_t line = 20; line < lines - 20; ++line)
                for (std::uint32_t k = first; k < last; ++k) {
                    const vec2 here = rest(line, k);
                    power += static_cast<double>(dot(here, here));
                    for (int i = 0; i < 2; ++i) slid[i] += static_cast<double>(dot(here, moved[i](line, k)));
                    for (std::uint32_t lag = 1; lag < 12; ++lag)
                        across[lag] += static_cast<double>(dot(here, rest(line + lag, k)));
                }
        }
        // The width at half the height, interpolated as that of the expected curve is.
        const auto half_width = [&](const auto& correlation) {
            std::uint32_t lag = 1;
            while (lag < 11 && correlation(lag) > 0.5) ++lag;
            const double above = correlation(lag - 1), below = correlation(lag);
            return lag - 1 + (above - 0.5) / (above - below);
        };
        const auto expected = [&](double lag) {
            return std::exp(-std::pow(lag * static_cast<double>(row.spacing / sigma), 2) / 4);
        };
        const double wider = half_width([&](std::uint32_t lag) { return lag == 0 ? 1 : across[lag] / power; }) /
                             half_width([&](std::uint32_t lag) { return expected(lag); });
        MESSAGE((row.frequency / 1e6F), " MHz, lines ", (row.spacing * 1e3F), " mm apart: width ", wider,
                " of the beam's; slid by half a width and one: ", (slid[0] / power), " (0.707), ", (slid[1] / power),
                " (0.250)");
        // At 12 MHz a cell is 2.2 standard deviations of the beam, more than its page allows.
        const bool coarse = row.frequency > 10_MHz;
        CHECK(std::fabs(wider - 1) < (coarse ? 0.12 : 0.03));
        CHECK(std::fabs(slid[0] / power / 0.7071 - 1) < 0.1);
        CHECK(std::fabs(slid[1] / power / 0.25 - 1) < (coarse ? 0.3 : 0.1));
    }
}

TEST_CASE("a hand that is not quite still keeps its speckle: turned by a tenth of a degree, on any probe") {
    const scene body = scene{speckle_test::silent}.build(exec::seq);
    const auto kept = [&](const auto& probe, const pose& turned) {
        const acquisition scan{.depth = 40_mm, .samples = 2048};
        return speckle_test::correlation(speckle_test::envelope_of(body, probe, pose{}, scan),
                                         speckle_test::envelope_of(body, probe, turned, scan));
    };
    const float turn = 0.1_deg;
    const pose rocked = look_at({0, 0, 0}, {0, std::sin(turn), std::cos(turn)}, {1, 0, 0}),
               swept = look_at({0, 0, 0}, {0, 0, 1}, {std::cos(turn), std::sin(turn), 0});
    const linear_array linear{.lines = 256, .width = 38_mm, .frequency = 7.5_MHz};
    const convex_array convex{.lines = 192, .frequency = 3.5_MHz};
    const double figures[] = {kept(linear, rocked), kept(convex, rocked), kept(linear, swept), kept(convex, swept)};
    MESSAGE("rocked: linear ", figures[0], ", convex ", figures[1], "; swept: linear ", figures[2], ", convex ",
            figures[3]);
    for (const double figure : figures) CHECK(figure > 0.85);
}

TEST_CASE("a convex probe that slides half a line sees most of its speckle slide") {
    const scene body = scene{speckle_test::silent}.build(exec::seq);
    const convex_array probe{.lines = 384, .radius = 60_mm, .field_of_view = 60_deg, .frequency = 3.5_MHz};
    const acquisition scan{.depth = 60_mm, .samples = 2048};
    const auto frame_at = [&](float aside) {
        return speckle_test::frame{speckle_test::envelope_of(body, probe, {.translation = {aside, 0, 0}}, scan), 384,
                                   2048, 60e-3};
    };
    const speckle_test::frame rest = frame_at(0), slid = frame_at(0.35_mm);
    // Where the lines are 0.35 mm apart (67 mm from their centre, less the radius: 134 / 120 of it) a line has become
    // its neighbour in place, if not in direction.
    std::vector<double> there, here;
    for (std::uint32_t line = 120; line < 264; ++line)
        for (std::uint32_t k = 2048 * 5 / 60; k < 2048 * 30 / 60; ++k) {
            const double pitch = 60e-3 * 60 / 57.2958 / 384 * (60e-3 + (k + 0.5) / 2048 * 60e-3) / 60e-3;
            if (std::fabs(pitch - 0.175e-3) > 0.01e-3 && std::fabs(pitch - 0.35e-3) > 0.01e-3) continue;
            const std::uint32_t lines = pitch < 0.25e-3 ? 2 : 1;
            there.push_back(rest.values[std::size_t{line + lines} * 2048 + k]);
            here.push_back(slid.values[std::size_t{line} * 2048 + k]);
        }
    const double found = speckle_test::correlation(there, here);
    MESSAGE("slid by 0.35 mm: correlation ", found, " of ", there.size());
    CHECK(found > 0.7);
}

TEST_CASE("compressed tissue takes its speckle with it") {
    scene body = scene{speckle_test::silent}.build(exec::seq);
    const linear_array probe{.lines = 128, .width = 15_mm, .frequency = 7.5_MHz};
    const acquisition scan{.depth = 30_mm, .samples = 3000};
    const auto frame_of = [&] {
        return speckle_test::frame{speckle_test::envelope_of(body, probe, pose{}, scan), 128, 3000, 30e-3};
    };
    const auto rest = frame_of();
    body.deform(exec::par, [](vec3 p) { return vec3{p.x, p.y, 0.95F * p.z}; }); // by 5 % towards the probe
    const auto pressed = frame_of();
    // Patch by patch: what was at depth z is now at 0.95 z; within a patch the phases of the echoes drift apart slowly.
    double worst = 1;
    for (double z = 4e-3; z < 26e-3; z += 2e-3) {
        std::vector<double> a, b;
        for (std::uint32_t line = 10; line < 118; ++line)
            for (double offset = -0.1e-3; offset <= 0.1e-3; offset += 20e-6) {
                a.push_back(rest.at(line, (z + offset) / 30e-3 * 3000));
                b.push_back(pressed.at(line, (0.95 * (z + offset)) / 30e-3 * 3000));
            }
        worst = std::min(worst, speckle_test::correlation(a, b));
    }
    MESSAGE("least correlation of a patch ", worst);
    CHECK(worst > 0.8);
}
