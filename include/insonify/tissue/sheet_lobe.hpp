#ifndef INSONIFY_TISSUE_SHEET_LOBE_HPP
#define INSONIFY_TISSUE_SHEET_LOBE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/tissue/structure.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

inline constexpr float bits_per_decibel = 0.16609640F; // log2(10) / 20
/// Largest value of the random numbers that sheets take their levels from: a sum of two uniform ones, of variance 1.
inline constexpr float max_level_number = 2.4494897F;

/// Sine of the angle at which the echo of a sheet has fallen to half its amplitude: the lobe of the aperture (see
/// `specular_return`, whose half width is 0.53 of the edge's angle), widened by the waviness of the sheet.
INSONIFY_FN inline float lobe_of(float waviness, float fnumber) {
    const float aperture = 0.53F * std::atan(1 / (2 * fnumber)), facets = 1.1774F * waviness;
    return std::sin(min(std::sqrt(aperture * aperture + facets * facets), pi / 2));
}

/// Angle between a lattice of sheets and the fibres, radians: to either side by turns, 0.3 to 1 of `tilt`.
INSONIFY_FN inline float tilt_of_lattice(const structure::sheet_layer& layer, std::uint32_t k) {
    const float steep = 0.3F + 0.7F * static_cast<float>(k * 5 % 6) / 5;
    return (k % 2 == 0 ? steep : -steep) * layer.tilt;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
