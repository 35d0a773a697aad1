#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/kernel/kernel_table.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace lateral_kernel_test {
namespace {

/// The weights of all lines on one line, in double precision: Gaussian in metres along the arc, normalized.
template <class Probe>
std::vector<double> reference(const Probe& probe, float end, double depth, int line) {
    const auto lines = static_cast<int>(probe.lines);
    const double sigma = static_cast<double>(beam_of(probe, end).lateral_sigma(static_cast<float>(depth)));
    const double spacing = static_cast<double>(line_spacing(probe, static_cast<float>(depth)));
    std::vector<double> weights(probe.lines);
    double sum = 0;
    for (int i = 0; i < lines; ++i) {
        int apart = std::abs(i - line);
        if (is_full_circle(probe)) apart = std::min(apart, lines - apart);
        const double sigmas = apart * spacing / sigma;
        weights[static_cast<std::size_t>(i)] = std::exp(-sigmas * sigmas / 2);
        sum += weights[static_cast<std::size_t>(i)];
    }
    for (double& w : weights) w /= sum;
    return weights;
}

template <class Probe>
void check_weights(const Probe& probe) {
    constexpr std::uint32_t samples = 1200;
    constexpr float end = 60_mm;
    const detail::lateral_kernel kernel = detail::make_lateral_kernel(probe, {.depth = end, .samples = samples});
    std::vector<float> amplitudes;
    const auto covariance = [](float apart) { return max(0, 1 - apart / 0.31_mm); };
    const auto gain = [](std::uint32_t line) { return 1 + 0.25F * static_cast<float>(line % 3); };
    const auto lines = static_cast<int>(probe.lines);
    for (const std::uint32_t sample : {4U, 100U, 604U, 1196U}) {
        const detail::lateral_weights weights = detail::weights_at(kernel, sample);
        constexpr std::uint32_t step = detail::lateral_kernel::depth_step; // weights are those of the middle of a step
        const double depth = (sample / step * step + 0.5 * step) * static_cast<double>(end) / samples;
        for (const int line : {0, 1, lines / 3, lines - 1}) {
            const std::vector<double> expected = reference(probe, end, depth, line);
            const auto here = static_cast<std::uint32_t>(line);
            double sum = 0, worst = 0;
            for (int offset = weights.first(here); offset <= weights.last(here); ++offset) {
                const double weight = static_cast<double>(weights.half[static_cast<std::size_t>(std::abs(offset))]) /
                                      static_cast<double>(weights.existing(here));
                const int other = (line + offset + lines) % lines;
                worst = std::max(worst, std::fabs(weight - expected[static_cast<std::size_t>(other)]));
                sum += weight;
            }
            CHECK(sum == doctest::Approx(1).epsilon(1e-5).scale(1e-30));
            CHECK(worst < 2e-3 * expected[static_cast<std::size_t>(line)]);

            double power = 0;
            for (int i = 0; i < lines; ++i)
                for (int j = 0; j < lines; ++j) {
                    int apart = std::abs(i - j);
                    if (kernel.full_circle) apart = std::min(apart, lines - apart);
                    power +=
                        expected[static_cast<std::size_t>(i)] * expected[static_cast<std::size_t>(j)] *
                        static_cast<double>(gain(static_cast<std::uint32_t>(i)) * gain(static_cast<std::uint32_t>(j)) *
                                            covariance(static_cast<float>(apart) * weights.spacing));
                }
            std::vector<float> of_lags;
            for (int lag = 0; lag <= 2 * weights.half_width(); ++lag)
                of_lags.push_back(covariance(static_cast<float>(lag) * weights.spacing));
            CHECK(weights.power<simd_width>(here, view<const float>{of_lags}, gain, amplitudes) ==
                  doctest::Approx(power).epsilon(2e-3).scale(1e-30));
        }
    }
}

} // namespace

TEST_CASE("lateral_kernel: weights are Gaussian in metres and sum to 1 over the lines that exist, at the ends too") {
    check_weights(linear_array{.lines = 96, .width = 20_mm, .frequency = 5_MHz, .focus = 30_mm});
    check_weights(convex_array{.lines = 64, .frequency = 3.5_MHz});
    check_weights(phased_array{.lines = 64, .frequency = 2.5_MHz});
    check_weights(radial_array{.lines = 64, .radius = 5_mm, .frequency = 5_MHz});
    check_weights(linear_array{.lines = 3, .width = 0.5_mm, .frequency = 5_MHz});
}

TEST_CASE("lateral_kernel: weights are linear in depth between the centres of two steps") {
    const phased_array probe{.lines = 64, .frequency = 2.5_MHz};
    const detail::lateral_kernel kernel = detail::make_lateral_kernel(probe, {.depth = 60_mm, .samples = 1203});
    for (const std::uint32_t sample : {0U, 3U, 4U, 500U, 1199U, 1202U}) {
        constexpr std::uint32_t length = detail::lateral_kernel::depth_step, last = 1202 / length;
        const double place = std::min(std::max((sample + 0.5) / length - 0.5, 0.0), static_cast<double>(last));
        const auto step = static_cast<std::uint32_t>(place);
        const detail::lateral_weights above = detail::weights_at(kernel, length * step),
                                      below = detail::weights_at(kernel, length * std::min(step + 1, last));
        const detail::lateral_kernel::blend blend = kernel.blend_at(sample);
        CHECK(blend.above.first == above.half.first);
        CHECK(blend.above.size() == above.half.size());
        CHECK(blend.below.first == below.half.first);
        CHECK(blend.below.size() == below.half.size());
        CHECK(blend.fraction == doctest::Approx(place - step).epsilon(1e-4).scale(1e-30));
    }
}

TEST_CASE("lateral_kernel: one made in reused memory equals a new one") {
    const acquisition scan{.depth = 60_mm, .samples = 1203};
    const detail::lateral_kernel fresh = detail::make_lateral_kernel(phased_array{.lines = 64}, scan);
    const detail::lateral_kernel again = detail::make_lateral_kernel(
        phased_array{.lines = 64}, scan,
        detail::make_lateral_kernel(linear_array{.lines = 200}, {.depth = 30_mm, .samples = 50}));
    CHECK(again.weights == fresh.weights);
    CHECK(again.entries.size() == fresh.entries.size());
    CHECK(again.lines == 64);
}

TEST_CASE("lateral_kernel: a single line has the weight 1") {
    const detail::lateral_kernel kernel =
        detail::make_lateral_kernel(linear_array{.lines = 1}, {.depth = 10_mm, .samples = 20});
    CHECK(kernel.half_width() == 0);
    CHECK(detail::weights_at(kernel, 19).half[0] == 1);
    CHECK(detail::weights_at(kernel, 0).existing(0) == 1);
    CHECK_THROWS_AS(detail::make_lateral_kernel(linear_array{}, {.depth = 10_mm}), usage_error);
}

} // namespace lateral_kernel_test
