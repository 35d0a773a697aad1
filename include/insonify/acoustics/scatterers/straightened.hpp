#ifndef INSONIFY_ACOUSTICS_SCATTERERS_STRAIGHTENED_HPP
#define INSONIFY_ACOUSTICS_SCATTERERS_STRAIGHTENED_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/scatterers/scattering.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Calls `field.scatter`; where fibres are curved, in coordinates in which they are straight, piece by piece.
template <class Field, class Emit>
INSONIFY_FN void scatter_along_fibres(const Field& field, const material_line& line, float begin, float end,
                                      float spacing, const Emit& emit) {
    if (line.structure == nullptr || line.structure->chart.empty()) {
        field.scatter(line, begin, end, spacing, emit);
        return;
    }
    const auto straight = [&](vec3 point) {
        return line.structure->chart(line.displacement == nullptr ? point : line.displacement->rest(point));
    };
    constexpr float piece = 2e-3F;
    for (float from = begin; from < end;) {
        const float to = from + 1.5F * piece < end ? from + piece : end;
        const vec3 first = straight(line.at(from)), middle = line.at(0.5F * (from + to));
        const auto turned = [&](vec3 direction) { // and stretched
            constexpr float step = 0.5e-3F;
            return (straight(middle + step * direction) - straight(middle - step * direction)) * (0.5F / step);
        };
        material_line own = line;
        own.displacement = nullptr;
        own.along = (straight(line.at(to)) - first) * (1 / (to - from));
        own.origin = first - from * own.along;
        own.elevation = normalize(turned(line.elevation));
        if (line.steering != vec3{0, 0, 0}) own.steering = turned(line.steering);
        if (own.along != vec3{0, 0, 0}) field.scatter(own, from, to, spacing, emit);
        from = to;
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
