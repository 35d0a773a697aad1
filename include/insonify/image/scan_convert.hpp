#ifndef INSONIFY_IMAGE_SCAN_CONVERT_HPP
#define INSONIFY_IMAGE_SCAN_CONVERT_HPP

#include <insonify/execution/for_each.hpp>
#include <insonify/image/check_size.hpp>
#include <insonify/image/image.hpp>
#include <insonify/probe/acquisition.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/transducer.hpp>
#include <cfloat>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Pixels are square; the field of view is fitted into the picture and centred.
struct scan_convert_settings {
    uvec2 size{0, 0};     ///< columns, rows; a 0 is chosen so that the field fills the picture; both 0: 512 columns
    float background = 0; ///< grey of the pixels outside the field of view
};

/// Which samples make a pixel: made once for a probe, a depth and a picture size, good for every frame.
///
/// Pixel coordinates run from the upper left corner of the picture, right and down; the centre of the first pixel is
/// {0.5, 0.5}. Points are {x, z} in the slice plane, metres in the probe's frame.
struct scan_map {
    static constexpr std::uint32_t outside = ~0U; ///< in `first`: the pixel is not in the field of view

    uvec2 size{0, 0};          ///< columns, rows
    vec2 centre{0, 0};         ///< the point in the middle of the picture
    float pitch = 0;           ///< edge of a pixel, metres
    float background = 0;      ///< grey of the pixels outside the field of view
    std::uint32_t count = 0;   ///< lines
    std::uint32_t samples = 0; ///< along each line
    float depth = 0;           ///< metres

    std::vector<std::uint32_t> first{}; ///< a pixel: index of the upper left one of its four samples, or `outside`
    std::vector<float> across{};        ///< a pixel: share of the next line
    std::vector<float> along{};         ///< a pixel: share of the next sample

    /// The index of the sample at the same depth on the next line; that of a full circle's last line is its first.
    INSONIFY_FN std::uint32_t beside(std::uint32_t sample) const {
        const std::uint32_t last_line = (count - 1) * samples;
        return sample < last_line ? sample + samples : sample - last_line;
    }

    /// From pixel coordinates to {x, z} in the slice plane, metres.
    INSONIFY_FN vec2 point(vec2 pixel) const {
        return centre + pitch * (pixel - 0.5F * vec2{static_cast<float>(size.x), static_cast<float>(size.y)});
    }
    /// The centre of a pixel.
    INSONIFY_FN vec2 point(std::uint32_t column, std::uint32_t row) const {
        return point({static_cast<float>(column) + 0.5F, static_cast<float>(row) + 0.5F});
    }
    /// From {x, z} in the slice plane, metres, to pixel coordinates.
    INSONIFY_FN vec2 pixel(vec2 point) const {
        return (point - centre) / pitch + 0.5F * vec2{static_cast<float>(size.x), static_cast<float>(size.y)};
    }
};

/// Makes the tables of `scan_convert`.
///
/// The field of view reaches half a line beyond the centres of the first and the last line, and from depth 0 to
/// `depth`. Where it is a full circle, the first line follows upon the last.
/// @param scan  depth and samples of the lines to come; `samples` must be stated
/// @throws usage_error  where the probe, the acquisition or the picture size makes no sense
template <exec::policy Policy, transducer Probe>
scan_map make_scan_map(const Policy& policy, const Probe& probe, const acquisition& scan,
                       const scan_convert_settings& settings = {}) {
    probe.check();
    if (!is_depth(scan.depth) || scan.samples == 0)
        throw usage_error{"scan_convert: the lines need a depth from 1 nm to 1000 km and at least one sample"};
    constexpr std::uint32_t most = 1U << 23U; // floats count halves no further
    if (probe.lines > most || scan.samples > most || std::uint64_t{probe.lines} * scan.samples >= scan_map::outside)
        throw usage_error{"scan_convert: at most 2^23 lines and 2^23 samples a line, and below 2^32 in all"};
    if (!is_finite(settings.background)) throw usage_error{"scan_convert: `background` must be a finite grey"};

    const auto lines = static_cast<float>(probe.lines);
    vec2 lower{FLT_MAX, FLT_MAX};
    vec2 upper{-FLT_MAX, -FLT_MAX};
    constexpr int steps = 512; // even, so that the middle of a sector, its deepest point, is one of them
    for (int i = 0; i <= steps; ++i) {
        const ray beam = probe.beam(lines * static_cast<float>(i) / steps - 0.5F);
        for (const vec3 end : {beam.origin, beam.at(scan.depth)}) {
            lower = {lesser(lower.x, end.x), lesser(lower.y, end.z)};
            upper = {greater(upper.x, end.x), greater(upper.y, end.z)};
        }
    }
    const vec2 extent = upper - lower;

    // A dimension not asked for is rounded up, but for the rounding errors of the extent.
    const auto pixels_of = [](float length, float pitch) {
        const float pixels = std::ceil(length / pitch - 1e-3F);
        return pixels < 1 ? 1U : pixels < 4e9F ? static_cast<std::uint32_t>(pixels) : ~0U;
    };
    scan_map map{.size = settings.size,
                 .centre = 0.5F * (lower + upper),
                 .background = settings.background,
                 .count = probe.lines,
                 .samples = scan.samples,
                 .depth = scan.depth};
    if (map.size.x == 0 && map.size.y == 0) map.size.x = 512;
    const float pitch_across = map.size.x == 0 ? 0 : extent.x / static_cast<float>(map.size.x);
    const float pitch_down = map.size.y == 0 ? 0 : extent.y / static_cast<float>(map.size.y);
    map.pitch = greater(pitch_across, pitch_down);
    if (!is_finite(map.pitch) || !(map.pitch > 0))
        throw usage_error{"scan_convert: the field of view has no width; ask for a number of rows, not of columns"};
    if (map.size.x == 0) map.size.x = pixels_of(extent.x, map.pitch);
    if (map.size.y == 0) map.size.y = pixels_of(extent.y, map.pitch);
    check_size(map.size);

    const std::size_t pixels = static_cast<std::size_t>(map.size.x) * map.size.y;
    map.first.assign(pixels, scan_map::outside);
    map.across.assign(pixels, 0.0F);
    map.along.assign(pixels, 0.0F);
    const bool full_circle = is_full_circle(probe);
    const float last_line = greater(lines - 2, 0);
    const float last_sample = greater(static_cast<float>(map.samples) - 2, 0);
    exec::for_each_block(policy, map.size.y, 1, 20 * static_cast<float>(map.size.x), [&](std::size_t row, std::size_t) {
        const auto y = static_cast<std::uint32_t>(row);
        for (std::uint32_t x = 0; x < map.size.x; ++x) {
            const vec2 at = probe.locate(map.point(x, y));
            if (!(at.x >= -0.5F && at.x <= lines - 0.5F && at.y >= 0 && at.y <= map.depth)) continue;
            const float sample = at.y / map.depth * static_cast<float>(map.samples) - 0.5F;
            const float line_below = full_circle ? std::floor(at.x) : clamped(std::floor(at.x), 0, last_line);
            const float sample_below = clamped(std::floor(sample), 0, last_sample);
            const std::size_t i = row * map.size.x + x;
            const float line = line_below < 0 ? lines - 1 : line_below;
            map.first[i] = static_cast<std::uint32_t>(line) * map.samples + static_cast<std::uint32_t>(sample_below);
            map.across[i] = clamped(at.x - line_below, 0, 1);
            map.along[i] = clamped(sample - sample_below, 0, 1);
        }
    });
    return map;
}

/// The map of the frame before, made anew where the probe, the lines or the settings have changed, or where probes cannot
/// be compared.
template <transducer Probe>
class kept_scan_map {
  public:
    /// @throws usage_error  as `make_scan_map`
    template <exec::policy Policy>
    const scan_map& operator()(const Policy& policy, const Probe& probe, const acquisition& scan,
                               const scan_convert_settings& settings) {
        if constexpr (std::equality_comparable<Probe>) {
            if (made_for_ && made_for_->probe == probe && made_for_->settings.size == settings.size &&
                made_for_->settings.background == settings.background && map_.depth == scan.depth &&
                map_.samples == scan.samples)
                return map_;
        }
        map_ = make_scan_map(policy, probe, scan, settings);
        made_for_.emplace(cause{probe, settings});
        return map_;
    }

  private:
    struct cause {
        Probe probe;
        scan_convert_settings settings;
    };
    std::optional<cause> made_for_{};
    scan_map map_{};
};

/// The picture of one frame: bilinear between lines and between samples, on the values as they are.
///
/// Allocates nothing but the picture.
/// @param recycled  a picture whose memory is used again
/// @throws usage_error  where the lines are not those that the map was made for
template <exec::policy Policy>
image scan_convert(const Policy& policy, const scan_lines& lines, const scan_map& map, image recycled = {}) {
    if (lines.count != map.count || lines.samples != map.samples || lines.depth != map.depth ||
        lines.values.size() != static_cast<std::size_t>(map.count) * map.samples)
        throw usage_error{"scan_convert: lines, samples or depth differ from those that the map was made for; make one "
                          "anew with make_scan_map"};
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

/// The picture of one frame, for those who draw only one: makes the map and forgets it.
/// @throws usage_error  where the lines are empty or not the probe's, or a setting makes no sense
template <exec::policy Policy, transducer Probe>
image scan_convert(const Policy& policy, const scan_lines& lines, const Probe& probe,
                   const scan_convert_settings& settings = {}) {
    return scan_convert(policy, lines,
                        make_scan_map(policy, probe, {.depth = lines.depth, .samples = lines.samples}, settings));
}

} // namespace insonify::inline INSONIFY_ABI
#endif
