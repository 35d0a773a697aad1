#include <insonify/core/error.hpp>
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

TEST_CASE("text: the parts of a message are joined in their order") {
    CHECK(detail::joined({}).empty());
    CHECK(detail::joined({"size ", std::to_string(12), "x", std::string{"7"}, ""}) == "size 12x7");
}

TEST_CASE("text: numbers have four significant digits at most") {
    CHECK(detail::number_text(38) == "38");
    CHECK(detail::number_text(0.0012345F) == "0.001234");
    CHECK(detail::number_text(-5e6F) == "-5e+06");
}
