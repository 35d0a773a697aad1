#ifndef INSONIFY_ACOUSTICS_STRAIGHTENED_HPP
#define INSONIFY_ACOUSTICS_STRAIGHTENED_HPP

#include <insonify/acoustics/cell_field.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// The field without its material map, and the map: by default there is none.
/// @{
template <class Field>
INSONIFY_FN const Field& rigid_field(const Field& field) {
    return field;
}
template <class Field>
INSONIFY_FN vec3 point_at_rest(const Field&, std::uint32_t, vec3 point) {
    return point;
}
template <class Numbers, class Material>
INSONIFY_FN cell_field<Numbers, undeformed> rigid_field(const cell_field<Numbers, Material>& field) {
    return {.seed = field.seed, .cell = field.cell, .numbers = field.numbers};
}
template <class Numbers, class Material>
INSONIFY_FN vec3 point_at_rest(const cell_field<Numbers, Material>& field, std::uint32_t object, vec3 point) {
    return field.material(object, point);
}
/// @}

/// Calls `field.scatter`; where fibres are curved, in coordinates in which they are straight, piece by piece.
template <class Field, class Emit>
INSONIFY_FN void scatter_along_fibres(const Field& field, const material_line& line, float begin, float end,
                                      float spacing, const Emit& emit) {
    if (line.structure == nullptr || line.structure->chart.empty()) {
        field.scatter(line, begin, end, spacing, emit);
        return;
    }
    const auto& rigid = rigid_field(field);
    const auto straight = [&](vec3 point) { return line.structure->chart(point_at_rest(field, line.object, point)); };
    constexpr float piece = 2e-3F;
    for (float from = begin; from < end;) {
        const float to = from + 1.5F * piece < end ? from + piece : end;
        const vec3 first = straight(line.at(from)), middle = line.at(0.5F * (from + to));
        const auto turned = [&](vec3 direction) { // and stretched
            constexpr float step = 0.5e-3F;
            return (straight(middle + step * direction) - straight(middle - step * direction)) * (0.5F / step);
        };
        material_line own = line;
        own.along = (straight(line.at(to)) - first) * (1 / (to - from));
        own.origin = first - from * own.along;
        own.elevation = normalize(turned(line.elevation));
        if (line.steering != vec3{0, 0, 0}) own.steering = turned(line.steering);
        if (own.along != vec3{0, 0, 0}) rigid.scatter(own, from, to, spacing, emit);
        from = to;
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail
#endif
