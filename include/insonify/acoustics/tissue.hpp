#ifndef INSONIFY_ACOUSTICS_TISSUE_HPP
#define INSONIFY_ACOUSTICS_TISSUE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/units.hpp>
#include <insonify/tissue/structure.hpp>
#include <optional>
#include <string_view>

namespace insonify::inline INSONIFY_ABI {

/// Media of the body, of instruments and of phantoms. The values are rounded choices within the published range; none
/// is copied from a single database.
///
/// Sources, by their short names: IT'IS: tissue database of the IT'IS Foundation, V4.1. Fernandes: Fernandes et al.,
/// Bioengineering 2025 12:946. raysim: its material table. Buerger: the open re-implementation of Buerger et al. 2013.
/// Sensors: 2023 23:5942. Diagnostics: 2023 13:855. Mech. Mater.: 2012 44:174. Lu: Lu et al., Ultrasound Med. Biol.
/// 1999. Fei: Fei & Shung, J. Acoust. Soc. Am. 1985. k-Wave, PyMUST, BabelBrain: the documentation of these programs.
/// Szabo, Culjat: as commonly quoted. Spirou: 2005. Browne: 2003. Gammex: guide to the 405 phantoms. CIRS: data of the
/// 040GSE. ISO: 9613. ASTM: E494. Assentoft: Assentoft et al., Ultrasonics 2001 39:263 (oesophagus of guinea pigs).
/// "Convention" marks values without a published source; this includes most backscatter
/// levels, which follow the clinical appearance. Published attenuation of one tissue usually varies between
/// laboratories by a factor of 2, and by more where an entry says so; sound speed varies by a few percent.
///
/// Roughness is by convention: 30 um for bone, 20 um for soft solids, 6 um for thin muscles and for the layers of
/// walls,
/// so that those along the beam are hardly visible, 2 um for polished metal, 0 for liquids and gases.
/// Phantoms, liquids, walls and what scatters little have no structure.
///
/// Sources of structure: sizes of fascicles, lobules and bundles are those of anatomy textbooks (Standring, Gray's
/// Anatomy, 41st edition). Levels and spacings of muscle were chosen so that images resemble 300 frames of calf and
/// thigh from four scanners in the spacing, length, thickness and contrast of streaks. All other levels are convention,
/// after the clinical appearance.
namespace tissue {

// clang-format off

/// Skeletal muscle: the walls of its fascicles, the perimysium, are short bright sheets along the fibres, 2 to 3 mm
/// apart, and bent across them; longer and stronger ones divide it. Brightness varies over 3 to 10 mm. Epimysium
/// and aponeuroses are 0.7 to 1.5 mm thick.
inline constexpr structure muscle_structure{
    .mottling = {3.5F, {8_mm, 4_mm, 4_mm}}, .grain = {1.8F, {4_mm, 1.5_mm, 1.5_mm}}, .wave = 0.2_mm,
    .sheets = {.fill = 0.64F, .lattices = 5, .cell = {17_mm, 5.5_mm, 2_mm}, .thickness = 0.1_mm, .level_db = 21,
               .spread_db = 8.5F, .turn = 0.8F, .bend = 0.5F, .waviness = 0.4F},
    .septa = {.fill = 0.6F, .lattices = 2, .cell = {45_mm, 18_mm, 9_mm}, .thickness = 0.14_mm, .level_db = 26,
              .spread_db = 5, .turn = 0.5F, .bend = 0.5F, .tilt = 0.05F, .waviness = 0.4F, .diffuse_db = -16},
    .sheath = {.thickness = 1_mm, .insertion = 20_mm}};

/// A muscle of a few millimetres, as those of the neck, between the fingers or of the abdominal wall: fascicles are
/// flattened as the muscle is, and the sheath leaves room for them. Convention.
inline constexpr structure thin_muscle_structure{
    .mottling = {2.5F, {8_mm, 4_mm, 2.5_mm}}, .grain = {1.8F, {4_mm, 1.2_mm, 1.2_mm}}, .wave = 0.15_mm,
    .sheets = {.fill = 0.6F, .lattices = 5, .cell = {18_mm, 4.2_mm, 1.7_mm}, .thickness = 0.11_mm, .level_db = 21,
               .spread_db = 7, .turn = 0.6F, .bend = 0.5F, .waviness = 0.3F},
    .sheath = {.thickness = 0.45_mm, .level_db = 15, .diffuse_db = -18}};

/// Loose connective tissue: a few wavy lamellae of unequal strength. Convention.
inline constexpr structure connective_structure{
    .mottling = {3, {9_mm, 6_mm, 4_mm}}, .wave = 0.45_mm, .wave_length = 12_mm,
    .septa = {.fill = 0.75F, .lattices = 4, .cell = {22_mm, 12_mm, 2.6_mm}, .thickness = 0.13_mm, .level_db = 20,
              .spread_db = 6, .turn = 0.5F, .tilt = 0.15F, .waviness = 0.35F, .diffuse_db = -18}};

/// Myocardium: as skeletal muscle, with finer and fainter sheets. Convention.
inline constexpr structure heart_structure{
    .mottling = {2, {8_mm, 5_mm, 5_mm}}, .grain = {1.5F, {4_mm, 1.5_mm, 1.5_mm}}, .wave = 0.2_mm,
    .sheets = {.fill = 0.5F, .lattices = 4, .cell = {8_mm, 1.6_mm, 1.6_mm}, .thickness = 0.12_mm, .level_db = 12,
               .spread_db = 6, .waviness = 0.4F}};

/// Subcutaneous fat: wavy septa of unequal strength, 0.3 to 0.6 mm thick, which run nearly parallel to the skin over 20
/// to 50 mm, branch, and join the fascia; shorter and fainter ones between them. Along the beam they cannot be seen.
inline constexpr structure fat_structure{
    .mottling = {2.2F, {8_mm, 8_mm, 4_mm}}, .wave = 0.7_mm, .wave_length = 17_mm,
    .sheets = {.fill = 0.3F, .lattices = 2, .cell = {14_mm, 9_mm, 3_mm}, .thickness = 0.1_mm, .level_db = 13,
               .spread_db = 5, .turn = 0.2F, .tilt = 0.2F, .waviness = 0.3F},
    .septa = {.fill = 0.9F, .lattices = 4, .cell = {60_mm, 45_mm, 6.5_mm}, .thickness = 0.12_mm, .level_db = 25,
              .spread_db = 6, .turn = 0.14F, .tilt = 0.14F, .waviness = 0.25F, .diffuse_db = -30}};

/// Fat between and around muscles and organs: coarse patches, without septa. Convention.
inline constexpr structure deep_fat_structure{.mottling = {2.5F, {9_mm, 9_mm, 6_mm}}, .grain = {1.5F, {4_mm, 4_mm, 3_mm}}};

/// Tendon and ligament: parallel fibrils, 0.2 to 0.5 mm apart, 10 to 30 mm long. Their sheets hardly wave, so the echo
/// falls within a few degrees of tilt.
/// Source of the anisotropy: Crass, van de Vegte & Harkavy, Radiology 1988 (loss of echoes within 2 to 7 degrees).
inline constexpr structure tendon_structure{
    .mottling = {1, {12_mm, 3_mm, 3_mm}}, .wave = 0.05_mm, .wave_length = 12_mm,
    .sheets = {.fill = 0.95F, .lattices = 6, .cell = {26_mm, 0.7_mm, 0.7_mm}, .thickness = 0.06_mm, .level_db = 34,
               .spread_db = 3.5F, .tilt = 0.005F, .waviness = 0.01F, .diffuse_db = -30}};

/// Peripheral nerve: round dark bundles of 0.3 to 1 mm, the fascicles, in the bright net of the epineurium.
inline constexpr structure nerve_structure{
    .mottling = {1, {8_mm, 2_mm, 2_mm}}, .wave = 0.15_mm, .wave_length = 15_mm,
    .bundles = {.spacing = 1.2_mm, .diameter = 1_mm, .level_db = -18}};

/// Skin: two or three fine layers parallel to its surface.
inline constexpr structure skin_structure{
    .mottling = {1, {4_mm, 4_mm, 1_mm}}, .wave = 0.05_mm,
    .sheets = {.fill = 0.7F, .cell = {30_mm, 30_mm, 0.6_mm}, .thickness = 0.08_mm, .level_db = 9, .spread_db = 3,
               .turn = 0.02F, .tilt = 0.01F, .waviness = 0.3F}};

/// Liver, spleen, brain: even, with mottling over 5 to 15 mm, 1 to 2 dB. Convention.
inline constexpr structure parenchyma_structure{.mottling = {1.2F, {9_mm, 9_mm, 9_mm}}};

/// Thyroid: the same, in lobules. Convention.
inline constexpr structure thyroid_structure{.mottling = {1.6F, {4_mm, 4_mm, 4_mm}}};

/// Renal cortex: the same, finer. Convention.
inline constexpr structure kidney_structure{.mottling = {1.5F, {5_mm, 5_mm, 5_mm}}};

// density, sound speed, attenuation at 1 MHz, exponent of frequency, backscatter, roughness, density of scatterers,
// structure

/// Degassed, at 20 degrees Celsius. Sources: IT'IS, raysim, Sensors, Diagnostics, k-Wave (attenuation).
inline constexpr medium water{998, 1482, 0.00217_dB_per_cm, 2, 0, 0};

/// 0.9 % saline at 25 degrees; also a local anaesthetic. Convention: as water.
inline constexpr medium saline{1004, 1505, 0.0022_dB_per_cm, 2, 0, 0};

/// At 37 degrees. Sources: IT'IS (0.206 f^1.05), raysim (0.18 f), Buerger, Diagnostics, Szabo (0.14 f^1.21, adopted).
/// Backscatter at 5 to 8 MHz, flowing: about 30 dB below liver, after Shung et al., J. Acoust. Soc. Am. 1976.
inline constexpr medium blood{.density = 1055, .sound_speed = 1575, .attenuation = 0.15_dB_per_cm, .attenuation_power = 1.2F,
                              .backscatter = amplitude_of_decibels(-30), .flowing = true};

/// Subcutaneous. Sources: IT'IS (0.38 to 0.61 dB/cm), Fernandes, raysim (0.63), Sensors (0.8), Diagnostics,
/// Mech. Mater.
inline constexpr medium fat{930, 1455, 0.6_dB_per_cm, 1, amplitude_of_decibels(-6), 20_um, 0, fat_structure};

/// Between and around muscles and organs. As `fat` without its septa, and as dark as between them.
inline constexpr medium deep_fat{930, 1455, 0.6_dB_per_cm, 1, amplitude_of_decibels(-11), 20_um, 0, deep_fat_structure};

/// Dermis. Sources: IT'IS, Fernandes, Sensors, Diagnostics, Buerger, Mech. Mater.
/// Published attenuation: 0.35 (Diagnostics), 1.0 (Buerger) and 1.84 dB/cm (IT'IS); an intermediate value is adopted.
inline constexpr medium skin{1110, 1625, 1.2_dB_per_cm, 1, amplitude_of_decibels(3), 20_um, 0, skin_structure};

/// Skeletal, with the beam across its fibres. Sources: IT'IS, Fernandes, raysim, Sensors, Diagnostics, Mech. Mater.
/// Anisotropic: 0.96 dB/cm across the fibres, 1.40 along them (Diagnostics); 1562 and 1599 m/s (Fernandes).
inline constexpr medium muscle{1075, 1580, 1.0_dB_per_cm, 1, amplitude_of_decibels(-6), 20_um, 0, muscle_structure};

/// Tendon and ligament. Sources: IT'IS (1.26 f^1.17), Fernandes, Mech. Mater., Culjat (4.7 dB/cm).
inline constexpr medium tendon{1130, 1750, 1.8_dB_per_cm, 1.1F, amplitude_of_decibels(6), 20_um, 0, tendon_structure};

/// Connective tissue. Sources: Diagnostics (attenuation), Culjat (density and speed); IT'IS has 1027 kg/m^3, 1545 m/s.
inline constexpr medium fascia{1120, 1613, 1.57_dB_per_cm, 1, amplitude_of_decibels(6), 20_um};

/// A skeletal muscle of a few millimetres. As `muscle`, with a thinner sheath.
inline constexpr medium thin_muscle{1075, 1580, 1.0_dB_per_cm, 1, amplitude_of_decibels(-7), 6_um, 0, thin_muscle_structure};

/// Loose, between muscles and around vessels. Source: IT'IS (density and speed); attenuation between fat and fascia.
inline constexpr medium connective_tissue{1027, 1545, 0.9_dB_per_cm, 1, amplitude_of_decibels(-9), 6_um, 0, connective_structure};

/// The capsule of a gland or organ: dense connective tissue, in a thin layer. Source: as `fascia`.
inline constexpr medium capsule{1100, 1600, 1.57_dB_per_cm, 1, amplitude_of_decibels(4), 6_um};

/// A fascicle of a nerve: hypoechoic. Convention, after IT'IS for the whole nerve.
inline constexpr medium nerve_fascicle{1065, 1605, 1.0_dB_per_cm, 1, amplitude_of_decibels(-13), 6_um};

/// The connective tissue around the fascicles of a nerve: hyperechoic. Convention, after IT'IS for the whole nerve.
inline constexpr medium epineurium{1070, 1610, 1.2_dB_per_cm, 1, amplitude_of_decibels(4), 6_um};

/// Peripheral. Source: IT'IS.
inline constexpr medium nerve{1075, 1630, 1.1_dB_per_cm, 1, amplitude_of_decibels(3), 20_um, 0, nerve_structure};

/// The reference for backscatter: 5e-4 /cm/sr at 3 MHz (Lu).
/// Sources: IT'IS, Fernandes, raysim, Buerger, Diagnostics, Mech. Mater., Lu (1.66 dB/cm at 3 MHz, in vivo).
inline constexpr medium liver{1060, 1570, 0.52_dB_per_cm, 1.05F, amplitude_of_decibels(0), 20_um, 0, parenchyma_structure};

/// Cortex. Sources: IT'IS, Fernandes, Buerger, Diagnostics, Mech. Mater.
/// IT'IS has 0.244 dB/cm for the kidney but 1.04 for its cortex; the 1.0 of Buerger and Diagnostics is adopted.
inline constexpr medium kidney{1060, 1560, 1.0_dB_per_cm, 1, amplitude_of_decibels(-4), 20_um, 0, kidney_structure};

/// Gland; brighter than muscle, as fine as liver. Density: ICRU Report 44. The rest by convention, around `liver`.
inline constexpr medium thyroid{1050, 1565, 0.6_dB_per_cm, 1.1F, amplitude_of_decibels(1), 6_um, 0, thyroid_structure};

/// Sources: IT'IS, Diagnostics, Mech. Mater., Szabo. Excised spleen scatters least of five organs (Fei), but clinically
/// it is as bright as liver or brighter, which is adopted.
inline constexpr medium spleen{1060, 1567, 0.4_dB_per_cm, 1.3F, amplitude_of_decibels(0), 20_um, 0, parenchyma_structure};

/// Sources: IT'IS, Fernandes, Mech. Mater., BabelBrain (0.60 dB/cm), Szabo.
inline constexpr medium brain{1040, 1550, 0.58_dB_per_cm, 1.3F, amplitude_of_decibels(-6), 20_um, 0, parenchyma_structure};

/// Myocardium. Sources: IT'IS, Fernandes, Diagnostics, Mech. Mater.
inline constexpr medium heart{1065, 1570, 0.45_dB_per_cm, 1.1F, amplitude_of_decibels(-4), 20_um, 0, heart_structure};

/// Sources: IT'IS, Buerger (whose impedance, 1.99 MRayl, is the highest), Mech. Mater.
inline constexpr medium vessel_wall{1100, 1570, 0.7_dB_per_cm, 1, amplitude_of_decibels(3), 20_um};

/// The layers of an artery's wall, which give it a double line: from inside, bright intima, dark media, bright
/// adventitia, which gradually becomes loose. Source of the lines: Pignoli et al., Circulation 1986 74:1399;
/// densities and speeds around those of
/// `vessel_wall`, levels by convention.
/// @{
inline constexpr medium intima{1085, 1590, 0.7_dB_per_cm, 1, amplitude_of_decibels(-4), 6_um};
inline constexpr medium tunica_media{1035, 1505, 0.7_dB_per_cm, 1, amplitude_of_decibels(-14), 6_um};
inline constexpr medium adventitia{1055, 1540, 1.2_dB_per_cm, 1, amplitude_of_decibels(-5), 6_um};
/// @}

/// Of a vein: one thin layer. Convention, as `vessel_wall`.
inline constexpr medium vein_wall{1075, 1570, 0.7_dB_per_cm, 1, amplitude_of_decibels(-3), 6_um};

/// Mucosa and submucosa of gullet and gut: hyperechoic. Source: Assentoft (1584 m/s); the rest by convention.
inline constexpr medium mucosa{1050, 1584, 0.8_dB_per_cm, 1, amplitude_of_decibels(0), 6_um};

/// The muscle of gullet and gut: hypoechoic. Source: Assentoft (1624 m/s); the rest as `muscle`.
inline constexpr medium muscularis{1060, 1624, 1.0_dB_per_cm, 1, amplitude_of_decibels(-10), 6_um};

/// Of the urinary bladder. Source: IT'IS, except its 1500 m/s, which is that database's default.
inline constexpr medium bladder_wall{1075, 1560, 0.5_dB_per_cm, 1, amplitude_of_decibels(-2), 20_um};

/// Source: IT'IS.
inline constexpr medium urine{1022, 1538, 0.006_dB_per_cm, 1.6F, 0, 0};

/// Sources: IT'IS (0.131 dB/cm), Buerger (1.0).
inline constexpr medium gallbladder_wall{1070, 1580, 0.5_dB_per_cm, 1, amplitude_of_decibels(0), 20_um};

/// Source: IT'IS, except its density of 928 kg/m^3: bile is denser than water.
inline constexpr medium bile{1015, 1510, 0.03_dB_per_cm, 1.3F, 0, 0};

/// Hyaline. Sources: IT'IS, Fernandes, Mech. Mater.
/// The 0.038 dB/cm of IT'IS is implausibly low. Attenuation by convention; textbooks have about 5 dB/cm.
inline constexpr medium cartilage{1100, 1650, 3.0_dB_per_cm, 1, amplitude_of_decibels(-15), 20_um};

/// Cortical, as a fluid: longitudinal waves only. Only its surface is visible.
/// Sources: IT'IS (6.71 MRayl), Fernandes (5.95), Sensors (6.50), Diagnostics, Mech. Mater., BabelBrain.
/// raysim, Buerger and older textbooks have 7.80 MRayl with 4080 m/s, which exceeds all measurements.
inline constexpr medium bone_cortical{1910, 3500, 5.0_dB_per_cm, 1, 0, 30_um};

/// Cancellous. Sources: IT'IS (4.08 f^1.2), Fernandes, Mech. Mater., Culjat.
inline constexpr medium bone_trabecular{1180, 2100, 6.0_dB_per_cm, 1, 0, 30_um};

/// Same as `bone_cortical`.
inline constexpr medium bone = bone_cortical;

/// Inflated. Sources: IT'IS (949 m/s, 20.1 dB/cm), Diagnostics; sound speed and exponent by convention.
inline constexpr medium lung{400, 650, 40.0_dB_per_cm, 0.6F, 0, 20_um};

/// At 20 degrees. Sources: ISO (1.60 dB/cm from its leading term), Buerger (1.64).
/// IT'IS has 0.0034 dB/cm, 470 times too low, and Diagnostics 7.5; neither is adopted.
inline constexpr medium air{1.2F, 343, 1.6_dB_per_cm, 2, 0, 0};

/// Coupling gel. Convention; Buerger gives it the impedance of the first tissue.
inline constexpr medium gel{1020, 1520, 0.05_dB_per_cm, 1, 0, 0};

/// Lens of a probe: silicone rubber. Convention.
inline constexpr medium lens{1200, 1020, 4.0_dB_per_cm, 1.3F, 0, 20_um};

/// Crystalline. Sources: IT'IS, Mech. Mater.
/// Attenuation as in IT'IS, which is implausibly low; others have about 2 dB/cm.
inline constexpr medium eye_lens{1076, 1643, 0.06_dB_per_cm, 1, amplitude_of_decibels(-15), 20_um};

/// The mean that scanners assume. Sources: PyMUST, CIRS, Culjat, and the derating of the FDA (0.3 dB/cm).
inline constexpr medium soft_tissue{1058, 1540, 0.5_dB_per_cm, 1, amplitude_of_decibels(-2), 20_um};

/// Stainless, 304 or 316: needles. Source: ASTM. Longitudinal waves only (shear: 3100 m/s).
inline constexpr medium steel{7900, 5740, 0.05_dB_per_cm, 1, 0, 2_um};

/// Ti-6Al-4V. Sources: ASTM, Sensors. Longitudinal waves only (shear: about 3250 m/s).
inline constexpr medium titanium{4430, 6170, 0.3_dB_per_cm, 1, 0, 2_um};

/// Plastisol phantom. Source: Spirou (1400 m/s, 0.56 f^1.51 below 1.25 MHz).
inline constexpr medium pvcp{1000, 1400, 0.56_dB_per_cm, 1.5F, amplitude_of_decibels(-6), 20_um};

/// Tissue-mimicking material of 0.5 dB/(cm MHz). Sources: CIRS, Gammex, Browne (measured exponents: 1.08 to 1.83).
inline constexpr medium tmm_low{1040, 1540, 0.5_dB_per_cm, 1, amplitude_of_decibels(0), 20_um};

/// Tissue-mimicking material of 0.7 dB/(cm MHz). Source: CIRS.
inline constexpr medium tmm_high{1040, 1540, 0.7_dB_per_cm, 1, amplitude_of_decibels(0), 20_um};

/// Anechoic tissue-mimicking material, for cysts in phantoms. Source: Gammex.
inline constexpr medium tmm_cyst{1040, 1540, 0.05_dB_per_cm, 1, 0, 20_um};

/// Tissue-mimicking rubber. It is slower than the 1540 m/s that scanners assume, so displayed depths are 6 % too large.
/// Source: Browne; sound speed by convention, 1450 m/s at 23 degrees.
inline constexpr medium urethane{1050, 1450, 0.5_dB_per_cm, 1.3F, amplitude_of_decibels(0), 20_um};

// clang-format on

/// A medium with its name in `tissue`.
struct named_medium {
    const char* name = ""; ///< such as "muscle"
    medium value{};        ///< its properties
};

// clang-format off
#define INSONIFY_NAMED(id) named_medium{#id, id}
/// Every medium of `tissue`.
inline constexpr named_medium all[] = {
    INSONIFY_NAMED(water), INSONIFY_NAMED(saline), INSONIFY_NAMED(blood), INSONIFY_NAMED(fat), INSONIFY_NAMED(deep_fat),
    INSONIFY_NAMED(skin),
    INSONIFY_NAMED(muscle), INSONIFY_NAMED(thin_muscle), INSONIFY_NAMED(tendon), INSONIFY_NAMED(fascia),
    INSONIFY_NAMED(connective_tissue), INSONIFY_NAMED(capsule), INSONIFY_NAMED(nerve), INSONIFY_NAMED(nerve_fascicle),
    INSONIFY_NAMED(epineurium), INSONIFY_NAMED(thyroid), INSONIFY_NAMED(intima), INSONIFY_NAMED(tunica_media),
    INSONIFY_NAMED(adventitia), INSONIFY_NAMED(vein_wall), INSONIFY_NAMED(mucosa), INSONIFY_NAMED(muscularis),
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

/// The medium of that name, case-sensitive; none if there is no such medium.
constexpr std::optional<medium> find(std::string_view name) {
    for (const named_medium& each : all)
        if (name == each.name) return each.value;
    return std::nullopt;
}

} // namespace tissue
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
