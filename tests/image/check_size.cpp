#include <insonify/image/image.hpp>
#include <doctest/doctest.h>
#include <string>

using namespace insonify;

namespace check_size_test {

TEST_CASE("check_size: images without pixels or with more than 16384 a side are refused with their size") {
    const auto sentence = [](uvec2 size) -> std::string {
        try {
            detail::check_size(size, "draw");
        } catch (const usage_error& e) {
            return e.what();
        }
        return "none";
    };
    CHECK(sentence({1, 1}) == "none");
    CHECK(sentence({16384, 16384}) == "none");
    CHECK(sentence({0, 100}) == "draw: size 0x100 has no pixels; it must be at least 1x1");
    CHECK(sentence({100, 0}).find("100x0") != std::string::npos);
    CHECK(sentence({16385, 1}) == "draw: size 16385x1 exceeds 16384 pixels a side; ask for fewer");
    CHECK(sentence({1, ~0U}).find("1x4294967295 exceeds") != std::string::npos);
}

} // namespace check_size_test
