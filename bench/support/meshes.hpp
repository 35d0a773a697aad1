#ifndef INSONIFY_BENCH_SUPPORT_MESHES_HPP
#define INSONIFY_BENCH_SUPPORT_MESHES_HPP

#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <cmath>

/// The meshes that every figure is measured on: 100 mm across and centered at the origin, but for the leg.
namespace bench {

using namespace insonify;

/// A sphere with bumps as an organ has: 20 * 4^subdivisions triangles.
inline mesh make_organ(std::uint32_t subdivisions) {
    mesh organ = make_sphere({0, 0, 0}, 1, subdivisions);
    for (vec3& p : organ.positions) {
        const float bumps = 0.08F * std::sin(5 * p.x + 1) * std::cos(4 * p.y) + 0.04F * std::sin(13 * p.z + 7 * p.x) +
                            0.01F * std::cos(31 * p.y - 23 * p.z);
        p *= 45_mm * (1 + bumps);
    }
    return organ;
}
inline mesh organ_82k() { return make_organ(6); }
inline mesh organ_1_3m() { return make_organ(8); }

/// Small triangles anywhere, sharing no vertex.
inline mesh soup(std::uint32_t count = 500'000) {
    mesh m;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto at = [&](std::uint64_t k) {
            const std::uint64_t first = 12 * std::uint64_t{i} + 3 * k;
            return vec3{hash_uniform(1, first) - 0.5F, hash_uniform(1, first + 1) - 0.5F,
                        hash_uniform(1, first + 2) - 0.5F};
        };
        const vec3 centre = 100_mm * at(0);
        for (std::uint64_t corner = 1; corner <= 3; ++corner) m.positions.push_back(centre + 2_mm * at(corner));
        m.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return m;
}

/// The paper's cube at 12 * 4^subdivisions triangles: 786,432 at 8.
inline mesh cube(std::uint32_t subdivisions = 8) {
    return make_box({-30_mm, -30_mm, -30_mm}, {30_mm, 30_mm, 30_mm}, subdivisions);
}

/// Appends a mesh to another.
inline void append(mesh& all, const mesh& one) {
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), one.positions.begin(), one.positions.end());
    for (const uvec3& face : one.faces) all.faces.push_back(face + first);
}

/// 32 spheres one inside the other, 655,360 triangles: a line crosses 64 surfaces.
inline mesh shells() {
    mesh all;
    for (int shell = 1; shell <= 32; ++shell) {
        const mesh one = make_sphere({0, 0, 0}, 45_mm * static_cast<float>(shell) / 32, 5);
        append(all, one);
    }
    return all;
}

/// A closed spindle along z of circular rings, bumpy and bent, whose triangles have edges of about `edge`: as meshes made
/// from segmented images have, long pieces and short ones alike.
struct spindle {
    vec3 centre{0, 0, 0};
    float half_length = 0;
    float radius = 0;
    float bend = 0; ///< of its ends, along x
};

inline mesh make_spindle(const spindle& shape, float edge) {
    const auto rings = static_cast<std::uint32_t>(2 * shape.half_length / edge);
    const auto around = static_cast<std::uint32_t>(2 * pi * shape.radius / edge);
    mesh m;
    for (std::uint32_t ring = 0; ring <= rings; ++ring) {
        const float along = 2 * static_cast<float>(ring) / static_cast<float>(rings) - 1;
        const float profile = std::sqrt(1 - along * along * along * along);
        const bool pole = ring == 0 || ring == rings;
        for (std::uint32_t i = 0; i < (pole ? 1 : around); ++i) {
            const float turn = 2 * pi * static_cast<float>(i) / static_cast<float>(around);
            const float z = shape.half_length * along,
                        bumps = 1 + 0.05F * std::sin(3 * turn + 90 * z) + 0.02F * std::cos(7 * turn - 400 * z);
            const float r = pole ? 0.0F : shape.radius * profile * bumps;
            m.positions.push_back(shape.centre +
                                  vec3{r * std::cos(turn) + shape.bend * along * along, r * std::sin(turn), z});
        }
    }
    const auto vertex = [&](std::uint32_t ring, std::uint32_t i) {
        return ring == 0 ? 0 : ring == rings ? 1 + (rings - 1) * around : 1 + (ring - 1) * around + i % around;
    };
    for (std::uint32_t ring = 0; ring < rings; ++ring)
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t a = vertex(ring, i), b = vertex(ring, i + 1);
            const std::uint32_t c = vertex(ring + 1, i + 1), d = vertex(ring + 1, i);
            if (ring > 0) m.faces.push_back({a, b, c});
            if (ring + 1 < rings) m.faces.push_back({a, c, d});
        }
    return m;
}

/// A leg of sixty separate pieces, 1 M triangles in a body 800 mm long and 130 mm wide that lies far from the origin of
/// its coordinates, as in a scan: long muscles and bones, vessels, and small pieces at the lower end.
inline constexpr vec3 leg_centre{480_mm, -410_mm, 900_mm};
inline constexpr float leg_length = 800_mm, leg_width = 130_mm;

inline mesh leg_1m() {
    struct kind {
        std::uint32_t count;
        float half_length[2], radius[2];
    };
    constexpr kind kinds[] = {{12, {150_mm, 240_mm}, {10_mm, 20_mm}}, // muscles and long bones
                              {14, {120_mm, 300_mm}, {2_mm, 4_mm}},   // vessels and nerves
                              {18, {30_mm, 70_mm}, {5_mm, 11_mm}},    // short muscles and tendons
                              {16, {6_mm, 16_mm}, {4_mm, 9_mm}}};     // bones of the foot
    mesh all;
    std::uint64_t piece = 0;
    for (const kind& of : kinds)
        for (std::uint32_t i = 0; i < of.count; ++i, ++piece) {
            const auto random = [&](std::uint64_t k) { return hash_uniform(7, 8 * piece + k); };
            spindle one;
            one.half_length = of.half_length[0] + (of.half_length[1] - of.half_length[0]) * random(0);
            one.radius = of.radius[0] + (of.radius[1] - of.radius[0]) * random(1);
            one.bend = 15_mm * (random(2) - 0.5F);
            const float turn = 2 * pi * random(3), from_axis = (0.5F * leg_width - one.radius) * std::sqrt(random(4));
            const float room = 0.5F * leg_length - one.half_length; // above and below
            const float along = of.half_length[1] < 20_mm ? 40_mm * random(5) - room : (2 * random(5) - 1) * room;
            one.centre = leg_centre + vec3{from_axis * std::cos(turn), from_axis * std::sin(turn), along};
            append(all, make_spindle(one, 1.05_mm));
        }
    return all;
}

} // namespace bench
#endif
