#include <insonify/execution/policy.hpp>
#include <algorithm>
#include <cstdint>
#include <doctest/doctest.h>
#include <thread>
#include <vector>

namespace foreign {

struct backwards {}; // a policy of a user's own: one overload, found by argument-dependent lookup

template <class Body>
void for_each_index(const backwards&, std::size_t count, const Body& body) {
    while (count > 0) body(--count);
}

struct alone : backwards {}; // says on how many threads it runs
std::uint32_t max_threads(const alone&) { return 1; }

} // namespace foreign

using namespace insonify;

static_assert(exec::policy<exec::sequenced_policy> && exec::policy<exec::parallel_policy>);
static_assert(exec::policy<exec::unsequenced_policy> && exec::policy<exec::parallel_unsequenced_policy>);
static_assert(exec::policy<foreign::backwards> && !exec::policy<int>);
static_assert(!exec::is_unsequenced_v<foreign::backwards> && exec::is_unsequenced_v<exec::parallel_unsequenced_policy>);

TEST_CASE("a user's own policy is found and used") {
    std::vector<std::size_t> order;
    exec::for_each_block(foreign::backwards{}, 10, 4, 1e6F, [&](std::size_t begin, std::size_t end) {
        order.push_back(begin);
        order.push_back(end);
    });
    CHECK(order == std::vector<std::size_t>{8, 10, 4, 8, 0, 4});
}

TEST_CASE("blocks cover every index once, the last one shorter") {
    for (const std::size_t count : {0UL, 1UL, 7UL, 8UL, 9UL, 100UL}) {
        std::vector<int> calls(count);
        exec::for_each_block(exec::par, count, 8, 1e6F, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) ++calls[i];
        });
        CHECK(calls == std::vector<int>(count, 1));
    }
}

TEST_CASE("little work stays on the calling thread, in order") {
    std::vector<std::size_t> begins;
    exec::for_each_block(exec::par.threads(4), 1000, 10, 1, [&](std::size_t begin, std::size_t end) {
        CHECK(end == begin + 10);
        begins.push_back(begin); // a race, were there other threads
    });
    REQUIRE(begins.size() == 100);
    for (std::size_t i = 0; i < begins.size(); ++i) CHECK(begins[i] == 10 * i);
}

TEST_CASE("seq and unseq go in order, and let exceptions through at once") {
    std::size_t calls = 0;
    const auto throws_at_3 = [&](std::size_t i) {
        ++calls;
        if (i == 3) throw 3;
    };
    CHECK_THROWS_AS(for_each_index(exec::seq, 10, throws_at_3), int);
    CHECK_THROWS_AS(for_each_index(exec::unseq, 10, throws_at_3), int);
    CHECK(calls == 8);
}

TEST_CASE("a policy says on how many threads it runs at most") {
    using exec::max_threads;
    CHECK(max_threads(exec::seq) == 1);
    CHECK(max_threads(exec::unseq) == 1);
    CHECK(max_threads(exec::par.threads(3)) == 3);
    CHECK(max_threads(exec::par_unseq.threads(5)) == 5);
    const std::uint32_t processors = std::max(1U, std::thread::hardware_concurrency());
    CHECK(max_threads(exec::par) == processors);
    CHECK(max_threads(foreign::backwards{}) == processors); // it could be any number
    CHECK(max_threads(foreign::alone{}) == 1);
}
