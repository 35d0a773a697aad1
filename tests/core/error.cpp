#include <insonify/core/error.hpp>
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

TEST_CASE("text: the parts of a message are joined in their order") {
    CHECK(detail::joined({}).empty());
    CHECK(detail::joined({"size ", 12, "x", std::string{"7"}, ""}) == "size 12x7");
    CHECK(detail::joined({-3, " ", ~std::uint64_t{0}, " ", 0.5F, " ", std::string_view{"m"}}) ==
          "-3 18446744073709551615 0.5 m");
}

TEST_CASE("text: numbers have four significant digits at most") {
    CHECK(detail::number_text(38) == "38");
    CHECK(detail::number_text(0.0012345F) == "0.001234");
    CHECK(detail::number_text(-5e6F) == "-5e+06");
}

TEST_CASE("errors: messages of one part or several") {
    CHECK(std::string{usage_error{"line ", 3U, " has no sample"}.what()} == "line 3 has no sample");
    CHECK(std::string{geometry_error{"empty"}.what()} == "empty");
    const std::string message = "cannot be read";
    CHECK(std::string{io_error{message}.what()} == message);
    CHECK(std::string{io_error(message).what()} == message);
}
