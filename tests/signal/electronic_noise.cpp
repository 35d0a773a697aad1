#include <insonify/signal/electronic_noise.hpp>
#include <doctest/doctest.h>
#include <limits>

using namespace insonify;

TEST_CASE("electronic noise has the given level, differs from frame to frame, and is equal for any number of threads") {
    const iq_lines silence{64, 2000, 0.04F};
    const iq_lines noise = add_electronic_noise(exec::seq, silence, {.level_db = -100});
    double power = 0;
    for (const vec2 v : noise.values) power += static_cast<double>(dot(v, v));
    CHECK(10 * std::log10(power / 128000) == doctest::Approx(-100).epsilon(5e-4).scale(1e-30));
    for (const std::uint32_t threads : {1U, 2U, 3U, 8U})
        CHECK(add_electronic_noise(exec::par.threads(threads), silence, {.level_db = -100}) == noise);
    CHECK_FALSE(add_electronic_noise(exec::par, silence, {.level_db = -100, .frame = 1}) == noise);
    CHECK_FALSE(add_electronic_noise(exec::par, silence, {.level_db = -100, .seed = 2}) == noise);
    CHECK_THROWS_AS(add_electronic_noise(exec::par, silence, {.level_db = std::numeric_limits<float>::quiet_NaN()}),
                    usage_error);
}
