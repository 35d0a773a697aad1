#ifndef INSONIFY_IMAGE_COLOUR_IMAGE_HPP
#define INSONIFY_IMAGE_COLOUR_IMAGE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/math.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// A colour image: rows from the top; red, green and blue from 0 to 1, as displays take them.
struct colour_image {
    uvec2 size{0, 0};         ///< columns, rows
    std::vector<vec3> pixels; ///< row by row

    colour_image() = default;
    /// All pixels have one colour.
    explicit colour_image(uvec2 columns_rows, vec3 colour = {0, 0, 0})
        : size{columns_rows}, pixels(static_cast<std::size_t>(columns_rows.x) * columns_rows.y, colour) {}

    /// One pixel; indices are not checked.
    /// @{
    vec3& operator()(std::uint32_t column, std::uint32_t row) {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    const vec3& operator()(std::uint32_t column, std::uint32_t row) const {
        return pixels[static_cast<std::size_t>(row) * size.x + column];
    }
    /// @}

    friend bool operator==(const colour_image&, const colour_image&) = default;
};

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
