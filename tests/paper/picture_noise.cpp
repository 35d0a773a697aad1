#include <insonify/paper/picture.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <initializer_list>
#include <limits>
#include <utility>

using namespace insonify;

namespace noise_test {
namespace {

struct moments {
    double mean = 0;
    double deviation = 0;
};
moments moments_of(const image& picture) {
    double sum = 0, squares = 0;
    for (const float value : picture.pixels) {
        sum += static_cast<double>(value);
        squares += static_cast<double>(value) * static_cast<double>(value);
    }
    const auto n = static_cast<double>(picture.pixels.size());
    return {sum / n, std::sqrt(squares / n - sum / n * sum / n)};
}

} // namespace

TEST_CASE("make_noise: factors with mean 1 and the signal-to-noise ratio of speckle, 1.913") {
    for (const std::uint64_t seed : {1ULL, 2ULL, 12345678901234ULL}) {
        CAPTURE(seed);
        const moments m = moments_of(make_noise(exec::par, {512, 384}, {.seed = seed}));
        CHECK(m.mean == doctest::Approx(1).epsilon(0.005).scale(1e-30));
        CHECK(m.mean / m.deviation == doctest::Approx(1.913).epsilon(0.02).scale(1e-30));
    }
}

TEST_CASE("make_noise: Rayleigh distribution") {
    const image noise = make_noise(exec::par, {1000, 1000});
    for (const double level : {0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0}) {
        std::size_t below = 0;
        for (const float value : noise.pixels) below += static_cast<double>(value) < level;
        const double expected = 1 - std::exp(-3.14159265358979 / 4 * level * level);
        CAPTURE(level);
        CHECK(std::fabs(static_cast<double>(below) / 1e6 - expected) < 2e-3); // 4 standard errors
    }
}

TEST_CASE("make_noise: neighbours are uncorrelated") {
    const image noise = make_noise(exec::par, {1000, 1000});
    const moments m = moments_of(noise);
    for (const uvec2 step : {uvec2{1, 0}, uvec2{0, 1}, uvec2{1, 1}, uvec2{2, 0}}) {
        double sum = 0;
        for (std::uint32_t y = 0; y + step.y < 1000; ++y)
            for (std::uint32_t x = 0; x + step.x < 1000; ++x)
                sum += (static_cast<double>(noise(x, y)) - m.mean) *
                       (static_cast<double>(noise(x + step.x, y + step.y)) - m.mean);
        CHECK(std::fabs(sum / 1e6 / (m.deviation * m.deviation)) < 5e-3);
    }
}

TEST_CASE("make_noise: `strength` scales the deviation from 1") {
    const image none = make_noise(exec::seq, {50, 50}, {.strength = 0});
    for (const float value : none.pixels) CHECK(value == 1);
    const moments m = moments_of(make_noise(exec::par, {512, 384}, {.strength = 0.5F}));
    CHECK(m.mean == doctest::Approx(1).epsilon(0.005).scale(1e-30));
    CHECK(m.mean / m.deviation == doctest::Approx(2 * 1.913).epsilon(0.02).scale(1e-30));
}

TEST_CASE("make_noise: bit-equal for equal seeds and any number of threads, different for another seed") {
    const image reference = make_noise(exec::seq, {123, 77}, {.seed = 7});
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
        CHECK(make_noise(exec::par.threads(threads), {123, 77}, {.seed = 7}) == reference);
    CHECK(make_noise(exec::par_unseq, {123, 77}, {.seed = 7}) == reference);
    CHECK(make_noise(exec::seq, {123, 77}, {.seed = 8}) != reference);
}

TEST_CASE("make_noise: a larger image extends a smaller one") {
    const image reduced = make_noise(exec::seq, {20, 10});
    const image large = make_noise(exec::seq, {33, 15});
    for (std::uint32_t y = 0; y < 10; ++y)
        for (std::uint32_t x = 0; x < 20; ++x) CHECK(reduced(x, y) == large(x, y));
}

TEST_CASE("add_noise: multiplies pixel by pixel and reuses a moved buffer") {
    image picture{{3, 2}};
    picture.pixels = {0, 0.5F, 1, 0.25F, 2, 0.125F};
    image noise{{3, 2}};
    noise.pixels = {3, 2, 0.5F, 4, 1, 0};
    const float* buffer = picture.pixels.data();
    picture = add_noise(exec::seq, std::move(picture), noise);
    CHECK(picture.pixels == std::vector<float>{0, 1, 0.5F, 1, 2, 0});
    CHECK(picture.pixels.data() == buffer);
}

TEST_CASE("noise: sizes and settings out of range are refused") {
    for (const float bad :
         {-0.1F, 1.1F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
        CHECK_THROWS_AS(make_noise(exec::seq, {4, 4}, {.strength = bad}), usage_error);
    CHECK_THROWS_AS(make_noise(exec::seq, {0, 4}), usage_error);
    CHECK_THROWS_AS(make_noise(exec::seq, {1000000, 1000000}), usage_error);
    CHECK_THROWS_AS(add_noise(exec::seq, image{{4, 4}}, image{{4, 5}}), usage_error);
    image torn{{4, 4}};
    torn.pixels.pop_back();
    CHECK_THROWS_AS(add_noise(exec::seq, image{{4, 4}}, torn), usage_error);
}

} // namespace noise_test
