#ifndef INSONIFY_TISSUE_STRUCTURE_RMS_HPP
#define INSONIFY_TISSUE_STRUCTURE_RMS_HPP

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

/// Mean and mean square of a random factor.
struct two_moments {
    float mean = 1;
    float square = 1;
};

/// Of 10^(n deviation_db / 20), n normally distributed.
INSONIFY_FN inline two_moments moments_of(const structure::variation& v) {
    const float neper = 0.115129255F * v.deviation_db;
    return {std::exp(neper * neper / 2), std::exp(2 * neper * neper)};
}

/// Of the sum of a layer's sheets at one point, where the beam runs along z.
///
///     mean   = n p <level> V1 <echo>,   V1 = sqrt(2 pi) t <l w> (pi / 2)^2 / 4 / cell
///     square = n p <level^2> V2 <echo^2> + (1 - 1 / n) mean^2,   V2 = sqrt(pi) t <l w> (4 / 3)^2 / 4 / cell
///
/// for n lattices with a fraction p of full cells, thickness t, length l and width w of the sheets. Source: integrals of
/// the profile exp(-d^2 / 2 t^2) and of the outline sqrt((1 - x^2) (1 - y^2)) of `structure_gains::sheet`.
INSONIFY_FN inline two_moments moments_of(const structure::sheet_layer& of, float fnumber) {
    if (!(of.fill > 0)) return {0, 0};
    // The level is 10^((level_db + spread_db n) / 20), n a sum of two uniform numbers: <exp(a n)> = (sinh(b) / b)^2.
    const auto level = [&](float power) {
        const float neper = 0.115129255F * power, b = 0.5F * neper * of.spread_db * max_level_number;
        const float spread = b > 1e-3F ? std::sinh(b) / b : 1.0F;
        return std::exp(neper * of.level_db) * spread * spread;
    };
    const float lobe = lobe_of(of.waviness, fnumber), diffuse = std::exp2(bits_per_decibel * of.diffuse_db);
    // Over the angles of the normals, in a lattice that is tilted.
    const auto echo_of = [&](float tilt) {
        constexpr int angles = 16;
        two_moments echo{0, 0};
        for (int i = 0; i < angles; ++i) {
            const float facing = std::cos((static_cast<float>(i) + 0.5F) / angles * of.turn) * std::cos(tilt);
            const float one = diffuse + (1 - diffuse) * std::exp2((facing * facing - 1) / (lobe * lobe));
            echo = {echo.mean + one / angles, echo.square + one * one / angles};
        }
        return echo;
    };
    constexpr float length = 0.75F * 0.725F, width = 0.8F * 0.8F; // means, in cells
    two_moments sum{0, 0};
    float scale = 1;
    for (std::uint32_t k = 0; k < of.lattices; ++k, scale *= 0.8F) {
        const float area = 0.25F * length * width * of.fill * of.thickness / (scale * of.cell.z);
        const two_moments echo = echo_of(tilt_of_lattice(of, k));
        const float mean = level(1) * 2.5066283F * area * 2.4674011F * echo.mean;
        const float square = level(2) * 1.7724539F * area * 1.7777778F * echo.square;
        sum = {sum.mean + mean, sum.square + square + 2 * sum.mean * mean};
    }
    return sum;
}

/// Of the factor of bundles. The edge of a bundle counts half.
INSONIFY_FN inline two_moments moments_of(const structure::bundle_layer& of) {
    if (!(of.spacing > 0)) return {};
    const float relative = of.diameter / of.spacing, inside = 0.25F * pi * relative * relative * 0.65333F;
    const float level = std::exp2(bits_per_decibel * of.level_db);
    return {1 + inside * (level - 1), 1 + inside * (level * level - 1)};
}

/// The rms of `structure_gains` over a large volume, where the beam runs along z; waves do not change it.
INSONIFY_FN inline float structure_rms(const structure& s, float fnumber) {
    const two_moments all = moments_of(s.mottling), grain = moments_of(s.grain), bundles = moments_of(s.bundles),
                      sheets = moments_of(s.sheets, fnumber), septa = moments_of(s.septa, fnumber);
    const float between = grain.mean * bundles.mean;
    return std::sqrt(all.square * (grain.square * bundles.square + sheets.square + septa.square +
                                   2 * between * (sheets.mean + septa.mean) + 2 * sheets.mean * septa.mean));
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
