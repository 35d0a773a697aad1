#ifndef INSONIFY_ACOUSTICS_STRUCTURED_LINE_HPP
#define INSONIFY_ACOUSTICS_STRUCTURED_LINE_HPP

#include <insonify/acoustics/cell_layout.hpp>
#include <insonify/acoustics/sheath_gains.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// What the structure of its medium does to the speckle along one straight segment of a line; nothing where it has none.
class structured_line {
  public:
    /// @param segment  of the line, in the undeformed material
    /// @param begin    of the segment, metres along the line
    /// @param end      of the segment, metres along the line
    /// @param key      of the object
    INSONIFY_FN structured_line(const material_line& line, const rest_line& segment, float begin, float end,
                                std::uint32_t key)
        : line_{line}, segment_{segment}, begin_{begin}, key_{key}, window_{end - begin} {}

    /// Multiplies `count` complex amplitudes, at equal steps from a distance on, metres along the line; distances never decrease.
    /// The arrays have room for whole registers.
    INSONIFY_FN void apply(float first, float step, std::uint32_t count, float* real, float* imaginary) {
        if (line_.structure == nullptr) return;
        const vec3 propagation = normalize(segment_.along - line_.tilt * line_.elevation);
        window_.multiply({*line_.structure, segment_.origin, segment_.along, propagation, line_.fnumber, key_},
                         first - begin_, step, count, real, imaginary);
        const structure::sheath_layer& sheath = line_.structure->of.sheath;
        if (!(sheath.thickness > 0)) return;
        const sheath_gains of_sheath{sheath, segment_.origin, segment_.along, line_.fnumber, key_};
        if (line_.own_surfaces.x > 0)
            of_sheath.apply(first - begin_, step, count, line_.surfaces.x - begin_, line_.own_surfaces.x, real,
                            imaginary);
        if (line_.own_surfaces.y > 0)
            of_sheath.apply(first - begin_, step, count, line_.surfaces.y - begin_, -line_.own_surfaces.y, real,
                            imaginary);
    }

  private:
    const material_line& line_;
    const rest_line& segment_;
    float begin_; // metres along the line
    std::uint32_t key_;
    gain_window window_;
};

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
