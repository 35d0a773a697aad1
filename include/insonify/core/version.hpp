#ifndef INSONIFY_CORE_VERSION_HPP
#define INSONIFY_CORE_VERSION_HPP

/// The library's version as one number: major * 10000 + minor * 100 + patch. CMake reads it from here.
#define INSONIFY_VERSION 200

#endif
