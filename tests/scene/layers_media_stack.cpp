#include <insonify/core/random.hpp>
#include <insonify/scene/layers.hpp>
#include <doctest/doctest.h>
#include <set>
#include <vector>

using namespace insonify;

TEST_CASE("the object of lowest rank that contains the point gives the medium, whatever the number of objects") {
    for (const std::size_t objects : {1U, 2U, 31U, 32U, 33U, 64U, 65U, 200U}) {
        std::vector<std::uint32_t> ranks(objects);
        media_stack stack{.ranks = view<std::uint32_t>{ranks}};
        std::set<std::uint32_t> inside; // what the stack represents
        CHECK(stack.top() == media_stack::none);
        for (std::uint64_t step = 0; step < 2000; ++step) {
            const auto rank = static_cast<std::uint32_t>(hash_bits(objects, step) % objects);
            stack.toggle(rank);
            if (inside.erase(rank) == 0) inside.insert(rank);
            REQUIRE(stack.top() == (inside.empty() ? media_stack::none : *inside.begin()));
            REQUIRE(std::vector(inside.begin(), inside.end()) == std::vector(ranks.data(), ranks.data() + stack.count));
        }
        CHECK_FALSE(stack.overflow);
        stack.clear();
        CHECK(stack.top() == media_stack::none);
    }
}

TEST_CASE("an object alone on the stack gives the medium, whatever its rank") {
    std::vector<std::uint32_t> ranks(8);
    media_stack stack{.ranks = view<std::uint32_t>{ranks}};
    for (std::uint32_t rank = 0; rank < 200; ++rank) {
        stack.toggle(rank);
        CHECK(stack.top() == rank);
        stack.toggle(rank);
        CHECK(stack.top() == media_stack::none);
    }
}

TEST_CASE("a stack that is too small says so, as does a copy") {
    std::uint32_t two[2] = {}, one = 0;
    media_stack stack{.ranks = {two, 2}}, copy{.ranks = {&one, 1}};
    stack.toggle(3);
    stack.toggle(1);
    CHECK_FALSE(stack.overflow);
    copy.assign(stack);
    CHECK(copy.overflow);
    stack.toggle(2);
    CHECK(stack.overflow);
    CHECK(stack.top() == 1);
    stack.clear();
    CHECK_FALSE(stack.overflow);
}
