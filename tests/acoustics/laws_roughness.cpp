#include <insonify/acoustics/laws.hpp>
#include <insonify/core/random.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>
#include <vector>

using namespace insonify;

namespace roughness_test {
namespace {

incidence at_interface(float roughness, float cosine, float frequency) {
    return {.before = {.density = 1000, .sound_speed = 1540},
            .after = {.density = 1900, .sound_speed = 3500, .roughness = roughness},
            .cosine = cosine,
            .frequency = frequency};
}

} // namespace

TEST_CASE("roughness: 50 um at 5 MHz weakens the specular echo by 18 dB, less at oblique incidence") {
    const auto loss_db = [](float cosine) {
        return 20 * std::log10(kirchhoff{}.coherent(at_interface(50_um, cosine, 5_MHz)));
    };
    const double kh = 2 * 3.14159265358979 * 5e6 / 1540 * 50e-6;
    MESSAGE("measured " << loss_db(1) << " dB, expected -18");
    CHECK(std::fabs(loss_db(1) + 18) < 0.1F);
    for (const double cosine : {1.0, 0.8, 0.5, 0.1}) { // -2 (k h cos i)^2 nepers
        const double expected = -2 * kh * kh * cosine * cosine * 8.685889638;
        CHECK(loss_db(static_cast<float>(cosine)) == doctest::Approx(expected).epsilon(1e-4).scale(1e-30));
    }
}

TEST_CASE("roughness: coherent and diffuse energy sum to the reflected energy") {
    for (const float height : {2_um, 20_um, 30_um, 50_um, 200_um})
        for (const float cosine : {1.0F, 0.7F, 0.2F})
            for (const float frequency : {1_MHz, 5_MHz, 15_MHz}) {
                const incidence at = at_interface(height, cosine, frequency);
                const double kept = kirchhoff{}.coherent(at), scattered = kirchhoff{}.diffuse(at);
                CHECK(std::fabs(kept * kept + scattered - 1) < 1e-6);
                CHECK(scattered > 0);
                const double r = fresnel{}.energy_reflection(at.before, at.after, cosine);
                CHECK(r * (kept * kept + scattered) + fresnel{}.energy_transmission(at.before, at.after, cosine) ==
                      doctest::Approx(1).epsilon(1e-6).scale(1e-30));
            }
}

TEST_CASE("roughness: a nearly smooth surface scatters 4 k^2 h^2 without cancellation, a smooth one nothing") {
    const double kh = 2 * 3.14159265358979 * 2e6 / 1540 * 0.1e-6;
    CHECK(kirchhoff{}.diffuse(at_interface(0.1_um, 1, 2_MHz)) ==
          doctest::Approx(4 * kh * kh).epsilon(1e-5).scale(1e-30));
    CHECK(kirchhoff{}.diffuse(at_interface(0, 1, 5_MHz)) == 0);
    CHECK(kirchhoff{}.coherent(at_interface(0, 1, 5_MHz)) == 1);
}

TEST_CASE("roughness: an interface has the larger roughness, and the wavelength of the first medium") {
    const medium smooth{.roughness = 2_um}, rough{.roughness = 30_um};
    CHECK(rms_height(incidence{smooth, rough}) == 30_um);
    CHECK(rms_height(incidence{rough, smooth}) == 30_um);
    incidence at = at_interface(30_um, 1, 5_MHz);
    const float before = kirchhoff{}.rms_phase(at);
    at.before.sound_speed /= 2;
    CHECK(kirchhoff{}.rms_phase(at) == doctest::Approx(2 * before).scale(1e-30));
    at.after.sound_speed /= 2;
    CHECK(kirchhoff{}.rms_phase(at) == doctest::Approx(2 * before).scale(1e-30));
}

} // namespace roughness_test

namespace roughness_test {
namespace {
struct polished { // a minimal law
    float coherent(const incidence&) const { return 1; }
    float diffuse(const incidence&) const { return 0; }
};
struct coherent_only {
    float coherent(const incidence&) const { return 1; }
};
} // namespace
static_assert(roughness_law<polished> && roughness_law<kirchhoff> && !roughness_law<coherent_only>);
} // namespace roughness_test

TEST_CASE("roughness: soft borders return what mirrors of random slopes return, hard ones what Lambert's law says") {
    // Power that facets of normally distributed slopes reflect into a narrow cone around the direction that it comes from,
    // for each area of the surface and solid angle, over 1 / pi of Lambert's law.
    constexpr double pi_exact = 3.14159265358979;
    const double slope = std::tan(pi_exact / 12), cone = 0.06;
    constexpr int facets = 2'000'000;
    for (const double degrees : {0.0, 10.0, 20.0, 30.0}) {
        const double angle = degrees * pi_exact / 180, x = std::sin(angle), z = std::cos(angle);
        double returned = 0;
        for (int i = 0; i < facets; ++i) {
            const vec2 random = hash_normal(1, static_cast<std::uint64_t>(i));
            const double p = slope * double{random.x}, q = slope * double{random.y};
            const double facing = (x * p + z) / std::sqrt(1 + p * p + q * q); // cosine of the angle on the facet
            if (facing > std::cos(cone / 2)) returned += facing * std::sqrt(1 + p * p + q * q);
        }
        const double ratio = returned / facets / (2 * (1 - std::cos(cone)));
        CHECK(double{scattered_back(false, static_cast<float>(z))} ==
              doctest::Approx(ratio).epsilon(0.05).scale(1e-30));
        CHECK(double{scattered_back(true, static_cast<float>(z))} == doctest::Approx(z * z).scale(1e-30));
    }
    CHECK(scattered_back(false, 0) == 0);
}
