#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/paper/law2011.hpp>
#include <array>
#include <doctest/doctest.h>

using namespace insonify;

static_assert(acoustic_model<law2011>);

namespace law2011_test {
namespace {

// The paper's base scene in closed form: a cube of 1.7 / 7.8 MRayl bone between 20 and 40 mm in muscle.
constexpr std::array<medium, 2> media{medium{.density = 1000, .sound_speed = 1700, .attenuation = 1_dB_per_cm},
                                      medium{.density = 2000, .sound_speed = 3900, .attenuation = 5_dB_per_cm}};
constexpr std::array<layer, 3> layers{layer{0, 20_mm, 0}, layer{20_mm, 40_mm, 1}, layer{40_mm, 60_mm, 0}};

struct expected_intensity {
    float frequency, depth, bare, attenuated; // published sums of eq. 1: I_r without and with the attenuation to it
};
constexpr expected_intensity table[] = {
    {2.5_MHz, 10_mm, 0.749894F, 0.749894F},       {2.5_MHz, 19.5_mm, 0.9827917F, 0.8057062F},
    {2.5_MHz, 20.5_mm, 0.3075433F, 0.3075433F},   {2.5_MHz, 30_mm, 0.07837117F, 0.07837117F},
    {2.5_MHz, 39.5_mm, 0.2622799F, 0.02820545F},  {2.5_MHz, 40.5_mm, 0.01076620F, 0.01076620F},
    {2.5_MHz, 50_mm, 0.008190541F, 0.008190541F}, {5_MHz, 10_mm, 0.5623413F, 0.5623413F},
    {5_MHz, 19.5_mm, 0.7377610F, 0.4596494F},     {5_MHz, 20.5_mm, 0.1609371F, 0.1609371F},
    {5_MHz, 30_mm, 0.01045096F, 0.01045096F},     {5_MHz, 39.5_mm, 0.2429872F, 9.584799e-4F},
    {5_MHz, 40.5_mm, 3.355928e-4F, 3.355928e-4F}, {5_MHz, 50_mm, 1.942283e-4F, 1.942283e-4F},
    {7.5_MHz, 10_mm, 0.4216965F, 0.4216965F},     {7.5_MHz, 19.5_mm, 0.5979727F, 0.2622266F},
    {7.5_MHz, 20.5_mm, 0.08421827F, 0.08421827F}, {7.5_MHz, 30_mm, 0.001393658F, 0.001393658F},
    {7.5_MHz, 39.5_mm, 0.2423316F, 3.257114e-5F}, {7.5_MHz, 40.5_mm, 1.046074e-5F, 1.046074e-5F},
    {7.5_MHz, 50_mm, 4.605880e-6F, 4.605880e-6F}};

// 60 mm in samples of 0.5 mm.
std::vector<float> line_of(const law2011& model, const auto& policy, float frequency) {
    std::vector<float> samples(120);
    model(policy, {layers, media, frequency}, 0.5_mm, samples);
    return samples;
}

} // namespace
} // namespace law2011_test

TEST_CASE("law2011: the paper's base scene agrees with its closed form to 1e-5") {
    for (const auto& row : law2011_test::table) {
        const traced_line line{law2011_test::layers, law2011_test::media, row.frequency};
        const float bare = law2011{}.at(line, row.depth);
        const float attenuated = law2011{.reflection = law2011::reflection::attenuated}.at(line, row.depth);
        CAPTURE(row.frequency);
        CAPTURE(row.depth);
        CHECK(bare == doctest::Approx(row.bare).epsilon(1e-5).scale(1e-30));
        CHECK(attenuated == doctest::Approx(row.attenuated).epsilon(1e-5).scale(1e-30));
    }
}

TEST_CASE("law2011: two-way attenuation agrees with the closed form with /10 for /20") {
    struct {
        float depth, expected;
    } const rows[] = {{10_mm, 0.3162278F}, {19.5_mm, 0.5182245F}, {30_mm, 1.858473e-4F}, {40.5_mm, 3.260713e-7F}};
    for (const auto& row : rows) // published sums of eq. 1 with /10 for /20, 5 MHz
        CHECK(law2011{.travel = law2011::travel::two_way}.at({law2011_test::layers, law2011_test::media, 5_MHz},
                                                             row.depth) ==
              doctest::Approx(row.expected).epsilon(1e-5).scale(1e-30));
}

TEST_CASE("law2011: a whole line equals its points, with and without SIMD, for every option") {
    for (const auto where : {law2011::band::before, law2011::band::after})
        for (const auto weakened : {law2011::reflection::bare, law2011::reflection::attenuated})
            for (const auto there : {law2011::travel::one_way, law2011::travel::two_way})
                for (const auto what : {law2011::incident::field, law2011::incident::backscattered}) {
                    const law2011 model{.reflection_length = 2.2_mm,
                                        .travel = there,
                                        .reflection = weakened,
                                        .band = where,
                                        .incident = what};
                    const std::vector<float> scalar = law2011_test::line_of(model, exec::seq, 5_MHz);
                    const std::vector<float> simd = law2011_test::line_of(model, exec::unseq, 5_MHz);
                    for (std::size_t k = 0; k < scalar.size(); ++k) {
                        const float depth = (static_cast<float>(k) + 0.5F) * 0.5_mm;
                        const float expected = model.at({law2011_test::layers, law2011_test::media, 5_MHz}, depth);
                        CHECK(scalar[k] == doctest::Approx(expected).epsilon(1e-5).scale(1e-30));
                        CHECK(std::fabs(simd[k] - scalar[k]) < 1e-6F); // of amplitude 1
                        CHECK(simd[k] == doctest::Approx(scalar[k]).epsilon(1e-5).scale(1e-30));
                    }
                }
}

TEST_CASE("law2011: the bright band lies before or after the interface, depending on the option") {
    const traced_line line{law2011_test::layers, law2011_test::media, 5_MHz};
    const law2011 before{}, after{.band = law2011::band::after};
    const float r = 0.412299F;
    CHECK(before.at(line, 19.5_mm) - after.at(line, 19.5_mm) == doctest::Approx(r).epsilon(1e-4).scale(1e-30));
    CHECK(after.at(line, 20.5_mm) - before.at(line, 20.5_mm) == doctest::Approx(r).epsilon(1e-4).scale(1e-30));
    CHECK(before.at(line, 18.9_mm) == after.at(line, 18.9_mm));
    CHECK(before.at(line, 21.1_mm) == after.at(line, 21.1_mm));
}

TEST_CASE("law2011: reflected and transmitted fractions agree with the literature and sum to 1") {
    const auto of_impedance = [](float rayl) { return medium{.density = rayl / 1500, .sound_speed = 1500}; };
    struct {
        float z1, z2, reflected;
    } const rows[] = {{1.70_MRayl, 7.80_MRayl, 0.412299F},   {1.38_MRayl, 1.70_MRayl, 0.010794F},
                      {1.63_MRayl, 0.0004_MRayl, 0.999019F}, {1.63_MRayl, 1.48_MRayl, 0.002326F},
                      {1.70_MRayl, 1.61_MRayl, 0.000739F},   {1.38_MRayl, 1.62_MRayl, 0.006400F}};
    for (const auto& row : rows) {
        const medium a = of_impedance(row.z1), b = of_impedance(row.z2);
        CHECK(std::fabs(law2011::reflected(a, b) - row.reflected) < 1e-6F);
        CHECK(law2011::reflected(a, b) == doctest::Approx(law2011::reflected(b, a)).scale(1e-30));
        CHECK(std::fabs(law2011::reflected(a, b) + law2011::transmitted(a, b) - 1) < 1e-6F);
    }
}

TEST_CASE("law2011: adjacent layers of one medium have no interface") {
    const std::array<layer, 3> two_objects{layer{0, 10_mm, 0, 1}, layer{10_mm, 15_mm, 0, 2}, layer{15_mm, 30_mm, 1, 3}};
    const std::array<layer, 2> one_object{layer{0, 15_mm, 0}, layer{15_mm, 30_mm, 1}};
    const law2011 model{.reflection_length = 8_mm}; // the band extends across the border of the objects
    for (const float depth : {5_mm, 8_mm, 9.9_mm, 10.1_mm, 14_mm, 20_mm})
        CHECK(model.at({two_objects, law2011_test::media, 5_MHz}, depth) ==
              doctest::Approx(model.at({one_object, law2011_test::media, 5_MHz}, depth)).scale(1e-30));
    std::vector<float> a(64), b(64);
    model(exec::unseq, {two_objects, law2011_test::media, 5_MHz}, 30_mm / 64, a);
    model(exec::unseq, {one_object, law2011_test::media, 5_MHz}, 30_mm / 64, b);
    for (std::size_t k = 0; k < a.size(); ++k) CHECK(a[k] == doctest::Approx(b[k]).epsilon(1e-6).scale(1e-30));
}

TEST_CASE("law2011: attenuation grows as f, or as f to the medium's exponent") {
    const medium m{.attenuation = 50, .attenuation_power = 1.5F};
    CHECK(law2011{}.loss(m, 4_MHz) == doctest::Approx(200).scale(1e-30));
    CHECK(law2011{.spectrum = law2011::spectrum::power_law}.loss(m, 4_MHz) == doctest::Approx(400).scale(1e-30));
    CHECK(law2011{.travel = law2011::travel::two_way}.loss(m, 4_MHz) == doctest::Approx(400).scale(1e-30));
}

TEST_CASE("law2011: speckle has the medium's backscatter relative to liver") {
    const std::array<medium, 1> media{medium{.backscatter = 0.5F}};
    const std::array<layer, 1> layers{layer{0, 1, 0}};
    CHECK(law2011{.incident = law2011::incident::backscattered}.at({layers, media, 5_MHz}, 0.5F) ==
          doctest::Approx(0.5 * std::pow(10.0, -55.0 / 20)).epsilon(2e-3).scale(1e-30));
}

TEST_CASE("law2011: at_interface gives the reflected and transmitted fractions of the intensity") {
    const medium &muscle = law2011_test::media[0], &bone = law2011_test::media[1];
    const response answer = law2011{}.at_interface({muscle, bone, 0.5F, 5_MHz});
    CHECK(answer.reflected == doctest::Approx(0.412299).epsilon(1e-5).scale(1e-30)); // the angle is not used
    CHECK(answer.transmitted == doctest::Approx(0.587701).epsilon(1e-5).scale(1e-30));
}
