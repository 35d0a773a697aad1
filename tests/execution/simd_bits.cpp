#include <insonify/core/random.hpp>
#include <insonify/execution/simd.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>

using namespace insonify;

namespace simd_bits_test {
namespace {
template <int N>
void check() {
    std::uint32_t stored[N];
    store_bits<N>(steps_of_bits<N>(7, 0x9E3779B9U), stored);
    for (std::uint32_t i = 0; i < N; ++i) CHECK(stored[i] == 7 + i * 0x9E3779B9U);
    store_bits<N>(mix_lanes<N>(steps_of_bits<N>(100, 3)), stored);
    for (std::uint32_t i = 0; i < N; ++i) CHECK(stored[i] == mix_bits(100 + 3 * i));

    float x[N] = {}, result[N];
    for (const float value : {0.0F, -0.0F, 0.25F, -0.25F, 3.0F, -3.0F, 4.999F, -4.999F, 1e6F, -1e6F, 2e9F, -2e9F}) {
        x[N - 1] = value;
        store_bits<N>(floor_bits<N>(load<N>(x)), stored);
        CHECK(static_cast<std::int32_t>(stored[N - 1]) == static_cast<std::int32_t>(std::floor(value)));
        store(floats_of<N>(floor_bits<N>(load<N>(x))), result);
        CHECK(result[N - 1] == std::floor(value));
        store(raw_floats<N>(raw_bits<N>(load<N>(x))), result);
        CHECK(result[N - 1] == value);
        store(select(load<N>(x) < lanes<N>(1.0F), load<N>(x), lanes<N>(0.0F)), result);
        CHECK(result[N - 1] == (value < 1 ? value : 0));
        const bit_lanes<N> not_a_number = steps_of_bits<N>(0xFFFFFFFFU, 0), three = steps_of_bits<N>(3, 0); // as bits
        store_bits<N>(select_bits<N>(load<N>(x) < lanes<N>(1.0F), not_a_number, three), stored);
        CHECK(stored[N - 1] == (value < 1 ? 0xFFFFFFFFU : 3U));
        CHECK((N == 1 || stored[0] == 0xFFFFFFFFU)); // x is 0 there
        store(floats_of<N>((not_finite<N>(load<N>(x)) | not_number<N>(load<N>(x))) >> 31), result);
        CHECK(result[N - 1] == 0);
    }
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float value : {infinity, -infinity, std::nanf("1"), -std::nanf("1")}) {
        x[N - 1] = value;
        store_bits<N>(not_finite<N>(load<N>(x)) >> 31, stored);
        CHECK(stored[N - 1] == 1);
        store_bits<N>(not_number<N>(load<N>(x)) >> 31, stored);
        CHECK((stored[N - 1] == 1) == std::isnan(value));
    }
}
} // namespace
} // namespace simd_bits_test

TEST_CASE("bit_lanes do what numbers of 32 bits do, one by one") {
    simd_bits_test::check<1>();
    simd_bits_test::check<4>();
    simd_bits_test::check<simd_width>();
}
