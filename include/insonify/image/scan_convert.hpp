#ifndef INSONIFY_IMAGE_SCAN_CONVERT_HPP
#define INSONIFY_IMAGE_SCAN_CONVERT_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/memo.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/image/image.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/pulse.hpp>
#include <utility>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Size and background of the image.
///
/// If one side is chosen, pixels are square and the field of view fits. If both are given, a rectangular field of view
/// fills the image, whatever the shape of its pixels; any other, such as a sector, is fitted with square pixels.
struct scan_convert_settings {
    uvec2 size{0, 0};     ///< columns, rows; a 0 is chosen to fit the field of view; both 0: 512 columns
    float background = 0; ///< brightness of the pixels outside the field of view
};

/// Interpolation table of `scan_convert`: made once for a probe, a depth and an image size, valid for every frame.
///
/// Pixel coordinates start at the upper left corner of the image and increase to the right and down; the centre of the
/// first pixel is {0.5, 0.5}. Points are {x, z} in the slice plane, metres in the probe frame.
struct scan_map {
    static constexpr std::uint32_t outside = ~0U; ///< in `first`: the pixel is outside the field of view

    uvec2 size{0, 0};          ///< columns, rows
    vec2 centre{0, 0};         ///< the point at the centre of the image
    vec2 pitch{0, 0};          ///< width and height of a pixel, metres
    float background = 0;      ///< brightness of the pixels outside the field of view
    std::uint32_t count = 0;   ///< number of lines
    std::uint32_t samples = 0; ///< depth samples of each line
    float depth = 0;           ///< metres

    std::vector<std::uint32_t> first{}; ///< of each pixel: index of the upper left of its four samples, or `outside`
    std::vector<float> across{};        ///< of each pixel: weight of the next line
    std::vector<float> along{};         ///< of each pixel: weight of the next sample

    /// Index of the sample at the same depth on the next line; in a full circle the last line is next to the first.
    INSONIFY_FN std::uint32_t beside(std::uint32_t sample) const {
        const std::uint32_t last_line = (count - 1) * samples;
        return sample < last_line ? sample + samples : sample - last_line;
    }

    /// From pixel coordinates to {x, z} in the slice plane, metres.
    INSONIFY_FN vec2 point(vec2 pixel) const { return centre + pitch * (pixel - 0.5F * vec2{size}); }
    /// Centre of a pixel.
    INSONIFY_FN vec2 point(std::uint32_t column, std::uint32_t row) const {
        return point(vec2{uvec2{column, row}} + 0.5F);
    }
    /// From {x, z} in the slice plane, metres, to pixel coordinates.
    INSONIFY_FN vec2 pixel(vec2 point) const { return (point - centre) / pitch + 0.5F * vec2{size}; }
};

namespace detail {

/// Depth and samples of lines.
/// @throws usage_error  where there are no samples
template <class Value>
acquisition acquisition_of(const line_grid<Value>& lines) {
    if (lines.samples == 0) throw usage_error{"scan_convert: the lines have no samples; trace them first"};
    return {.depth = lines.depth, .samples = lines.samples};
}

/// @throws usage_error  for lines that do not match the map
template <class Value>
void check_lines_of_map(const line_grid<Value>& lines, const scan_map& map) {
    if (lines.count != map.count || lines.samples != map.samples || lines.depth != map.depth ||
        lines.values.size() != static_cast<std::size_t>(map.count) * map.samples)
        throw usage_error{
            "scan_convert: the number of lines, of samples or the depth differs from that of the map; make a "
            "new one with make_scan_map"};
}

/// Nearest-neighbour interpolation.
/// @param outside  value of the pixels outside the field of view
/// @throws usage_error  for lines that do not match the map
template <exec::policy Policy, class Value>
pixel_grid<Value> nearest_pixels(const Policy& policy, const line_grid<Value>& lines, const scan_map& map,
                                 Value outside, pixel_grid<Value> recycled) {
    check_lines_of_map(lines, map);
    recycled.size = map.size;
    recycled.pixels.assign(map.first.size(), outside);
    exec::for_each_in_blocks(policy, map.first.size(), 2048, 2, [&](std::size_t i) {
        if (map.first[i] == scan_map::outside) return;
        const std::size_t line = map.across[i] > 0.5F ? map.beside(map.first[i]) : map.first[i];
        const std::size_t sample = map.along[i] > 0.5F ? 1 : 0;
        recycled.pixels[i] = lines.values[line + sample];
    });
    return recycled;
}

/// See `make_scan_map`.
template <transducer Probe>
scan_map map_pixels(const any_policy<false>& policy, const Probe& probe, const acquisition& scan,
                    const scan_convert_settings& settings, scan_map recycled) {
    probe.check();
    check_depth(scan.depth, "scan_convert");
    const std::uint32_t samples =
        scan.samples != 0 ? scan.samples : samples_for(scan.depth, nominal_pulse(probe).sigma_z(probe.frequency));
    constexpr std::uint32_t max_count = 1U << 23U; // larger floats cannot represent half a sample
    if (probe.lines > max_count || samples > max_count || std::uint64_t{probe.lines} * samples >= scan_map::outside)
        throw usage_error{"scan_convert: at most 2^23 lines and 2^23 samples a line, and below 2^32 in all"};
    if (!is_finite(settings.background)) throw usage_error{"scan_convert: `background` must be finite"};

    const auto lines = static_cast<float>(probe.lines);
    vec2 lower{FLT_MAX, FLT_MAX};
    vec2 upper{-FLT_MAX, -FLT_MAX};
    constexpr int steps = 512; // even, to include the middle of a sector, its deepest point
    for (int i = 0; i <= steps; ++i) {
        const ray beam = probe.beam(lines * static_cast<float>(i) / steps - 0.5F);
        for (const vec3 end : {beam.origin, beam.at(scan.depth)}) {
            lower = {min(lower.x, end.x), min(lower.y, end.z)};
            upper = {max(upper.x, end.x), max(upper.y, end.z)};
        }
    }
    const vec2 extent = upper - lower;
    const vec2 middle = 0.5F * (lower + upper);
    const auto inside = [&](vec2 at) { // in lines and metres
        return at.x >= -0.5F && at.x <= lines - 0.5F && at.y >= 0 && at.y <= scan.depth;
    };
    bool is_rectangle = extent.x > 0;
    for (const vec2 corner : {vec2{-0.499F, -0.499F}, {0.499F, -0.499F}, {-0.499F, 0.499F}, {0.499F, 0.499F}})
        is_rectangle = is_rectangle && inside(probe.locate(middle + corner * extent));

    // A side that is chosen is rounded up, with a tolerance for rounding errors of the extent.
    const auto pixels_of = [](float length, float pitch) {
        const float pixels = std::ceil(length / pitch - 1e-3F);
        return pixels < 1 ? 1U : pixels < 4e9F ? static_cast<std::uint32_t>(pixels) : ~0U;
    };
    scan_map map = std::move(recycled);
    map.size = settings.size;
    map.centre = middle;
    map.background = settings.background;
    map.count = probe.lines;
    map.samples = samples;
    map.depth = scan.depth;
    if (map.size.x == 0 && map.size.y == 0) map.size.x = 512;
    map.pitch = {map.size.x == 0 ? 0 : extent.x / static_cast<float>(map.size.x),
                 map.size.y == 0 ? 0 : extent.y / static_cast<float>(map.size.y)};
    const float wider = max(map.pitch.x, map.pitch.y);
    if (!is_rectangle || map.size.x == 0 || map.size.y == 0) map.pitch = {wider, wider};
    if (!is_finite(wider) || !(wider > 0))
        throw usage_error{
            "scan_convert: the field of view has no width; give the number of rows and leave that of columns at 0"};
    if (map.size.x == 0) map.size.x = pixels_of(extent.x, wider);
    if (map.size.y == 0) map.size.y = pixels_of(extent.y, wider);
    if (map.size.x > max_picture_side || map.size.y > max_picture_side)
        check_size(map.size, "scan_convert",
                   scan.depth >= 1 ? joined({"depth is ", scan.depth, " m: did you mean ", scan.depth, "_mm?"})
                                   : joined({"the field of view is ", extent.x, " m wide and ", extent.y,
                                             " m high; ask for fewer"}));

    const std::size_t pixels = static_cast<std::size_t>(map.size.x) * map.size.y;
    map.first.resize(pixels);
    map.across.resize(pixels);
    map.along.resize(pixels);
    const bool full_circle = is_full_circle(probe);
    const float last_line = max(lines - 2, 0);
    const float last_sample = max(static_cast<float>(map.samples) - 2, 0);
    exec::for_each_block(policy, map.size.y, 1, 20 * static_cast<float>(map.size.x), [&](std::size_t row, std::size_t) {
        const auto y = static_cast<std::uint32_t>(row);
        for (std::uint32_t x = 0; x < map.size.x; ++x) {
            const vec2 at = probe.locate(map.point(x, y));
            const std::size_t i = row * map.size.x + x;
            if (!inside(at)) {
                map.first[i] = scan_map::outside;
                map.across[i] = map.along[i] = 0;
                continue;
            }
            const float sample = at.y / map.depth * static_cast<float>(map.samples) - 0.5F;
            const float line_below = full_circle ? std::floor(at.x) : clamp(std::floor(at.x), 0, last_line);
            const float sample_below = clamp(std::floor(sample), 0, last_sample);
            const float line = line_below < 0 ? lines - 1 : line_below;
            map.first[i] = static_cast<std::uint32_t>(line) * map.samples + static_cast<std::uint32_t>(sample_below);
            map.across[i] = clamp(at.x - line_below, 0, 1);
            map.along[i] = clamp(sample - sample_below, 0, 1);
        }
    });
    return map;
}

} // namespace detail

/// Makes the interpolation table of `scan_convert`.
///
/// The field of view extends half a line beyond the first and the last line, and from depth 0 to `depth`.
/// @param scan  depth and samples of the lines to come; 0 samples: as many as `b_mode` chooses for the pulse of the
///              probe
/// @param recycled  a map whose memory is reused
/// @throws usage_error  for a probe, depth, number of samples or picture size out of range
template <exec::policy Policy, transducer Probe>
scan_map make_scan_map(const Policy& policy, const Probe& probe, const acquisition& scan,
                       const scan_convert_settings& settings = {}, scan_map recycled = {}) {
    return detail::map_pixels(detail::any_policy<false>{policy}, probe, scan, settings, std::move(recycled));
}

/// A map that is kept from frame to frame, and made again where the probe, the lines or the settings have changed, or
/// where probes cannot be compared.
template <transducer Probe>
class kept_scan_map {
  public:
    /// @throws usage_error  as `make_scan_map`
    template <exec::policy Policy>
    const scan_map& operator()(const Policy& policy, const Probe& probe, const acquisition& scan,
                               const scan_convert_settings& settings) {
        return map_([&](scan_map& map) { map = make_scan_map(policy, probe, scan, settings, std::exchange(map, {})); },
                    probe, scan.depth, scan.samples, settings.size.x, settings.size.y, settings.background);
    }
    /// The map that was returned last.
    const scan_map& value() const { return map_.value(); }

  private:
    detail::memo<scan_map, Probe, float, std::uint32_t, std::uint32_t, std::uint32_t, float> map_{};
};

/// Scan conversion of one frame: bilinear interpolation between lines and samples.
///
/// @param recycled  an image whose memory is reused
/// @throws usage_error  for lines that do not match the map
template <exec::policy Policy>
image scan_convert(const Policy& policy, const scan_lines& lines, const scan_map& map, image recycled = {}) {
    detail::check_lines_of_map(lines, map);
    const std::size_t next_sample = map.samples > 1 ? 1 : 0;
    recycled.size = map.size;
    recycled.pixels.resize(map.first.size());
    exec::for_each_block(policy, map.size.y, 1, 3 * static_cast<float>(map.size.x), [&](std::size_t y, std::size_t) {
        const float* values = lines.values.data();
        for (std::size_t i = y * map.size.x; i < (y + 1) * map.size.x; ++i) {
            if (map.first[i] == scan_map::outside) {
                recycled.pixels[i] = map.background;
                continue;
            }
            const auto between = [along = map.along[i], next_sample](const float* sample) {
                return multiply_add(along, sample[next_sample] - sample[0], sample[0]);
            };
            const float here = between(values + map.first[i]);
            recycled.pixels[i] = multiply_add(map.across[i], between(values + map.beside(map.first[i])) - here, here);
        }
    });
    return recycled;
}

using label_image = pixel_grid<label_id>; ///< the object at each pixel

/// Scan-converts labels: each pixel has the label of the nearest sample, or `background_label` outside the field.
///
/// Pixels correspond to those of the image that `scan_convert` makes of lines with the same map. Structures thinner
/// than a pixel may be missed: trace with about as many samples as the image has rows.
/// @param recycled  an image whose memory is reused
/// @throws usage_error  for labels that do not match the map
template <exec::policy Policy>
label_image scan_convert(const Policy& policy, const label_lines& labels, const scan_map& map,
                         label_image recycled = {}) {
    return detail::nearest_pixels(policy, labels, map, background_label, std::move(recycled));
}

/// The same for a single frame of brightness or labels, with a temporary map.
/// @throws usage_error  for lines that are empty or not those of the probe, or a setting out of range
template <exec::policy Policy, class Value, transducer Probe>
auto scan_convert(const Policy& policy, const line_grid<Value>& lines, const Probe& probe,
                  const scan_convert_settings& settings = {}) {
    return scan_convert(policy, lines, make_scan_map(policy, probe, detail::acquisition_of(lines), settings));
}

/// Scan-converts values that must not be interpolated, such as angles: each pixel has that of the nearest sample.
/// @throws usage_error  for lines that do not match the map
template <exec::policy Policy>
image scan_convert_nearest(const Policy& policy, const scan_lines& lines, const scan_map& map) {
    return detail::nearest_pixels(policy, lines, map, map.background, image{});
}

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
