#ifndef INSONIFY_IMAGE_LABEL_IMAGE_HPP
#define INSONIFY_IMAGE_LABEL_IMAGE_HPP

#include <insonify/image/scan_convert.hpp>

namespace insonify::inline INSONIFY_ABI {

/// A picture of labels: row by row from the top.
struct label_image {
    uvec2 size{0, 0};             ///< columns, rows
    std::vector<label_id> pixels; ///< row by row

    label_image() = default;
    /// All pixels of one label.
    INSONIFY_LAZY explicit label_image(uvec2 columns_rows, label_id label = background_label)
        : size{columns_rows}, pixels(static_cast<std::size_t>(columns_rows.x) * columns_rows.y, label) {}

    /// One pixel; neither index is checked.
    /// @{
    INSONIFY_LAZY label_id& operator()(std::uint32_t column, std::uint32_t row) {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    INSONIFY_LAZY const label_id& operator()(std::uint32_t column, std::uint32_t row) const {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    /// @}

    friend bool operator==(const label_image&, const label_image&) = default;
};

/// Gives each pixel in the field of view the value of the sample nearest to it, and leaves the others as they are.
/// @throws usage_error  where the lines are not those that the map was made for
template <exec::policy Policy, class Value>
void copy_nearest(const Policy& policy, const line_grid<Value>& lines, const scan_map& map,
                  std::vector<Value>& pixels) {
    if (lines.count != map.count || lines.samples != map.samples || lines.depth != map.depth ||
        lines.values.size() != static_cast<std::size_t>(map.count) * map.samples)
        throw usage_error{"scan_convert: lines, samples or depth differ from those that the map was made for; make one "
                          "anew with make_scan_map"};
    exec::for_each_block(policy, map.size.y, 1, 2 * static_cast<float>(map.size.x), [&](std::size_t y, std::size_t) {
        for (std::size_t i = y * map.size.x; i < (y + 1) * map.size.x; ++i) {
            if (map.first[i] == scan_map::outside) continue;
            const std::size_t line = map.across[i] > 0.5F ? map.beside(map.first[i]) : map.first[i];
            const std::size_t sample = map.along[i] > 0.5F ? 1 : 0;
            pixels[i] = lines.values[line + sample];
        }
    });
}

/// The labels of one frame as a picture: of the nearest sample, `background_label` outside the field of view.
///
///     const scan_map map = make_scan_map(exec::par, probe, {.depth = truth.depth, .samples = truth.samples});
///     label_image mask = scan_convert(exec::par, truth, map);
///
/// Pixel by pixel the same place as in the picture that `scan_convert` makes of lines with such a map. A thing thinner
/// than a pixel may fall between two: trace surfaces with about as many samples as the picture has rows.
/// @throws usage_error  where the labels are not those that the map was made for
template <exec::policy Policy>
label_image scan_convert(const Policy& policy, const label_lines& labels, const scan_map& map) {
    label_image picture{map.size};
    copy_nearest(policy, labels, map, picture.pixels);
    return picture;
}

/// The labels of one frame as a picture, for those who need only one: makes the map and forgets it.
/// @throws usage_error  where the labels are empty or not the probe's, or a setting makes no sense
template <exec::policy Policy, transducer Probe>
label_image scan_convert(const Policy& policy, const label_lines& labels, const Probe& probe,
                         const scan_convert_settings& settings = {}) {
    return scan_convert(policy, labels,
                        make_scan_map(policy, probe, {.depth = labels.depth, .samples = labels.samples}, settings));
}

/// Numbers that must not be mixed, such as angles of incidence, as a picture: those of the nearest sample.
/// @throws usage_error  where the lines are not those that the map was made for
template <exec::policy Policy>
image scan_convert_nearest(const Policy& policy, const scan_lines& lines, const scan_map& map) {
    image picture{map.size, map.background};
    copy_nearest(policy, lines, map, picture.pixels);
    return picture;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
