#ifndef INSONIFY_EXAMPLES_ANATOMY_MEDIA_HPP
#define INSONIFY_EXAMPLES_ANATOMY_MEDIA_HPP

#include <insonify/acoustics/tissue.hpp>

/// Media that only these regions need. Variants of those in `tissue`, with levels by convention.
namespace anatomy::media {

using namespace insonify;

namespace detail {

constexpr medium with_roughness(medium of, float roughness) {
    of.roughness = roughness;
    return of;
}

constexpr medium with_level(medium of, float level_db) {
    of.backscatter *= amplitude_of_decibels(level_db);
    return of;
}

} // namespace detail

/// Subcutaneous fat and skin whose borders along the beam are hardly visible.
inline constexpr medium fat = detail::with_roughness(tissue::fat, 6_um);
inline constexpr medium skin = detail::with_roughness(tissue::skin, 8_um);

/// The muscle of the skin of the neck, a millimetre thick: too thin for a sheath of its own.
inline constexpr medium platysma{1075, 1585, 1.0_dB_per_cm, 1, amplitude_of_decibels(-9), 6_um};

/// Mucus and bubbles in the folds of a collapsed gullet: as bright as its mucosa, and more.
inline constexpr medium mucus{1030, 1530, 0.8_dB_per_cm, 1, amplitude_of_decibels(8), 10_um};

/// The fibrous disc between two vertebrae.
inline constexpr medium disc{1100, 1620, 2.0_dB_per_cm, 1, amplitude_of_decibels(-3), 15_um};

} // namespace anatomy::media

#endif
