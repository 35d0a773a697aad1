#ifndef INSONIFY_ACOUSTICS_TISSUE_HPP
#define INSONIFY_ACOUSTICS_TISSUE_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/later.hpp>
#include <optional>
#include <string_view>

namespace insonify::inline INSONIFY_ABI {

/// Amplitude of a level in whole decibels: 10^(level / 20).
constexpr float amplitude_of_decibels(int level) {
    constexpr double step = 1.1220184543019634356; // 10^(1/20)
    double amplitude = 1;
    for (; level > 0; --level) amplitude *= step;
    for (; level < 0; ++level) amplitude /= step;
    return static_cast<float>(amplitude);
}

/// Media of the body, of tools and of phantoms: rounded picks between published values, none a copy of one database.
///
/// The short names of the sources:
/// IT'IS: tissue database of the IT'IS Foundation, V4.1. Fernandes: Fernandes et al., Bioengineering 2025 12:946.
/// raysim: its material table. Buerger: the open re-implementation of Buerger et al. 2013. Sensors: 2023 23:5942.
/// Diagnostics: 2023 13:855. Mech. Mater.: 2012 44:174. Lu: Lu et al., Ultrasound Med. Biol. 1999. Fei: Fei & Shung,
/// J. Acoust. Soc. Am. 1985. k-Wave, PyMUST, BabelBrain: the documentation of these programs. Szabo, Culjat: as
/// commonly quoted. Spirou: 2005. Browne: 2003. Gammex: guide of the 405 phantoms. CIRS: pages of the 040GSE. ISO:
/// 9613. ASTM: E494. "Convention" marks what no document was read for; backscatter is mostly such: what looks right in
/// a clinic. Attenuation differs between laboratories by up to a factor of 2 for one tissue, speed by less than a
/// percent.
///
/// Roughness is a choice: 30 um for bone, 20 um for soft solids, 2 um for polished metal, 0 for liquids and gases.
namespace tissue {

// clang-format off
// density, sound speed, attenuation at 1 MHz, its power, backscatter, roughness

/// Degassed, at 20 degrees Celsius. Sources: IT'IS, raysim, Sensors, Diagnostics, k-Wave (attenuation).
inline constexpr medium water{998, 1482, 0.00217_dB_per_cm, 2, 0, 0};

/// Saline of 0.9 % at 25 degrees, a local anaesthetic as well. Convention: like water.
inline constexpr medium saline{1004, 1505, 0.0022_dB_per_cm, 2, 0, 0};

/// At 37 degrees. Sources: IT'IS (0.206 f^1.05), raysim (0.18 f), Buerger, Diagnostics, Szabo (0.14 f^1.21: followed).
inline constexpr medium blood{1055, 1575, 0.15_dB_per_cm, 1.2F, amplitude_of_decibels(-20), 0};

/// Under the skin. Sources: IT'IS (0.38 to 0.61 dB/cm), Fernandes, raysim (0.63), Sensors (0.8), Diagnostics,
/// Mech. Mater.
inline constexpr medium fat{930, 1455, 0.6_dB_per_cm, 1, amplitude_of_decibels(-6), 20_um};

/// Dermis. Sources: IT'IS, Fernandes, Sensors, Diagnostics, Buerger, Mech. Mater.
/// Its attenuation is given as 0.35 (Diagnostics), 1.0 (Buerger) and 1.84 dB/cm (IT'IS): here the middle.
inline constexpr medium skin{1110, 1625, 1.2_dB_per_cm, 1, amplitude_of_decibels(3), 20_um};

/// Skeletal, the beam across its fibres. Sources: IT'IS, Fernandes, raysim, Sensors, Diagnostics, Mech. Mater.
/// Anisotropic: 0.96 dB/cm across the fibres, 1.40 along them (Diagnostics); 1562 and 1599 m/s (Fernandes).
inline constexpr medium muscle{1075, 1580, 1.0_dB_per_cm, 1, amplitude_of_decibels(-6), 20_um};

/// Tendon and ligament. Sources: IT'IS (1.26 f^1.17), Fernandes, Mech. Mater., Culjat (4.7 dB/cm).
inline constexpr medium tendon{1130, 1750, 1.8_dB_per_cm, 1.1F, amplitude_of_decibels(6), 20_um};

/// Connective tissue. Sources: Diagnostics (attenuation), Culjat (density and speed); IT'IS has 1027 kg/m^3, 1545 m/s.
inline constexpr medium fascia{1120, 1613, 1.57_dB_per_cm, 1, amplitude_of_decibels(6), 20_um};

/// Peripheral. Source: IT'IS alone.
inline constexpr medium nerve{1075, 1630, 1.1_dB_per_cm, 1, amplitude_of_decibels(3), 20_um};

/// The reference of backscatter: 5e-4 /cm/sr at 3 MHz (Lu).
/// Sources: IT'IS, Fernandes, raysim, Buerger, Diagnostics, Mech. Mater., Lu (1.66 dB/cm at 3 MHz, in vivo).
inline constexpr medium liver{1060, 1570, 0.52_dB_per_cm, 1.05F, amplitude_of_decibels(0), 20_um};

/// Cortex. Sources: IT'IS, Fernandes, Buerger, Diagnostics, Mech. Mater.
/// IT'IS has 0.244 dB/cm for the kidney but 1.04 for its cortex; Buerger and Diagnostics 1.0: followed.
inline constexpr medium kidney{1060, 1560, 1.0_dB_per_cm, 1, amplitude_of_decibels(-4), 20_um};

/// Sources: IT'IS, Diagnostics, Mech. Mater., Szabo. Excised it scatters least of five organs (Fei), in the clinic it
/// looks like liver or brighter: the latter followed.
inline constexpr medium spleen{1060, 1567, 0.4_dB_per_cm, 1.3F, amplitude_of_decibels(0), 20_um};

/// Sources: IT'IS, Fernandes, Mech. Mater., BabelBrain (0.60 dB/cm), Szabo.
inline constexpr medium brain{1040, 1550, 0.58_dB_per_cm, 1.3F, amplitude_of_decibels(-6), 20_um};

/// Myocardium. Sources: IT'IS, Fernandes, Diagnostics, Mech. Mater.
inline constexpr medium heart{1065, 1570, 0.45_dB_per_cm, 1.1F, amplitude_of_decibels(-4), 20_um};

/// Sources: IT'IS, Buerger (whose impedance, 1.99 MRayl, is the highest), Mech. Mater.
inline constexpr medium vessel_wall{1100, 1570, 0.7_dB_per_cm, 1, amplitude_of_decibels(3), 20_um};

/// Of the urinary bladder. Source: IT'IS, whose 1500 m/s is that database's default and not followed.
inline constexpr medium bladder_wall{1075, 1560, 0.5_dB_per_cm, 1, amplitude_of_decibels(-2), 20_um};

/// Source: IT'IS.
inline constexpr medium urine{1022, 1538, 0.006_dB_per_cm, 1.6F, 0, 0};

/// Sources: IT'IS (0.131 dB/cm), Buerger (1.0).
inline constexpr medium gallbladder_wall{1070, 1580, 0.5_dB_per_cm, 1, amplitude_of_decibels(0), 20_um};

/// Source: IT'IS, but for its density of 928 kg/m^3: bile is denser than water.
inline constexpr medium bile{1015, 1510, 0.03_dB_per_cm, 1.3F, 0, 0};

/// Hyaline. Sources: IT'IS, Fernandes, Mech. Mater.
/// The 0.038 dB/cm of IT'IS are implausibly low; attenuation by convention, textbooks have about 5.
inline constexpr medium cartilage{1100, 1650, 3.0_dB_per_cm, 1, amplitude_of_decibels(-15), 20_um};

/// Cortical, as a fluid: longitudinal waves only. Its surface is what is seen.
/// Sources: IT'IS (6.71 MRayl), Fernandes (5.95), Sensors (6.50), Diagnostics, Mech. Mater., BabelBrain.
/// raysim, Buerger and classic teaching have 7.80 MRayl with 4080 m/s: not followed, it is above all measurements.
inline constexpr medium bone_cortical{1910, 3500, 5.0_dB_per_cm, 1, 0, 30_um};

/// Cancellous. Sources: IT'IS (4.08 f^1.2), Fernandes, Mech. Mater., Culjat.
inline constexpr medium bone_trabecular{1180, 2100, 6.0_dB_per_cm, 1, 0, 30_um};

/// Another name for `bone_cortical`.
inline constexpr medium bone = bone_cortical;

/// Inflated. Sources: IT'IS (949 m/s, 20.1 dB/cm), Diagnostics; speed and power by convention.
inline constexpr medium lung{400, 650, 40.0_dB_per_cm, 0.6F, 0, 20_um};

/// At 20 degrees. Sources: ISO (its leading term gives 1.60 dB/cm), Buerger (1.64).
/// IT'IS has 0.0034 dB/cm, 470 times too low, and Diagnostics 7.5: neither followed.
inline constexpr medium air{1.2F, 343, 1.6_dB_per_cm, 2, 0, 0};

/// For coupling. Convention; Buerger sets its impedance to that of the first tissue.
inline constexpr medium gel{1020, 1520, 0.05_dB_per_cm, 1, 0, 0};

/// Of a probe: silicone rubber. Convention.
inline constexpr medium lens{1200, 1020, 4.0_dB_per_cm, 1.3F, 0, 20_um};

/// Crystalline. Sources: IT'IS, Mech. Mater.
/// The attenuation is that of IT'IS and implausibly low; others have about 2 dB/cm.
inline constexpr medium eye_lens{1076, 1643, 0.06_dB_per_cm, 1, amplitude_of_decibels(-15), 20_um};

/// What a scanner assumes everywhere. Sources: PyMUST, CIRS, Culjat, and the derating of the FDA (0.3 dB/cm).
inline constexpr medium soft_tissue{1058, 1540, 0.5_dB_per_cm, 1, amplitude_of_decibels(-2), 20_um};

/// Stainless, 304 or 316: needles. Source: ASTM. Longitudinal waves only (shear: 3100 m/s).
inline constexpr medium steel{7900, 5740, 0.05_dB_per_cm, 1, 0, 2_um};

/// Ti-6Al-4V. Sources: ASTM, Sensors. Longitudinal waves only (shear: about 3250 m/s).
inline constexpr medium titanium{4430, 6170, 0.3_dB_per_cm, 1, 0, 2_um};

/// Plastisol phantom. Source: Spirou (1400 m/s, 0.56 f^1.51 below 1.25 MHz).
inline constexpr medium pvcp{1000, 1400, 0.56_dB_per_cm, 1.5F, amplitude_of_decibels(-6), 20_um};

/// Tissue-mimicking, the class of 0.5 dB/(cm MHz). Sources: CIRS, Gammex, Browne (measured powers: 1.08 to 1.83).
inline constexpr medium tmm_low{1040, 1540, 0.5_dB_per_cm, 1, amplitude_of_decibels(0), 20_um};

/// Tissue-mimicking, the class of 0.7 dB/(cm MHz). Source: CIRS.
inline constexpr medium tmm_high{1040, 1540, 0.7_dB_per_cm, 1, amplitude_of_decibels(0), 20_um};

/// A cyst of a phantom: tissue-mimicking without scatterers. Source: Gammex.
inline constexpr medium tmm_cyst{1040, 1540, 0.05_dB_per_cm, 1, 0, 20_um};

/// Tissue-mimicking rubber: slower than the 1540 m/s a scanner assumes, so depths look 6 % too large.
/// Source: Browne; its speed by convention, 1450 m/s at 23 degrees.
inline constexpr medium urethane{1050, 1450, 0.5_dB_per_cm, 1.3F, amplitude_of_decibels(0), 20_um};

// clang-format on

/// A medium under the name that it has in `tissue`.
struct named_medium {
    const char* name = ""; ///< as written in the code
    medium value{};        ///< its numbers
};

// clang-format off
#define INSONIFY_NAMED(id) named_medium{#id, id}
/// Every medium of `tissue`.
inline constexpr named_medium all[] = {
    INSONIFY_NAMED(water), INSONIFY_NAMED(saline), INSONIFY_NAMED(blood), INSONIFY_NAMED(fat), INSONIFY_NAMED(skin),
    INSONIFY_NAMED(muscle), INSONIFY_NAMED(tendon), INSONIFY_NAMED(fascia), INSONIFY_NAMED(nerve),
    INSONIFY_NAMED(liver), INSONIFY_NAMED(kidney), INSONIFY_NAMED(spleen), INSONIFY_NAMED(brain),
    INSONIFY_NAMED(heart), INSONIFY_NAMED(vessel_wall), INSONIFY_NAMED(bladder_wall), INSONIFY_NAMED(urine),
    INSONIFY_NAMED(gallbladder_wall), INSONIFY_NAMED(bile), INSONIFY_NAMED(cartilage), INSONIFY_NAMED(bone),
    INSONIFY_NAMED(bone_cortical), INSONIFY_NAMED(bone_trabecular), INSONIFY_NAMED(lung), INSONIFY_NAMED(air),
    INSONIFY_NAMED(gel), INSONIFY_NAMED(lens), INSONIFY_NAMED(eye_lens), INSONIFY_NAMED(soft_tissue),
    INSONIFY_NAMED(steel), INSONIFY_NAMED(titanium), INSONIFY_NAMED(pvcp), INSONIFY_NAMED(tmm_low),
    INSONIFY_NAMED(tmm_high), INSONIFY_NAMED(tmm_cyst), INSONIFY_NAMED(urethane),
};
#undef INSONIFY_NAMED
// clang-format on

/// The medium of that name, as a mesh file may give it; none where there is no such name. Case counts.
INSONIFY_LAZY constexpr later_t<Later, std::optional<medium>> find(std::string_view name) {
    for (const named_medium& each : all)
        if (name == each.name) return each.value;
    return std::nullopt;
}

} // namespace tissue
} // namespace insonify::inline INSONIFY_ABI
#endif
