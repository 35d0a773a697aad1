#ifndef INSONIFY_IMAGE_IMAGE_HPP
#define INSONIFY_IMAGE_IMAGE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Pixels in rows from the top.
template <class Pixel>
struct pixel_grid {
    uvec2 size{0, 0};          ///< columns, rows
    std::vector<Pixel> pixels; ///< row by row

    /// No pixels.
    pixel_grid() = default;
    /// All pixels have one value.
    explicit pixel_grid(uvec2 columns_rows, Pixel value = {})
        : size{columns_rows}, pixels(static_cast<std::size_t>(columns_rows.x) * columns_rows.y, value) {}

    /// One pixel; indices are not checked.
    Pixel& operator()(std::uint32_t column, std::uint32_t row) {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    /// The same, to be read.
    const Pixel& operator()(std::uint32_t column, std::uint32_t row) const {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }

    friend bool operator==(const pixel_grid&, const pixel_grid&) = default;
};

using image = pixel_grid<float>;       ///< greyscale: 0 black to 1 white
using colour_image = pixel_grid<vec3>; ///< red, green and blue from 0 to 1, as displays take them

/// Largest number of columns, and of rows, of an image.
inline constexpr std::uint32_t max_picture_side = 16384;

namespace detail {

/// @param caller  start of the sentence
/// @param advice  end of the sentence for an image that is too large
/// @throws usage_error  for an image without pixels, or with a side above `max_picture_side`
inline void check_size(uvec2 size, const char* caller, std::string_view advice = "ask for fewer") {
    if (size.x > 0 && size.y > 0 && size.x <= max_picture_side && size.y <= max_picture_side) return;
    if (size.x == 0 || size.y == 0)
        throw usage_error{caller, ": size ", size.x, "x", size.y, " has no pixels; it must be at least 1x1"};
    throw usage_error{caller, ": size ", size.x, "x", size.y, " exceeds 16384 pixels a side; ", advice};
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
