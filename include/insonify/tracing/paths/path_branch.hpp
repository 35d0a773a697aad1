#ifndef INSONIFY_TRACING_PATHS_PATH_BRANCH_HPP
#define INSONIFY_TRACING_PATHS_PATH_BRANCH_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/layer.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

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
        constexpr float smallest = 0.25F; // of the determinant: at most 6 dB
        return 1 / std::sqrt(max(std::fabs(determinant(mat3{1} + metres * bend_)), smallest));
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

/// A path that has not been followed yet: see `paths`.
struct path_branch {
    line_frame frame{};      ///< where its next piece begins, and along what
    echo_path path{};        ///< the state of the sound there
    detail::ray_tube tube{}; ///< curvature of the wave front there
    float own_surface =
        0; ///< cosine of incidence on the surface it leaves, if that is the present object's own; else 0
    std::uint32_t bounces = 0; ///< reflections so far
    std::uint32_t inside = 0;  ///< how many objects contain it: the last ones of `line_scratch::branch_objects`
    bool inverted = false;     ///< an odd number of the reflections turned the sign of the pressure
};

/// A path that arrived at a surface. Sound that arrives along one such path may return along another: see `paths`.
struct path_arrival {
    line_frame frame{};        ///< of the path's last piece
    vec3 point{0, 0, 0};       ///< where it ended
    vec3 normal{0, 0, 0};      ///< of the surface
    echo_path path{};          ///< the state of the sound there
    layer above{};             ///< before the surface
    layer below{};             ///< behind it
    std::uint32_t bounces = 0; ///< reflections so far
    bool inverted = false;     ///< an odd number of the reflections turned the sign of the pressure
    bool at_face = false;      ///< the surface is the face of the probe
};

} // namespace detail

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
