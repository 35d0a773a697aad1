#ifndef INSONIFY_IO_IMPLEMENTATION_PACKAGES_HPP
#define INSONIFY_IO_IMPLEMENTATION_PACKAGES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cassert>
// NOLINTBEGIN(modernize-deprecated-headers): stb_image_write includes these names.
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
// NOLINTEND(modernize-deprecated-headers)

// Private copies of tinyobjloader, in a renamed namespace, and of stb_image_write, static functions in a namespace.
// Every macro that configures them or that they define is saved and restored, so that a program can include its own
// copies in this file, before or after, and in others. The C headers that stb_image_write needs are included above,
// outside its namespace. The rest of this file counts as a header of the system: compilers do not warn of the packages.
#if !defined(_MSC_VER)
#pragma GCC system_header
#endif
#pragma push_macro("tinyobj")
#pragma push_macro("TINY_OBJ_LOADER_H_")
#pragma push_macro("TINYOBJLOADER_IMPLEMENTATION")
#pragma push_macro("TINYOBJLOADER_USE_DOUBLE")
#pragma push_macro("TINYOBJLOADER_USE_MAPBOX_EARCUT")
#pragma push_macro("TINYOBJ_OVERRIDE")
#pragma push_macro("IS_SPACE")
#pragma push_macro("IS_DIGIT")
#pragma push_macro("IS_NEW_LINE")
#pragma push_macro("INCLUDE_STB_IMAGE_WRITE_H")
#pragma push_macro("STB_IMAGE_WRITE_IMPLEMENTATION")
#pragma push_macro("STB_IMAGE_WRITE_STATIC")
#pragma push_macro("STBI_WRITE_NO_STDIO")
#pragma push_macro("STBIWDEF")
#pragma push_macro("STBIW_MALLOC")
#pragma push_macro("STBIW_REALLOC")
#pragma push_macro("STBIW_REALLOC_SIZED")
#pragma push_macro("STBIW_FREE")
#pragma push_macro("STBIW_MEMMOVE")
#pragma push_macro("STBIW_ASSERT")
#pragma push_macro("STBIW_CRC32")
#pragma push_macro("STBIW_ZLIB_COMPRESS")
#undef tinyobj
#undef TINY_OBJ_LOADER_H_
#undef TINYOBJLOADER_IMPLEMENTATION
#undef TINYOBJLOADER_USE_DOUBLE
#undef TINYOBJLOADER_USE_MAPBOX_EARCUT
#undef TINYOBJ_OVERRIDE
#undef IS_SPACE
#undef IS_DIGIT
#undef IS_NEW_LINE
#undef INCLUDE_STB_IMAGE_WRITE_H
#undef STB_IMAGE_WRITE_IMPLEMENTATION
#undef STB_IMAGE_WRITE_STATIC
#undef STBI_WRITE_NO_STDIO
#undef STBIWDEF
#undef STBIW_MALLOC
#undef STBIW_REALLOC
#undef STBIW_REALLOC_SIZED
#undef STBIW_FREE
#undef STBIW_MEMMOVE
#undef STBIW_ASSERT
#undef STBIW_CRC32
#undef STBIW_ZLIB_COMPRESS
#define TINYOBJLOADER_IMPLEMENTATION
#define INSONIFY_JOIN(left, right) left##right
#define INSONIFY_TINYOBJ(abi) INSONIFY_JOIN(insonify_tinyobj_, abi)
#define tinyobj INSONIFY_TINYOBJ(INSONIFY_ABI)
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#define STBIW_ASSERT(condition) assert(condition)

#if __has_include(<tiny_obj_loader.h>)
#include <tiny_obj_loader.h>
#else
#error "insonify needs tiny_obj_loader.h to read OBJ files: install libtinyobjloader-dev"
#endif

namespace insonify::inline INSONIFY_ABI::detail {
namespace loader = tinyobj;

namespace stb {
using ::abs; // insonify::abs would hide it
#if __has_include(<stb_image_write.h>)
#include <stb_image_write.h>
#elif __has_include(<stb/stb_image_write.h>)
#include <stb/stb_image_write.h>
#else
#error "insonify needs stb_image_write.h to write PNG files: install libstb-dev"
#endif
} // namespace stb
} // namespace insonify::inline INSONIFY_ABI::detail

#undef INSONIFY_JOIN
#undef INSONIFY_TINYOBJ
#pragma pop_macro("tinyobj")
#pragma pop_macro("TINY_OBJ_LOADER_H_")
#pragma pop_macro("TINYOBJLOADER_IMPLEMENTATION")
#pragma pop_macro("TINYOBJLOADER_USE_DOUBLE")
#pragma pop_macro("TINYOBJLOADER_USE_MAPBOX_EARCUT")
#pragma pop_macro("TINYOBJ_OVERRIDE")
#pragma pop_macro("IS_SPACE")
#pragma pop_macro("IS_DIGIT")
#pragma pop_macro("IS_NEW_LINE")
#pragma pop_macro("INCLUDE_STB_IMAGE_WRITE_H")
#pragma pop_macro("STB_IMAGE_WRITE_IMPLEMENTATION")
#pragma pop_macro("STB_IMAGE_WRITE_STATIC")
#pragma pop_macro("STBI_WRITE_NO_STDIO")
#pragma pop_macro("STBIWDEF")
#pragma pop_macro("STBIW_MALLOC")
#pragma pop_macro("STBIW_REALLOC")
#pragma pop_macro("STBIW_REALLOC_SIZED")
#pragma pop_macro("STBIW_FREE")
#pragma pop_macro("STBIW_MEMMOVE")
#pragma pop_macro("STBIW_ASSERT")
#pragma pop_macro("STBIW_CRC32")
#pragma pop_macro("STBIW_ZLIB_COMPRESS")

#include <insonify/core/restore_macros.hpp>

#endif
