#include <insonify/execution/simd.hpp>
#include <doctest/doctest.h>

using namespace insonify;

TEST_CASE("lanes do what floats do, one by one") {
    constexpr int n = simd_width;
    float a[n], b[n], result[n];
    for (int i = 0; i < n; ++i) {
        a[i] = static_cast<float>(i) - 1.5F;
        b[i] = 2.5F - static_cast<float>(i * i);
    }
    const auto each = [&](const lanes<n>& value, const auto& expected) {
        store(value, result);
        for (int i = 0; i < n; ++i) CHECK(result[i] == expected(a[i], b[i]));
    };
    const lanes<n> x = load<n>(a), y = load<n>(b);
    each(x + y, [](float p, float q) { return p + q; });
    each(x - y, [](float p, float q) { return p - q; });
    each(x * y, [](float p, float q) { return p * q; });
    each(x / y, [](float p, float q) { return p / q; });
    each(inverse(x), [](float p, float) { return 1 / p; });
    each(-x, [](float p, float) { return -p; });
    each(lesser(x, y), [](float p, float q) { return std::fmin(p, q); });
    each(greater(x, y), [](float p, float q) { return std::fmax(p, q); });
    each(absolute(x), [](float p, float) { return std::fabs(p); });
    each(select(x < y, x, y), [](float p, float q) { return p < q ? p : q; });
    each(multiply_add(x, y, lanes<n>(0.25F)), [](float p, float q) { return multiply_add(p, q, 0.25F); });

    std::uint32_t less = 0, both = 0;
    for (int i = 0; i < n; ++i) {
        less |= (a[i] < b[i] ? 1U : 0U) << static_cast<unsigned>(i);
        both |= (a[i] < b[i] && -1 <= a[i] ? 1U : 0U) << static_cast<unsigned>(i);
    }
    CHECK(bits_of(x < y) == less);
    CHECK(bits_of(x < y && lanes<n>(-1.0F) <= x) == both);
    CHECK(bits_of(x < y || y < x || (x <= y && y <= x)) == (1U << static_cast<unsigned>(n)) - 1);
}
