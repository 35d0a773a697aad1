#ifndef INSONIFY_IMAGE_CHECK_SIZE_HPP
#define INSONIFY_IMAGE_CHECK_SIZE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/text.hpp>
#include <cstdint>
#include <string>
#include <string_view>

namespace insonify::inline INSONIFY_ABI {

/// Largest number of columns, and of rows, of an image.
inline constexpr std::uint32_t max_picture_side = 16384;

namespace detail {

inline bool is_picture_size(uvec2 size) {
    return size.x > 0 && size.y > 0 && size.x <= max_picture_side && size.y <= max_picture_side;
}

/// @param caller  start of the sentence
/// @param advice  end of the sentence for an image that is too large
/// @throws usage_error  for an image without pixels, or with a side above `max_picture_side`
inline void check_size(uvec2 size, const char* caller, std::string_view advice = "ask for fewer") {
    if (is_picture_size(size)) return;
    const std::string columns = std::to_string(size.x), rows = std::to_string(size.y);
    if (size.x == 0 || size.y == 0)
        throw usage_error{joined({caller, ": size ", columns, "x", rows, " has no pixels; it must be at least 1x1"})};
    throw usage_error{joined({caller, ": size ", columns, "x", rows, " exceeds 16384 pixels a side; ", advice})};
}

} // namespace detail

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
