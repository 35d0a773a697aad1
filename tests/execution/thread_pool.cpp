#include <insonify/execution/policy.hpp>
#include <atomic>
#include <chrono>
#include <doctest/doctest.h>
#include <set>
#include <stdexcept>
#include <string>

using namespace insonify;

TEST_CASE("every index is called once, on any number of threads") {
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U, 40U})
        for (const std::size_t count : {0UL, 1UL, 2UL, 7UL, 1000UL}) {
            std::vector<std::atomic<int>> calls(count);
            for_each_index(exec::par.threads(threads), count, [&](std::size_t i) { ++calls[i]; });
            for (const auto& c : calls) REQUIRE(c == 1);
        }
}

TEST_CASE("threads(n) means n participants at most, the caller being one") {
    const std::thread::id caller = std::this_thread::get_id();
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{30};
    std::atomic<bool> caller_came = false;
    std::mutex mutex;
    std::set<std::thread::id> seen;
    for_each_index(exec::par.threads(3), 400, [&](std::size_t) { // others wait for the caller, which may start late
        const std::thread::id here = std::this_thread::get_id();
        if (here == caller) caller_came = true;
        while (!caller_came && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::microseconds{50});
        const std::lock_guard lock{mutex};
        seen.insert(here);
    });
    CHECK(seen.size() <= 3);
    CHECK(seen.count(caller) == 1);
    for_each_index(exec::par.threads(1), 3, [&](std::size_t) { CHECK(std::this_thread::get_id() == caller); });
    CHECK_THROWS_AS(for_each_index(exec::par.threads(1025), 3, [](std::size_t) {}), usage_error);
}

TEST_CASE("the exception of the lowest index leaves the call, and the pool goes on working") {
    for (int round = 0; round < 50; ++round) {
        std::string what;
        std::atomic<int> below = 0;
        try {
            for_each_index(exec::par.threads(4), 200, [&](std::size_t i) {
                if (i >= 60 && i % 20 == 0) throw std::runtime_error{std::to_string(i)};
                if (i < 60) ++below;
            });
        } catch (const std::runtime_error& e) {
            what = e.what();
        }
        REQUIRE(what == "60");
        REQUIRE(below == 60);
    }
    std::atomic<int> calls = 0;
    for_each_index(exec::par.threads(4), 100, [&](std::size_t) { ++calls; });
    CHECK(calls == 100);
}

#if !defined(__EMSCRIPTEN__) || defined(__EMSCRIPTEN_PTHREADS__) // threads of the test's own
TEST_CASE("nested parallel calls and calls from several threads at once all end") {
    std::atomic<int> calls = 0;
    const auto nested = [&] {
        for_each_index(exec::par.threads(3), 8, [&](std::size_t) {
            for_each_index(exec::par_unseq.threads(4), 8,
                           [&](std::size_t) { for_each_index(exec::par, 4, [&](std::size_t) { ++calls; }); });
        });
    };
    std::thread other{nested}, third{nested};
    nested();
    other.join();
    third.join();
    CHECK(calls == 3 * 8 * 8 * 4);
}
#endif

TEST_CASE("an exception within a nested call reaches the outer caller") {
    CHECK_THROWS_AS(for_each_index(exec::par.threads(4), 4,
                                   [](std::size_t) {
                                       for_each_index(exec::par.threads(4), 4, [](std::size_t i) {
                                           if (i == 2) throw std::out_of_range{"inner"};
                                       });
                                   }),
                    std::out_of_range);
}
