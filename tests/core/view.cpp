#include <insonify/core/view.hpp>
#include <array>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

static_assert(std::is_trivially_copyable_v<view<const float>>);
static_assert(!std::constructible_from<view<const float>, std::vector<float>>, "a view of a temporary would dangle");

TEST_CASE("function_ref: calls the function that it refers to, which keeps its state") {
    int calls = 0;
    const auto count = [&calls](int more, float) { return calls += more; };
    const detail::function_ref<int(int, float)> all{count}, copy = all;
    CHECK(all(2, 0) == 2);
    CHECK(copy(3, 0) == 5);
    CHECK(calls == 5);
}

TEST_CASE("view: refers to the elements of a container") {
    std::vector<int> numbers{4, 5, 6};
    const view<const int> seen{numbers};
    CHECK(seen.size() == 3);
    CHECK(seen[2] == 6);
    CHECK(seen.data() == numbers.data());
    int sum = 0;
    for (const int n : seen) sum += n;
    CHECK(sum == 15);

    const view<int> writable{numbers};
    writable[0] = 7;
    CHECK(numbers[0] == 7);

    const std::array<int, 2> fixed{1, 2};
    CHECK(view<const int>{fixed}.size() == 2);
    CHECK(view<const int>{}.empty());
}
