#include <insonify/acoustics/tissue.hpp>
#include <insonify/doppler/colour_doppler.hpp>
#include <insonify/doppler/velocity_field.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/probe/linear_array.hpp>
#include <chrono>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <limits>
#include <numbers>

using namespace insonify;

namespace colour_doppler_test {
namespace {

const linear_array probe{.lines = 96, .width = 30_mm, .frequency = 5_MHz};

// A tube of 8 mm at an angle to the lines, 20 mm deep in the middle.
struct tube {
    scene body;
    vec3 along, middle{0, 0, 20_mm};
    poiseuille stream;
    float axial; // peak velocity along the lines

    /// @param surround  backscatter of the tissue around it
    tube(float angle, float peak, float surround) : body{tissue_of(surround)} {
        along = {std::sin(angle), 0, std::cos(angle)};
        axial = peak * std::cos(angle);
        stream = {.from = middle - 60_mm * along, .to = middle + 60_mm * along, .radius = 4_mm, .peak_velocity = peak};
        medium blood = tissue::blood;
        blood.sound_speed = display_speed; // so that scanner and field mean the same velocity
        stream.object = body.add(make_cylinder(stream.from, stream.to, 4_mm, 96), blood);
        body.build(exec::par);
    }
    static medium tissue_of(float backscatter) {
        medium around = tissue::liver;
        around.structure = {};
        around.backscatter = backscatter;
        around.sound_speed = display_speed;
        return around;
    }

    struct result {
        double mean = 0, flow = 0, deviation = 0;
    };
    /// Mean velocity over the round cross-section (away from the probe), and volume flow, from the velocities in the slice.
    result measure(doppler_settings settings, int frames) const {
        double sum = 0, area = 0, squares = 0, count = 0;
        for (int frame = 0; frame < frames; ++frame) {
            settings.time = 0.1F * static_cast<float>(frame);
            const flow_lines seen = colour_doppler(exec::par_unseq, body, probe, pose{}, stream, settings);
            for (std::uint32_t line = 0; line < seen.count; ++line)
                for (std::uint32_t k = 0; k < seen.samples; ++k) {
                    const vec3 point{((static_cast<float>(line) + 0.5F) / 96 - 0.5F) * 30_mm, 0,
                                     (static_cast<float>(k) + 0.5F) / static_cast<float>(seen.samples) * seen.depth};
                    const vec3 from_middle = point - middle;
                    const float r = length(from_middle - dot(from_middle, along) * along);
                    if (!(r < 4_mm) || point.z < 8_mm || point.z > 32_mm) continue;
                    const float away = -seen(line, k).velocity;
                    sum += static_cast<double>(r * away);
                    area += static_cast<double>(r);
                    squares += static_cast<double>(away * away);
                    count += 1;
                }
        }
        const double mean = sum / area;
        return {mean, mean / static_cast<double>(along.z) * std::numbers::pi * 16e-6, std::sqrt(squares / count)};
    }
};

} // namespace

TEST_CASE("colour Doppler: the mean velocity of Poiseuille flow at three angles and three speeds") {
    for (const float angle : {30_deg, 45_deg, 60_deg})
        for (const float peak : {0.05F, 0.2F, 0.8F}) {
            const tube t{angle, peak, 0};
            const float prf = 1.4F * 4 * probe.frequency * t.axial / display_speed;
            const double found = t.measure({.depth = 40_mm,
                                            .prf = prf,
                                            .ensemble = 12,
                                            .wall = {.type = wall_filter::kind::none},
                                            .average_length = 0.5_mm,
                                            .average_lines = 1,
                                            .burst = 1},
                                           2)
                                     .mean;
            const double expected = 0.5 * static_cast<double>(t.axial);
            MESSAGE(std::lround(angle * 180 / pi), " degrees, ", peak, " m/s: mean along the lines ", found,
                    " m/s, expected ", expected, " (", 100 * (found / expected - 1), " %)");
            CHECK(std::fabs(found / expected - 1) < 0.05);
        }
}

TEST_CASE("colour Doppler: volume flow by integration, beside tissue and after the wall filter") {
    for (const float angle : {30_deg, 45_deg}) {
        const tube t{angle, 0.4F, 1};
        const float prf = 1.4F * 4 * probe.frequency * t.axial / display_speed;
        const double found = t.measure({.depth = 40_mm,
                                        .prf = prf,
                                        .ensemble = 16,
                                        .wall = {.order = 0},
                                        .average_length = 0.5_mm,
                                        .average_lines = 1,
                                        .burst = 1},
                                       3)
                                 .flow,
                     expected = static_cast<double>(t.stream.volume_flow(0));
        MESSAGE(std::lround(angle * 180 / pi), " degrees: ", found * 1e6, " ml/s, expected ", expected * 1e6, " (",
                100 * (found / expected - 1), " %; the filter takes slow flow)");
        CHECK(std::fabs(found / expected - 1) < 0.1);
    }
}

TEST_CASE("colour Doppler: aliasing at exactly c0 prf / (4 f0)") {
    scene body{tube::tissue_of(1)};
    body.build(exec::par);
    const auto shown = [&](float velocity) {
        const auto field = [=](object_id, vec3, float) { return vec3{0, 0, -velocity}; }; // towards the probe
        const iq_ensemble echoes = doppler_ensemble(exec::par_unseq, body, probe, pose{}, field,
                                                    {.depth = 30_mm, .prf = 4_kHz, .pulses = 4, .burst = 24});
        autocorrelation all;
        for (const autocorrelation& each : autocorrelate(exec::par, echoes, 64, 64).values) {
            all.power += each.power;
            all.lag_one += each.lag_one;
        }
        return flow_of(all, max_doppler_velocity(4_kHz, 5_MHz)).velocity;
    };
    float below = 0.25F, above = 0.35F;
    CHECK(shown(below) > 0);
    CHECK(shown(above) < 0);
    for (int i = 0; i < 11; ++i) {
        const float middle = 0.5F * (below + above);
        (shown(middle) > 0 ? below : above) = middle;
    }
    const double expected = 1540.0 * 4e3 / (4 * 5e6);
    MESSAGE("the sign changes at ", above, " m/s, expected ", expected);
    CHECK(above == doctest::Approx(expected).epsilon(0.003).scale(1e-30));
    CHECK(shown(0.5F) == doctest::Approx(0.5 - 2 * expected).epsilon(0.01).scale(1e-30));
}

TEST_CASE("colour Doppler: flow across the lines has no mean velocity") {
    const tube t{90_deg, 0.4F, 0};
    const tube::result found = t.measure({.depth = 40_mm, .prf = 4_kHz, .ensemble = 12, .wall = {.order = 0}}, 4);
    MESSAGE("mean ", found.mean, " m/s, expected 0; rms of a sample ", found.deviation, " m/s of 0.4 m/s");
    CHECK(std::fabs(found.mean) < 0.01 * 0.4);
    CHECK(found.deviation < 0.1 * 0.4);
}

TEST_CASE("colour Doppler: walls that move at 1 cm/s are filtered to -40 dB") {
    const tube t{60_deg, 0, 1};
    const auto field = [&](object_id, vec3, float) { return vec3{0, 0, 0.01F}; };
    const ensemble_settings settings{.depth = 40_mm, .prf = 4_kHz, .pulses = 10, .noise_db = no_level_db};
    const iq_ensemble echoes = doppler_ensemble(exec::par_unseq, t.body, probe, pose{}, field, settings);
    const auto power_of = [](const iq_ensemble& of) {
        double sum = 0;
        for (const iq_lines& each : of.pulses)
            for (const vec2 value : each.values) sum += static_cast<double>(dot(value, value));
        return sum / static_cast<double>(of.pulses.size());
    };
    for (const wall_filter& filter :
         {wall_filter{.order = 2}, wall_filter{.type = wall_filter::kind::fir, .order = 6}}) {
        // What the filter leaves of the carrier's phasor.
        const std::vector<float> matrix = wall_filter_matrix(filter, 10);
        double left = 0;
        for (std::size_t j = 0; j < matrix.size() / 10; ++j) {
            std::complex<double> sum = 0;
            for (std::size_t k = 0; k < 10; ++k)
                sum += static_cast<double>(matrix[j * 10 + k]) *
                       std::polar(1.0, -4 * std::numbers::pi * 5e6 * 0.01 / 4e3 / 1540 * static_cast<double>(k));
            left += std::norm(sum) * 10 / static_cast<double>(matrix.size());
        }
        const double found =
            10 * std::log10(power_of(filter_walls(exec::par_unseq, echoes, filter)) / power_of(echoes));
        MESSAGE(std::string{filter.type == wall_filter::kind::fir ? "FIR" : "polynomial"}, ": ", found,
                " dB, expected about ", 10 * std::log10(left));
        if (filter.type == wall_filter::kind::polynomial) CHECK(found < -40);
        CHECK(found == doctest::Approx(10 * std::log10(left)).epsilon(0.06).scale(1e-30));
    }
}

TEST_CASE("colour Doppler: the box, threads, and memory that is kept do not change the velocities") {
    const tube t{45_deg, 0.3F, 1};
    doppler_settings settings{.depth = 40_mm};
    const flow_lines whole = colour_doppler(exec::par_unseq, t.body, probe, pose{}, t.stream, settings);
    CHECK(whole == colour_doppler(exec::unseq, t.body, probe, pose{}, t.stream, settings));
    CHECK(whole == colour_doppler(exec::par_unseq.threads(3), t.body, probe, pose{}, t.stream, settings));
    CHECK(whole.count == 96);
    CHECK(whole.max_velocity == doctest::Approx(0.308).scale(1e-30));

    settings.noise_db = no_level_db; // whose numbers are those of the traced lines
    const flow_lines all = colour_doppler(exec::par_unseq, t.body, probe, pose{}, t.stream, settings);
    settings.box = {.from = 12_mm, .to = 28_mm, .first_line = 30, .lines = 25};
    colour_scanner<> own;
    for (int repeat = 0; repeat < 2; ++repeat) {
        const flow_lines boxed = own.acquire(exec::par_unseq, t.body, probe, pose{}, physical{}, t.stream, settings);
        double worst = 0;
        bool outside_is_empty = true;
        for (std::uint32_t line = 0; line < 96; ++line)
            for (std::uint32_t k = 0; k < boxed.samples; ++k) {
                const float depth = (static_cast<float>(k) + 0.5F) / static_cast<float>(boxed.samples) * 40_mm;
                const bool inside = line >= 30 && line < 55 && depth >= 12_mm && depth <= 28_mm;
                if (!inside) outside_is_empty &= boxed(line, k) == flow_sample{};
                if (inside && all(line, k).power > 1e-11F)
                    worst = std::max(worst,
                                     static_cast<double>(std::fabs(boxed(line, k).velocity - all(line, k).velocity)));
            }
        MESSAGE("largest difference in the box ", worst, " m/s, expected below 0.01");
        CHECK(worst < 0.01);
        CHECK(outside_is_empty);
    }
}

// A row of parallel lines that states no more than a tracer needs.
struct bare_probe {
    std::uint32_t lines = 96;
    float frequency = 5_MHz;

    void check() const {}
    ray beam(float line) const { return {{(line - 47.5F) * 0.25_mm, 0, 0}, {0, 0, 1}}; }
    vec2 locate(vec2 point) const { return {point.x / 0.25_mm + 47.5F, point.y}; }
};

TEST_CASE("colour Doppler: the box does not move the focus of a probe that states none") {
    const tube t{45_deg, 0.3F, 1};
    doppler_settings settings{.depth = 40_mm, .noise_db = no_level_db};
    const flow_lines all = colour_doppler(exec::par_unseq, t.body, bare_probe{}, pose{}, t.stream, settings);
    settings.box = {.from = 10_mm, .to = 22_mm};
    const flow_lines boxed = colour_doppler(exec::par_unseq, t.body, bare_probe{}, pose{}, t.stream, settings);
    double worst = 0;
    for (std::uint32_t line = 8; line < 88; ++line)
        for (std::uint32_t k = 0; k < boxed.samples; ++k)
            if (boxed(line, k).power > 1e-11F)
                worst = std::max(
                    worst, std::fabs(10 * std::log10(static_cast<double>(boxed(line, k).power / all(line, k).power))));
    MESSAGE("largest difference in the box ", worst, " dB, expected below 0.2");
    CHECK(worst < 0.2);
}

TEST_CASE("colour Doppler: settings out of range are refused") {
    const tube t{45_deg, 0.3F, 1};
    const auto attempt = [&](const doppler_settings& settings) {
        colour_doppler(exec::seq, t.body, probe, pose{}, t.stream, settings);
    };
    CHECK_THROWS_AS(attempt({.ensemble = 1, .wall = {.type = wall_filter::kind::none}}), usage_error);
    CHECK_THROWS_AS(attempt({.average_length = -1}), usage_error);
    CHECK_THROWS_WITH(attempt({.box = {.first_line = 90, .lines = 7}}),
                      "colour_doppler: the box must lie in the 96 lines of the probe; lower `first_line` or `lines`");
    CHECK_THROWS_AS(attempt({.box = {.from = 30_mm, .to = 20_mm}}), usage_error);
    CHECK_THROWS_AS(attempt({.box = {.to = 1}}), usage_error);
    CHECK_THROWS_AS(attempt({.wall = {.order = 7}}), usage_error);
    CHECK_THROWS_AS(attempt({.average_length = 1e30F}), usage_error);
    for (const float burst : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0F})
        CHECK_THROWS_WITH(attempt({.burst = burst}),
                          "pulse: `burst` must be a finite number of cycles, or 0 for impulse excitation");
}

} // namespace colour_doppler_test
