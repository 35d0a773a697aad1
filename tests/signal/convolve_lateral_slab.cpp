#include <insonify/core/random.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

using namespace insonify;

namespace lateral_slab_test {
namespace {
// Reference: every sample summed in double precision.
template <class Probe>
void check(const Probe& probe, std::uint32_t samples) {
    const detail::lateral_kernel kernel = detail::make_lateral_kernel(probe, {.depth = 40_mm, .samples = samples});
    std::vector<vec2> lines(std::size_t{probe.lines} * samples), memory;
    for (std::size_t i = 0; i < lines.size(); ++i) lines[i] = hash_normal(samples, i);
    std::vector<vec2> one = lines, many = lines;
    detail::lateral_slab slab{kernel, memory};
    for (std::size_t first = 0; first < samples; first += detail::lateral_slab::samples) {
        const std::size_t count = std::min<std::size_t>(detail::lateral_slab::samples, samples - first);
        slab.weigh(first, count);
        slab.copy(one.data() + first, samples, count);
        slab.apply<1>(one.data() + first, samples, count);
        slab.copy(many.data() + first, samples, count);
        slab.apply<simd_width>(many.data() + first, samples, count);
    }
    double worst = 0;
    for (std::uint32_t k = 0; k < samples; ++k) {
        const detail::lateral_kernel::blend at = kernel.blend_at(k);
        const auto weight = [&](std::size_t apart) {
            const double above = apart < at.above.size() ? static_cast<double>(at.above[apart]) : 0;
            const double below = apart < at.below.size() ? static_cast<double>(at.below[apart]) : 0;
            return above + static_cast<double>(at.fraction) * (below - above);
        };
        const int half_width = static_cast<int>(std::max(at.above.size(), at.below.size())) - 1;
        const int count = static_cast<int>(probe.lines);
        for (int line = 0; line < count; ++line) {
            double x = 0, y = 0, all = 0;
            for (int offset = -half_width; offset <= half_width; ++offset) {
                int other = line + offset;
                if (kernel.full_circle) other = (other + count) % count;
                if (other < 0 || other >= count) continue;
                const double w = weight(static_cast<std::size_t>(std::abs(offset)));
                const vec2 value = lines[static_cast<std::size_t>(other) * samples + k];
                x += w * static_cast<double>(value.x), y += w * static_cast<double>(value.y), all += w;
            }
            for (const std::vector<vec2>* result : {&one, &many}) {
                const vec2 found = (*result)[static_cast<std::size_t>(line) * samples + k];
                worst = std::max({worst, std::fabs(static_cast<double>(found.x) - x / all),
                                  std::fabs(static_cast<double>(found.y) - y / all)});
            }
        }
    }
    CHECK(worst < 3e-6);
}
} // namespace
} // namespace lateral_slab_test

TEST_CASE(
    "lateral_slab: every line is the weighted mean of the neighbours that exist, for any number of lines and samples") {
    for (const std::uint32_t samples : {1U, 31U, 32U, 33U, 200U}) {
        lateral_slab_test::check(linear_array{.lines = 128, .width = 20_mm, .frequency = 5_MHz}, samples);
        lateral_slab_test::check(linear_array{.lines = 1}, samples);
        lateral_slab_test::check(linear_array{.lines = 3, .width = 0.5_mm, .frequency = 5_MHz}, samples);
        lateral_slab_test::check(phased_array{.lines = 64, .frequency = 2.5_MHz}, samples);
        lateral_slab_test::check(radial_array{.lines = 64, .radius = 5_mm, .frequency = 5_MHz}, samples);
    }
}
