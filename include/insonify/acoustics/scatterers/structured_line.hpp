#ifndef INSONIFY_ACOUSTICS_SCATTERERS_STRUCTURED_LINE_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_STRUCTURED_LINE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/scatterers/cell_layout.hpp>
#include <insonify/tissue/sheath_gains.hpp>
#include <cfloat>

namespace insonify::inline INSONIFY_ABI::detail {

/// What the structure of its medium does to the speckle along one straight segment of a line.
class structured_line {
  public:
    /// @param line     in a medium that has a structure
    /// @param segment  of the line, in the undeformed material
    /// @param begin    of the segment, metres along the line
    /// @param end      of the segment, metres along the line
    /// @param key      of the object
    INSONIFY_FN structured_line(const material_line& line, const rest_line& segment, float begin, float end,
                                std::uint32_t key)
        : gains_{*line.structure, segment.origin,
                 segment.along,   normalize(segment.along - line.tilt * segment.elevation),
                 line.fnumber,    key},
          begin_{begin}, window_{gains_, end - begin}, behind_entry_{sheath_at(line, segment, end - begin, key,
                                                                               line.surfaces.x - begin,
                                                                               line.own_surfaces.x)},
          before_exit_{sheath_at(line, segment, end - begin, key, line.surfaces.y - begin, -line.own_surfaces.y)} {}

    /// Multiplies `count` complex amplitudes, at equal steps from a distance on, metres along the line; distances never
    /// decrease. The arrays have room for whole registers.
    INSONIFY_FN void apply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        window_.multiply(first - begin_, step, count, real, imaginary);
        behind_entry_.apply(first - begin_, step, count, real, imaginary);
        before_exit_.apply(first - begin_, step, count, real, imaginary);
    }

  private:
    INSONIFY_FN static sheath_gains sheath_at(const material_line& line, const rest_line& segment, float length,
                                              std::uint32_t key, float surface, float cosine) {
        const bool both_own = line.own_surfaces.x != 0 && line.own_surfaces.y != 0;
        return {line.structure->of.sheath,
                segment.origin,
                segment.along,
                line.fnumber,
                key,
                length,
                surface,
                cosine,
                both_own ? 0.5F * (line.surfaces.y - line.surfaces.x) : FLT_MAX};
    }

    structure_gains gains_;
    float begin_; // metres along the line
    gain_window window_;
    sheath_gains behind_entry_, before_exit_;
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
