#include <insonify/execution/policy.hpp>
#include <doctest/doctest.h>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

using namespace insonify;

namespace any_policy_test {

/// A user's own: goes through the indices backwards.
struct backwards {
    std::vector<std::size_t>* order;
};
template <class Body>
void for_each_index(const backwards& policy, std::size_t count, const Body& body) {
    while (count-- > 0) {
        policy.order->push_back(count);
        body(count);
    }
}

} // namespace any_policy_test

static_assert(exec::policy<detail::any_policy<false>> && exec::policy<detail::any_policy<true>>);
static_assert(std::is_same_v<decltype(detail::any_policy{exec::par}), detail::any_policy<false>>);
static_assert(std::is_same_v<decltype(detail::any_policy{exec::par_unseq.threads(2)}), detail::any_policy<true>>);
static_assert(exec::is_unsequenced_v<detail::any_policy<true>> && !exec::is_unsequenced_v<detail::any_policy<false>>);

TEST_CASE("any policy calls each index once, as the policy behind it does") {
    const auto check = [](const auto& policy) {
        std::vector<int> calls(1000);
        for_each_index(detail::any_policy{policy}, calls.size(), [&](std::size_t i) { ++calls[i]; });
        CHECK(calls == std::vector<int>(1000, 1));
        calls.assign(1000, 0);
        exec::for_each_block(detail::any_policy{policy}, calls.size(), 64, 1e6F,
                             [&](std::size_t begin, std::size_t end) {
                                 for (std::size_t i = begin; i < end; ++i) ++calls[i];
                             });
        CHECK(calls == std::vector<int>(1000, 1));
    };
    check(exec::seq);
    check(exec::unseq);
    check(exec::par);
    check(exec::par_unseq.threads(3));
    std::vector<std::size_t> order;
    const any_policy_test::backwards own{&order};
    check(own);
    REQUIRE(order.size() == 1000 + 16);
    CHECK(order.front() == 999);
}

TEST_CASE("of the exceptions under any policy the one of the lowest index leaves") {
    const exec::parallel_policy three = exec::par.threads(3);
    try {
        for_each_index(detail::any_policy{three}, 1000, [](std::size_t i) {
            if (i % 7 == 6) throw std::runtime_error{std::to_string(i)};
        });
        FAIL("nothing was thrown");
    } catch (const std::runtime_error& thrown) {
        CHECK(std::string{thrown.what()} == "6");
    }
}
