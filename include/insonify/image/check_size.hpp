#ifndef INSONIFY_IMAGE_CHECK_SIZE_HPP
#define INSONIFY_IMAGE_CHECK_SIZE_HPP

#include <insonify/core/error.hpp>
#include <insonify/core/math.hpp>
#include <cstddef>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// A picture larger than this is taken for a mistake.
inline constexpr std::size_t most_pixels = std::size_t{1} << 28U;

/// @throws usage_error  where a picture has no pixels, or more than `most_pixels`
INSONIFY_LAZY void check_size(uvec2 size) {
    const std::size_t pixels = static_cast<std::size_t>(size.x) * size.y;
    if (pixels == 0 || pixels > most_pixels)
        throw usage_error{"a picture of " + std::to_string(size.x) + " x " + std::to_string(size.y) +
                          " pixels was asked for; it must have at least 1 and at most 2^28 pixels"};
}

} // namespace insonify::inline INSONIFY_ABI
#endif
