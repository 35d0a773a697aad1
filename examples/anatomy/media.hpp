#ifndef INSONIFY_EXAMPLES_ANATOMY_MEDIA_HPP
#define INSONIFY_EXAMPLES_ANATOMY_MEDIA_HPP

#include <insonify/acoustics/tissue.hpp>

/// Media that only these regions need. Variants of those in `tissue`, with levels by convention.
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

} // namespace anatomy::media

#endif
