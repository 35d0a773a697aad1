#ifndef INSONIFY_IO_HPP
#define INSONIFY_IO_HPP

/// Files: OBJ meshes, PNG images.
#include <insonify/io/obj.hpp>
#include <insonify/io/png.hpp>

#endif
