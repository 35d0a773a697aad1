#ifndef INSONIFY_TISSUE_STRUCTURE_HPP
#define INSONIFY_TISSUE_STRUCTURE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <insonify/core/units.hpp>
#include <insonify/core/view.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

/// What a tissue is made of above the scale of speckle: a medium's `structure`. Plain data; empty by default.
///
/// The structure redistributes the echo power of the medium: it multiplies the amplitude of its speckle by
///
///     g = mottling (grain bundles + sheets + septa) / rms
///
/// and leaves the mean power as it is, for a beam across the fibres. It is anchored in the material and computed from
/// hashes, so nothing is stored.
///
/// Sizes are metres along three axes of the object: x along its fibres, y and z across them, z where the object is
/// flattest. See `fibres` of `object_settings`.
struct structure {
    static constexpr std::uint32_t max_lattices = 6; ///< of one layer of sheets

    /// Slow random variation of the level.
    struct variation {
        float deviation_db = 0;         ///< standard deviation of the level, dB; 0: none
        vec3 size{8e-3F, 4e-3F, 4e-3F}; ///< distance between independent values

        friend bool operator==(const variation&, const variation&) = default;
    };

    /// Thin bright sheets of finite size, such as the perimysium between the fascicles of a muscle, or the septa of
    /// fat. There is at most one in each cell of a lattice. Further lattices have cells of 0.8 times the size, and are
    /// turned about the fibres. The echo of a sheet depends on its angle to the beam as that of an interface does.
    struct sheet_layer {
        float fill = 0;                      ///< fraction of the cells that contain a sheet; 0: none
        std::uint32_t lattices = 1;          ///< 1 to `max_lattices`
        vec3 cell{14e-3F, 2.4e-3F, 2.4e-3F}; ///< of the first lattice; sheets are up to 0.75 as long and 0.8 as wide
        float thickness = 0.13e-3F;          ///< standard deviation of a sheet's profile, metres
        float level_db =
            18; ///< amplitude in the middle of a sheet that faces the beam, relative to the speckle around it
        float spread_db = 8;    ///< standard deviation of that level from sheet to sheet
        float turn = pi / 2;    ///< normals are turned about the fibres by at most this, from z; radians
        float bend = 0;         ///< largest slope of the edge of a sheet against its middle, across the fibres
        float tilt = 0.04F;     ///< lattices are tilted against the fibres by up to this, radians
        float waviness = 0.1F;  ///< standard deviation of the angle of the sheet's facets, radians
        float diffuse_db = -12; ///< amplitude that remains at any angle, relative to that at normal incidence

        friend bool operator==(const sheet_layer&, const sheet_layer&) = default;
    };

    /// Round bundles along the fibres, such as the fascicles of a nerve in the net of its epineurium.
    struct bundle_layer {
        float spacing = 0;   ///< of their centres across the fibres, metres; 0: none
        float diameter = 0;  ///< of the largest, metres, at most the spacing; the smallest have 0.6 times as much
        float level_db = -9; ///< amplitude inside, relative to the net

        friend bool operator==(const bundle_layer&, const bundle_layer&) = default;
    };

    /// The sheath of an object, such as the epimysium and the aponeuroses of a muscle: a bright layer below its
    /// surface, of two parallel lines with a dark slit between them, uneven in thickness and brightness. It adds to the
    /// echo power. It lies where the surface is the object's own: not around a vessel within, and only once where two
    /// objects touch.
    struct sheath_layer {
        float thickness = 0;    ///< mean, metres; 0: none
        float level_db = 24;    ///< amplitude at normal incidence, relative to the speckle of the medium
        float spread_db = 5;    ///< standard deviation of that level along the surface
        float waviness = 0.3F;  ///< standard deviation of the angle of its facets, radians
        float diffuse_db = -10; ///< amplitude that remains at any angle, relative to that at normal incidence
        /// Length over which fibres curve into the inside of the sheath, on which they end, metres; 0: they stay
        /// straight and go on to the surface.
        float insertion = 0;

        friend bool operator==(const sheath_layer&, const sheath_layer&) = default;
    };

    variation mottling{};      ///< of everything
    variation grain{};         ///< of the speckle between the sheets
    float wave = 0;            ///< deviation of sheets and bundles from straight, standard deviation in metres
    float wave_length = 9e-3F; ///< of these waves along the fibres, metres
    sheet_layer sheets{};      ///< short sheets
    sheet_layer septa{};       ///< long ones
    bundle_layer bundles{};    ///< along the fibres
    sheath_layer sheath{};     ///< below the surface of the object

    /// Whether there is any structure.
    INSONIFY_FN constexpr bool empty() const {
        return mottling.deviation_db == 0 && grain.deviation_db == 0 && sheets.fill == 0 && septa.fill == 0 &&
               bundles.spacing == 0 && sheath.thickness == 0;
    }

    friend bool operator==(const structure&, const structure&) = default;
};

/// True if every value is finite and in range: sizes above 0, fractions from 0 to 1, deviations 0 to 40 dB.
INSONIFY_FN inline bool is_valid(const structure& s) {
    const auto within = [](float value, float smallest, float largest) {
        return value >= smallest && value <= largest;
    };
    const auto size_fits = [&](vec3 size) {
        return within(size.x, 1e-6F, 10) && within(size.y, 1e-6F, 10) && within(size.z, 1e-6F, 10);
    };
    const auto varies = [&](const structure::variation& v) {
        return within(v.deviation_db, 0, 40) && size_fits(v.size);
    };
    const auto has_sheets = [&](const structure::sheet_layer& l) {
        return within(l.fill, 0, 1) && l.lattices >= 1 && l.lattices <= structure::max_lattices && size_fits(l.cell) &&
               within(l.thickness, 1e-6F, 1) && within(l.level_db, -100, 100) && within(l.spread_db, 0, 40) &&
               within(l.turn, 0, pi / 2) && within(l.bend, 0, 1) && within(l.tilt, 0, 1) && within(l.waviness, 0, pi) &&
               within(l.diffuse_db, -200, 0);
    };
    const auto& b = s.bundles;
    return varies(s.mottling) && varies(s.grain) && within(s.wave, 0, 1) && within(s.wave_length, 1e-6F, 10) &&
           has_sheets(s.sheets) && has_sheets(s.septa) && within(b.spacing, 0, 1) && within(b.diameter, 0, b.spacing) &&
           within(b.level_db, -200, 100) && within(s.sheath.thickness, 0, 1) && within(s.sheath.level_db, -200, 100) &&
           within(s.sheath.spread_db, 0, 40) && within(s.sheath.waviness, 0, pi) &&
           within(s.sheath.diffuse_db, -200, 0) && within(s.sheath.insertion, 0, 1);
}

namespace detail {

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
/// for n lattices with a fraction p of full cells, thickness t, length l and width w of the sheets. Source: integrals
/// of the profile exp(-d^2 / 2 t^2) and of the outline sqrt((1 - x^2) (1 - y^2)) of `structure_gains::sheet`.
INSONIFY_FN inline two_moments moments_of(const structure::sheet_layer& of, float fnumber) {
    if (!(of.fill > 0)) return {0, 0};
    // The level is 10^((level_db + spread_db n) / 20), n a sum of two uniform numbers: <exp(a n)> = (sinh(b) / b)^2.
    const auto level = [&](float power) {
        const float neper = 0.115129255F * power, b = 0.5F * neper * of.spread_db * max_level_number;
        const float spread = b > 1e-3F ? std::sinh(b) / b : 1.0F;
        return std::exp(neper * of.level_db) * spread * spread;
    };
    const float lobe = lobe_of(of.waviness, fnumber), diffuse = amplitude_of_decibels(of.diffuse_db);
    // Over the angles of the normals, in a lattice that is tilted: even steps of `turn`, and with each a bend and a
    // place across the sheet from the R2 sequence (Roberts 2018). Places lie within 0.8 of the half width, with a mean
    // square of 0.21: the outline weighs the mean with 1/4 and the mean square with 1/5.
    const auto echo_of = [&](float tilt) {
        constexpr int angles = 32;
        two_moments echo{0, 0};
        for (int i = 0; i < angles; ++i) {
            const float n = static_cast<float>(i) + 0.5F, bend = 0.75487767F * n, across = 0.56984029F * n;
            const float slope = 0.8F * (2 * (across - std::floor(across)) - 1) * (bend - std::floor(bend)) * of.bend;
            const float facing = std::cos(n / angles * of.turn + std::atan(slope)) * std::cos(tilt);
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
    const float level = amplitude_of_decibels(of.level_db);
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

} // namespace detail

/// Coordinates in which curved fibres are straight: at the nodes of a grid, linear in between. Trivially copyable;
/// refers to the scene's arrays. Fibres run along x, and layers are flat in z, as in `structure`.
struct fibre_chart {
    view<const vec3> nodes{}; ///< x varies fastest; metres
    uvec3 count{0, 0, 0};     ///< of nodes along each axis, at least 2
    vec3 origin{0, 0, 0};     ///< of the grid, in coordinates of the object
    float spacing = 1;        ///< of the nodes, metres

    /// Whether fibres are straight everywhere.
    INSONIFY_FN bool empty() const { return nodes.empty(); }

    /// The coordinates of a point of the object; metres. Beyond the grid those of its outermost cells go on.
    INSONIFY_FN vec3 operator()(vec3 point) const {
        return detail::interpolated(nodes.data(), count, (point - origin) / spacing);
    }
};

/// A structure in the axes of one object, prepared for lines of any probe. Trivially copyable.
struct placed_structure {
    /// One lattice of sheets.
    struct lattice {
        mat3 axes{1};          ///< columns: along the fibres and across them, in coordinates of the object
        vec3 cell{1, 1, 1};    ///< metres
        mat3 cells{1};         ///< the axes divided by the cell: from metres to cells
        vec3 aside{0, 0, 0};   ///< cells per metre along z of the structure
        std::uint32_t key = 0; ///< of its random numbers
    };
    /// A layer of sheets.
    struct sheets {
        structure::sheet_layer of{};                    ///< as set
        lattice lattices[structure::max_lattices] = {}; ///< each turned about the fibres
        std::uint32_t count = 0;                        ///< of lattices; 0: no sheets
        float diffuse = 0;                              ///< amplitude of `diffuse_db`
    };

    structure of{};        ///< as set
    mat3 axes{1};          ///< columns x, y and z of `structure`, in coordinates of the object
    sheets layers[2] = {}; ///< `structure::sheets` and `structure::septa`
    fibre_chart chart{};   ///< where fibres are curved; the axes are those of its coordinates

    placed_structure() = default; ///< none

    /// @param s           of the medium
    /// @param directions  orthonormal columns: along the fibres, across, and where the object is flattest
    INSONIFY_FN placed_structure(const structure& s, const mat3& directions) : of{s}, axes{directions} {
        place(s.sheets, 0x51ED270BU, layers[0]);
        place(s.septa, 0xA3C59AC3U, layers[1]);
        for (std::uint32_t i = 0; i < fnumbers; ++i)
            rms_[i] = detail::structure_rms(s, std::exp2(static_cast<float>(i) / steps));
    }

    /// The rms of the factor on amplitude over a large volume, where the beam runs along z; the F-number is that of the
    /// receiving aperture.
    INSONIFY_FN float rms(float fnumber) const {
        const detail::table_place at{steps * std::log2(fnumber), fnumbers};
        return rms_[at.above] + at.part * (rms_[at.below] - rms_[at.above]);
    }

  private:
    static constexpr float steps = 4;             // of the F-number, in each doubling
    static constexpr std::uint32_t fnumbers = 17; // from 1 to 16
    float rms_[fnumbers] = {};

    // Lattices turn by 2.4 rad, the golden angle, from one to the next, where normals may have any direction across the
    // fibres.
    INSONIFY_FN void place(const structure::sheet_layer& layer, std::uint32_t key, sheets& to) const {
        to.of = layer;
        to.count = layer.fill > 0 ? layer.lattices : 0;
        to.diffuse = amplitude_of_decibels(layer.diffuse_db);
        float scale = 1;
        for (std::uint32_t k = 0; k < to.count; ++k, scale *= 0.8F) {
            const float turn = layer.turn < pi / 2 ? 0.0F : 2.4F * static_cast<float>(k);
            const float tilt = detail::tilt_of_lattice(layer, k);
            const float c = std::cos(turn), s = std::sin(turn);
            const vec3 across = c * axes[1] - s * axes[2], upright = s * axes[1] + c * axes[2];
            const float ct = std::cos(tilt), st = std::sin(tilt);
            lattice& own = to.lattices[k];
            own.axes = mat3{ct * axes[0] + st * upright, across, ct * upright - st * axes[0]};
            own.cell = scale * layer.cell;
            own.key = key + k * 0x632BE5ABU;
            for (int i = 0; i < 3; ++i) {
                own.cells[i] = own.axes[i] / own.cell[i];
                own.aside[i] = dot(own.cells[i], axes[2]);
            }
        }
    }
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
