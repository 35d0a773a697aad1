#include <insonify/execution/simd.hpp>
#include <algorithm>
#include <complex>
#include <doctest/doctest.h>
#include <numeric>
#include <type_traits>

using namespace insonify;

namespace simd_test {
namespace {
template <int N>
void check() {
    float a[N], b[N], result[N];
    for (int i = 0; i < N; ++i) {
        a[i] = static_cast<float>(i) - 1.5F;
        b[i] = 2.5F - static_cast<float>(i * i);
    }
    const auto each = [&](const lanes<N>& value, const auto& expected) {
        store(value, result);
        for (int i = 0; i < N; ++i) CHECK(result[i] == expected(a[i], b[i]));
    };
    const lanes<N> x = load<N>(a), y = load<N>(b);
    each(x + y, [](float p, float q) { return p + q; });
    each(x - y, [](float p, float q) { return p - q; });
    each(x * y, [](float p, float q) { return p * q; });
    each(x / y, [](float p, float q) { return p / q; });
    each(inverse(x), [](float p, float) { return 1 / p; });
    each(-x, [](float p, float) { return -p; });
    each(min(x, y), [](float p, float q) { return std::fmin(p, q); });
    each(max(x, y), [](float p, float q) { return std::fmax(p, q); });
    each(abs(x), [](float p, float) { return std::fabs(p); });
    each(sqrt(abs(x)), [](float p, float) { return std::sqrt(std::fabs(p)); });
    each(select(x < y, x, y), [](float p, float q) { return p < q ? p : q; });
    each(multiply_add(x, y, lanes<N>(0.25F)), [](float p, float q) { return multiply_add(p, q, 0.25F); });
    each(each_lane<N>([&](int i) { return b[i]; }), [](float, float q) { return q; });
    each(lanes<N>(3.0F), [](float, float) { return 3.0F; });
    for (const lanes<N>& negative : {lanes<N>(-0.0F), -lanes<N>(0.0F)}) {
        store(negative, result);
        CHECK(std::signbit(result[N - 1]));
    }

    std::uint32_t less = 0, both = 0;
    for (int i = 0; i < N; ++i) {
        less |= (a[i] < b[i] ? 1U : 0U) << static_cast<unsigned>(i);
        both |= (a[i] < b[i] && -1 <= a[i] ? 1U : 0U) << static_cast<unsigned>(i);
    }
    constexpr std::uint32_t all = (1U << static_cast<unsigned>(N)) - 1;
    CHECK(bits_of(x < y) == less);
    CHECK(bits_of(!(x < y)) == (all ^ less));
    CHECK(bits_of(x < y && lanes<N>(-1.0F) <= x) == both);
    CHECK(bits_of(x < y || y < x || (x <= y && y <= x)) == all);
    CHECK(bits_of(x == x) == all);

    CHECK(reduce_min(y) == *std::min_element(b, b + N));
    CHECK(reduce_max(y) == *std::max_element(b, b + N));
    CHECK(sum(y) == std::accumulate(b, b + N, 0.0F)); // exact: multiples of 1/2
}
} // namespace
} // namespace simd_test

TEST_CASE("lanes do what floats do, one by one") {
    simd_test::check<1>();
    simd_test::check<4>();
    simd_test::check<8>();
}

TEST_CASE("complex numbers in pairs of lanes are multiplied") {
    const auto check = [](auto width) {
        constexpr int n = decltype(width)::value;
        float a[n], b[n], products[n];
        for (int i = 0; i < n; ++i) {
            a[i] = static_cast<float>(i + 1);
            b[i] = static_cast<float>(3 - 2 * i);
        }
        store(complex_products<n>(load<n>(a), load<n>(b)), products);
        for (int i = 0; i < n; i += 2) {
            const auto number = [i](const float* of) { return std::complex<float>{of[i], of[i + 1]}; };
            CHECK(number(products) == number(a) * number(b)); // of small whole numbers: exact
        }
    };
    check(std::integral_constant<int, 4>{});
    check(std::integral_constant<int, max_simd_width>{});
}

TEST_CASE("a difference of products has the sign of the exact one where a fused multiply-add exists") {
    if constexpr (!detail::has_fma) return;
    const float a = 1 + 0x1p-12F, b = 1 - 0x1p-12F; // a b = 1 - 2^-24, which rounds to 1
    const lanes<4> difference = difference_of_products(lanes<4>(a), lanes<4>(b), lanes<4>(1.0F), lanes<4>(1.0F));
    CHECK(bits_of(difference < lanes<4>(0.0F)) == 15);
    const lanes<4> opposite = difference_of_products(lanes<4>(1.0F), lanes<4>(1.0F), lanes<4>(b), lanes<4>(a));
    CHECK(bits_of(lanes<4>(0.0F) < opposite) == 15);
}
