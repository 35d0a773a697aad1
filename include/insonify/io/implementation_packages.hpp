#ifndef INSONIFY_IO_IMPLEMENTATION_PACKAGES_HPP
#define INSONIFY_IO_IMPLEMENTATION_PACKAGES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>
// NOLINTBEGIN(modernize-deprecated-headers): stb_image_write includes these names.
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
// NOLINTEND(modernize-deprecated-headers)

// Private copies of tinyobjloader, in an unnamed namespace, and of stb_image_write, static functions in a namespace: so
// what is not used of them is not compiled, a tenth of what the README's program emits. Every macro that configures
// them or that they define is saved and restored, so that a program can include its own copies in this file, before or
// after, and in others. The headers that they need are included above, outside these namespaces. The rest of this file
// counts as a header of the system: compilers do not warn of the packages.
#if !defined(_MSC_VER)
#pragma GCC system_header
#endif
#define INSONIFY_PRAGMA(text) _Pragma(#text)
#define INSONIFY_MACROS_OF_PACKAGES(action)                                                                            \
    INSONIFY_PRAGMA(action("tinyobj"))                                                                                 \
    INSONIFY_PRAGMA(action("TINY_OBJ_LOADER_H_"))                                                                      \
    INSONIFY_PRAGMA(action("TINYOBJLOADER_IMPLEMENTATION"))                                                            \
    INSONIFY_PRAGMA(action("TINYOBJLOADER_USE_DOUBLE"))                                                                \
    INSONIFY_PRAGMA(action("TINYOBJLOADER_USE_MAPBOX_EARCUT"))                                                         \
    INSONIFY_PRAGMA(action("TINYOBJ_OVERRIDE"))                                                                        \
    INSONIFY_PRAGMA(action("IS_SPACE"))                                                                                \
    INSONIFY_PRAGMA(action("IS_DIGIT"))                                                                                \
    INSONIFY_PRAGMA(action("IS_NEW_LINE"))                                                                             \
    INSONIFY_PRAGMA(action("INCLUDE_STB_IMAGE_WRITE_H"))                                                               \
    INSONIFY_PRAGMA(action("STB_IMAGE_WRITE_IMPLEMENTATION"))                                                          \
    INSONIFY_PRAGMA(action("STB_IMAGE_WRITE_STATIC"))                                                                  \
    INSONIFY_PRAGMA(action("STBI_WRITE_NO_STDIO"))                                                                     \
    INSONIFY_PRAGMA(action("STBIWDEF"))                                                                                \
    INSONIFY_PRAGMA(action("STBIW_MALLOC"))                                                                            \
    INSONIFY_PRAGMA(action("STBIW_REALLOC"))                                                                           \
    INSONIFY_PRAGMA(action("STBIW_REALLOC_SIZED"))                                                                     \
    INSONIFY_PRAGMA(action("STBIW_FREE"))                                                                              \
    INSONIFY_PRAGMA(action("STBIW_MEMMOVE"))                                                                           \
    INSONIFY_PRAGMA(action("STBIW_ASSERT"))                                                                            \
    INSONIFY_PRAGMA(action("STBIW_CRC32"))                                                                             \
    INSONIFY_PRAGMA(action("STBIW_ZLIB_COMPRESS"))
INSONIFY_MACROS_OF_PACKAGES(push_macro)
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
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#define STBIW_ASSERT(condition) assert(condition)

namespace insonify_packages {
namespace {
#if __has_include(<tiny_obj_loader.h>)
#include <tiny_obj_loader.h>
#else
#error "insonify needs tiny_obj_loader.h to read OBJ files: install libtinyobjloader-dev"
#endif
} // namespace
} // namespace insonify_packages

namespace insonify::inline INSONIFY_ABI::detail {
namespace loader = insonify_packages::tinyobj;

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

INSONIFY_MACROS_OF_PACKAGES(pop_macro)
#undef INSONIFY_MACROS_OF_PACKAGES
#undef INSONIFY_PRAGMA

#include <insonify/core/restore_macros.hpp>

#endif
