#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#define INSONIFY_IMPLEMENTATION
#include <insonify/insonify.hpp>
#include <doctest/doctest.h>
