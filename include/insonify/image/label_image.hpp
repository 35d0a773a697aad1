#ifndef INSONIFY_IMAGE_LABEL_IMAGE_HPP
#define INSONIFY_IMAGE_LABEL_IMAGE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/image/scan_convert.hpp>

namespace insonify::inline INSONIFY_ABI {

/// An image of labels: rows from the top.
struct label_image {
    uvec2 size{0, 0};             ///< columns, rows
    std::vector<label_id> pixels; ///< row by row

    label_image() = default;
    /// All pixels have one label.
    explicit label_image(uvec2 columns_rows, label_id label = background_label)
        : size{columns_rows}, pixels(static_cast<std::size_t>(columns_rows.x) * columns_rows.y, label) {}

    /// One pixel; indices are not checked.
    /// @{
    label_id& operator()(std::uint32_t column, std::uint32_t row) {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    const label_id& operator()(std::uint32_t column, std::uint32_t row) const {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    /// @}

    friend bool operator==(const label_image&, const label_image&) = default;
};

namespace detail {

/// Nearest-neighbour interpolation of each pixel in the field of view; other pixels are unchanged.
/// @throws usage_error  for lines that do not match the map
template <exec::policy Policy, class Value>
void copy_nearest(const Policy& policy, const line_grid<Value>& lines, const scan_map& map,
                  std::vector<Value>& pixels) {
    check_lines_of_map(lines, map);
    exec::for_each_block(policy, map.size.y, 1, 2 * static_cast<float>(map.size.x), [&](std::size_t y, std::size_t) {
        for (std::size_t i = y * map.size.x; i < (y + 1) * map.size.x; ++i) {
            if (map.first[i] == scan_map::outside) continue;
            const std::size_t line = map.across[i] > 0.5F ? map.beside(map.first[i]) : map.first[i];
            const std::size_t sample = map.along[i] > 0.5F ? 1 : 0;
            pixels[i] = lines.values[line + sample];
        }
    });
}

} // namespace detail

/// Scan-converts labels: each pixel has the label of the nearest sample, or `background_label` outside the field of
/// view.
///
///     const scan_map map = make_scan_map(exec::par, probe, {.depth = truth.depth, .samples = truth.samples});
///     label_image mask = scan_convert(exec::par, truth, map);
///
/// Pixels correspond to those of the image that `scan_convert` makes of lines with the same map. Structures thinner
/// than a pixel may be missed: trace with about as many samples as the image has rows.
/// @param recycled  an image whose memory is reused
/// @throws usage_error  for labels that do not match the map
template <exec::policy Policy>
label_image scan_convert(const Policy& policy, const label_lines& labels, const scan_map& map,
                         label_image recycled = {}) {
    recycled.size = map.size;
    recycled.pixels.assign(map.first.size(), background_label);
    detail::copy_nearest(policy, labels, map, recycled.pixels);
    return recycled;
}

/// The same for a single frame, with a temporary map.
/// @throws usage_error  for labels that are empty or not those of the probe, or a setting out of range
template <exec::policy Policy, transducer Probe>
label_image scan_convert(const Policy& policy, const label_lines& labels, const Probe& probe,
                         const scan_convert_settings& settings = {}) {
    return scan_convert(policy, labels, make_scan_map(policy, probe, detail::acquisition_of(labels), settings));
}

/// Scan-converts values that must not be interpolated, such as angles of incidence: each pixel has that of the nearest
/// sample.
/// @throws usage_error  for lines that do not match the map
template <exec::policy Policy>
image scan_convert_nearest(const Policy& policy, const scan_lines& lines, const scan_map& map) {
    image picture{map.size, map.background};
    detail::copy_nearest(policy, lines, map, picture.pixels);
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
