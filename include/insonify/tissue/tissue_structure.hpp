#ifndef INSONIFY_TISSUE_TISSUE_STRUCTURE_HPP
#define INSONIFY_TISSUE_TISSUE_STRUCTURE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/units.hpp>
#include <insonify/tissue/structure.hpp>

/// The structure of the tissues that have one above the scale of speckle.
///
/// Sources: sizes of fascicles, lobules and bundles are those of anatomy textbooks (Standring, Gray's Anatomy, 41st
/// edition). Levels and spacings of muscle were chosen so that images resemble 300 frames of calf and thigh from four
/// scanners in the spacing, length, thickness and contrast of streaks. All other levels are convention, after the clinical
/// appearance.
namespace insonify::inline INSONIFY_ABI::tissue {

/// Skeletal muscle: the walls of its fascicles, the perimysium, are short bright sheets along the fibres, 2 to 3 mm apart;
/// brightness varies over 3 to 10 mm. Epimysium and aponeuroses are 0.7 to 1.5 mm thick.
inline constexpr structure muscle_structure{
    .mottling = {3.5F, {8_mm, 4_mm, 4_mm}},
    .grain = {1.8F, {4_mm, 1.5_mm, 1.5_mm}},
    .wave = 0.2_mm,
    .sheets = {.fill = 0.5F,
               .lattices = 6,
               .cell = {22_mm, 2.4_mm, 2.4_mm},
               .thickness = 0.15_mm,
               .level_db = 24,
               .spread_db = 7.8F,
               .waviness = 0.35F},
    .sheath = {.thickness = 1_mm},
};

/// Myocardium: as skeletal muscle, with finer and fainter sheets. Convention.
inline constexpr structure heart_structure{
    .mottling = {2, {8_mm, 5_mm, 5_mm}},
    .grain = {1.5F, {4_mm, 1.5_mm, 1.5_mm}},
    .wave = 0.2_mm,
    .sheets = {.fill = 0.5F,
               .lattices = 4,
               .cell = {8_mm, 1.6_mm, 1.6_mm},
               .thickness = 0.12_mm,
               .level_db = 12,
               .spread_db = 6,
               .waviness = 0.4F},
};

/// Subcutaneous fat: one to three wavy septa, 0.3 to 0.6 mm thick, which run nearly parallel to the skin over 20 to 50 mm.
/// Along the beam they cannot be seen.
inline constexpr structure fat_structure{
    .mottling = {1.5F, {8_mm, 8_mm, 4_mm}},
    .wave = 0.7_mm,
    .wave_length = 18_mm,
    .septa = {.fill = 0.9F,
              .lattices = 3,
              .cell = {50_mm, 40_mm, 5_mm},
              .thickness = 0.16_mm,
              .level_db = 20,
              .spread_db = 4,
              .turn = 0.05F,
              .tilt = 0.05F,
              .waviness = 0.2F,
              .diffuse_db = -30},
};

/// Tendon and ligament: parallel fibrils, 0.2 to 0.5 mm apart, 10 to 30 mm long. Their sheets hardly wave, so the echo
/// falls within a few degrees of tilt.
/// Source of the anisotropy: Crass, van de Vegte & Harkavy, Radiology 1988 (loss of echoes within 2 to 7 degrees).
inline constexpr structure tendon_structure{
    .mottling = {1, {12_mm, 3_mm, 3_mm}},
    .wave = 0.05_mm,
    .wave_length = 12_mm,
    .sheets = {.fill = 0.95F,
               .lattices = 6,
               .cell = {26_mm, 0.7_mm, 0.7_mm},
               .thickness = 0.06_mm,
               .level_db = 34,
               .spread_db = 3.5F,
               .tilt = 0.005F,
               .waviness = 0.01F,
               .diffuse_db = -30},
};

/// Peripheral nerve: round dark bundles of 0.3 to 1 mm, the fascicles, in the bright net of the epineurium.
inline constexpr structure nerve_structure{
    .mottling = {1, {8_mm, 2_mm, 2_mm}},
    .wave = 0.15_mm,
    .wave_length = 15_mm,
    .bundles = {.spacing = 1.2_mm, .diameter = 1_mm, .level_db = -18},
};

/// Skin: two or three fine layers parallel to its surface.
inline constexpr structure skin_structure{
    .mottling = {1, {4_mm, 4_mm, 1_mm}},
    .wave = 0.05_mm,
    .sheets = {.fill = 0.7F,
               .cell = {30_mm, 30_mm, 0.6_mm},
               .thickness = 0.08_mm,
               .level_db = 9,
               .spread_db = 3,
               .turn = 0.02F,
               .tilt = 0.01F,
               .waviness = 0.3F},
};

/// Liver, spleen, brain: even, with mottling over 5 to 15 mm, 1 to 2 dB. Convention.
inline constexpr structure parenchyma_structure{.mottling = {1.2F, {9_mm, 9_mm, 9_mm}}};

/// Renal cortex: the same, finer. Convention.
inline constexpr structure kidney_structure{.mottling = {1.5F, {5_mm, 5_mm, 5_mm}}};

} // namespace insonify::inline INSONIFY_ABI::tissue

#include <insonify/core/restore_macros.hpp>

#endif
