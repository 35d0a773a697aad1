#include <insonify/acoustics/tissue.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>
#include <string>

using namespace insonify;

namespace tissue_test {
namespace {

/// Rounded to about four digits.
struct row {
    const char* name;
    double impedance;   // MRayl
    double attenuation; // dB/cm at 5 MHz
    double backscatter; // relative to liver
};

const row published[] = {
    // clang-format off
    {"water", 1.479, 0.05425, 0},
    {"saline", 1.511, 0.055, 0},
    {"blood", 1.662, 1.035, 0.0316228}, // -30 dB, flowing: Shung et al. 1976
    {"fat", 1.353, 3, 0.501187},
    {"deep_fat", 1.353, 3, 0.281838}, // as fat; its level by convention
    {"skin", 1.804, 6, 1.41254},
    {"muscle", 1.698, 5, 0.501187},
    {"tendon", 1.977, 10.57, 1.99526},
    {"fascia", 1.807, 7.85, 1.99526},
    {"nerve", 1.752, 5.5, 1.41254},
    {"liver", 1.664, 2.818, 1},
    {"kidney", 1.654, 5, 0.630957},
    {"spleen", 1.661, 3.241, 1},
    {"brain", 1.612, 4.7, 0.501187},
    {"heart", 1.672, 2.643, 0.630957},
    {"vessel_wall", 1.727, 3.5, 1.41254},
    {"bladder_wall", 1.677, 2.5, 0.794328},
    {"urine", 1.572, 0.0788, 0},
    {"gallbladder_wall", 1.691, 2.5, 1},
    {"bile", 1.533, 0.2431, 0},
    {"cartilage", 1.815, 15, 0.177828},
    {"bone_cortical", 6.685, 25, 0},
    {"bone_trabecular", 2.478, 30, 0},
    {"lung", 0.26, 105.1, 0},
    {"air", 0.0004116, 40, 0},
    {"gel", 1.55, 0.25, 0},
    {"lens", 1.224, 32.41, 0},
    {"eye_lens", 1.768, 0.3, 0.177828},
    {"soft_tissue", 1.629, 2.5, 0.794328},
    {"steel", 45.35, 0.25, 0},
    {"titanium", 27.33, 1.5, 0},
    {"pvcp", 1.4, 6.261, 0.501187},
    {"tmm_low", 1.602, 2.5, 1},
    {"tmm_high", 1.602, 3.5, 1},
    {"tmm_cyst", 1.602, 0.25, 0},
    {"urethane", 1.522, 4.052, 1},
    // By convention around their neighbours; connective tissue: IT'IS 1027 kg/m^3, 1545 m/s; oesophagus: Assentoft 2001
    {"thin_muscle", 1.698, 5, 0.446684},
    {"connective_tissue", 1.587, 4.5, 0.354813},
    {"capsule", 1.76, 7.85, 1.58489},
    {"nerve_fascicle", 1.709, 5, 0.223872},
    {"epineurium", 1.7227, 6, 1.58489},
    {"thyroid", 1.643, 3.524, 1.12202},
    {"intima", 1.72515, 3.5, 0.630957},
    {"tunica_media", 1.55767, 3.5, 0.199526},
    {"adventitia", 1.6247, 6, 0.562341},
    {"vein_wall", 1.68775, 3.5, 0.707946},
    {"mucosa", 1.663, 4, 1},
    {"muscularis", 1.721, 5, 0.316228},
    // clang-format on
};

double roughness_of(const std::string& name) {
    for (const char* liquid : {"water", "saline", "blood", "urine", "bile", "gel", "air"})
        if (name == liquid) return 0;
    for (const char* thin : {"thin_muscle", "connective_tissue", "capsule", "nerve_fascicle", "epineurium", "thyroid",
                             "intima", "tunica_media", "adventitia", "vein_wall", "mucosa", "muscularis"})
        if (name == thin) return 6e-6;
    if (name.starts_with("bone")) return 30e-6;
    return name == "steel" || name == "titanium" ? 2e-6 : 20e-6;
}

} // namespace

TEST_CASE("tissue: impedance, attenuation and backscatter agree with the published table") {
    for (const row& expected : published) {
        CAPTURE(expected.name);
        const auto found = tissue::find(expected.name);
        REQUIRE(found.has_value());
        CHECK(static_cast<double>(found->impedance()) * 1e-6 ==
              doctest::Approx(expected.impedance).epsilon(2e-3).scale(1e-30));
        const double at_5_mhz = static_cast<double>(found->attenuation) / 100 *
                                std::pow(5.0, static_cast<double>(found->attenuation_power));
        CHECK(at_5_mhz == doctest::Approx(expected.attenuation).epsilon(2e-3).scale(1e-30));
        CHECK(static_cast<double>(found->backscatter) ==
              doctest::Approx(expected.backscatter).epsilon(1e-5).scale(1e-30));
        CHECK(static_cast<double>(found->roughness) ==
              doctest::Approx(roughness_of(expected.name)).epsilon(1e-6).scale(1e-30));
        CHECK(is_valid(*found));
    }
}

TEST_CASE("tissue: density and speed are stated in SI units") {
    CHECK(tissue::muscle.density == 1075);
    CHECK(tissue::muscle.sound_speed == 1580);
    CHECK(tissue::muscle.attenuation == 100);
    CHECK(tissue::air.density == 1.2F);
    CHECK(tissue::steel.sound_speed == 5740);
    CHECK(tissue::lung.attenuation_power == 0.6F);
}

TEST_CASE("tissue: the media give the reflections of textbooks") {
    const auto reflected = [](const medium& a, const medium& b) {
        const double z1 = static_cast<double>(a.impedance()), z2 = static_cast<double>(b.impedance());
        return (z2 - z1) * (z2 - z1) / ((z2 + z1) * (z2 + z1));
    };
    CHECK(reflected(tissue::muscle, tissue::air) > 0.998);
    CHECK(reflected(tissue::muscle, tissue::bone) == doctest::Approx(0.354).epsilon(0.01).scale(1e-30));
    CHECK(reflected(tissue::fat, tissue::muscle) == doctest::Approx(0.0128).epsilon(0.02).scale(1e-30));
    CHECK(reflected(tissue::muscle, tissue::blood) < 0.001);
}

TEST_CASE("tissue: each medium is listed once, under its own name") {
    CHECK(std::size(tissue::all) == std::size(published) + 1); // cortical bone has two names
    for (const tissue::named_medium& each : tissue::all) {
        CAPTURE(each.name);
        CHECK(tissue::find(each.name) == each.value);
        int same_name = 0;
        for (const tissue::named_medium& other : tissue::all) same_name += std::string{each.name} == other.name;
        CHECK(same_name == 1);
    }
}

TEST_CASE("tissue: bone is cortical bone") {
    CHECK(tissue::bone == tissue::bone_cortical);
    CHECK(tissue::find("bone") == tissue::bone_cortical);
}

TEST_CASE("tissue: the wall of an artery has a dark layer between two bright ones") {
    CHECK(tissue::tunica_media.backscatter < 0.4F * tissue::intima.backscatter);
    CHECK(tissue::tunica_media.backscatter < 0.4F * tissue::adventitia.backscatter);
    CHECK(tissue::intima.impedance() > tissue::blood.impedance());
    CHECK(tissue::tunica_media.impedance() < tissue::adventitia.impedance());
}

TEST_CASE("tissue: an unknown name finds nothing") {
    for (const char* name : {"", "Bone", "bon", "bones", "muscle ", "unobtainium"}) CHECK_FALSE(tissue::find(name));
}

} // namespace tissue_test
