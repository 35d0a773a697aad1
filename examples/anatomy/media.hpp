#ifndef INSONIFY_EXAMPLES_ANATOMY_MEDIA_HPP
#define INSONIFY_EXAMPLES_ANATOMY_MEDIA_HPP

#include <insonify/acoustics/tissue.hpp>
#include <insonify/core/units.hpp>

/// Media that only these regions need. Variants of those in `tissue`, with levels by convention, after the appearance of
/// clinical images.
namespace anatomy::media {

using namespace insonify;

/// Below a deep fascia, between it and the muscles: fatty. Rough, for the fascia waves over less than a resolution cell.
inline constexpr medium deep_fascia{
    995, 1510, 0.9_dB_per_cm, 1, amplitude_of_decibels(-9), 26_um, 0, tissue::connective_structure};

/// The muscle of the skin of the neck, a millimetre thick and infiltrated by fat: too thin for a sheath of its own.
inline constexpr medium platysma{990, 1495, 1.0_dB_per_cm, 1, amplitude_of_decibels(-11), 35_um};

/// Mucus and bubbles in the folds of a collapsed gullet: as bright as its mucosa, and more.
inline constexpr medium mucus{1030, 1530, 0.8_dB_per_cm, 1, amplitude_of_decibels(12), 10_um};

/// The fibrous disc between two vertebrae.
inline constexpr medium disc{1100, 1620, 2.0_dB_per_cm, 1, amplitude_of_decibels(-3), 15_um};

// Of the back.

/// The long muscles of the back: as `tissue::muscle`, with a thin sheath that drops out along the beam.
inline constexpr medium back_muscle = [] {
    medium of = tissue::muscle;
    of.roughness = 12_um;
    of.structure.sheath = {.thickness = 0.9_mm, .level_db = 22, .diffuse_db = -15, .insertion = 20_mm};
    return of;
}();

/// Elastic, and brighter than the muscles on it.
inline constexpr medium ligamentum_flavum{1110, 1660, 1.5_dB_per_cm, 1, amplitude_of_decibels(9), 20_um};

/// Between two spinous processes: fibres and fat.
inline constexpr medium interspinous_ligament{
    1060,
    1590,
    1.3_dB_per_cm,
    1,
    amplitude_of_decibels(-3),
    10_um,
    0,
    structure{.mottling = {2, {6_mm, 3_mm, 3_mm}}, .grain = {1.5F, {4_mm, 1.5_mm, 1.5_mm}}}};

/// The dura mater, and the longitudinal ligament of the vertebral bodies: dense sheets.
inline constexpr medium dura{1140, 1720, 1.6_dB_per_cm, 1, amplitude_of_decibels(8), 4_um};

/// Between dura and bone.
inline constexpr medium epidural_fat{940, 1460, 0.6_dB_per_cm, 1, amplitude_of_decibels(-9), 6_um};

/// The disc between two lumbar vertebrae: its outer lamellae let little sound pass.
inline constexpr medium annulus{1110, 1640, 3.0_dB_per_cm, 1, amplitude_of_decibels(-9), 20_um};

/// At 37 degrees. As water, with salt.
inline constexpr medium cerebrospinal_fluid{1005, 1520, 0.005_dB_per_cm, 2, 0, 0};

// Of the abdomen.

/// Within the abdomen: omentum, mesentery and what lies behind the peritoneum.
inline constexpr medium visceral_fat{
    950,
    1470,
    0.7_dB_per_cm,
    1,
    amplitude_of_decibels(-2),
    10_um,
    0,
    structure{.mottling = {2.5F, {9_mm, 9_mm, 6_mm}}, .grain = {1.5F, {4_mm, 4_mm, 3_mm}}}};

/// Around the kidney, within the renal fascia.
inline constexpr medium perirenal_fat{
    950, 1465, 0.7_dB_per_cm, 1, amplitude_of_decibels(1), 10_um, 0, structure{.mottling = {2, {6_mm, 6_mm, 4_mm}}}};

/// Fat, vessels and calyces in the middle of the kidney: the brightest part of it.
inline constexpr medium renal_sinus{
    970,
    1480,
    0.8_dB_per_cm,
    1,
    amplitude_of_decibels(7),
    10_um,
    0,
    structure{.mottling = {4, {6_mm, 5_mm, 5_mm}}, .grain = {2.5F, {2.5_mm, 2.5_mm, 2.5_mm}}}};

/// The medulla of the kidney: darker than the cortex.
inline constexpr medium renal_pyramid{1050, 1555, 0.9_dB_per_cm, 1, amplitude_of_decibels(-12), 6_um};

/// The sheath around the branches of the portal vein (Glisson): fat and fibres, with artery and bile duct.
inline constexpr medium portal_tract{1040, 1545, 0.9_dB_per_cm, 1, amplitude_of_decibels(7), 15_um};

/// A gallstone: cholesterol, partly calcified.
inline constexpr medium gallstone{1350, 2400, 8.0_dB_per_cm, 1, amplitude_of_decibels(3), 60_um};

} // namespace anatomy::media

/// Media of a limb, whose borders are softer than those of `tissue`: in images, outlines drop out where they lie along the
/// beam, and vary along it.
namespace anatomy::media::limb {

/// Fascicles are flattened, so that their sheaths are short lines across the fibres.
inline constexpr medium muscle = [] {
    medium made = tissue::muscle;
    made.roughness = 6_um;
    made.structure.sheath = {.thickness = 0.8_mm, .level_db = 21, .diffuse_db = -16, .insertion = 20_mm};
    made.structure.sheets.cell = {21_mm, 3.6_mm, 2_mm};
    return made;
}();
/// Subcutaneous.
inline constexpr medium fat = [] {
    medium made = tissue::fat;
    made.roughness = 12_um;
    made.backscatter = amplitude_of_decibels(-4);
    made.structure.wave = 0.6_mm;
    made.structure.septa.cell = {48_mm, 38_mm, 4_mm};
    made.structure.septa.level_db = 23;
    return made;
}();
/// Of what is too thin for sheets.
inline constexpr structure patches{.mottling = {4, {9_mm, 6_mm, 4_mm}}};
/// A deep fascia: its layers of collagen and fat are a grainy echo rather than two mirrors.
inline constexpr medium fascia{1000, 1515, 1.5_dB_per_cm, 1, amplitude_of_decibels(8), 14_um, 0, patches};
/// An aponeurosis on its muscle: collagen that differs little in impedance.
inline constexpr medium aponeurosis{1088, 1600, 1.5_dB_per_cm, 1, amplitude_of_decibels(3), 6_um, 0, patches};
/// Loose, partly fatty tissue between muscles and around vessels.
inline constexpr medium loose_tissue{
    1050, 1550, 0.8_dB_per_cm, 1, amplitude_of_decibels(-3), 6_um, 0, tissue::connective_structure};
/// The outermost layer of the wall of an artery in fatty tissue, which it fades into.
inline constexpr medium soft_adventitia{1045, 1545, 1.0_dB_per_cm, 1, amplitude_of_decibels(-2), 6_um};

} // namespace anatomy::media::limb

#endif
