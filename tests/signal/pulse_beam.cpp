#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/signal/pulse.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

namespace beam_test {
namespace {

struct bare_probe {
    std::uint32_t lines = 3;
    float frequency = 5_MHz;
    ray beam(float line) const { return {.origin = {(line - 1) * 1_mm, 0, 0}}; }
    vec2 locate(vec2 point) const { return {point.x / 1_mm + 1, point.y}; }
    void check() const {}
};

} // namespace

TEST_CASE("beam: the width at the focus is that of independent simulations") { // V12, V13
    struct {
        float fnumber, frequency;
        double own, py_must; // mm: a Rayleigh integral in three dimensions, and PyMUST
    } const rows[] = {{2, 5_MHz, 0.571, 0.577},
                      {2, 7.5_MHz, 0.389, 0.391},
                      {2.94F, 5_MHz, 0.822, 0.832},
                      {2.94F, 7.5_MHz, 0.554, 0.561}};
    for (const auto& row : rows) {
        const linear_array probe{.frequency = row.frequency, .fnumber = row.fnumber, .focus = 30_mm};
        const double width = 1e3 * static_cast<double>(beam_of(probe, 60_mm).lateral_width(30_mm));
        MESSAGE("F/", row.fnumber, ", ", (row.frequency * 1e-6F), " MHz: ", width, " mm; expected ", row.own, ", ",
                row.py_must);
        CHECK(width == doctest::Approx(row.own).epsilon(0.05).scale(1e-30));
        CHECK(width == doctest::Approx(row.py_must).epsilon(0.05).scale(1e-30));
    }
}

TEST_CASE("beam: the width away from the focus follows a simulated array that receives at constant F/2") {
    struct {
        float depth;
        double simulated; // mm
    } const rows[] = {{14, 0.7921}, {18, 0.7839}, {22, 0.8312}, {24, 0.8435}, {26, 0.6499}, {28, 0.5596}, {30, 0.5591},
                      {32, 0.5929}, {34, 0.6409}, {36, 0.7162}, {40, 0.8324}, {44, 0.8202}, {48, 0.7730}, {50, 0.7679}};
    const beam_model beam = beam_of(linear_array{.frequency = 5_MHz, .focus = 30_mm}, 60_mm);
    double worst = 0;
    for (const auto& row : rows) {
        const double width = 1e3 * static_cast<double>(beam.lateral_width(row.depth * 1_mm));
        worst = std::max(worst, std::fabs(width / row.simulated - 1));
    }
    MESSAGE("furthest from the simulation: ", 100 * worst, " %");
    CHECK(worst < 0.1);
}

namespace {

// -6 dB width of the two-way field at a depth, mm: sums over all elements at every frequency of the pulse, the transmit
// aperture focused at `focus`, the receive aperture at each depth; the peak of the envelope over time. Metres, hertz.
double simulated_width(double frequency, double fnumber, double focus, double depth) {
    using complex = std::complex<double>;
    constexpr double speed = 1540, pi_exact = 3.14159265358979;
    const double wavelength = speed / frequency, sigma = 0.6 * frequency / 2.3548;
    constexpr int frequencies = 25, times = 101;
    const auto field = [&](double x, double aperture, double focused, double f) {
        const int elements = std::max(3, static_cast<int>(std::lround(aperture / (wavelength / 2.2))));
        complex sum = 0;
        for (int i = 0; i < elements; ++i) {
            const double u = (i - (elements - 1) / 2.0) * aperture / elements, path = std::hypot(x - u, depth);
            sum += std::polar(1 / path, -2 * pi_exact * f / speed * (path - depth - std::hypot(u, focused) + focused));
        }
        return sum;
    };
    const auto peak = [&](double x) {
        complex spectrum[frequencies];
        double offset[frequencies], largest = 0;
        for (int i = 0; i < frequencies; ++i) {
            offset[i] = (2.0 * i / (frequencies - 1) - 1) * 2.5 * sigma;
            const double f = frequency + offset[i];
            spectrum[i] = std::exp(-offset[i] * offset[i] / (2 * sigma * sigma)) * field(x, focus / fnumber, focus, f) *
                          field(x, depth / fnumber, depth, f);
        }
        for (int t = 0; t < times; ++t) {
            const double time = (t - (times - 1) / 2.0) * 0.15 / frequency;
            complex sum = 0;
            for (int i = 0; i < frequencies; ++i) sum += spectrum[i] * std::polar(1.0, 2 * pi_exact * offset[i] * time);
            largest = std::max(largest, std::abs(sum));
        }
        return largest;
    };
    const double middle = peak(0), step = 0.04 * wavelength * fnumber;
    double before = middle;
    for (double x = step;; x += step) {
        const double here = peak(x);
        if (here < 0.5 * middle) return 2e3 * (x - step + step * (before - 0.5 * middle) / (before - here));
        before = here;
    }
}

} // namespace

TEST_CASE("beam: the width at any depth is that of a simulated array within a tenth, from F/2 to F/4") {
    for (const float fnumber : {2.0F, 3.0F, 4.0F}) {
        const beam_model beam = beam_of(linear_array{.frequency = 5_MHz, .fnumber = fnumber, .focus = 30_mm}, 60_mm);
        for (int depth = 14; depth <= 50; depth += 4) {
            const double expected = simulated_width(5e6, static_cast<double>(fnumber), 30e-3, depth * 1e-3);
            const double width = 1e3 * static_cast<double>(beam.lateral_width(static_cast<float>(depth) * 1_mm));
            MESSAGE("F/", fnumber, ", ", depth, " mm: ", width, " mm (expected ", expected, " mm)");
            CHECK(std::fabs(width / expected - 1) < 0.1);
        }
    }
}

TEST_CASE("beam: the active aperture grows with depth up to its limit") {
    const linear_array probe{.width = 20_mm, .frequency = 5_MHz, .fnumber = 2, .focus = 10_mm};
    const beam_model beam = beam_of(probe, 100_mm);
    CHECK(beam.fnumber(10_mm) == 2);
    CHECK(beam.fnumber(40_mm) == doctest::Approx(2).scale(1e-30));
    CHECK(beam.fnumber(100_mm) == doctest::Approx(5).scale(1e-30));
    // Far from the focus the factor k of the width is 1.26.
    const beam_model deep =
        beam_of(linear_array{.width = 20_mm, .frequency = 15_MHz, .fnumber = 2, .focus = 30_mm}, 0.3F);
    CHECK(deep.lateral_width(300_mm) == doctest::Approx(1.26 * 0.102667e-3 * 15).epsilon(1e-3).scale(1e-30));
    CHECK(deep.lateral_sigma(300_mm) ==
          doctest::Approx(1.26 * 0.102667e-3 * 15 / std::sqrt(8 * std::log(2.0))).epsilon(1e-3).scale(1e-30));
    const convex_array convex{.radius = 60_mm, .field_of_view = 60_deg};
    CHECK(beam_of(convex, 0.1F).aperture == doctest::Approx(60e-3 * std::acos(-1.0) / 3).scale(1e-30));
    CHECK(beam_of(phased_array{.width = 15_mm}, 0.1F).aperture == 15_mm);
}

TEST_CASE("beam: a focus of 0 is half the image depth") {
    CHECK(beam_of(linear_array{}, 80_mm).focus == 40_mm);
    CHECK(beam_of(linear_array{.focus = 18_mm}, 80_mm).focus == 18_mm);
}

TEST_CASE("beam: the slice is thinnest at the elevation focus and spreads like the geometric shadow of the aperture") {
    const beam_model beam =
        beam_of(linear_array{.frequency = 5_MHz, .elevation_height = 5_mm, .elevation_focus = 20_mm}, 60_mm);
    CHECK(beam.elevation_fnumber() == doctest::Approx(4).scale(1e-30));
    CHECK(beam.elevation_sigma(20_mm) == doctest::Approx(0.92 * 0.308e-3 * 4 / 2.3548).scale(1e-30));
    for (const float depth : {5_mm, 60_mm}) { // a uniform shadow of width w has the deviation w / sqrt(12)
        const double shadow = 5e-3 * std::fabs(1 - static_cast<double>(depth) / 20e-3) / std::sqrt(12.0);
        const double focal = 0.92 * 0.308e-3 * 4 / 2.3548;
        CHECK(beam.elevation_sigma(depth) == doctest::Approx(std::hypot(shadow, focal)).epsilon(2e-3).scale(1e-30));
    }
}

TEST_CASE("beam: a probe without optional members has the default beam") {
    const beam_model beam = beam_of(bare_probe{}, 80_mm);
    CHECK(beam.fnumber(10) == 2);
    CHECK(beam.focus == 40_mm);
    CHECK(beam.wavelength == doctest::Approx(0.308e-3).scale(1e-30));
    CHECK(beam.elevation_fnumber() == doctest::Approx(4).scale(1e-30));
}

TEST_CASE("beam: a probe without `elevation_height` has the default slice thickness, not zero") {
    struct with_height : bare_probe {
        float elevation_height = 5_mm, elevation_focus = 20_mm;
    };
    for (const float depth : {1_mm, 20_mm, 60_mm}) {
        const float sigma = beam_of(bare_probe{}, 80_mm).elevation_sigma(depth);
        CHECK(sigma > 0.1_mm);
        CHECK(sigma == beam_of(with_height{}, 80_mm).elevation_sigma(depth));
    }
}

TEST_CASE("beam: the members of a user's probe are checked, even where its own `check` accepts anything") {
    struct flat : bare_probe {
        float elevation_height = 0;
    };
    struct slow : bare_probe {
        slow() { frequency = 5; }
    };
    CHECK_THROWS_WITH_AS(beam_of(flat{}, 80_mm), "probe: elevation_height is 0 m; it must be from 1 nm to 1 m",
                         usage_error);
    CHECK_THROWS_WITH_AS(beam_of(slow{}, 80_mm), "probe: frequency is 5 Hz: did you mean 5_MHz?", usage_error);
    CHECK_THROWS_WITH_AS(beam_of(bare_probe{}, 80), "beam_of: depth is 80 m: did you mean 80_mm?", usage_error);
}

TEST_CASE("beam: the line spacing of a flat array is constant, that of a sector grows with depth") {
    CHECK(line_spacing(linear_array{.lines = 128, .width = 38.4_mm}, 5_mm) == doctest::Approx(0.3e-3).scale(1e-30));
    CHECK(line_spacing(linear_array{.lines = 1, .width = 2_mm}, 5_mm) == doctest::Approx(2e-3).scale(1e-30));
    CHECK(line_spacing(bare_probe{}, 50_mm) == doctest::Approx(1e-3).scale(1e-30));
    const double third = std::acos(-1.0) / 3;
    for (const std::uint32_t lines : {3U, 192U})
        for (const float depth : {0.0F, 1_mm, 100_mm}) {
            const convex_array convex{.lines = lines, .radius = 60_mm, .field_of_view = 60_deg};
            const double radius = 60e-3 + static_cast<double>(depth);
            CHECK(line_spacing(convex, depth) == doctest::Approx(radius * third / lines).epsilon(1e-4).scale(1e-30));
            const phased_array phased{.lines = lines, .field_of_view = 60_deg};
            CHECK(line_spacing(phased, depth) ==
                  doctest::Approx(static_cast<double>(depth) * third / lines).epsilon(1e-4).scale(1e-30));
        }
}

TEST_CASE("beam: probes and depths out of range are refused") {
    for (const float depth : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN()})
        CHECK_THROWS_AS(beam_of(linear_array{}, depth), usage_error);
    CHECK_THROWS_AS(beam_of(linear_array{.fnumber = 0}, 0.1F), usage_error);
}

} // namespace beam_test
