#ifndef INSONIFY_TESTS_TRACING_REFERENCE_HPP
#define INSONIFY_TESTS_TRACING_REFERENCE_HPP

#include <insonify/core/random.hpp>
#include <insonify/geometry/shapes.hpp>
#include <insonify/paper/law2011.hpp>
#include <insonify/scene/scene.hpp>
#include <algorithm>
#include <vector>

/// The paper's equations by brute force in double precision: every triangle of every object, no tree, no SIMD, and
/// nothing of the library's but the meshes and poses.
namespace reference {

using insonify::object;
using insonify::scene;
using vec = glm::dvec3;

struct change {
    double depth;
    insonify::medium before, after;
};

struct line {
    insonify::medium at_face{};
    std::vector<change> changes{}; // where the medium changes, ascending
};

inline vec in_world(const insonify::pose& at, insonify::vec3 p) {
    return glm::dmat3{at.rotation} * vec{p} + vec{at.translation};
}

// Distances at which the half line meets the surface. Source: Moeller & Trumbore 1997.
inline std::vector<double> crossings(const object& one, vec origin, vec direction) {
    std::vector<double> found;
    for (const insonify::uvec3& face : one.surface.faces) {
        const vec a = in_world(one.at, one.surface.positions[face.x]);
        const vec e1 = in_world(one.at, one.surface.positions[face.y]) - a;
        const vec e2 = in_world(one.at, one.surface.positions[face.z]) - a;
        const vec p = glm::cross(direction, e2), s = origin - a, q = glm::cross(s, e1);
        const double det = glm::dot(e1, p);
        if (det == 0) continue;
        const double u = glm::dot(s, p) / det, v = glm::dot(direction, q) / det, t = glm::dot(e2, q) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && t >= 0) found.push_back(t);
    }
    return found;
}

inline line trace(const scene& body, const insonify::ray& beam) {
    struct event {
        double depth;
        std::size_t object;
    };
    const vec origin{beam.origin}, direction{beam.direction};
    const auto& objects = body.objects();
    std::vector<event> events;
    std::vector<bool> inside(objects.size());
    std::vector<double> volume(objects.size());
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const std::vector<double> found = crossings(objects[i], origin, direction);
        inside[i] = found.size() % 2 == 1;
        for (const double depth : found) events.push_back({depth, i});
        volume[i] = std::fabs(insonify::enclosed_volume(objects[i].surface));
    }
    std::sort(events.begin(), events.end(), [](const event& a, const event& b) { return a.depth < b.depth; });
    const auto medium_now = [&] {
        std::size_t best = objects.size();
        for (std::size_t i = 0; i < objects.size(); ++i) {
            if (!inside[i]) continue;
            const bool better = best == objects.size() || objects[i].priority > objects[best].priority ||
                                (objects[i].priority == objects[best].priority && volume[i] <= volume[best]);
            if (better) best = i;
        }
        return best == objects.size() ? body.background() : objects[best].inside;
    };
    line result{medium_now()};
    insonify::medium current = result.at_face;
    for (const event& e : events) {
        inside[e.object] = !inside[e.object];
        const insonify::medium after = medium_now();
        if (after == current) continue;
        result.changes.push_back({e.depth, current, after});
        current = after;
    }
    return result;
}

inline double impedance(const insonify::medium& m) { return static_cast<double>(m.density) * m.sound_speed; }

// I = I_a I_t + I_r, literally: one way, I_r without attenuation, the band before the interface.
inline double intensity(const line& l, double depth, double megahertz, double reflection_length) {
    double transmitted = 1, decibels = 0, above = 0;
    insonify::medium here = l.at_face;
    for (const change& c : l.changes) {
        const double z1 = impedance(c.before), z2 = impedance(c.after);
        if (c.depth > depth) {
            const double r = (z2 - z1) / (z2 + z1);
            decibels += here.attenuation * megahertz * (depth - above);
            return std::pow(10.0, -decibels / 20) * transmitted +
                   (c.depth - depth <= reflection_length ? transmitted * r * r : 0);
        }
        decibels += here.attenuation * megahertz * (c.depth - above);
        above = c.depth;
        transmitted *= 4 * z1 * z2 / ((z1 + z2) * (z1 + z2));
        here = c.after;
    }
    decibels += here.attenuation * megahertz * (depth - above);
    return std::pow(10.0, -decibels / 20) * transmitted;
}

// Within 2 um of an interface, or of the end of its band, rounding may put a sample on either side.
inline bool in_doubt(const line& l, double depth, double reflection_length) {
    for (const change& c : l.changes)
        if (std::fabs(c.depth - depth) < 2e-6 || std::fabs(c.depth - reflection_length - depth) < 2e-6) return true;
    return false;
}

} // namespace reference

#endif
