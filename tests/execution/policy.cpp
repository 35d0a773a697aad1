#include <insonify/execution/policy.hpp>
#include <doctest/doctest.h>

#if __has_include(<pstl/execution_defs.h>)
using namespace insonify;

namespace policy_test {
namespace standard = __pstl::execution; // what std::execution's objects are; <execution> itself would need TBB to link
}

static_assert(exec::policy<policy_test::standard::sequenced_policy>);
static_assert(exec::policy<policy_test::standard::parallel_policy>);
static_assert(exec::is_unsequenced_v<policy_test::standard::unsequenced_policy>);
static_assert(exec::is_unsequenced_v<policy_test::standard::parallel_unsequenced_policy>);
static_assert(!exec::is_unsequenced_v<policy_test::standard::parallel_policy>);

TEST_CASE("the standard's policy objects run on the library's own threads") {
    std::vector<int> calls(1000);
    for_each_index(policy_test::standard::parallel_policy{}, calls.size(), [&](std::size_t i) { ++calls[i]; });
    for_each_index(policy_test::standard::parallel_unsequenced_policy{}, calls.size(),
                   [&](std::size_t i) { ++calls[i]; });
    for_each_index(policy_test::standard::sequenced_policy{}, calls.size(), [&](std::size_t i) { ++calls[i]; });
    for_each_index(policy_test::standard::unsequenced_policy{}, calls.size(), [&](std::size_t i) { ++calls[i]; });
    CHECK(calls == std::vector<int>(1000, 4));
    CHECK(exec::max_threads(policy_test::standard::sequenced_policy{}) == 1);
    CHECK(exec::max_threads(policy_test::standard::parallel_policy{}) == exec::max_threads(exec::par));
}
#endif
