#ifndef INSONIFY_GEOMETRY_NEEDLE_HPP
#define INSONIFY_GEOMETRY_NEEDLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/units.hpp>
#include <insonify/geometry/shapes.hpp>
#include <cmath>
#include <cstdint>

namespace insonify::inline INSONIFY_ABI {

/// Outer diameter of a needle of a gauge from 14 (2.11 mm) to 30 (0.31 mm), metres.
///
/// Source: the nominal sizes of the Birmingham gauge.
/// @throws geometry_error  for another gauge
inline float needle_diameter(std::uint32_t gauge) {
    constexpr std::uint32_t thickest = 14, thinnest = 30;
    constexpr float diameters[] = {2.108_mm, 1.829_mm, 1.651_mm, 1.473_mm, 1.270_mm, 1.067_mm,
                                   0.908_mm, 0.819_mm, 0.718_mm, 0.641_mm, 0.566_mm, 0.514_mm,
                                   0.464_mm, 0.413_mm, 0.362_mm, 0.337_mm, 0.312_mm};
    if (gauge < thickest || gauge > thinnest)
        throw geometry_error{"needle_diameter: gauge ", gauge,
                             " is not in the table; give one from 14 to 30, or the diameter itself to make_needle"};
    return diameters[gauge - thickest];
}

/// Optional arguments of `make_needle`.
struct needle_settings {
    float bevel = 15_deg;             ///< angle between the bevel and the axis, 5 to 90 degrees, radians
    std::uint32_t segments = 48;      ///< around the axis, 3 to 4096
    std::uint32_t segments_along = 1; ///< along the shaft, 1 to 4096: more for a needle that bends
};

/// A solid needle along the z axis that points to +z. Its tip is at (-diameter / 2, 0, 0), its other end at -length,
/// and its bevel faces +x.
///
///     const mesh needle = make_needle(needle_diameter(22), 80_mm);
///     body.add(needle, tissue::steel, {.priority = 2, .at = look_at(tip, beyond, {0, 1, 0}), .crease_angle = 12_deg});
///
/// The bevel is plane. Its edge is sharp only where the object's `crease_angle` is smaller than the bevel's angle.
/// @param diameter  outer, metres
/// @param length    from the tip to the other end, metres, more than the bevel's
/// @throws geometry_error  for a size out of range
inline mesh make_needle(float diameter, float length, const needle_settings& settings = {}) {
    detail::check_shape_length("make_needle", "diameter", diameter);
    detail::check_shape_length("make_needle", "length", length);
    if (!(settings.bevel >= 5_deg) || !(settings.bevel <= 90_deg))
        throw geometry_error{"make_needle: `bevel` is ", settings.bevel, " radians; it must be from 5_deg to 90_deg"};
    if (settings.segments < 3 || settings.segments > 4096 || settings.segments_along < 1 ||
        settings.segments_along > 4096)
        throw geometry_error{"make_needle: `segments` is ", settings.segments, ", `segments_along` ",
                             settings.segments_along, "; they must be from 3 to 4096 and from 1 to 4096"};
    const float radius = diameter / 2, per_width = 1 / std::tan(settings.bevel);
    if (!(length > 1.01F * diameter * per_width))
        throw geometry_error{"make_needle: `length` is ", length, " m, but the bevel alone is ", diameter * per_width,
                             " m long; give a longer needle or a steeper bevel"};
    const auto bevel_at = [&](float x) { return -(x + radius) * per_width; };

    // Both ends have a middle and, just within the rim, a ring that keeps normals interpolated over the rim near it.
    mesh needle;
    const std::uint32_t n = settings.segments;
    needle.positions = {{0, 0, -length}, {0, 0, bevel_at(0)}};
    for (std::uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / n; // from the tip on
        const float x = -radius * static_cast<float>(std::cos(angle)),
                    y = -radius * static_cast<float>(std::sin(angle));
        constexpr float within = 0.95F;
        needle.positions.push_back({within * x, within * y, -length});
        for (std::uint32_t ring = 0; ring <= settings.segments_along; ++ring) {
            const float part = static_cast<float>(ring) / static_cast<float>(settings.segments_along);
            needle.positions.push_back({x, y, (1 - part) * -length + part * bevel_at(x)});
        }
        needle.positions.push_back({within * x, within * y, bevel_at(within * x)});
    }
    detail::add_tube_faces(needle, n, settings.segments_along + 3);
    return detail::checked_shape("make_needle", std::move(needle));
}

/// Where a needle of `make_needle` is.
///
///     body.place(needle, needle_pose(tip, target - tip, {0, 0, -1})); // the bevel up, towards a probe above
///
/// @param tip        of its axis, in the world, metres: the sharp point lies half a diameter beside it
/// @param direction  in which it points, of any length above 0
/// @param bevel      to which its bevel faces, as far as it is across the needle
/// @throws geometry_error  where `bevel` is parallel to `direction`, or one of them is 0
inline pose needle_pose(vec3 tip, vec3 direction, vec3 bevel) {
    const float size = length(direction);
    if (!is_finite(tip) || !is_finite(direction) || !is_finite(bevel) ||
        !(length(cross(direction, bevel)) > 1e-4F * size * length(bevel)))
        throw geometry_error{
            "needle_pose: `direction` and `bevel` must be directions other than 0 that are not parallel, "
            "and `tip` finite"};
    return look_at(tip, tip + direction / size, bevel);
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
