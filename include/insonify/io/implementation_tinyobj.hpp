#ifndef INSONIFY_IO_IMPLEMENTATION_TINYOBJ_HPP
#define INSONIFY_IO_IMPLEMENTATION_TINYOBJ_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>

// A private copy of tinyobjloader in a renamed namespace, with every macro that configures it or that it defines saved
// and restored, so that a program can include its own copy in this file, before or after, and in others.
#pragma push_macro("tinyobj")
#pragma push_macro("TINY_OBJ_LOADER_H_")
#pragma push_macro("TINYOBJLOADER_IMPLEMENTATION")
#pragma push_macro("TINYOBJLOADER_USE_DOUBLE")
#pragma push_macro("TINYOBJLOADER_USE_MAPBOX_EARCUT")
#pragma push_macro("TINYOBJ_OVERRIDE")
#pragma push_macro("IS_SPACE")
#pragma push_macro("IS_DIGIT")
#pragma push_macro("IS_NEW_LINE")
#undef tinyobj
#undef TINY_OBJ_LOADER_H_
#undef TINYOBJLOADER_IMPLEMENTATION
#undef TINYOBJLOADER_USE_DOUBLE
#undef TINYOBJLOADER_USE_MAPBOX_EARCUT
#undef TINYOBJ_OVERRIDE
#undef IS_SPACE
#undef IS_DIGIT
#undef IS_NEW_LINE
#define TINYOBJLOADER_IMPLEMENTATION
#define INSONIFY_JOIN(left, right) left##right
#define INSONIFY_TINYOBJ(abi) INSONIFY_JOIN(insonify_tinyobj_, abi)
#define tinyobj INSONIFY_TINYOBJ(INSONIFY_ABI)

#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Weverything"
#elif defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wuseless-cast"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

#if __has_include(<tiny_obj_loader.h>)
#include <tiny_obj_loader.h>
#else
#error "insonify needs tiny_obj_loader.h to read OBJ files: install libtinyobjloader-dev"
#endif

namespace insonify::inline INSONIFY_ABI::detail {
namespace loader = tinyobj;
}

#if defined(__clang__)
#pragma clang diagnostic pop
#elif defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

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

#include <insonify/core/restore_macros.hpp>

#endif
