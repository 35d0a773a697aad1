#ifndef INSONIFY_TRACING_RAY_TUBE_HPP
#define INSONIFY_TRACING_RAY_TUBE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// The curvature of the wave front that a path follows. Waves leave the probe plane; curved mirrors spread or focus them:
///
///     a(s) = 1 / sqrt(|det(I + s K)|)    amplitude after s metres
///
/// with the curvature K in 1/m, a symmetric tensor in the world whose null direction is the path's. Source: conservation of
/// energy in a tube of rays, as in geometrical acoustics.
class ray_tube {
  public:
    /// Whether the wave front is plane.
    INSONIFY_FN bool plane() const { return bend_ == mat3{0}; }

    /// a(s). Near a focus it is bounded: there the beam has its diffraction-limited width.
    INSONIFY_FN float amplitude(float metres) const {
        constexpr float least = 0.25F; // of the determinant: at most 6 dB
        return 1 / std::sqrt(max(std::fabs(determinant(mat3{1} + metres * bend_)), least));
    }

    /// The tube after s metres: K (I + s K)^-1.
    INSONIFY_FN ray_tube after(float metres) const {
        const mat3 grown = mat3{1} + metres * bend_;
        const float size = determinant(grown);
        ray_tube next;
        if (std::fabs(size) < 1e-3F) return next; // at a focus
        const mat3 inverse = mat3{cross(grown[1], grown[2]), cross(grown[2], grown[0]), cross(grown[0], grown[1])};
        next.bend_ = (1 / size) * (bend_ * transpose(inverse));
        return next;
    }

    /// The tube that a mirror makes of this one:
    ///
    ///     K' = M K M + 2 cos^2 i sum_jk H_jk t_j t_k^T,   M = I - 2 n n^T,   t_j = e_j - n (e_j . d') / (n . d')
    ///
    /// H are the second derivatives of the mirror's depth along the incident direction d, over the axes e_j across it; d' is the
    /// reflected direction, n the normal, i the angle of incidence. Source: equal phase of both waves on the mirror, to second
    /// order.
    /// @param curvature  H: along both axes, and mixed, 1/m
    INSONIFY_FN ray_tube mirrored(vec3 normal, vec3 reflected, vec3 across, vec3 elevation, vec3 curvature) const {
        const float towards = dot(normal, reflected);
        ray_tube next;
        if (std::fabs(towards) < 0.05F) return next;
        const mat3 mirror = mat3{1} - 2.0F * product(normal, normal);
        const vec3 x = across - (dot(across, reflected) / towards) * normal,
                   y = elevation - (dot(elevation, reflected) / towards) * normal;
        next.bend_ = mirror * bend_ * mirror +
                     (2 * towards * towards) * (curvature.x * product(x, x) + curvature.y * product(y, y) +
                                                curvature.z * (product(x, y) + product(y, x)));
        return next;
    }

  private:
    INSONIFY_FN static mat3 product(vec3 a, vec3 b) { return {b.x * a, b.y * a, b.z * a}; } // a b^T

    mat3 bend_{0}; // K
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
