#include <insonify/acoustics/tissue.hpp>
#include <insonify/channels.hpp>
#include <insonify/core/units.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/signal/envelope.hpp>
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace own_array_test {
namespace {

/// A matrix array: column after column, from left to right.
struct matrix_array {
    std::uint32_t columns = 8, rows = 4, elements = columns * rows;
    float pitch = 0.3_mm, element_width = 0.27_mm, height = 0.27_mm, elevation_focus = 1; // no lens, nearly
    float frequency = 5_MHz, bandwidth = 0.6F, sound_speed = 1540, fnumber = 2;

    ray element(std::uint32_t i) const {
        const auto place = [](std::uint32_t number, std::uint32_t of) {
            return static_cast<float>(number) - 0.5F * static_cast<float>(of - 1);
        };
        return {.origin = {place(i / rows, columns) * pitch, place(i % rows, rows) * pitch, 0}};
    }
    void check() const {
        if (columns == 0 || rows == 0) throw usage_error{"matrix_array: it has no elements"};
    }
};
static_assert(element_transducer<matrix_array>);

using complex = std::complex<double>;
constexpr double full_turn = 6.283185307179586;
const complex imaginary_unit{0, 1};

// Spectrum of a record at the carrier over that of the pulse.
complex transfer(const channel_data& data, std::uint32_t transmit, std::uint32_t element) {
    const auto frequency = static_cast<double>(data.frequency), rate = static_cast<double>(data.sampling_frequency);
    complex sum = 0;
    for (std::uint32_t k = 0; k < data.samples; ++k)
        sum += static_cast<double>(data(transmit, element, k)) *
               std::exp(-imaginary_unit * full_turn * frequency * (k / rate));
    const double sigma = static_cast<double>(data.bandwidth) * frequency / 2.3548;
    return sum / rate / (std::sqrt(full_turn) / (full_turn * sigma) / 2);
}

// Rayleigh's integral over the face of an element, soft baffle.
complex field_at(const matrix_array& of, std::uint32_t element, vec3 place) {
    const double k = full_turn * static_cast<double>(of.frequency) / static_cast<double>(of.sound_speed),
                 w = static_cast<double>(of.element_width), h = static_cast<double>(of.height);
    const vec3 centre = of.element(element).origin;
    constexpr int steps = 12;
    complex sum = 0;
    for (int a = 0; a < steps; ++a)
        for (int b = 0; b < steps; ++b) {
            const double x = static_cast<double>(place.x - centre.x) - w * ((a + 0.5) / steps - 0.5),
                         y = static_cast<double>(place.y - centre.y) - h * ((b + 0.5) / steps - 0.5),
                         z = static_cast<double>(place.z), r = std::sqrt(x * x + y * y + z * z);
            sum += std::exp(-imaginary_unit * k * r) * z / (r * r);
        }
    return imaginary_unit * k / full_turn * sum * (w / steps) * (h / steps);
}

} // namespace

TEST_CASE("channels: a matrix array of one's own receives a point as Rayleigh's integral says") {
    const scene body = scene{medium{.density = 1000, .sound_speed = 1540}}.build(exec::par);
    const matrix_array array;
    const double k = full_turn * 5e6 / 1540;
    for (const vec3 place : {vec3{0, 0, 12_mm}, vec3{1_mm, 1.5_mm, 10_mm}, vec3{-1.5_mm, -2_mm, 14_mm}}) {
        const std::vector<point_scatterer> points{{place, 1e-3F}};
        const channel_data data =
            trace_channels(exec::par_unseq, body, array, pose{}, physical{}, full_synthetic_aperture(array),
                           {.depth = 18_mm, .sampling_frequency = 40_MHz, .points = points});
        REQUIRE(data.elements == 32);
        double worst_db = 0, worst_ns = 0, worst_delay = 0;
        bool reciprocal = true;
        for (std::uint32_t n = 0; n < 32; n += 3)
            for (std::uint32_t m = 0; m < 32; ++m) {
                const complex expected = 1e-3 * field_at(array, n, place) * field_at(array, m, place) * full_turn /
                                         (imaginary_unit * k * static_cast<double>(array.element_width * array.height));
                const complex ratio = transfer(data, n, m) / expected;
                worst_db = std::max(worst_db, std::fabs(20 * std::log10(std::abs(ratio))));
                worst_ns = std::max(worst_ns, std::fabs(1e9 * std::arg(ratio) / (full_turn * 5e6)));
                for (std::uint32_t i = 0; i < data.samples; ++i)
                    reciprocal = reciprocal && data(n, m, i) == data(m, n, i);
                // The energy arrives after the distance over the speed of sound.
                double moment = 0, energy = 0;
                for (std::uint32_t i = 0; i < data.samples; ++i) {
                    const double power = std::pow(static_cast<double>(data(n, m, i)), 2);
                    moment += power * i;
                    energy += power;
                }
                const double way = static_cast<double>(length(place - array.element(n).origin) +
                                                       length(place - array.element(m).origin));
                worst_delay = std::max(worst_delay, std::fabs(moment / energy / 40e6 - way / 1540));
            }
        MESSAGE("at y ", place.y * 1e3F, " mm: within ", worst_db, " dB, ", worst_ns, " ns, energy within ",
                worst_delay * 1e9, " ns");
        CHECK(worst_db < 0.05);
        CHECK(worst_ns < 0.5);
        CHECK(worst_delay < 5e-9);
        CHECK(reciprocal);
    }
}

TEST_CASE("beamform: a matrix array of one's own sees points out of the plane y = 0 where they are") {
    const scene body = scene{medium{.density = 1000, .sound_speed = 1540}}.build(exec::par);
    const matrix_array array{};
    const std::vector<point_scatterer> points{{{0.4_mm, 0.3_mm, 5_mm}, 1e-3F}};
    const channel_data data = trace_channels(exec::par_unseq, body, array, pose{}, physical{},
                                             full_synthetic_aperture(array), {.depth = 8_mm, .points = points});
    // A probe of one's own: lines of the plane y = `at`.
    struct shifted_lines : linear_array {
        float at = 0;
        ray beam(float line) const {
            ray own = linear_array::beam(line);
            own.origin.y = at;
            return own;
        }
    };
    float brightest = 0;
    vec3 found{0, 0, 0};
    for (int step = -4; step <= 4; ++step) {
        shifted_lines lines;
        lines.lines = 11;
        lines.width = 1.1_mm;
        lines.frequency = array.frequency;
        lines.at = 0.15_mm * static_cast<float>(step);
        const scan_lines seen = envelope(
            exec::par_unseq, beamform(exec::par_unseq, data, lines, {.depth = 6_mm, .samples = 240}, {.fnumber = 1}));
        for (std::uint32_t line = 0; line < seen.count; ++line)
            for (std::uint32_t k = 0; k < seen.samples; ++k)
                if (seen(line, k) > brightest) {
                    brightest = seen(line, k);
                    const ray beam = lines.beam(static_cast<float>(line));
                    found = beam.at((static_cast<float>(k) + 0.5F) * 6_mm / 240);
                }
    }
    CHECK(length(found - points[0].position) < 0.12_mm);
}

TEST_CASE("channels: an array of one's own whose elements look back or are out of order is named") {
    const scene body = scene{tissue::gel}.build(exec::seq);
    struct wrong_array : matrix_array {
        ray changed{};
        ray element(std::uint32_t i) const { return i == 5 ? changed : matrix_array::element(i); }
    };
    const std::vector<transmit> sent = full_synthetic_aperture(matrix_array{});
    wrong_array array;
    const vec3 centre = array.matrix_array::element(5).origin;
    const auto refused = [&](const ray& changed, const char* sentence) {
        array.changed = changed;
        CHECK_THROWS_WITH_AS(trace_channels(exec::seq, body, array, pose{}, physical{}, sent, {}), sentence,
                             usage_error);
    };
    refused({.origin = {NAN, 0, 0}}, "trace_channels: element 5 is not finite; check its centre and its normal");
    const char* const tilted = "trace_channels: element 5: its normal must have length 1 and lie in the plane y = 0";
    refused({.origin = centre, .direction = {0, 0.6F, 0.8F}}, tilted);
    refused({.origin = centre, .direction = {0, 0, 2}}, tilted);
    refused({.origin = centre, .direction = {1, 0, 0}},
            "trace_channels: element 5 looks back; z of its normal must be above 0: round arrays have no channel data");
    refused({.origin = centre - vec3{1_mm, 0, 0}},
            "trace_channels: element 5 lies left of the one before; elements must be in order of x, a matrix array "
            "column after column");
}

} // namespace own_array_test
