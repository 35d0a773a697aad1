#ifndef INSONIFY_IO_HPP
#define INSONIFY_IO_HPP

/// Files: OBJ meshes, PNG images.
#include <insonify/io/debug_obj.hpp>
#include <insonify/io/obj.hpp>
#include <insonify/io/png.hpp>

#endif
