#ifndef INSONIFY_SCENE_FIELD_DISTANCE_HPP
#define INSONIFY_SCENE_FIELD_DISTANCE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/probe/transducer.hpp>
#include <insonify/scene/nearest_point.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// The point of the field of view, its lines down to `depth` metres, that is nearest to p; in the probe's frame.
template <transducer Probe>
vec3 nearest_in_field(const Probe& probe, float depth, vec3 p) {
    const float end = static_cast<float>(probe.lines) - 0.5F;
    const ray line = probe.beam(clamp(probe.locate({p.x, p.z}).x, -0.5F, end));
    return line.at(clamp(dot(p - line.origin, line.direction), 0, depth));
}

/// Distance in metres between a triangle and the field of view, in the probe's frame. Never an underestimate; within one
/// percent where the field spans less than half a circle, since both are then convex.
template <transducer Probe>
float distance_to_field(const Probe& probe, float depth, const triangle& face) {
    vec3 point = (face.a + face.b + face.c) / 3.0F;
    float nearest = FLT_MAX;
    for (int i = 0; i < 32; ++i) { // alternating projections
        const vec3 in_field = nearest_in_field(probe, depth, point);
        point = nearest_on(face, in_field);
        const float distance = length(point - in_field);
        if (!(distance < 0.9999F * nearest)) return min(distance, nearest);
        nearest = distance;
    }
    return nearest;
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
