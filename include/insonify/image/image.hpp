#ifndef INSONIFY_IMAGE_IMAGE_HPP
#define INSONIFY_IMAGE_IMAGE_HPP

#include <insonify/core/math.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// A grey picture: row by row from the top, 0 black to 1 white.
struct image {
    uvec2 size{0, 0};          ///< columns, rows
    std::vector<float> pixels; ///< row by row

    image() = default;
    /// All pixels of one grey.
    INSONIFY_LAZY explicit image(uvec2 columns_rows, float value = 0)
        : size{columns_rows}, pixels(static_cast<std::size_t>(columns_rows.x) * columns_rows.y, value) {}

    /// One pixel; neither index is checked.
    /// @{
    INSONIFY_LAZY float& operator()(std::uint32_t column, std::uint32_t row) {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    INSONIFY_LAZY const float& operator()(std::uint32_t column, std::uint32_t row) const {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    /// @}

    friend bool operator==(const image&, const image&) = default;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
