#include <insonify/execution/simd.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace pack_test {
namespace {
template <int N>
void check() {
    std::uint32_t wrong = 0;
    const bit_lanes<N> values = steps_of_bits<N>(100, 7);
    for (std::uint32_t bits = 0; bits < 1U << static_cast<unsigned>(N); ++bits) {
        std::uint32_t packed[2 * N], expected = 0;
        for (std::uint32_t& one : packed) one = 5;
        const std::uint32_t count = detail::pack_lanes<N>(values, bits, packed + N / 2);
        for (std::uint32_t lane = 0; lane < N; ++lane)
            if ((bits >> lane & 1U) != 0) wrong += packed[N / 2 + expected++] != 100 + 7 * lane;
        wrong += count != expected;
        for (std::uint32_t i = 0; i < N / 2; ++i) wrong += packed[i] != 5 || packed[N + N / 2 + i] != 5;
    }
    CHECK(wrong == 0);
}
} // namespace
} // namespace pack_test

TEST_CASE("any set of lanes is packed in order, and nothing is written outside of the room for all") {
    pack_test::check<4>();
    pack_test::check<simd_width>();
}
