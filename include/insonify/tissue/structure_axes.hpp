#ifndef INSONIFY_TISSUE_STRUCTURE_AXES_HPP
#define INSONIFY_TISSUE_STRUCTURE_AXES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/ray.hpp>
#include <insonify/geometry/mesh.hpp>
#include <cmath>

namespace insonify::inline INSONIFY_ABI::detail {

/// A symmetric matrix.
struct symmetric3 {
    double at[3][3] = {};

    void add(double weight, const dvec3& a, const dvec3& b) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) at[i][j] += weight * a[i] * b[j];
    }
};

/// Eigenvectors as columns, by descending eigenvalue.
/// Source: the cyclic Jacobi method; Golub & Van Loan, Matrix Computations, section 8.5.
inline mat3 principal_axes(symmetric3 m) {
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < 12; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (m.at[p][q] == 0) continue;
                const double angle = (m.at[q][q] - m.at[p][p]) / (2 * m.at[p][q]);
                const double t = (angle < 0 ? -1 : 1) / (std::fabs(angle) + std::sqrt(angle * angle + 1));
                const double c = 1 / std::sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double a = m.at[k][p], b = m.at[k][q];
                    m.at[k][p] = c * a - s * b;
                    m.at[k][q] = s * a + c * b;
                }
                for (int k = 0; k < 3; ++k) {
                    const double a = m.at[p][k], b = m.at[q][k];
                    m.at[p][k] = c * a - s * b;
                    m.at[q][k] = s * a + c * b;
                    const double d = v[k][p], e = v[k][q];
                    v[k][p] = c * d - s * e;
                    v[k][q] = s * d + c * e;
                }
            }
    int order[3] = {0, 1, 2};
    const auto in_order = [&](int i, int j) {
        if (m.at[order[i]][order[i]] < m.at[order[j]][order[j]]) {
            const int first = order[i];
            order[i] = order[j];
            order[j] = first;
        }
    };
    in_order(0, 1);
    in_order(1, 2);
    in_order(0, 1);
    mat3 axes{1};
    for (int i = 0; i < 3; ++i)
        axes[i] = vec3{static_cast<float>(v[0][order[i]]), static_cast<float>(v[1][order[i]]),
                       static_cast<float>(v[2][order[i]])};
    return axes;
}

/// Covariance of the volume that a closed surface encloses, times that volume. Each face adds its tetrahedron with the
/// middle of the box; outside the surface these cancel.
inline symmetric3 volume_covariance(const mesh_view& surface, const aabb& box) {
    symmetric3 second;
    dvec3 first{0, 0, 0};
    double volume = 0;
    const dvec3 middle{box.centre()};
    for (std::size_t i = 0; i < surface.size(); ++i) {
        const triangle face = surface[i];
        const dvec3 a = dvec3{face.a} - middle, b = dvec3{face.b} - middle, c = dvec3{face.c} - middle, sum = a + b + c;
        const double own = dot(a, cross(b, c)) / 6;
        for (const dvec3& corner : {a, b, c, sum}) second.add(own / 20, corner, corner);
        first += 0.25 * own * sum;
        volume += own;
    }
    if (volume != 0) second.add(-1 / volume, first, first);
    if (volume < 0)
        for (auto& row : second.at)
            for (double& value : row) value = -value;
    return second;
}

/// Axes from the longest to the shortest side of a box.
inline mat3 axes_of(const aabb& box) {
    symmetric3 sides;
    for (int i = 0; i < 3; ++i) sides.at[i][i] = box.empty() ? -i : static_cast<double>(box.size()[i]);
    return principal_axes(sides);
}

/// The axes with the first one along `fibres`, if that is not 0, and the last one as it was, as far as possible.
inline mat3 aligned(const mat3& axes, vec3 fibres) {
    if (fibres == vec3{0, 0, 0}) return axes;
    const vec3 along = normalize(fibres);
    const vec3 flat = axes[2] - dot(axes[2], along) * along, other = axes[1] - dot(axes[1], along) * along;
    const vec3 upright = normalize(dot(flat, flat) > 0.1F ? flat : other);
    return mat3{along, cross(upright, along), upright};
}

/// The axes of an object: of its moments of inertia, the least along the fibres, unless these are given.
inline mat3 structure_axes(const mesh_view& surface, const aabb& box, vec3 fibres) {
    const symmetric3 moments = volume_covariance(surface, box);
    const double trace = moments.at[0][0] + moments.at[1][1] + moments.at[2][2];
    return aligned(trace > 0 && trace < 1e30 ? principal_axes(moments) : axes_of(box), fibres);
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
