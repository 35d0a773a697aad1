#ifndef INSONIFY_TISSUE_STRUCTURE_HPP
#define INSONIFY_TISSUE_STRUCTURE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>

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

    /// Thin bright sheets of finite size, such as the perimysium between the fascicles of a muscle, or the septa of fat.
    /// There is at most one in each cell of a lattice. Further lattices have cells of 0.8 times the size, and are turned
    /// about the fibres. The echo of a sheet depends on its angle to the beam as that of an interface does.
    struct sheet_layer {
        float fill = 0;                      ///< fraction of the cells that contain a sheet; 0: none
        std::uint32_t lattices = 1;          ///< 1 to `max_lattices`
        vec3 cell{14e-3F, 2.4e-3F, 2.4e-3F}; ///< of the first lattice; sheets are up to 0.75 as long and 0.8 as wide
        float thickness = 0.13e-3F;          ///< standard deviation of a sheet's profile, metres
        float level_db =
            18; ///< amplitude in the middle of a sheet that faces the beam, relative to the speckle around it
        float spread_db = 8;    ///< standard deviation of that level from sheet to sheet
        float turn = pi / 2;    ///< normals are turned about the fibres by at most this, from z; radians
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

    /// The sheath of an object, such as the epimysium and the aponeuroses of a muscle: a bright layer below its surface, of two
    /// parallel lines with a dark slit between them, uneven in thickness and brightness. It adds to the echo power. It lies
    /// where the surface is the object's own: not around a vessel within, and only once where two objects touch.
    struct sheath_layer {
        float thickness = 0;    ///< mean, metres; 0: none
        float level_db = 24;    ///< amplitude at normal incidence, relative to the speckle of the medium
        float spread_db = 3;    ///< standard deviation of that level along the surface
        float waviness = 0.3F;  ///< standard deviation of the angle of its facets, radians
        float diffuse_db = -10; ///< amplitude that remains at any angle, relative to that at normal incidence

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
               within(l.turn, 0, pi / 2) && within(l.tilt, 0, 1) && within(l.waviness, 0, pi) &&
               within(l.diffuse_db, -200, 0);
    };
    const auto& b = s.bundles;
    return varies(s.mottling) && varies(s.grain) && within(s.wave, 0, 1) && within(s.wave_length, 1e-6F, 10) &&
           has_sheets(s.sheets) && has_sheets(s.septa) && within(b.spacing, 0, 1) && within(b.diameter, 0, b.spacing) &&
           within(b.level_db, -200, 100) && within(s.sheath.thickness, 0, 1) && within(s.sheath.level_db, -200, 100) &&
           within(s.sheath.spread_db, 0, 40) && within(s.sheath.waviness, 0, pi) &&
           within(s.sheath.diffuse_db, -200, 0);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
