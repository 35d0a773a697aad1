#ifndef INSONIFY_IO_HPP
#define INSONIFY_IO_HPP

/// Files: OBJ meshes, PNG images. One file of a program defines INSONIFY_IMPLEMENTATION before it includes this or
/// insonify.hpp.
#include <insonify/io/obj.hpp>
#include <insonify/io/png.hpp>

#endif
// Outside the guard, so that it is reached also after an earlier include or a precompiled header.
#include <insonify/io/implementation.hpp>
