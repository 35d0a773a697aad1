#include <doctest/doctest.h>
#include <insonify/insonify.hpp>

// main.cpp includes the umbrella with INSONIFY_IMPLEMENTATION, this file and every other without.
TEST_CASE("a second translation unit includes the umbrella and calls what the first one implements") {
    CHECK_THROWS_AS(insonify::write_png("no/such/folder/picture.png", {{1, 1}, {0}}), insonify::io_error);
}
