#include <insonify/acoustics/echo_line.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace echo_line_test {
namespace {
double phase_of(vec2 v) { return std::atan2(static_cast<double>(v.y), static_cast<double>(v.x)); }
} // namespace
} // namespace echo_line_test

TEST_CASE("an echo is divided linearly between its two samples, with the phase of its depth") {
    std::vector<vec2> samples(100, vec2{0, 0});
    const float spacing = 20_um, depth = 20_um * (40.25F + 0.5F);
    echo_line{samples, spacing, 5_MHz}.add(depth, {0.5F, 0});
    CHECK(length(samples[40]) == doctest::Approx(0.375).epsilon(1e-3));
    CHECK(length(samples[41]) == doctest::Approx(0.125).epsilon(1e-3));
    const double cycles = 2 * 5e6 * static_cast<double>(depth) / 1540;
    const double expected = -2 * 3.14159265358979 * (cycles - std::floor(cycles));
    CHECK(std::cos(echo_line_test::phase_of(samples[40]) - expected) == doctest::Approx(1).epsilon(1e-4));
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (i != 40 && i != 41) CHECK(samples[i] == vec2{0, 0});
}

TEST_CASE("echoes at equal steps are what they are one by one") {
    std::vector<vec2> together(400, vec2{0, 0}), apart(400, vec2{0, 0});
    std::vector<float> real(72), imaginary(72); // room for a last register
    for (std::size_t i = 0; i < real.size(); ++i) {
        real[i] = std::cos(static_cast<float>(i));
        imaginary[i] = std::sin(1.7F * static_cast<float>(i));
    }
    const echo_line a{together, 10_um, 7.5_MHz}, b{apart, 10_um, 7.5_MHz};
    // Over both ends too: the line is 4 mm long.
    for (const float depth : {-0.7_mm, 1_mm, 3.2_mm}) {
        a.add(depth, 25_um, 61, real.data(), imaginary.data(), 0.3F, 0.99F);
        for (std::size_t i = 0; i < 61; ++i)
            b.add(depth + static_cast<float>(i) * 25_um,
                  vec2{real[i], imaginary[i]} * 0.3F * std::pow(0.99F, static_cast<float>(i)));
    }
    for (std::size_t i = 0; i < 400; ++i) CHECK(length(together[i] - apart[i]) < 2e-4F);
}

TEST_CASE("echoes beside the line are dropped, and at its ends keep their part within") {
    std::vector<vec2> samples(10, vec2{0, 0});
    const echo_line line{samples, 1_mm, 1_MHz};
    for (const float depth : {-5_mm, 11_mm, 1e9F, -1e9F}) line.add(depth, {1, 0});
    for (const vec2 v : samples) CHECK(v == vec2{0, 0});
    line.add(0.25_mm, {1, 0});
    CHECK(length(samples[0]) == doctest::Approx(0.75));
    line.add(9.75_mm, {1, 0});
    CHECK(length(samples[9]) == doctest::Approx(0.75));
    CHECK(line.depth() == doctest::Approx(10_mm));
}
