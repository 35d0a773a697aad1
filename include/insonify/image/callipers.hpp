#ifndef INSONIFY_IMAGE_CALLIPERS_HPP
#define INSONIFY_IMAGE_CALLIPERS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/view.hpp>
#include <insonify/image/scan_convert.hpp>

namespace insonify::inline INSONIFY_ABI {

/// Distance between two points of a picture, metres.
/// @param from, to  pixel coordinates: see `scan_map`
inline float distance(const scan_map& map, vec2 from, vec2 to) { return length(map.pitch * (to - from)); }

/// What is measured of an outline.
struct outline_measure {
    float area = 0;          ///< square metres
    float circumference = 0; ///< metres
    vec2 centroid{0, 0};     ///< of the area, pixel coordinates
};

/// Measures a traced outline: a polygon, closed from its last point to its first.
///
///     area = |sum of x_i y_i+1 - x_i+1 y_i| / 2
///
/// @param outline  pixel coordinates, in either direction, without crossings; fewer than three enclose nothing, and the
///                 centroid is their mean
inline outline_measure measure_outline(const scan_map& map, view<const vec2> outline) {
    const std::size_t count = outline.size();
    if (count == 0) return {};
    double twice = 0, x = 0, y = 0, around = 0, mean_x = 0, mean_y = 0;
    const vec2 origin = outline[0]; // small products
    for (std::size_t i = 0; i < count; ++i) {
        const vec2 a = outline[i] - origin, b = outline[(i + 1) % count] - origin;
        const double cross = double{a.x} * double{b.y} - double{b.x} * double{a.y};
        twice += cross;
        x += cross * (double{a.x} + double{b.x});
        y += cross * (double{a.y} + double{b.y});
        around += double{length(map.pitch * (b - a))};
        mean_x += double{a.x};
        mean_y += double{a.y};
    }
    const bool flat = !(std::fabs(twice) > 0);
    const auto points = static_cast<double>(count);
    const vec2 inside{static_cast<float>(flat ? mean_x / points : x / (3 * twice)),
                      static_cast<float>(flat ? mean_y / points : y / (3 * twice))};
    return {.area = static_cast<float>(0.5 * std::fabs(twice) * double{map.pitch.x} * double{map.pitch.y}),
            .circumference = static_cast<float>(around),
            .centroid = origin + inside};
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
