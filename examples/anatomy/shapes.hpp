#ifndef INSONIFY_EXAMPLES_ANATOMY_SHAPES_HPP
#define INSONIFY_EXAMPLES_ANATOMY_SHAPES_HPP

#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/implicit.hpp>
#include <insonify/geometry/shapes.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

/// Organs by code: tables of sections, tubes along lines, and functions that are joined smoothly.
namespace anatomy {

using namespace insonify;

/// Smooth random values in space, about -1 to 1, with independent values a `size` apart.
inline float noise(std::uint64_t seed, vec3 place, float size) {
    const vec3 p = place / size;
    const vec3 cell{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    const vec3 f = p - cell, s = f * f * (3.0F - 2.0F * f);
    const auto corner = [&](int i, int j, int k) {
        const auto at = [](float value, int step) {
            return static_cast<std::uint64_t>(static_cast<std::int64_t>(value) + step + 4096);
        };
        return 2 * hash_uniform(seed, (at(cell.x, i) << 26U) ^ (at(cell.y, j) << 13U) ^ at(cell.z, k)) - 1;
    };
    const auto mixed = [](float a, float b, float t) { return a + t * (b - a); };
    const auto row = [&](int j, int k) { return mixed(corner(0, j, k), corner(1, j, k), s.x); };
    return mixed(mixed(row(0, 0), row(1, 0), s.y), mixed(row(0, 1), row(1, 1), s.y), s.z);
}

/// The smaller and the larger of two values, rounded where they differ by less than `width`; also with a slope of at
/// most that of the steeper one. Source: the polynomial smooth minimum, I. Quilez.
/// @{
inline float smooth_min(float a, float b, float width) {
    const float h = max(width - std::fabs(a - b), 0) / width;
    return min(a, b) - 0.25F * h * h * width;
}
inline float smooth_max(float a, float b, float width) { return -smooth_min(-a, -b, width); }
/// @}

/// What of `body` is outside `hole`.
inline float less(float body, float hole, float width) { return smooth_max(body, -hole, width); }

/// A smooth step from 0 at `from` to 1 at `to`.
inline float ramp(float x, float from, float to) {
    const float t = clamp((x - from) / (to - from), 0, 1);
    return t * t * (3 - 2 * t);
}

/// Distance from an ellipsoid, to first order; exact on its surface.
inline float ellipsoid(vec3 p, vec3 radii) {
    const vec3 scaled = p / radii;
    const float k = length(scaled);
    return k > 0 ? k * (k - 1) / length(scaled / radii) : -min(min(radii.x, radii.y), radii.z);
}

/// Distance from a cone with round ends.
inline float round_cone(vec3 p, vec3 from, float from_radius, vec3 to, float to_radius) {
    const vec3 axis = to - from, away = p - from;
    const float part = clamp(dot(away, axis) / dot(axis, axis), 0, 1);
    return length(away - part * axis) - (from_radius + part * (to_radius - from_radius));
}

/// Values between points, by a cubic through all of them, smooth at each.
/// @param knot   knot(i), ascending
/// @param i      of the point before
/// @param part   0 there, 1 at the next point
/// Source: Catmull & Rom 1974, with uneven knots.
template <class Value, class Knot>
Value cubic_between(const std::vector<Value>& points, const Knot& knot, std::size_t i, float part) {
    const Value b = points[i], c = points[i + 1];
    const float step = knot(i + 1) - knot(i);
    Value leaving = c - b, arriving = c - b; // slopes, per step
    if (i > 0) {
        const float before = knot(i) - knot(i - 1);
        leaving = (step / before) * (b - points[i - 1]) - (step / (before + step)) * (c - points[i - 1]) + (c - b);
    }
    if (i + 2 < points.size()) {
        const float after = knot(i + 2) - knot(i + 1);
        arriving = (c - b) - (step / (step + after)) * (points[i + 2] - b) + (step / after) * (points[i + 2] - c);
    }
    const float t = part;
    return b + t * (leaving +
                    t * ((3.0F * (c - b) - 2.0F * leaving - arriving) + t * (leaving + arriving - 2.0F * (c - b))));
}

/// A smooth line through points, as `make_tube` takes it: vessels, nerves.
/// @param spacing  of its sections, about, metres
inline std::vector<tube_section> smooth_line(const std::vector<tube_section>& points, float spacing) {
    std::vector<vec3> centres, radii;
    std::vector<float> knots{0};
    for (const tube_section& one : points) {
        // Centripetal knots: no loops where distances are uneven (Yuksel, Schaefer & Keyser 2011).
        if (!centres.empty()) knots.push_back(knots.back() + std::sqrt(length(one.centre - centres.back())));
        centres.push_back(one.centre);
        radii.push_back({one.radii.x, one.radii.y, one.turn});
    }
    const auto knot = [&](std::size_t k) { return knots[k]; };
    std::vector<tube_section> line;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const auto pieces = static_cast<std::uint32_t>(std::ceil(length(centres[i + 1] - centres[i]) / spacing));
        for (std::uint32_t k = i == 0 ? 0 : 1; k <= pieces; ++k) {
            const float part = static_cast<float>(k) / static_cast<float>(pieces);
            const vec3 size = cubic_between(radii, knot, i, part);
            line.push_back({cubic_between(centres, knot, i, part), {size.x, size.y}, size.z});
        }
    }
    return line;
}

/// Distance from a chain of round cones along a line: a vessel as a function, for trees that are joined smoothly.
inline float chain(vec3 p, const std::vector<tube_section>& line) {
    float nearest = FLT_MAX;
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        nearest = min(nearest, round_cone(p, line[i].centre, line[i].radii.x, line[i + 1].centre, line[i + 1].radii.x));
    return nearest;
}

/// The cross-section of a structure at one place along the body.
struct section {
    float along = 0;              ///< y, metres
    vec2 centre{0, 0};            ///< x and z, metres
    float half_width = 5e-3F;     ///< of its long axis, metres
    float half_thickness = 2e-3F; ///< across it, metres
    float turn = 0;               ///< of the long axis, from x towards z, radians
    float bend = 0; ///< curvature of the long axis, 1/m; above 0 its ends turn to the side of the short axis

    friend section operator+(const section& a, const section& b) { return combined(a, b, 1); }
    friend section operator-(const section& a, const section& b) { return combined(a, b, -1); }
    friend section operator*(float factor, const section& a) { return combined({0, {0, 0}, 0, 0}, a, factor); }

  private:
    static section combined(const section& a, const section& b, float factor) {
        return {a.along + factor * b.along,
                a.centre + factor * b.centre,
                a.half_width + factor * b.half_width,
                a.half_thickness + factor * b.half_thickness,
                a.turn + factor * b.turn,
                a.bend + factor * b.bend};
    }
};

/// A structure along y by a table of sections, cubic in between. A section is a superellipse whose long axis is an arc.
///
/// It is known in two ways: as a mesh by `surface`, and as a function by `distance`.
struct swept {
    std::vector<section> sections{}; ///< by ascending `along`, at least 2
    float power = 2.3F;              ///< of the superellipse: 2 is an ellipse, more is more rectangular
    float start = 4e-3F;             ///< length over which its first end is rounded off, metres
    float end = 4e-3F;               ///< the same of its last end
    float waves = 0;                 ///< amplitude of irregular waves of its surface, metres
    std::uint64_t seed = 0;          ///< of the waves

    /// The section at a place; its sizes shrink to 0 at the ends.
    section at(float along) const {
        std::size_t i = 0;
        while (i + 2 < sections.size() && sections[i + 1].along < along) ++i;
        const float part = (along - sections[i].along) / (sections[i + 1].along - sections[i].along);
        section here = cubic_between(
            sections, [&](std::size_t k) { return sections[k].along; }, i, clamp(part, 0, 1));
        const auto rounded = [](float from_end, float over) {
            const float t = 1 - clamp(from_end / over, 0, 1);
            return std::sqrt(max(1 - t * t, 0));
        };
        const float size = rounded(along - sections.front().along, start) * rounded(sections.back().along - along, end);
        here.along = along;
        here.half_width = max(here.half_width, 1e-5F) * size;
        here.half_thickness = max(here.half_thickness, 1e-5F) * size;
        return here;
    }

    /// The point of the outline of a section at an angle.
    vec3 point(const section& here, float angle, float grown = 0) const {
        const float wave = wave_at(angle, here.along) * min(here.half_thickness / 1e-3F, 1);
        const float c = std::cos(angle), s = std::sin(angle);
        const auto powered = [&](float value) { return std::copysign(std::pow(std::fabs(value), 2 / power), value); };
        const float u = max(here.half_width + grown + wave, 1e-5F) * powered(c),
                    v = max(here.half_thickness + grown + wave, 1e-5F) * powered(s);
        // On the arc: its point at the length u, and v along its normal there.
        const float turned = here.bend * u;
        const float x = std::fabs(turned) > 1e-4F ? std::sin(turned) / here.bend : u;
        const float z = std::fabs(turned) > 1e-4F ? (1 - std::cos(turned)) / here.bend : 0.5F * turned * u;
        const vec2 local{x - v * std::sin(turned), z + v * std::cos(turned)};
        const float ct = std::cos(here.turn), st = std::sin(here.turn);
        return {here.centre.x + ct * local.x - st * local.y, here.along, here.centre.y + st * local.x + ct * local.y};
    }

    /// A distance from its surface, to first order; below 0 inside.
    float distance(vec3 p) const {
        const float from = sections.front().along, to = sections.back().along;
        const section here = at(clamp(p.y, from, to));
        const float ct = std::cos(here.turn), st = std::sin(here.turn);
        const vec2 away{p.x - here.centre.x, p.z - here.centre.y};
        const vec2 local{ct * away.x + st * away.y, ct * away.y - st * away.x};
        float u = local.x, v = local.y;
        if (std::fabs(here.bend) > 1e-3F) { // from the centre of the arc
            const float radius = 1 / here.bend, x = local.x, z = radius - local.y;
            const float side = std::copysign(1.0F, here.bend);
            u = std::atan2(x * side, z * side) * radius;
            v = radius - side * std::sqrt(x * x + z * z);
        }
        const float w = max(here.half_width, 1e-5F), t = max(here.half_thickness, 1e-5F);
        const float a = std::fabs(u) / w, b = std::fabs(v) / t;
        const float k = std::pow(std::pow(a, power) + std::pow(b, power), 1 / power);
        const float beyond = max(max(from - p.y, p.y - to), 0);
        if (k < 1e-3F) return beyond > 0 ? beyond : -t;
        const float across = std::pow(a / k, power - 1) / w, deep = std::pow(b / k, power - 1) / t;
        const float value = (k - 1) / std::sqrt(across * across + deep * deep) - wave_at(std::atan2(v / t, u / w), p.y);
        return beyond > 0 ? std::sqrt(beyond * beyond + max(value, 0) * max(value, 0)) : value;
    }

    /// Its closed surface.
    /// @param cell   mean side of its triangles, metres
    /// @param grown  outwards, metres: a wall or sheath around it
    mesh surface(float cell, float grown = 0) const {
        float widest = 0, perimeter = 0;
        for (const section& one : sections) {
            widest = max(widest, one.half_width);
            perimeter = max(perimeter, 4 * (one.half_width + one.half_thickness));
        }
        const float from = sections.front().along - grown, to = sections.back().along + grown;
        const auto around = static_cast<std::uint32_t>(clamp(std::round(perimeter / cell), 12, 160));
        // Rings lie closer where the ends are rounded off.
        std::vector<float> places;
        const auto rings_of = [&](float size) {
            return static_cast<std::uint32_t>(clamp(std::round(size / cell), 4, 24));
        };
        const float first = clamp(start + grown, 0.5e-3F, 0.45F * (to - from)),
                    last = clamp(end + grown, 0.5e-3F, 0.45F * (to - from));
        const std::uint32_t n = rings_of(first), m = rings_of(last);
        for (std::uint32_t i = 1; i <= n; ++i)
            places.push_back(from + first * (1 - std::cos(0.5F * pi * static_cast<float>(i) / static_cast<float>(n))));
        const auto middle = static_cast<std::uint32_t>(
            max(std::round((to - from - first - last) / (1.6F * cell)), 1)); // long triangles: it varies slowly along y
        for (std::uint32_t i = 1; i < middle; ++i)
            places.push_back(from + first +
                             (to - from - first - last) * static_cast<float>(i) / static_cast<float>(middle));
        for (std::uint32_t i = m; i >= 1; --i)
            places.push_back(to - last * (1 - std::cos(0.5F * pi * static_cast<float>(i) / static_cast<float>(m))));

        mesh body;
        const section front = at(sections.front().along), back = at(sections.back().along);
        body.positions = {{front.centre.x, from, front.centre.y}, {back.centre.x, to, back.centre.y}};
        const float stretch = (sections.back().along - sections.front().along) / (to - from);
        for (const float place : places) {
            // A grown end is rounded off over the same rings.
            section here = at(sections.front().along + stretch * (place - from));
            const float rim = clamp(min((place - from) / first, (to - place) / last), 0, 1);
            here.along = place;
            for (std::uint32_t i = 0; i < around; ++i)
                body.positions.push_back(point(here, 2 * pi * static_cast<float>(i) / static_cast<float>(around),
                                               grown * std::sqrt(rim * (2 - rim))));
        }
        const auto rings = static_cast<std::uint32_t>(places.size());
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t next = (i + 1) % around;
            body.faces.push_back({0, 2 + i, 2 + next});
            for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
                const std::uint32_t a = 2 + ring * around + i, b = 2 + ring * around + next;
                body.faces.insert(body.faces.end(), {{a, a + around, b + around}, {a, b + around, b}});
            }
            const std::uint32_t a = 2 + (rings - 1) * around;
            body.faces.push_back({1, a + next, a + i});
        }
        return body;
    }

    /// The box around it, enlarged.
    aabb box(float margin) const {
        aabb all;
        for (int i = 0; i <= 32; ++i) {
            const section here = at(sections.front().along +
                                    (sections.back().along - sections.front().along) * static_cast<float>(i) / 32);
            for (int k = 0; k < 16; ++k) all = merged(all, point(here, 2 * pi * static_cast<float>(k) / 16));
        }
        return {all.lower - vec3{margin}, all.upper + vec3{margin}};
    }

  private:
    float wave_at(float angle, float along) const {
        if (waves == 0) return 0;
        float sum = 0;
        for (std::uint64_t k = 0; k < 4; ++k) {
            const float turns = std::floor(2 + 4 * hash_uniform(seed, 3 * k));
            const float length = 15e-3F + 25e-3F * hash_uniform(seed, 3 * k + 1);
            sum += std::sin(turns * angle + 2 * pi * (along / length + hash_uniform(seed, 3 * k + 2)));
        }
        return 0.5F * waves * sum;
    }
};

/// The normals of a mesh's vertices: the mean of those of the faces, weighted by area.
inline std::vector<vec3> vertex_normals(const mesh& body) {
    std::vector<vec3> normals(body.positions.size(), vec3{0});
    for (const uvec3 f : body.faces) {
        const vec3 normal = cross(body.positions[f.y] - body.positions[f.x], body.positions[f.z] - body.positions[f.x]);
        for (const std::uint32_t corner : {f.x, f.y, f.z}) normals[corner] += normal;
    }
    for (vec3& normal : normals) normal = dot(normal, normal) > 0 ? normalize(normal) : vec3{0};
    return normals;
}

/// A mesh with its vertices moved. Steps of neighbours that differ by more than these are apart would make faces cross, and so
/// would those that turn a face over: they are averaged, and shortened where that does not suffice.
/// @param steps  of the vertices, metres
inline mesh displaced(mesh body, std::vector<vec3> steps) {
    constexpr float max_slope = 0.6F;  // of the steps along an edge
    constexpr float min_cosine = 0.3F; // between the normals of a face before and after
    constexpr int rounds = 12;
    struct neighbourhood {
        vec3 sum{0, 0, 0};
        float count = 0;
        bool crosses = false;
    };
    std::vector<neighbourhood> around;
    for (int round = 0; round < rounds; ++round) {
        around.assign(steps.size(), {});
        bool any = false;
        const auto normal = [&](uvec3 f, float part) {
            const auto at = [&](std::uint32_t i) { return body.positions[i] + part * steps[i]; };
            return cross(at(f.y) - at(f.x), at(f.z) - at(f.x));
        };
        for (const uvec3 f : body.faces) {
            const vec3 before = normal(f, 0), after = normal(f, 1);
            if (dot(before, after) < min_cosine * length(before) * length(after))
                around[f.x].crosses = around[f.y].crosses = around[f.z].crosses = any = true;
            for (const auto& [i, k] : {std::pair{f.x, f.y}, {f.y, f.z}, {f.z, f.x}}) { // each edge once in each sense
                around[i].sum += steps[k];
                around[i].count += 1;
                if (length(steps[i] - steps[k]) <= max_slope * length(body.positions[i] - body.positions[k])) continue;
                around[i].crosses = around[k].crosses = any = true;
            }
        }
        if (!any) break;
        const float factor = round < rounds / 2 ? 0.5F : 0.35F;
        for (std::size_t i = 0; i < steps.size(); ++i)
            if (around[i].crosses) steps[i] = factor * (steps[i] + around[i].sum / around[i].count);
    }
    for (std::size_t i = 0; i < steps.size(); ++i) body.positions[i] += steps[i];
    return body;
}

/// A mesh with its surface moved outwards by a thickness that is uneven: the wall of a vessel, the sheath of a nerve.
/// @param thickness  mean, metres; below 0: inwards
/// @param uneven     fraction by which it varies, over `size` metres
inline mesh grown(mesh body, float thickness, float uneven = 0, float size = 4e-3F, std::uint64_t seed = 0) {
    std::vector<vec3> steps = vertex_normals(body);
    for (std::size_t i = 0; i < steps.size(); ++i)
        steps[i] *= thickness * (uneven > 0 ? 1 + uneven * noise(seed, body.positions[i], size) : 1);
    return displaced(std::move(body), std::move(steps));
}

/// Moves what of a body is less deep than `limit` to beneath it: a muscle below its fascia.
/// @param depth  float(vec3), metres, about a distance from the skin
/// @param blend  depth over which the body is compressed below the limit, metres
template <class Depth>
mesh confined(mesh body, const Depth& depth, float limit, float blend = 0.6e-3F) {
    for (vec3& p : body.positions)
        for (int round = 0; round < 3; ++round) { // the depth is no exact distance
            const float now = depth(p);
            if (now > limit + blend) break;
            const float wanted = round == 0 ? smooth_max(now, limit, blend) : max(now, limit);
            if (wanted - now < 1e-7F) break;
            constexpr float h = 0.1e-3F;
            const vec3 slope =
                vec3{depth(p + vec3{h, 0, 0}) - now, depth(p + vec3{0, h, 0}) - now, depth(p + vec3{0, 0, h}) - now} /
                h;
            p += (wanted - now) / max(dot(slope, slope), 0.05F) * slope;
        }
    return body;
}

/// Several closed surfaces as one mesh.
inline void append(mesh& to, const mesh& more) {
    const auto first = static_cast<std::uint32_t>(to.positions.size());
    to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
    for (const uvec3 f : more.faces) to.faces.push_back(f + first);
}

/// The surface of {function < 0} where every ray from `centre` leaves it: for bodies that can be seen whole from there.
/// Faster than `mesh_implicit`, with a tenth of the triangles.
/// @param radii         of an ellipsoid that is about as long and wide as the body, metres: it spreads the triangles
/// @param subdivisions  20 * 4^subdivisions triangles
template <class Function>
mesh star_shaped(const Function& function, vec3 centre, vec3 radii, std::uint32_t subdivisions) {
    mesh body = make_sphere({0, 0, 0}, 1, subdivisions);
    for (vec3& p : body.positions) {
        const vec3 out = p * radii;
        constexpr float step = 0.08F, farthest = 4;
        float to = step;
        while (to < farthest && function(centre + to * out) < 0) to += step;
        float from = to - step;
        for (int round = 0; round < 12; ++round) {
            const float half = 0.5F * (from + to);
            (function(centre + half * out) < 0 ? from : to) = half;
        }
        p = centre + 0.5F * (from + to) * out;
    }
    return body;
}

} // namespace anatomy

#endif
