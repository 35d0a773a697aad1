/// What `io/` declares, compiled in the one file of a program that defines INSONIFY_IMPLEMENTATION, however often and
/// early that file includes this one.
#if defined(INSONIFY_IMPLEMENTATION) && !defined(INSONIFY_IO_IMPLEMENTATION_HPP)
#define INSONIFY_IO_IMPLEMENTATION_HPP

#include <insonify/io/implementation_debug_obj.hpp>
#include <insonify/io/implementation_obj.hpp>
#include <insonify/io/implementation_png.hpp>

#endif
