#ifndef INSONIFY_IO_PNG_HPP
#define INSONIFY_IO_PNG_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/image/image.hpp>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// Writes an 8-bit greyscale PNG file. Values are clamped to 0 (black) to 1 (white) and rounded; NaN is black.
///
/// Defined where INSONIFY_IMPLEMENTATION is defined.
/// @throws usage_error  for an image without pixels, with a side above `max_picture_side`, or with a number of pixels
///                      other than its size
/// @throws io_error     for a file that cannot be written
void write_png(const std::string& path, const image& picture);
/// Likewise an 8-bit RGB PNG file.
void write_png(const std::string& path, const colour_image& picture);

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
