/// Definitions of the functions that io/ declares, for the one source file of a program that defines
/// INSONIFY_IMPLEMENTATION. It may have included the library before.
#if defined(INSONIFY_IMPLEMENTATION) && !defined(INSONIFY_IO_IMPLEMENTATION_HPP)
#define INSONIFY_IO_IMPLEMENTATION_HPP

#include <insonify/io/implementation_file.hpp>
#include <insonify/io/implementation_obj.hpp>

#endif
