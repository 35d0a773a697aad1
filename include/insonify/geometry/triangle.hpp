#ifndef INSONIFY_GEOMETRY_TRIANGLE_HPP
#define INSONIFY_GEOMETRY_TRIANGLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/geometry/ray.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A triangle, counter-clockwise seen from outside; metres.
struct triangle {
    vec3 a{0, 0, 0}; ///< first corner
    vec3 b{0, 0, 0}; ///< second corner
    vec3 c{0, 0, 0}; ///< third corner
};

/// Bounding box; empty where a corner is not finite.
INSONIFY_FN inline aabb bounds(const triangle& t) {
    if (!is_finite(t.a) || !is_finite(t.b) || !is_finite(t.c)) return {};
    return {min(min(t.a, t.b), t.c), max(max(t.a, t.b), t.c)};
}

/// Outward normal whose length is twice the area.
INSONIFY_FN inline vec3 area_vector(const triangle& t) { return cross(t.b - t.a, t.c - t.a); }

/// Outward unit normal; `otherwise` where the area underflows or overflows.
INSONIFY_FN inline vec3 unit_normal(const triangle& t, vec3 otherwise) {
    const vec3 area = area_vector(t);
    const float size = length(area);
    return size > 0 && is_finite(size) ? normalize(area) : otherwise;
}

/// A ray with the shear that maps it to the z axis, where triangles are tested in two dimensions.
///
/// Source: Woop, Benthin & Wald 2013, "Watertight ray/triangle intersection".
struct sheared_ray {
    vec3 begin{0, 0, 0}; ///< origin, its coordinates permuted as below
    /// World axes that become x, y and z; the direction is largest along z.
    /// @{
    int x = 0, y = 1, z = 2;
    /// @}
    vec3 shear{0, 0, 1}; ///< x and y: shear per unit of z; z: scale from z to distance

    sheared_ray() = default;
    /// The shear of a ray.
    INSONIFY_FN explicit sheared_ray(const ray& r) {
        const vec3 size = abs(r.direction);
        const bool y_over_x = !(size.x > size.y); // branchless: directions are unpredictable
        z = (y_over_x ? size.y : size.x) > size.z ? static_cast<int>(y_over_x) : 2;
        x = z == 2 ? 0 : z + 1;
        y = z == 0 ? 2 : z - 1;
        const float origin[3] = {r.origin.x, r.origin.y, r.origin.z};
        const float along[3] = {r.direction.x, r.direction.y, r.direction.z};
        begin = {origin[x], origin[y], origin[z]};
        const float scale = 1 / along[z];
        shear = {along[x] * scale, along[y] * scale, scale};
    }

    /// A vector with its coordinates permuted.
    INSONIFY_FN vec3 in_order(vec3 v) const { return z == 2 ? v : z == 0 ? vec3{v.y, v.z, v.x} : vec3{v.z, v.x, v.y}; }

    /// x and y across the ray, z along it, not yet scaled. Equal vertices give bit-equal results.
    INSONIFY_FN vec3 operator()(vec3 p) const {
        const vec3 v = in_order(p) - begin;
        return {multiply_add(-shear.x, v.z, v.x), multiply_add(-shear.y, v.z, v.y), v.z};
    }
};

namespace detail {

/// Edge function in the sheared plane: twice the signed area of (origin, p, q).
///
/// Products of two floats are exact in double, so the sign is exact, and reversing the edge flips it.
INSONIFY_FN inline double edge_side(vec3 p, vec3 q) {
    return static_cast<double>(p.x) * q.y - static_cast<double>(p.y) * q.x;
}

/// Sign of the edge function, with ties broken by simulation of simplicity: the ray is displaced by an infinitesimal
/// step in x and an infinitesimally smaller one in y. So a point on a shared edge or vertex belongs to exactly one
/// triangle.
INSONIFY_FN inline int edge_sign(double side, vec3 p, vec3 q) {
    if (side != 0) return side > 0 ? 1 : -1;
    if (p.y != q.y) return p.y > q.y ? 1 : -1;
    return (q.x > p.x) - (q.x < p.x);
}

/// The point of a triangle that is nearest to p. Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
INSONIFY_FN inline vec3 nearest_on(const triangle& t, vec3 p) {
    const vec3 ab = t.b - t.a, ac = t.c - t.a;
    const float d1 = dot(ab, p - t.a), d2 = dot(ac, p - t.a);
    if (d1 <= 0 && d2 <= 0) return t.a;
    const float d3 = dot(ab, p - t.b), d4 = dot(ac, p - t.b);
    if (d3 >= 0 && d4 <= d3) return t.b;
    const float d5 = dot(ab, p - t.c), d6 = dot(ac, p - t.c);
    if (d6 >= 0 && d5 <= d6) return t.c;
    const auto along = [](vec3 from, vec3 edge, float part, float whole) {
        return whole > 0 ? from + (part / whole) * edge : from;
    };
    const float by_c = d1 * d4 - d3 * d2, by_b = d5 * d2 - d1 * d6, by_a = d3 * d6 - d5 * d4;
    if (by_c <= 0 && d1 >= 0 && d3 <= 0) return along(t.a, ab, d1, d1 - d3);
    if (by_b <= 0 && d2 >= 0 && d6 <= 0) return along(t.a, ac, d2, d2 - d6);
    if (by_a <= 0 && d4 >= d3 && d5 >= d6) return along(t.b, t.c - t.b, d4 - d3, (d4 - d3) + (d5 - d6));
    const float sum = by_a + by_b + by_c;
    return sum > 0 ? t.a + (by_b / sum) * ab + (by_c / sum) * ac : t.a;
}

} // namespace detail

/// Two-sided ray/triangle intersection; the limits of the ray are ignored.
///
/// Watertight: along any line through a closed mesh, entries and exits alternate, through edges and vertices as well.
INSONIFY_FN inline hit intersect(const sheared_ray& r, const triangle& t) {
    const vec3 a = r(t.a), b = r(t.b), c = r(t.c);
    const double u = detail::edge_side(b, c), v = detail::edge_side(c, a), w = detail::edge_side(a, b);
    const int side = detail::edge_sign(u, b, c);
    if (side == 0 || side != detail::edge_sign(v, c, a) || side != detail::edge_sign(w, a, b)) return {};
    const double area = u + v + w;
    if (!(area != 0)) return {};
    hit found;
    found.distance = static_cast<float>((u * a.z + v * b.z + w * c.z) / area * r.shear.z);
    return found;
}

/// The same, for a ray that is tested against one triangle only.
INSONIFY_FN inline hit intersect(const ray& r, const triangle& t) { return intersect(sheared_ray{r}, t); }

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
