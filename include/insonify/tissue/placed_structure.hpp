#ifndef INSONIFY_TISSUE_PLACED_STRUCTURE_HPP
#define INSONIFY_TISSUE_PLACED_STRUCTURE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/units.hpp>
#include <insonify/tissue/fibre_chart.hpp>
#include <insonify/tissue/structure_rms.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

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
        lattice lattices[structure::max_lattices] = {}; ///< each turned about the fibres
        std::uint32_t count = 0;                        ///< of lattices; 0: no sheets
        float diffuse = 0;                              ///< amplitude of `diffuse_db`
        structure::sheet_layer of{};                    ///< as set
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
        const float place = clamp(steps * std::log2(fnumber), 0, static_cast<float>(fnumbers - 1));
        const auto above = static_cast<std::uint32_t>(place);
        const std::uint32_t next = above + 1 < fnumbers ? above + 1 : above;
        return rms_[above] + (place - static_cast<float>(above)) * (rms_[next] - rms_[above]);
    }

  private:
    static constexpr float steps = 4;             // of the F-number, in each doubling
    static constexpr std::uint32_t fnumbers = 17; // from 1 to 16
    float rms_[fnumbers] = {};

    // Lattices turn by 2.4 rad, the golden angle, from one to the next, where normals may have any direction across the fibres.
    INSONIFY_FN void place(const structure::sheet_layer& layer, std::uint32_t key, sheets& to) const {
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
