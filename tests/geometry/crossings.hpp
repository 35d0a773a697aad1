#ifndef INSONIFY_TESTS_GEOMETRY_CROSSINGS_HPP
#define INSONIFY_TESTS_GEOMETRY_CROSSINGS_HPP

#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/ray.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace mesh_test {

using namespace insonify;

/// Where faces of one mesh cross each other.
struct crossings {
    std::size_t faces = 0; ///< that cross another one
    double depth = 0;      ///< largest distance from a face to the nearer end of an edge through it, metres
    vec3 place{0, 0, 0};   ///< of that crossing, metres
};

/// The faces of a mesh that cross others of it, found in a grid. Faces with a common edge are not compared.
inline crossings crossings_of(const mesh& body) {
    crossings found;
    const std::size_t count = body.faces.size();
    double side = 0;
    aabb all;
    std::vector<aabb> boxes(count);
    for (std::size_t f = 0; f < count; ++f) {
        for (const std::uint32_t corner : {body.faces[f].x, body.faces[f].y, body.faces[f].z})
            boxes[f] = merged(boxes[f], body.positions[corner]);
        all = merged(merged(all, boxes[f].lower), boxes[f].upper);
        const vec3 size = boxes[f].size();
        side += static_cast<double>(max(max(size.x, size.y), size.z)) / static_cast<double>(count);
    }
    const auto cell = static_cast<float>(1.2 * side);
    const auto cells = [&](vec3 p) { return uvec3{(p - all.lower) / cell}; };
    // Pairs of (hash of cell, face), sorted by cell.
    std::vector<std::pair<std::uint64_t, std::uint32_t>> entries;
    for (std::uint32_t f = 0; f < count; ++f) {
        const uvec3 from = cells(boxes[f].lower), to = cells(boxes[f].upper);
        for (std::uint64_t z = from.z; z <= to.z; ++z)
            for (std::uint64_t y = from.y; y <= to.y; ++y)
                for (std::uint64_t x = from.x; x <= to.x; ++x) entries.emplace_back(x << 42U | y << 21U | z, f);
    }
    std::sort(entries.begin(), entries.end());
    const auto at = [&](std::uint32_t corner) { return dvec3{body.positions[corner]}; };
    const auto has = [](uvec3 face, std::uint32_t corner) {
        return face.x == corner || face.y == corner || face.z == corner;
    };
    std::vector<bool> crosses(count, false);
    const auto compare = [&](std::uint32_t first, std::uint32_t second) {
        const uvec3 edges = body.faces[first], face = body.faces[second];
        const dvec3 a = at(face.x), b = at(face.y), c = at(face.z), n = cross(b - a, c - a);
        const double size = length(n);
        if (!(size > 0)) return;
        for (const auto& [from, to] : {std::pair{edges.x, edges.y}, {edges.y, edges.z}, {edges.z, edges.x}}) {
            if (has(face, from) || has(face, to)) continue;
            const dvec3 p = at(from), q = at(to);
            const double above = dot(p - a, n) / size, below = dot(q - a, n) / size;
            constexpr double touching = 1e-9;
            if (!(std::min(above, below) < -touching && std::max(above, below) > touching)) continue;
            const dvec3 x = p + above / (above - below) * (q - p);
            const double limit = 1e-6 * size * size;
            if (dot(cross(b - a, x - a), n) < limit || dot(cross(c - b, x - b), n) < limit ||
                dot(cross(a - c, x - c), n) < limit)
                continue;
            crosses[first] = crosses[second] = true;
            const double depth = std::min(std::fabs(above), std::fabs(below));
            if (depth > found.depth) found.depth = depth, found.place = vec3{x};
        }
    };
    for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
        while (end < entries.size() && entries[end].first == entries[begin].first) ++end;
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t k = i + 1; k < end; ++k) {
                const std::uint32_t one = entries[i].second, other = entries[k].second;
                const aabb &u = boxes[one], &v = boxes[other];
                if (u.lower.x > v.upper.x || v.lower.x > u.upper.x || u.lower.y > v.upper.y || v.lower.y > u.upper.y ||
                    u.lower.z > v.upper.z || v.lower.z > u.upper.z)
                    continue;
                const uvec3 f = body.faces[one], g = body.faces[other];
                if (has(f, g.x) + has(f, g.y) + has(f, g.z) >= 2) continue;
                compare(one, other);
                compare(other, one);
            }
    }
    for (const bool one : crosses) found.faces += one ? 1 : 0;
    return found;
}

} // namespace mesh_test

#endif
