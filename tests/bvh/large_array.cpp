#include <insonify/bvh/large_array.hpp>
#include <cstdint>
#include <doctest/doctest.h>
#include <stdexcept>
#include <utility>

using namespace insonify;

namespace large_array_test {

using namespace insonify::detail;

namespace {

large_array<std::uint32_t> counted(std::size_t size) {
    large_array<std::uint32_t> a(size);
    for (std::size_t i = 0; i < size; ++i) a[i] = static_cast<std::uint32_t>(7 * i);
    return a;
}

bool counts(const large_array<std::uint32_t>& a, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
        if (a[i] != 7 * i) return false;
    return true;
}

} // namespace

TEST_CASE("an array keeps its elements when it grows, also into huge pages, and when it shrinks") {
    constexpr std::size_t many = std::size_t{1} << 20U; // 4 MiB
    auto a = large_array_test::counted(1000);
    a.resize(many);
    REQUIRE(a.size() == many);
    CHECK(large_array_test::counts(a, 1000));
    CHECK(reinterpret_cast<std::uintptr_t>(a.data()) % (std::size_t{2} << 20U) == 0); // a page
    for (const std::size_t size : {1U, 3U, 100U, 1000U})
        CHECK(reinterpret_cast<std::uintptr_t>(large_array_test::counted(size).data()) % 64 == 0);
    const volatile std::size_t few = 10; // or g++ warns of a growth that never happens
    a.resize(few);
    const std::uint32_t* const before = a.data();
    a.reserve(100);
    a.resize(many); // was reserved
    CHECK(a.data() == before);
    CHECK(large_array_test::counts(a, 1000));
    CHECK(a.end() - a.begin() == static_cast<std::ptrdiff_t>(many));
}

TEST_CASE("reserve adds no elements") {
    large_array<double> a;
    a.reserve(100);
    CHECK(a.empty());
    CHECK(a.begin() == a.end());
}

TEST_CASE("copies are deep, moved-from arrays are empty, and self-assignment is allowed") {
    auto a = large_array_test::counted(100);
    large_array<std::uint32_t> copy = a;
    copy[3] = 1;
    CHECK(large_array_test::counts(a, 100));
    large_array<std::uint32_t> taken = std::move(a);
    CHECK(large_array_test::counts(taken, 100));
    CHECK(a.empty()); // NOLINT: what is left is told
    const auto& same = taken;
    taken = same;
    CHECK(large_array_test::counts(taken, 100));
    const large_array<std::uint32_t> nothing, copied = nothing;
    CHECK(copied.empty());
    taken = copied;
    CHECK(taken.empty());
}

TEST_CASE("more elements than an array can have are an error, which leaves it unchanged") {
    auto a = large_array_test::counted(100);
    CHECK_THROWS_AS(a.resize(a.max_size() + 1), std::length_error);
    CHECK(a.size() == 100);
    CHECK(large_array_test::counts(a, 100));
}

} // namespace large_array_test
