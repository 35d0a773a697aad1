#ifndef INSONIFY_PROBE_SECTOR_HPP
#define INSONIFY_PROBE_SECTOR_HPP

#include <insonify/core/error.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Lines that fan out from one point, the apex, which lies `radius` behind the face.
struct sector {
    std::uint32_t lines = 1;
    float radius = 0;        ///< of the face, metres
    float field_of_view = 1; ///< between the two ends of the fan, radians

    /// From (R sin t, 0, R cos t - R) towards (sin t, 0, cos t).
    INSONIFY_FN ray beam(float line) const {
        const float angle = share_of_line(line, lines) * field_of_view;
        const vec3 direction{std::sin(angle), 0, std::cos(angle)};
        return {.origin = radius * (direction - vec3{0, 0, 1}), .direction = direction};
    }
    INSONIFY_FN vec2 locate(vec2 point) const {
        const float along = point.y + radius;
        const float from_apex = std::sqrt(point.x * point.x + along * along);
        return {line_of_share(std::atan2(point.x, along) / field_of_view, lines), from_apex - radius};
    }
};

} // namespace insonify::inline INSONIFY_ABI
#endif
