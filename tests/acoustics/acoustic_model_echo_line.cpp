#include <insonify/acoustics/acoustic_model.hpp>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace echo_line_test {
namespace {
double phase_of(vec2 v) { return std::atan2(static_cast<double>(v.y), static_cast<double>(v.x)); }
} // namespace
} // namespace echo_line_test

TEST_CASE("echo_line: an echo is divided linearly between its two samples, with the phase of its depth") {
    std::vector<vec2> samples(100, vec2{0, 0});
    const float spacing = 20_um, depth = 20_um * (40.25F + 0.5F);
    echo_line{samples, spacing, 5_MHz}.add(depth, {0.5F, 0});
    CHECK(length(samples[40]) == doctest::Approx(0.375).epsilon(1e-3).scale(1e-30));
    CHECK(length(samples[41]) == doctest::Approx(0.125).epsilon(1e-3).scale(1e-30));
    const double cycles = 2 * 5e6 * static_cast<double>(depth) / 1540;
    const double expected = -2 * 3.14159265358979 * (cycles - std::floor(cycles));
    CHECK(std::cos(echo_line_test::phase_of(samples[40]) - expected) == doctest::Approx(1).epsilon(1e-4).scale(1e-30));
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (i != 40 && i != 41) CHECK(samples[i] == vec2{0, 0});
}

TEST_CASE("echo_line: a run of scatterers equals the sum of its echoes") {
    std::vector<vec2> together(400, vec2{0, 0}), apart(400, vec2{0, 0});
    std::vector<float> real(72), imaginary(72); // 61 and at most a vector
    for (std::size_t i = 0; i < real.size(); ++i) {
        real[i] = std::cos(static_cast<float>(i));
        imaginary[i] = std::sin(1.7F * static_cast<float>(i));
    }
    const echo_line a{together, 10_um, 7.5_MHz}, b{apart, 10_um, 7.5_MHz};
    // Runs across both ends of the line, which is 4 mm long, too.
    for (const float depth : {-0.7_mm, 1_mm, 3.2_mm}) {
        a.scatterers({.depth = depth,
                      .step = 25_um,
                      .count = 61,
                      .real = real.data(),
                      .imaginary = imaginary.data(),
                      .first_level = 0.3F,
                      .last_level = 0.3F * std::pow(0.99F, 61.0F)});
        for (std::size_t i = 0; i < 61; ++i)
            b.add(depth + static_cast<float>(i) * 25_um,
                  vec2{real[i], imaginary[i]} * 0.3F * std::pow(0.99F, static_cast<float>(i)));
    }
    for (std::size_t i = 0; i < 400; ++i) CHECK(length(together[i] - apart[i]) < 2e-4F);
}

TEST_CASE("echo_line: echoes beyond the ends are dropped, or keep the fraction inside") {
    std::vector<vec2> samples(10, vec2{0, 0});
    const echo_line line{samples, 1_mm, 1_MHz};
    for (const float depth : {-5_mm, 11_mm, 1e9F, -1e9F}) line.add(depth, {1, 0});
    for (const vec2 v : samples) CHECK(v == vec2{0, 0});
    line.add(0.25_mm, {1, 0});
    CHECK(length(samples[0]) == doctest::Approx(0.75).scale(1e-30));
    line.add(9.75_mm, {1, 0});
    CHECK(length(samples[9]) == doctest::Approx(0.75).scale(1e-30));
    CHECK(line.depth() == doctest::Approx(10_mm).scale(1e-30));
}

TEST_CASE("echo_line: a specular echo is real at the surface, whatever its slope") {
    std::vector<vec2> level(100, vec2{0, 0}), steep(100, vec2{0, 0}), expected(100, vec2{0, 0});
    echo_line{level, 20_um, 5_MHz}.surface(1.013_mm, -0.3F, {0, 0});
    echo_line{steep, 20_um, 5_MHz}.surface(1.013_mm, -0.3F, {0.5F, 2});
    echo_line{expected, 20_um, 5_MHz}.add(1.013_mm, {-0.3F, 0});
    CHECK(level == expected);
    CHECK(steep == expected);
    CHECK(length(level[50]) + length(level[49]) + length(level[51]) == doctest::Approx(0.3).scale(1e-30));
}

TEST_CASE("echo_line: a diffuse echo is the surface's random value times the rms amplitude") {
    std::vector<vec2> samples(100, vec2{0, 0}), expected(100, vec2{0, 0});
    std::vector<float> offsets;
    echo_line{samples, 20_um, 5_MHz}.rough_surface(1.5_mm, 0.2F, {0.1F, 0}, {}, [&](float offset) {
        offsets.push_back(offset);
        return vec2{0.6F, -1.2F};
    });
    echo_line{expected, 20_um, 5_MHz}.add(1.5_mm, {0.12F, -0.24F});
    REQUIRE(offsets.size() == 1);
    CHECK(offsets[0] == 0);
    for (std::size_t i = 0; i < samples.size(); ++i) CHECK(length(samples[i] - expected[i]) < 1e-7F);
    CHECK(length(samples[74]) + length(samples[75]) == doctest::Approx(0.2 * std::sqrt(0.36 + 1.44)).scale(1e-30));
}

TEST_CASE("echo_line: levels of scatterers change exponentially, but grow by 24 dB at most; below -300 dB they do not "
          "change") {
    const float real[] = {1, 1, 1, 1}, imaginary[] = {0, 0, 0, 0};
    const auto sum_at = [&](float first, float last, std::size_t sample) { // one scatterer per tenth sample
        std::vector<vec2> samples(64, vec2{0, 0});
        echo_line{samples, 10_um, 1_MHz}.scatterers({.depth = 105_um,
                                                     .step = 100_um,
                                                     .count = 4,
                                                     .real = real,
                                                     .imaginary = imaginary,
                                                     .first_level = first,
                                                     .last_level = last});
        return static_cast<double>(length(samples[sample - 1]) + length(samples[sample]) + length(samples[sample + 1]));
    };
    for (const std::size_t i : {0U, 1U, 2U, 3U})
        CHECK(sum_at(1, 0.0625F, 10 + 10 * i) ==
              doctest::Approx(std::pow(0.5, static_cast<double>(i))).epsilon(1e-3).scale(1e-30));
    CHECK(sum_at(1e-16F, 1, 40) == doctest::Approx(1e-16).epsilon(1e-3).scale(1e-30));
    CHECK(sum_at(1e-12F, 1, 30) == doctest::Approx(256e-12).epsilon(1e-3).scale(1e-30));
    CHECK(sum_at(0.5F, 0, 40) == doctest::Approx(0.5).epsilon(1e-3).scale(1e-30));

    std::vector<vec2> untouched(64, vec2{0, 0});
    echo_line{untouched, 10_um, 1_MHz}.scatterers({.depth = 0, .step = 10_um, .count = 0});
    for (const vec2 v : untouched) CHECK(v == vec2{0, 0});
}
