#include <insonify/acoustics/specular.hpp>
#include <insonify/core/units.hpp>
#include <algorithm>
#include <complex>
#include <doctest/doctest.h>
#include <initializer_list>
#include <vector>

using namespace insonify;

namespace specular_test {
namespace {

constexpr double radians = 3.14159265358979 / 180;

float decibels(float amplitude) { return 20 * std::log10(amplitude); }

// The angle in degrees at which a lobe falls to a level, by bisection.
float degrees_at(const specular_return& lobe, float level_db, float fnumber, float wavelengths) {
    float above = 0, below = 90;
    for (int i = 0; i < 40; ++i) {
        const float middle = (above + below) / 2;
        const float amplitude = lobe(middle * static_cast<float>(radians), fnumber, wavelengths);
        (amplitude > std::pow(10.0F, level_db / 20) ? above : below) = middle;
    }
    return above;
}

// A published simulation: an F/2 array focused on a plate 30 mm deep in 1540 m/s, echo level against tilt.
struct tilted_plate {
    float megahertz;
    float at_6_db; // degrees, interpolated in the full table
    struct {
        float degrees, db;
    } rows[9];
};
constexpr tilted_plate table[] = {
    {2.5F,
     7.693F,
     {{1, -0.091F},
      {2.5F, -0.606F},
      {4, -1.714F},
      {5, -2.811F},
      {6, -4.031F},
      {7.5F, -5.751F},
      {9, -8.066F},
      {10, -10.26F},
      {10.5F, -11.512F}}},
    {5,
     7.501F,
     {{1, -0.121F},
      {2.5F, -0.871F},
      {4, -2.334F},
      {5, -3.314F},
      {6, -4.245F},
      {7.5F, -5.999F},
      {9, -8.137F},
      {10, -10.053F},
      {10.5F, -11.32F}}},
    {7.5F,
     7.416F,
     {{1, -0.14F},
      {2.5F, -1.076F},
      {4, -2.503F},
      {5, -3.358F},
      {6, -4.359F},
      {7.5F, -6.102F},
      {9, -8.307F},
      {10, -10.107F},
      {10.5F, -11.228F}}},
};
float wavelengths_of(const tilted_plate& plate) { return 30e-3F * plate.megahertz * 1e6F / 1540; }

// The convolution of the triangle with the Fresnel zone by Simpson's rule in double; `exact` is its closed form.
double blurred_triangle(double angle, double fnumber, double wavelengths) {
    const double edge = std::atan(1 / (2 * fnumber));
    const auto amplitude = [&](double phi) {
        double real = 0, imaginary = 0;
        for (const double side : {-1.0, 1.0}) { // of the kink of the triangle
            constexpr int steps = 4000;
            for (int i = 0; i <= steps; ++i) {
                const double a = side * edge * i / steps;
                const double weight = (i == 0 || i == steps ? 1 : i % 2 == 1 ? 4 : 2) * (1 - std::fabs(a) / edge);
                const double phase = 2 * 3.14159265358979 * wavelengths * (phi - a) * (phi - a);
                real += weight * std::cos(phase);
                imaginary -= weight * std::sin(phase);
            }
        }
        return std::hypot(real, imaginary);
    };
    return amplitude(angle) / amplitude(0);
}

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

} // namespace

// V19
TEST_CASE("specular: the exact lobe agrees with a simulated tilted plate within 1 dB, down to -12 dB") {
    const specular_return exact{.lobe = specular_return::lobe::exact};
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

namespace {

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

TEST_CASE(
    "specular: the lobe of a pulse agrees with a broadband simulation of a plate within 0.4 dB, from F/2 to F/4") {
    for (const double fnumber : {2.0, 3.0, 4.0})
        for (const double megahertz : {2.5, 5.0, 7.5}) {
            const double worst = worst_of({}, megahertz * 1e6, fnumber, 0.03);
            MESSAGE("F/", fnumber, ", ", megahertz, " MHz: at most ", worst, " dB off; `exact` ",
                    worst_of({.lobe = specular_return::lobe::exact}, megahertz * 1e6, fnumber, 0.03), ", `aperture` ",
                    worst_of({.lobe = specular_return::lobe::aperture}, megahertz * 1e6, fnumber, 0.03));
            CHECK(worst < 0.4);
        }
}

// V19. The triangle has the same width at all frequencies, the plate does not: at 2.5 MHz, where the Fresnel zone is
// widest, the triangle is 0.69 degrees too narrow; from 5 MHz on the error is just below half a degree.
TEST_CASE("specular: the -6 dB angle of the aperture lobe is right within 0.5 degrees from 5 MHz on, 0.7 at 2.5 MHz") {
    const float half = degrees_at({.lobe = specular_return::lobe::aperture}, -6, 2, 1);
    for (const tilted_plate& plate : table) {
        const float tolerance = plate.megahertz < 5 ? 0.7F : 0.5F;
        MESSAGE(plate.megahertz << " MHz: measured " << half << " degrees, expected " << plate.at_6_db << " within "
                                << tolerance << ", off by " << plate.at_6_db - half);
        CHECK(std::fabs(half - plate.at_6_db) < tolerance);
    }
}

TEST_CASE("specular: the aperture lobe has the widths of its closed form") {
    const specular_return lobe{.lobe = specular_return::lobe::aperture};
    CHECK(degrees_at(lobe, -6.0206F, 2, 1) == doctest::Approx(7.018).epsilon(1e-3).scale(1e-30));
    CHECK(degrees_at(lobe, -6.0206F, 4, 1) == doctest::Approx(3.5625).epsilon(1e-3).scale(1e-30));
    CHECK(degrees_at(lobe, -20, 2, 1) == doctest::Approx(12.632).epsilon(1e-3).scale(1e-30));
    CHECK(lobe(14.04_deg, 2, 1) == 0);
    CHECK(lobe(80_deg, 2, 1) == 0);
}

TEST_CASE("specular: at F/4 the exact lobe has the simulated widths, 3.9 to 4.3 and 6.9 to 8.4 degrees, to 0.1") {
    const specular_return exact{.lobe = specular_return::lobe::exact};
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

TEST_CASE("specular: the exact lobe equals the convolution with the Fresnel zone within 1e-3") {
    const specular_return exact{.lobe = specular_return::lobe::exact};
    for (const float fnumber : {1.0F, 2.0F, 4.0F})
        for (const float wavelengths : {20.0F, 100.0F, 400.0F})
            for (int degrees = 0; degrees <= 40; degrees += 2) {
                const float angle = static_cast<float>(degrees) * 1_deg;
                CAPTURE(fnumber);
                CAPTURE(wavelengths);
                CAPTURE(degrees);
                const double expected = blurred_triangle(angle, fnumber, wavelengths);
                CHECK(std::fabs(exact(angle, fnumber, wavelengths) - expected) < 1e-3);
            }
}

TEST_CASE("specular: the exact lobe agrees with the sum over elements and images within 0.5 dB, down to -12 dB") {
    const specular_return exact{.lobe = specular_return::lobe::exact};
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

TEST_CASE("specular: the exact lobe tends to the aperture lobe for short wavelengths") {
    const specular_return exact{.lobe = specular_return::lobe::exact},
        triangle{.lobe = specular_return::lobe::aperture};
    for (int step = 0; step <= 40; ++step) {
        const float angle = static_cast<float>(step) * 0.5_deg;
        CHECK(std::fabs(exact(angle, 2, 1e5F) - triangle(angle, 2, 1e5F)) < 0.01F);
    }
}

TEST_CASE("specular: the cosine lobe is cos^power; power 1.386 / phi^2 gives -6 dB at phi") {
    CHECK(specular_return{.lobe = specular_return::lobe::cosine}(60_deg, 2, 1) == doctest::Approx(0.5).scale(1e-30));
    CHECK(specular_return{.lobe = specular_return::lobe::cosine, .power = 4}(60_deg, 2, 1) ==
          doctest::Approx(0.0625).scale(1e-30));
    CHECK(specular_return{.lobe = specular_return::lobe::cosine}(100_deg, 2, 1) == 0);
    for (const float power : {79.0F, 270.0F}) {
        const float half = degrees_at({.lobe = specular_return::lobe::cosine, .power = power}, -6.0206F, 2, 1);
        CHECK(half * static_cast<float>(radians) ==
              doctest::Approx(std::sqrt(1.386F / power)).epsilon(0.01).scale(1e-30));
    }
}

TEST_CASE("specular: every lobe is 1 at normal incidence, symmetric and monotonic") {
    for (const specular_return& lobe : {specular_return{},
                                        {.lobe = specular_return::lobe::aperture},
                                        {.lobe = specular_return::lobe::cosine, .power = 79},
                                        {.lobe = specular_return::lobe::exact}})
        for (const float fnumber : {1.0F, 2.0F, 4.0F})
            for (const float wavelengths : {20.0F, 100.0F, 400.0F}) {
                CHECK(lobe(0, fnumber, wavelengths) == doctest::Approx(1).scale(1e-30));
                float before = 1;
                for (float angle = 0; before > 0.25F; angle += 0.2_deg) {
                    const float amplitude = lobe(angle, fnumber, wavelengths);
                    REQUIRE(amplitude == lobe(-angle, fnumber, wavelengths));
                    REQUIRE(amplitude < before + 1e-3F);
                    before = amplitude;
                }
            }
}

} // namespace specular_test

namespace specular_test {
namespace {
struct everything { // a minimal law
    float operator()(float, float, float) const { return 1; }
};
} // namespace
static_assert(specular_law<everything> && specular_law<specular_return> && !specular_law<int>);
} // namespace specular_test
