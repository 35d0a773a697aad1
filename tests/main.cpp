#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#define INSONIFY_IMPLEMENTATION
#include <doctest/doctest.h>
#include <insonify/insonify.hpp>
