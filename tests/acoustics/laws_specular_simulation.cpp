#include <insonify/acoustics/laws.hpp>
#include "lobe_angles.hpp"
#include <algorithm>
#include <complex>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace specular_test {
namespace {

float decibels(float amplitude) { return 20 * std::log10(amplitude); }

float wavelengths_of(const tilted_plate& plate) { return 30e-3F * plate.megahertz * 1e6F / 1540; }

// Sum over all pairs of elements and mirrored elements, at one frequency and any angle: a tilted plate at the focus.
double image_source(double angle, double fnumber, double wavelengths) {
    constexpr int elements = 300;
    const double spacing = wavelengths / fnumber / elements; // lengths are in wavelengths
    const auto echo = [&](double phi) {
        const double nx = std::sin(phi), nz = -std::cos(phi);
        double real = 0, imaginary = 0;
        for (int i = 0; i < elements; ++i) {
            const double u = (i - (elements - 1) / 2.0) * spacing;
            const double to_plate = u * nx - wavelengths * nz; // the plate contains (0, wavelengths)
            const double image_x = u - 2 * to_plate * nx, image_z = -2 * to_plate * nz;
            for (int j = 0; j < elements; ++j) {
                const double v = (j - (elements - 1) / 2.0) * spacing;
                const double path = std::hypot(v - image_x, image_z);
                const double late = path - std::hypot(u, wavelengths) - std::hypot(v, wavelengths);
                real += std::cos(2 * 3.14159265358979 * late) / std::sqrt(path);
                imaginary += std::sin(2 * 3.14159265358979 * late) / std::sqrt(path);
            }
        }
        return std::hypot(real, imaginary);
    };
    return echo(angle) / echo(0);
}

// Largest deviation above -12 dB from a plate simulated with a broadband pulse: every pair of elements at every frequency,
// the peak of the envelope over time. Metres, hertz.
double worst_of(const specular_return& lobe, double frequency, double fnumber, double depth) {
    constexpr double pi_exact = 3.14159265358979, speed = 1540;
    const double aperture = depth / fnumber, sigma = 0.644 * frequency / 2.3548;
    const int elements = std::max(32, static_cast<int>(aperture / (speed / frequency / 3)));
    constexpr int frequencies = 21, times = 81;
    std::vector<std::complex<double>> spectrum(frequencies);
    const auto peak = [&](double tilt) {
        const double nx = std::sin(tilt), nz = -std::cos(tilt);
        std::fill(spectrum.begin(), spectrum.end(), 0);
        for (int i = 0; i < elements; ++i) {
            const double u = (i - (elements - 1) / 2.0) * aperture / elements, to_plate = u * nx - depth * nz;
            const double image_x = u - 2 * to_plate * nx, image_z = -2 * to_plate * nz;
            for (int j = 0; j < elements; ++j) {
                const double v = (j - (elements - 1) / 2.0) * aperture / elements,
                             path = std::hypot(v - image_x, image_z);
                const double late = path - std::hypot(u, depth) - std::hypot(v, depth);
                std::complex<double> wave =
                    std::polar(1 / path, -2 * pi_exact * (frequency - 3 * sigma) / speed * late);
                const std::complex<double> step =
                    std::polar(1.0, -2 * pi_exact * 6 * sigma / (frequencies - 1) / speed * late);
                for (std::complex<double>& f : spectrum) f += wave, wave *= step;
            }
        }
        double largest = 0;
        for (int t = 0; t < times; ++t) {
            const double time = (t - (times - 1) / 2.0) * 0.1 / frequency;
            std::complex<double> sum = 0;
            for (int f = 0; f < frequencies; ++f) {
                const double off = (-3 + 6.0 * f / (frequencies - 1)) * sigma;
                sum += spectrum[static_cast<std::size_t>(f)] *
                       std::polar(std::exp(-off * off / (2 * sigma * sigma)), 2 * pi_exact * off * time);
            }
            largest = std::max(largest, std::abs(sum));
        }
        return largest;
    };
    const double straight = peak(0);
    double worst = 0;
    for (double tilt = 0.05; tilt < 2; tilt += 0.05) {
        const double angle = tilt * std::atan(0.5 / fnumber), expected = 20 * std::log10(peak(angle) / straight);
        if (expected < -12) break;
        const double measured = static_cast<double>(decibels(lobe(
            static_cast<float>(angle), static_cast<float>(fnumber), static_cast<float>(depth * frequency / speed))));
        CHECK(std::fabs(measured - expected) < 10); // a number
        worst = std::max(worst, std::fabs(measured - expected));
    }
    CHECK(worst > 0);
    return worst;
}

} // namespace

// V19
TEST_CASE("specular: the exact lobe agrees with a simulated tilted plate within 1 dB, down to -12 dB") {
    const specular_return exact{.lobe = specular_return::lobe_shape::exact};
    for (const tilted_plate& plate : table) {
        float worst = 0;
        for (const auto& row : plate.rows) {
            const float angle = row.degrees * static_cast<float>(radians);
            const float measured = decibels(exact(angle, 2, wavelengths_of(plate)));
            worst = max(worst, std::fabs(measured - row.db));
            MESSAGE(plate.megahertz << " MHz, " << row.degrees << " degrees: measured " << measured << " dB, expected "
                                    << row.db);
            CHECK(std::fabs(measured - row.db) < 1);
        }
        const float half = degrees_at(exact, -6, 2, wavelengths_of(plate));
        MESSAGE(plate.megahertz << " MHz: at most " << worst << " dB off; -6 dB at " << half << " degrees, expected "
                                << plate.at_6_db);
        CHECK(worst < 0.55F);
        CHECK(std::fabs(half - plate.at_6_db) < 0.15F);
    }
}

TEST_CASE(
    "specular: the lobe of a pulse agrees with a broadband simulation of a plate within 0.4 dB, from F/2 to F/4") {
    for (const double fnumber : {2.0, 3.0, 4.0})
        for (const double megahertz : {2.5, 5.0, 7.5}) {
            const double worst = worst_of({}, megahertz * 1e6, fnumber, 0.03);
            MESSAGE("F/", fnumber, ", ", megahertz, " MHz: at most ", worst, " dB off; `exact` ",
                    worst_of({.lobe = specular_return::lobe_shape::exact}, megahertz * 1e6, fnumber, 0.03),
                    ", `aperture` ",
                    worst_of({.lobe = specular_return::lobe_shape::aperture}, megahertz * 1e6, fnumber, 0.03));
            CHECK(worst < 0.4);
        }
}

TEST_CASE("specular: at F/4 the exact lobe has the simulated widths, 3.9 to 4.3 and 6.9 to 8.4 degrees, to 0.1") {
    const specular_return exact{.lobe = specular_return::lobe_shape::exact};
    for (const tilted_plate& plate : table) {
        const float half = degrees_at(exact, -6, 4, wavelengths_of(plate));
        const float tenth = degrees_at(exact, -20, 4, wavelengths_of(plate));
        MESSAGE(plate.megahertz << " MHz: -6 dB at " << half << ", -20 dB at " << tenth << " degrees");
        CHECK(half > 3.8F);
        CHECK(half < 4.4F);
        CHECK(tenth > 6.8F);
        CHECK(tenth < 8.5F);
    }
}

TEST_CASE("specular: the exact lobe agrees with the sum over elements and images within 0.5 dB, down to -12 dB") {
    const specular_return exact{.lobe = specular_return::lobe_shape::exact};
    float worst = 0;
    for (const float fnumber : {2.0F, 3.0F, 5.0F})
        for (const float wavelengths : {50.0F, 150.0F, 300.0F})
            for (int step = 1; step < 8; ++step) {
                const float angle = static_cast<float>(step) / 8 / (2 * fnumber);
                const auto expected = static_cast<float>(image_source(angle, fnumber, wavelengths));
                if (decibels(expected) < -12) break;
                worst = max(worst, std::fabs(decibels(exact(angle, fnumber, wavelengths) / expected)));
            }
    MESSAGE("at most " << worst << " dB off, expected below 0.5");
    CHECK(worst > 0);
    CHECK(worst < 0.5F);
}

} // namespace specular_test
