#ifndef INSONIFY_IMAGE_IMAGE_HPP
#define INSONIFY_IMAGE_IMAGE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// A greyscale image: rows from the top, 0 black to 1 white.
struct image {
    uvec2 size{0, 0};          ///< columns, rows
    std::vector<float> pixels; ///< row by row

    image() = default;
    /// All pixels have one value.
    explicit image(uvec2 columns_rows, float value = 0)
        : size{columns_rows}, pixels(static_cast<std::size_t>(columns_rows.x) * columns_rows.y, value) {}

    /// One pixel; indices are not checked.
    /// @{
    float& operator()(std::uint32_t column, std::uint32_t row) {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    const float& operator()(std::uint32_t column, std::uint32_t row) const {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    /// @}

    friend bool operator==(const image&, const image&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
