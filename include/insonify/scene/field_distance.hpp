#ifndef INSONIFY_SCENE_FIELD_DISTANCE_HPP
#define INSONIFY_SCENE_FIELD_DISTANCE_HPP

#include <insonify/geometry/triangle.hpp>
#include <insonify/probe/transducer.hpp>

namespace insonify::inline INSONIFY_ABI {

/// The point of a triangle that is nearest to p. Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
INSONIFY_FN inline vec3 nearest_on(const triangle& t, vec3 p) {
    const vec3 ab = t.b - t.a, ac = t.c - t.a;
    const float d1 = dot(ab, p - t.a), d2 = dot(ac, p - t.a);
    if (d1 <= 0 && d2 <= 0) return t.a;
    const float d3 = dot(ab, p - t.b), d4 = dot(ac, p - t.b);
    if (d3 >= 0 && d4 <= d3) return t.b;
    const float d5 = dot(ab, p - t.c), d6 = dot(ac, p - t.c);
    if (d6 >= 0 && d5 <= d6) return t.c;
    const auto along = [](vec3 from, vec3 edge, float here, float all) {
        return all > 0 ? from + (here / all) * edge : from;
    };
    const float by_c = d1 * d4 - d3 * d2, by_b = d5 * d2 - d1 * d6, by_a = d3 * d6 - d5 * d4;
    if (by_c <= 0 && d1 >= 0 && d3 <= 0) return along(t.a, ab, d1, d1 - d3);
    if (by_b <= 0 && d2 >= 0 && d6 <= 0) return along(t.a, ac, d2, d2 - d6);
    if (by_a <= 0 && d4 >= d3 && d5 >= d6) return along(t.b, t.c - t.b, d4 - d3, (d4 - d3) + (d5 - d6));
    const float sum = by_a + by_b + by_c;
    return sum > 0 ? t.a + (by_b / sum) * ab + (by_c / sum) * ac : t.a;
}

/// The point of the field of view, its lines down to `depth` metres, that is nearest to p; in the probe's frame.
template <transducer Probe>
vec3 nearest_in_field(const Probe& probe, float depth, vec3 p) {
    const float end = static_cast<float>(probe.lines) - 0.5F;
    const ray line = probe.beam(clamped(probe.locate({p.x, p.z}).x, -0.5F, end));
    return line.at(clamped(dot(p - line.origin, line.direction), 0, depth));
}

/// Metres between a triangle and the field of view, in the probe's frame; no less than it is, and where the field spans
/// less than half a circle right to a hundredth, as both are convex.
template <transducer Probe>
float distance_to_field(const Probe& probe, float depth, const triangle& face) {
    vec3 point = (face.a + face.b + face.c) / 3.0F;
    float nearest = FLT_MAX;
    for (int i = 0; i < 32; ++i) { // alternating projections
        const vec3 in_field = nearest_in_field(probe, depth, point);
        point = nearest_on(face, in_field);
        const float distance = length(point - in_field);
        if (!(distance < 0.9999F * nearest)) return lesser(distance, nearest);
        nearest = distance;
    }
    return nearest;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
