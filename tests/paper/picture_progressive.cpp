#include <insonify/core/random.hpp>
#include <insonify/paper/picture.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace progressive_test {
namespace {

image random_frame(std::uint64_t seed) {
    image frame{{61, 97}};
    for (std::size_t i = 0; i < frame.pixels.size(); ++i) frame.pixels[i] = hash_uniform(seed, i);
    return frame;
}

} // namespace

TEST_CASE("progressive: the result after n frames is their arithmetic mean") {
    progressive mean;
    std::vector<double> sum(61 * 97);
    for (std::uint32_t n = 1; n <= 1000; ++n) {
        const image frame = random_frame(n);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(frame.pixels[i]);
        const image& picture = mean.add(exec::seq, frame, pose{});
        REQUIRE(mean.frames() == n);
        if (n != 1 && n != 2 && n != 7 && n != 100 && n != 1000) continue;
        double worst = 0;
        for (std::size_t i = 0; i < sum.size(); ++i)
            worst = std::fmax(worst, std::fabs(static_cast<double>(picture.pixels[i]) - sum[i] / n));
        CHECK(worst < 1e-6);
    }
}

TEST_CASE("progressive: a hundred thousand equal frames do not drift") {
    progressive mean;
    const image frame{{3, 1}, 0.7F};
    for (int n = 0; n < 100000; ++n) mean.add(exec::seq, frame, pose{});
    CHECK(std::fabs(mean.picture()(1, 0) - 0.7F) < 1e-6F);
}

TEST_CASE("progressive: restarts when the probe moves, and only then") {
    progressive mean;
    const image black{{4, 4}, 0}, white{{4, 4}, 1};
    const pose here{}, there{.translation = {0, 0, 1e-5F}};
    mean.add(exec::seq, black, here);
    CHECK(mean.add(exec::seq, white, here)(2, 2) == 0.5F);
    CHECK(mean.add(exec::seq, white, there)(2, 2) == 1);
    CHECK(mean.frames() == 1);
    CHECK(mean.add(exec::seq, black, there)(2, 2) == 0.5F);
    pose turned = there;
    turned.rotation = mat3{vec3{0, 1, 0}, vec3{-1, 0, 0}, vec3{0, 0, 1}};
    CHECK(mean.add(exec::seq, black, turned)(2, 2) == 0);
    CHECK(mean.frames() == 1);
}

TEST_CASE("progressive: restarts for an image of another size, and on request") {
    progressive mean;
    mean.add(exec::seq, image{{4, 4}, 1}, pose{});
    CHECK(mean.add(exec::seq, image{{2, 8}, 0}, pose{}) == image{{2, 8}, 0});
    CHECK(mean.add(exec::seq, image{{5, 5}, 0.5F}, pose{}) == image{{5, 5}, 0.5F});
    CHECK(mean.frames() == 1);
    mean.reset();
    CHECK(mean.frames() == 0);
    CHECK(mean.add(exec::seq, image{{5, 5}, 1}, pose{})(0, 0) == 1);
    CHECK(mean.frames() == 1);
}

TEST_CASE("progressive: bit-equal for any number of threads") {
    progressive reference, parallel;
    for (std::uint64_t n = 0; n < 10; ++n) {
        reference.add(exec::seq, random_frame(n), pose{});
        parallel.add(exec::par.threads(static_cast<std::uint32_t>(n % 4 + 1)), random_frame(n), pose{});
    }
    CHECK(parallel.picture() == reference.picture());
}

TEST_CASE("progressive: an empty image remains empty") {
    progressive mean;
    CHECK(mean.add(exec::seq, image{}, pose{}).pixels.empty());
}

} // namespace progressive_test
