#include <insonify/scanner.hpp>
#include <doctest/doctest.h>
#include <stdexcept>

using namespace insonify;

TEST_CASE("cine_loop: keeps the newest frames in order, whatever length is asked for, as a deque does") {
    cine_loop<int> loop;
    CHECK(loop.empty());
    std::vector<int> expected; // the newest at the end
    const std::uint32_t lengths[] = {3, 3, 3, 3, 3, 5, 5, 5, 5, 2, 2, 4, 1, 0, 6, 6, 6};
    int next = 1;
    for (const std::uint32_t length : lengths) {
        loop.add(length, [&](int& frame) { frame = next; });
        expected.push_back(next++);
        while (expected.size() > std::max(length, 1U)) expected.erase(expected.begin());
        REQUIRE(loop.size() == expected.size());
        for (std::uint32_t back = 0; back < loop.size(); ++back)
            CHECK(loop[back] == expected[expected.size() - 1 - back]);
    }
    loop.clear();
    CHECK(loop.empty());
}

TEST_CASE("cine_loop: a frame that could not be made is not added; the others stay") {
    cine_loop<int> loop;
    for (int i = 1; i < 6; ++i) loop.add(3, [&](int& frame) { frame = i; });
    CHECK_THROWS_AS(loop.add(3,
                             [](int& frame) {
                                 frame = 99;
                                 throw std::runtime_error{""};
                             }),
                    std::runtime_error);
    REQUIRE(loop.size() == 2); // the oldest was overwritten
    CHECK(loop[0] == 5);
    CHECK(loop[1] == 4);
    loop.add(3, [](int& frame) { frame = 6; });
    REQUIRE(loop.size() == 3);
    CHECK(loop[0] == 6);
    CHECK(loop[2] == 4);
}
