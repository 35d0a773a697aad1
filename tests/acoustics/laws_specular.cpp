#include <insonify/acoustics/laws.hpp>
#include <insonify/core/units.hpp>
#include "lobe_angles.hpp"
#include <doctest/doctest.h>

using namespace insonify;

namespace specular_test {
namespace {

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

struct everything { // a minimal law
    float operator()(float, float, float) const { return 1; }
};

} // namespace

static_assert(specular_law<everything> && specular_law<specular_return> && !specular_law<int>);

// V19. The triangle has the same width at all frequencies, the plate does not: at 2.5 MHz, where the Fresnel zone is
// widest, the triangle is 0.69 degrees too narrow; from 5 MHz on the error is just below half a degree.
TEST_CASE("specular: the -6 dB angle of the aperture lobe is right within 0.5 degrees from 5 MHz on, 0.7 at 2.5 MHz") {
    const float half = degrees_at({.lobe = specular_return::lobe_shape::aperture}, -6, 2, 1);
    for (const tilted_plate& plate : table) {
        const float tolerance = plate.megahertz < 5 ? 0.7F : 0.5F;
        MESSAGE(plate.megahertz << " MHz: measured " << half << " degrees, expected " << plate.at_6_db << " within "
                                << tolerance << ", off by " << plate.at_6_db - half);
        CHECK(std::fabs(half - plate.at_6_db) < tolerance);
    }
}

TEST_CASE("specular: the aperture lobe has the widths of its closed form") {
    const specular_return lobe{.lobe = specular_return::lobe_shape::aperture};
    CHECK(degrees_at(lobe, -6.0206F, 2, 1) == doctest::Approx(7.018).epsilon(1e-3).scale(1e-30));
    CHECK(degrees_at(lobe, -6.0206F, 4, 1) == doctest::Approx(3.5625).epsilon(1e-3).scale(1e-30));
    CHECK(degrees_at(lobe, -20, 2, 1) == doctest::Approx(12.632).epsilon(1e-3).scale(1e-30));
    CHECK(lobe(14.04_deg, 2, 1) == 0);
    CHECK(lobe(80_deg, 2, 1) == 0);
}

TEST_CASE("specular: the exact lobe equals the convolution with the Fresnel zone within 1e-3") {
    const specular_return exact{.lobe = specular_return::lobe_shape::exact};
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

TEST_CASE("specular: the exact lobe tends to the aperture lobe for short wavelengths") {
    const specular_return exact{.lobe = specular_return::lobe_shape::exact},
        triangle{.lobe = specular_return::lobe_shape::aperture};
    for (int step = 0; step <= 40; ++step) {
        const float angle = static_cast<float>(step) * 0.5_deg;
        CHECK(std::fabs(exact(angle, 2, 1e5F) - triangle(angle, 2, 1e5F)) < 0.01F);
    }
}

TEST_CASE("specular: every lobe is 1 at normal incidence, symmetric and monotonic") {
    for (const specular_return& lobe : {specular_return{},
                                        {.lobe = specular_return::lobe_shape::aperture},
                                        {.lobe = specular_return::lobe_shape::exact}})
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
