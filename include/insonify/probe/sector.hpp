#ifndef INSONIFY_PROBE_SECTOR_HPP
#define INSONIFY_PROBE_SECTOR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Lines that diverge from an apex, which lies `radius` behind the face.
struct sector {
    std::uint32_t lines = 1;
    float radius = 0;        ///< radius of the face, metres
    float field_of_view = 1; ///< angle between the ends of the sector, radians

    /// From (R sin t, 0, R cos t - R) towards (sin t, 0, cos t).
    INSONIFY_FN ray beam(float line) const {
        const float angle = aperture_fraction(line, lines) * field_of_view;
        const vec3 direction{std::sin(angle), 0, std::cos(angle)};
        return {.origin = radius * (direction - vec3{0, 0, 1}), .direction = direction};
    }
    INSONIFY_FN vec2 locate(vec2 point) const {
        const float along = point.y + radius;
        const float from_apex = std::sqrt(point.x * point.x + along * along);
        return {line_at_fraction(std::atan2(point.x, along) / field_of_view, lines), from_apex - radius};
    }
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
