#ifndef INSONIFY_BENCH_SUPPORT_RAYS_HPP
#define INSONIFY_BENCH_SUPPORT_RAYS_HPP

#include <insonify/core/random.hpp>
#include <insonify/core/units.hpp>
#include <insonify/geometry/pose.hpp>
#include <insonify/geometry/ray.hpp>
#include "meshes.hpp"
#include <cmath>
#include <vector>

/// The rays that every figure is measured with, for meshes 100 mm across around the origin.
namespace bench {

using namespace insonify;

inline vec3 random_direction(std::uint64_t seed, std::uint64_t i) {
    const float z = 2 * hash_uniform(seed, 2 * i) - 1, turn = 2 * pi * hash_uniform(seed, 2 * i + 1);
    const float r = std::sqrt(max(0.0F, 1 - z * z));
    return {r * std::cos(turn), r * std::sin(turn), z};
}

/// Where the probe stands in one of its sweeps: 10 mm outside, aimed through the middle, each time from another side.
inline pose probe_pose(std::uint64_t fan) {
    const vec3 out = random_direction(2, fan), across = normalize(cross(out, random_direction(3, fan)));
    return {mat3{across, cross(-out, across), -out}, 60_mm * out};
}

/// Appends the lines of a convex probe, 60 mm of radius and 70 degrees, line after line.
inline void add_fan(std::vector<ray>& rays, const pose& at, std::uint32_t lines) {
    for (std::uint32_t i = 0; i < lines; ++i) {
        const float turn = 70_deg * ((static_cast<float>(i) + 0.5F) / static_cast<float>(lines) - 0.5F);
        const vec3 along{std::sin(turn), 0, std::cos(turn)};
        rays.push_back({.origin = at.point(60_mm * along - vec3{0, 0, 60_mm}), .direction = at.direction(along)});
    }
}

/// `fans` slices of `lines` lines, each through the middle from another side.
inline std::vector<ray> fan_rays(std::uint32_t fans = 64, std::uint32_t lines = 512) {
    std::vector<ray> rays;
    for (std::uint32_t fan = 0; fan < fans; ++fan) add_fan(rays, probe_pose(fan), lines);
    return rays;
}

/// What a camera 200 mm away sees, row after row.
inline std::vector<ray> camera_rays(std::uint32_t width = 512, std::uint32_t height = 512) {
    std::vector<ray> rays;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            const vec3 towards{(static_cast<float>(x) + 0.5F) / static_cast<float>(width) - 0.5F,
                               (static_cast<float>(y) + 0.5F) / static_cast<float>(height) - 0.5F, 2};
            rays.push_back({.origin = {20_mm, 10_mm, -200_mm}, .direction = normalize(towards)});
        }
    return rays;
}

/// A picture of the whole leg from 1.6 m away, row after row: three rays in four miss its box.
inline std::vector<ray> leg_camera_rays(std::uint32_t width = 320, std::uint32_t height = 512) {
    const vec3 eye = leg_centre + vec3{-1500_mm, 500_mm, 200_mm}, ahead = normalize(leg_centre - eye);
    const vec3 across = normalize(cross(ahead, vec3{0, 0, 1})), up = cross(across, ahead);
    const float pixel = 0.56F / static_cast<float>(height);
    std::vector<ray> rays;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            const float to_right = pixel * (static_cast<float>(x) + 0.5F - 0.5F * static_cast<float>(width));
            const float upwards = pixel * (0.5F * static_cast<float>(height) - 0.5F - static_cast<float>(y));
            rays.push_back({.origin = eye, .direction = normalize(ahead + to_right * across + upwards * up)});
        }
    return rays;
}

/// Fans from around the leg: the lines start outside, cross it, and leave it again. The slices lie across the leg, along it
/// or between.
inline std::vector<ray> leg_fan_rays(std::uint32_t fans = 64, std::uint32_t lines = 512) {
    std::vector<ray> rays;
    for (std::uint32_t fan = 0; fan < fans; ++fan) {
        const float around = 2 * pi * hash_uniform(8, 3 * std::uint64_t{fan});
        const float along_leg = 0.9F * leg_length * (hash_uniform(8, 3 * std::uint64_t{fan} + 1) - 0.5F);
        const float roll = pi * hash_uniform(8, 3 * std::uint64_t{fan} + 2);
        const vec3 out{std::cos(around), std::sin(around), 0}, side{-out.y, out.x, 0};
        const vec3 across = std::cos(roll) * side + std::sin(roll) * vec3{0, 0, 1};
        const vec3 skin = leg_centre + vec3{0, 0, along_leg} + (0.5F * leg_width + 10_mm) * out;
        add_fan(rays, {mat3{across, cross(-out, across), -out}, skin}, lines);
    }
    return rays;
}

/// From anywhere inside, anywhere: no two rays have anything in common.
inline std::vector<ray> incoherent_rays(std::uint32_t count = 65'536) {
    std::vector<ray> rays;
    for (std::uint32_t i = 0; i < count; ++i) {
        const vec3 place{hash_uniform(5, 3 * std::uint64_t{i}), hash_uniform(5, 3 * std::uint64_t{i} + 1),
                         hash_uniform(5, 3 * std::uint64_t{i} + 2)};
        rays.push_back({.origin = 100_mm * (place - vec3{0.5F}), .direction = random_direction(6, i)});
    }
    return rays;
}

} // namespace bench
#endif
