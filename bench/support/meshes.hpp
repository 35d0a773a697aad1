#ifndef INSONIFY_BENCH_SUPPORT_MESHES_HPP
#define INSONIFY_BENCH_SUPPORT_MESHES_HPP

#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <cmath>

/// The meshes that every figure is measured on; 100 mm across, around the origin.
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

/// 32 spheres one inside the other, 655,360 triangles: a line crosses 64 surfaces.
inline mesh shells() {
    mesh all;
    for (int shell = 1; shell <= 32; ++shell) {
        const mesh one = make_sphere({0, 0, 0}, 45_mm * static_cast<float>(shell) / 32, 5);
        const auto first = static_cast<std::uint32_t>(all.positions.size());
        all.positions.insert(all.positions.end(), one.positions.begin(), one.positions.end());
        for (const uvec3& face : one.faces) all.faces.push_back(face + first);
    }
    return all;
}

} // namespace bench
#endif
