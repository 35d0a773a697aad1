#include <insonify/core/memo.hpp>
#include <doctest/doctest.h>
#include <limits>
#include <stdexcept>
#include <string>

using namespace insonify;

namespace memo_test {
namespace {

struct incomparable {
    int value = 0;
};

struct base {
    int value = 0;
    friend bool operator==(const base&, const base&) = default;
};
struct derived : base {
    int added = 0;
};
struct derived_with_equality : base {
    int added = 0;
    friend bool operator==(const derived_with_equality&, const derived_with_equality&) = default;
};

static_assert(detail::comparable<float> && detail::comparable<base> && detail::comparable<derived_with_equality>);
static_assert(!detail::comparable<incomparable> && !detail::comparable<derived>);

} // namespace
} // namespace memo_test

TEST_CASE("a memo computes once for the same causes, and again as soon as one of them changes") {
    detail::memo<std::string, int, float> table;
    int computed = 0;
    const auto value = [&](int count, float weight) {
        return table(
            [&](std::string& text) {
                ++computed;
                text = std::to_string(count) + "/" + std::to_string(static_cast<int>(weight));
            },
            count, weight);
    };
    CHECK(value(1, 2) == "1/2");
    CHECK(value(1, 2) == "1/2");
    CHECK(computed == 1);
    CHECK(value(3, 2) == "3/2");
    CHECK(value(3, 4) == "3/4");
    CHECK(value(3, 4) == "3/4");
    CHECK(computed == 3);
    CHECK(value(1, 2) == "1/2"); // only the last causes are kept
    CHECK(computed == 4);
}

TEST_CASE("causes are compared as copies: one that changes in place is noticed") {
    detail::memo<int, memo_test::base> table;
    memo_test::base cause{1};
    int computed = 0;
    const auto compute = [&](int& value) { value = ++computed; };
    CHECK(table(compute, cause) == 1);
    cause.value = 2;
    CHECK(table(compute, cause) == 2);
    CHECK(table(compute, cause) == 2);
}

TEST_CASE("causes that cannot be compared, or do not equal themselves, are taken to have changed") {
    int computed = 0;
    const auto compute = [&](int& value) { value = ++computed; };
    detail::memo<int, int, memo_test::incomparable> table;
    CHECK(table(compute, 1, memo_test::incomparable{2}) == 1);
    CHECK(table(compute, 1, memo_test::incomparable{2}) == 2);
    detail::memo<int, float> of_float;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK(of_float(compute, nan) == 3);
    CHECK(of_float(compute, nan) == 4);
    CHECK(of_float(compute, 1) == 5);
    CHECK(of_float(compute, 1) == 5);
}

TEST_CASE("a derived type that only inherits == is taken to have changed: its own members are not compared") {
    int computed = 0;
    const auto compute = [&](int& value) { value = ++computed; };
    detail::memo<int, memo_test::derived> inherited;
    CHECK(inherited(compute, memo_test::derived{{1}, 2}) == 1);
    CHECK(inherited(compute, memo_test::derived{{1}, 3}) == 2);
    detail::memo<int, memo_test::derived_with_equality> own;
    CHECK(own(compute, memo_test::derived_with_equality{{1}, 2}) == 3);
    CHECK(own(compute, memo_test::derived_with_equality{{1}, 2}) == 3);
    CHECK(own(compute, memo_test::derived_with_equality{{1}, 3}) == 4);
}

TEST_CASE("an exception while computing leaves nothing stale: neither for the new causes nor for the former") {
    detail::memo<int, int> table;
    int computed = 0;
    const auto compute = [&](int& value) { value = 10 * ++computed; };
    CHECK(table(compute, 1) == 10);
    const auto fail = [](int& value) {
        value = -1; // half done
        throw std::runtime_error{"no memory"};
    };
    CHECK_THROWS_AS(table(fail, 2), std::runtime_error);
    CHECK(table(compute, 1) == 20);
    CHECK_THROWS_AS(table(fail, 2), std::runtime_error);
    CHECK(table(compute, 2) == 30);
    CHECK(table(compute, 2) == 30);
}

TEST_CASE("the former value is handed in, so that its memory is reused; a copy of a memo is independent") {
    detail::memo<std::string, int> table;
    table([](std::string& text) { text = "first"; }, 1);
    const std::string before = table([](std::string&) { FAIL("computed twice"); }, 1);
    CHECK(before == "first");
    auto copy = table;
    CHECK(table([](std::string& text) { text += " then second"; }, 2) == "first then second");
    CHECK(copy([](std::string&) { FAIL("a copy keeps its causes"); }, 1) == "first");
}
