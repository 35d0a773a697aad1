#ifndef INSONIFY_SCENE_SURFACE_INCIDENCE_HPP
#define INSONIFY_SCENE_SURFACE_INCIDENCE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/layer.hpp>
#include <insonify/scene/scene_view.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// How a line meets a surface.
struct surface_incidence {
    float cosine = 1;        ///< of the angle of incidence, 0 to 1
    vec2 slope{0, 0};        ///< see `layer`
    vec3 curvature{0, 0, 0}; ///< see `layer`
    float roughness = -1;    ///< see `layer`
    vec3 normal{0, 0, 1};    ///< of the surface in the world, on the side away from the probe; length 1
    vec3 flat{0, 0, 1};      ///< of the face alone: the side of it that a point is on
};

/// How a line meets a face at a point in the world, with the normal that is interpolated over smooth edges; at normal incidence
/// where the face has no area.
INSONIFY_FN inline surface_incidence incidence_on(const object_view& one, std::uint32_t face, const line_frame& line,
                                                  vec3 point) {
    const vec3 along = one.at.local_direction(line.along), elevation = one.at.local_direction(line.elevation);
    const vec3 across = cross(elevation, along);
    const face_normals normals = one.normals.of_face(one.surface, face, -along);
    const float side = dot(normals.flat, along) < 0 ? -1.0F : 1.0F; // normals point along the line
    const vec3 flat = side * normals.flat;
    vec3 normal = flat;
    surface_incidence met;
    if (normals.curved) {
        const vec3 smooth = side * normals.at(one.at.local_point(point));
        const float towards = dot(smooth, along), size = length(smooth);
        if (towards > 0 && size > 0) { // else the line grazes the surface
            normal = smooth / size;
            // The change of the slope where the line moves across the surface: along the plane of the normal, as far along the
            // face.
            const float steep = 1 / max(towards, 0.1F * size);
            const vec2 slope = steep * vec2{dot(smooth, across), dot(smooth, elevation)};
            const auto slope_change = [&](vec3 to) {
                const vec3 on_surface = to - (steep * dot(smooth, to)) * along;
                const vec3 on_face = on_surface - dot(flat, on_surface) * flat;
                const vec3 change =
                    side * std::sqrt(dot(on_surface, on_surface) / dot(on_face, on_face)) * normals.change(on_face);
                return steep * (vec2{dot(change, across), dot(change, elevation)} - dot(change, along) * slope);
            };
            const vec2 in_slice = slope_change(across), out_of_it = slope_change(elevation);
            met.curvature = {-in_slice.x, -out_of_it.y, -0.5F * (in_slice.y + out_of_it.x)};
        }
    }
    const float facing = dot(normal, along), steep = 1 / max(facing, 1e-4F);
    met.cosine = min(facing, 1.0F);
    met.slope = steep * vec2{dot(normal, across), dot(normal, elevation)};
    met.normal = one.at.direction(normal);
    met.flat = one.at.direction(flat);
    return met;
}

/// Surfaces with less than this cosine of the angle of incidence are steep: 60 degrees.
inline constexpr float steep_cosine = 0.5F;

/// How a line meets a face at a distance. The tilt of a line does not count, except on steep surfaces, which are met because
/// of it. Lines that are turned about their origins (tracing/turned_fan.hpp) have an overload of their own.
INSONIFY_FN inline surface_incidence incidence_at(const line_frame& line, float distance, const object_view& one,
                                                  std::uint32_t face) {
    const vec3 point = line.at(distance);
    const surface_incidence met = incidence_on(one, face, line, point);
    if (line.tilt == 0 || met.cosine > steep_cosine) return met;
    return incidence_on(one, face, {line.origin, normalize(line.path()), line.elevation}, point);
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
