#include <insonify/insonify.hpp>
#include <doctest/doctest.h>

// main.cpp includes the umbrella with INSONIFY_IMPLEMENTATION, this file and every other without.
TEST_CASE("a second translation unit includes the umbrella and calls what the first one implements") {
    const insonify::image dot{insonify::uvec2{1, 1}};
    CHECK_THROWS_AS(insonify::write_png("no/such/folder/picture.png", dot), insonify::io_error);
}
