#ifndef INSONIFY_IO_PNG_HPP
#define INSONIFY_IO_PNG_HPP

#include <insonify/image/image.hpp>
#include <string>

namespace insonify::inline INSONIFY_ABI {

/// Writes a picture as PNG, 8 bits of grey: 0 and below is black, 1 and above white, NaN black, between them rounded.
///
/// Compiled where INSONIFY_IMPLEMENTATION is defined.
/// @throws usage_error  for a picture without pixels, with more than `most_pixels`, or with a number its size belies
/// @throws io_error     where the file cannot be written
void write_png(const std::string& path, const image& picture);

} // namespace insonify::inline INSONIFY_ABI
#endif
