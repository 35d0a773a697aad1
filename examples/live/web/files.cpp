/// What the library compiles once: files. It is small rather than fast.
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
