#include <insonify/image/check_size.hpp>
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

namespace check_size_test {

TEST_CASE("check_size: pictures without pixels and absurdly large ones are refused, with their size in the sentence") {
    CHECK_NOTHROW(check_size({1, 1}));
    CHECK_NOTHROW(check_size({16384, 16384}));
    CHECK_THROWS_AS(check_size({0, 100}), usage_error);
    CHECK_THROWS_AS(check_size({100, 0}), usage_error);
    CHECK_THROWS_AS(check_size({16385, 16384}), usage_error);
    CHECK_THROWS_AS(check_size({~0U, ~0U}), usage_error);
    try {
        check_size({70000, 80000});
    } catch (const usage_error& e) {
        CHECK(std::string{e.what()}.find("70000 x 80000") != std::string::npos);
    }
}

} // namespace check_size_test
