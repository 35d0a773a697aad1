#ifndef INSONIFY_TESTS_SCENE_BRUTE_FORCE_HPP
#define INSONIFY_TESTS_SCENE_BRUTE_FORCE_HPP

#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/scene/scene.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

/// Queries by brute force in double precision: every triangle of every object, without trees or boxes.
namespace brute_force {

using vec = glm::dvec3;
using insonify::object;
using insonify::scene;

struct corners {
    vec a, b, c;
    vec normal() const { return glm::normalize(glm::cross(b - a, c - a)); }
};

inline vec in_world(const insonify::pose& at, insonify::vec3 p) {
    return glm::dmat3{at.rotation} * vec{p} + vec{at.translation};
}
inline corners face_of(const object& one, std::size_t face) {
    const insonify::uvec3 f = one.surface.faces[face];
    const auto& p = one.surface.positions;
    return {in_world(one.at, p[f.x]), in_world(one.at, p[f.y]), in_world(one.at, p[f.z])};
}

/// Where a line crosses a triangle; NaN where it does not. Source: Moeller & Trumbore 1997.
inline double crossing(const corners& t, vec origin, vec direction) {
    const vec e1 = t.b - t.a, e2 = t.c - t.a, p = glm::cross(direction, e2), s = origin - t.a, q = glm::cross(s, e1);
    const double det = glm::dot(e1, p), u = glm::dot(s, p) / det, v = glm::dot(direction, q) / det;
    return det != 0 && u >= 0 && v >= 0 && u + v <= 1 ? glm::dot(e2, q) / det
                                                      : std::numeric_limits<double>::quiet_NaN();
}

/// Distance from a point to a segment.
inline double distance(vec a, vec b, vec p) {
    const double along = glm::dot(b - a, b - a), part = along > 0 ? glm::dot(p - a, b - a) / along : 0;
    return glm::length(p - (a + std::clamp(part, 0.0, 1.0) * (b - a)));
}
/// Distance from a point to a triangle: to its plane where the foot of the perpendicular lies inside, else to an edge.
inline double distance(const corners& t, vec p) {
    const double edges = std::min({distance(t.a, t.b, p), distance(t.b, t.c, p), distance(t.c, t.a, p)});
    const vec across = glm::cross(t.b - t.a, t.c - t.a);
    const double twice_area = glm::length(across);
    if (!(twice_area > 0)) return edges;
    const vec n = across / twice_area;
    const auto left_of = [&](vec from, vec to) { return glm::dot(glm::cross(to - from, p - from), n) >= 0; };
    const bool inside = left_of(t.a, t.b) && left_of(t.b, t.c) && left_of(t.c, t.a);
    return inside ? std::fabs(glm::dot(p - t.a, n)) : edges;
}
inline double distance(const object& one, vec p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < one.surface.faces.size(); ++f)
        nearest = std::min(nearest, distance(face_of(one, f), p));
    return nearest;
}

/// Whether a half line in an arbitrary direction crosses the surface an odd number of times.
inline bool contains(const object& one, vec p) {
    bool inside = false;
    for (std::size_t f = 0; f < one.surface.faces.size(); ++f)
        if (crossing(face_of(one, f), p, {0.3141, -0.7723, 0.5521}) >= 0) inside = !inside;
    return inside;
}

/// The object of highest priority that contains a point, then the one of smaller volume, then the one added later.
inline const object* object_at(const scene& body, vec p) {
    const object* best = nullptr;
    const auto volume = [](const object& one) { return std::fabs(insonify::enclosed_volume(one.surface)); };
    for (const object& one : body.objects()) {
        if (!contains(one, p)) continue;
        if (best == nullptr || one.priority > best->priority ||
            (one.priority == best->priority && volume(one) <= volume(*best)))
            best = &one;
    }
    return best;
}

/// All crossings of a ray with the objects that are accepted, within its limits, nearest first.
struct surface_crossing {
    double distance = 0;
    insonify::object_id object{};
    std::uint32_t face = 0;
};
template <class Filter>
std::vector<surface_crossing> crossings(const scene& body, const insonify::ray& r, const Filter& accepts) {
    std::vector<surface_crossing> found;
    for (const object& one : body.objects()) {
        if (!accepts(one.id)) continue;
        for (std::uint32_t f = 0; f < one.surface.faces.size(); ++f) {
            const double t = crossing(face_of(one, f), vec{r.origin}, vec{r.direction});
            if (t >= static_cast<double>(r.min_distance) && t <= static_cast<double>(r.max_distance))
                found.push_back({t, one.id, f});
        }
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.distance < b.distance; });
    return found;
}

/// A point of the cube from -1 to 1.
inline insonify::vec3 random_point(std::uint64_t seed, std::uint64_t i) {
    using insonify::hash_uniform;
    return {2 * hash_uniform(seed, 3 * i) - 1, 2 * hash_uniform(seed, 3 * i + 1) - 1,
            2 * hash_uniform(seed, 3 * i + 2) - 1};
}

/// Spheres, boxes and cylinders in random poses within some 60 mm of the origin: they nest and overlap, some with equal
/// priorities.
inline scene random_scene(std::uint64_t seed) {
    using namespace insonify;
    scene body{medium{.density = 1000}};
    for (std::uint64_t i = 0; i < 9; ++i) {
        const std::uint64_t own = hash_bits(seed, i);
        const float size = 8e-3F + 0.02F * hash_uniform(own, 0);
        const vec3 centre = 0.02F * random_point(own, 3);
        mesh surface = i % 3 == 0 ? make_sphere({0, 0, 0}, size, 2)
                       : i % 3 == 1
                           ? make_box(-vec3{size, 0.7F * size, 0.5F * size}, {size, 0.7F * size, 0.5F * size}, 1)
                           : make_cylinder({0, 0, -size}, {0, 0, size}, 0.6F * size, 20);
        body.add(std::move(surface), medium{.density = 1001 + static_cast<float>(i)},
                 {.priority = static_cast<int>(hash_bits(own, 7) % 2),
                  .at = look_at(centre, centre + random_point(own, 4), random_point(own, 5))});
    }
    body.build(exec::par);
    return body;
}

} // namespace brute_force

#endif
