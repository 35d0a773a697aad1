#ifndef INSONIFY_SIGNAL_RF_HPP
#define INSONIFY_SIGNAL_RF_HPP

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// The oscillating signal that a probe really receives: RF(z) = Re(IQ(z) exp(+j 4 pi f0 z / c0)).
///
/// In displayed depth the carrier has 2 f0 / c0 cycles a metre. `envelope` of it is that of the IQ lines.
/// @param frequency  f0 of the carrier, hertz
/// @throws usage_error  where there are less than four samples a cycle, or the lines or the frequency make no sense
template <exec::policy Policy>
scan_lines to_rf(const Policy& policy, const iq_lines& iq, float frequency) {
    if (iq.samples == 0 || iq.values.size() != static_cast<std::size_t>(iq.count) * iq.samples ||
        !is_finite(iq.depth) || !(iq.depth > 0))
        throw usage_error{"to_rf: the lines must have samples, and a depth above 0"};
    if (!is_finite(frequency) || !(frequency > 0))
        throw usage_error{"to_rf: the frequency must be a finite number of hertz above 0"};
    const double cycles_a_sample = 2.0 * frequency / display_speed * iq.depth / iq.samples;
    if (cycles_a_sample > 0.25001) {
        const float needed = lesser(std::ceil(static_cast<float>(4 * cycles_a_sample * iq.samples)), 1e9F);
        throw usage_error{"to_rf: an oscillating signal needs four samples a cycle; trace and convolve with at least " +
                          std::to_string(static_cast<std::uint32_t>(needed)) + " samples a line"};
    }

    std::vector<vec2> carrier(iq.samples); // cosine and sine
    for (std::uint32_t k = 0; k < iq.samples; ++k) {
        const double cycles = (k + 0.5) * cycles_a_sample;
        const auto phase = static_cast<float>(cycles - std::floor(cycles)) * 2 * pi;
        carrier[k] = {std::cos(phase), std::sin(phase)};
    }
    scan_lines rf{iq.count, iq.samples, iq.depth};
    exec::for_each_block(policy, iq.count, 1, 0.5F * static_cast<float>(iq.samples),
                         [&](std::size_t line, std::size_t) {
                             const vec2* from = iq.values.data() + line * iq.samples;
                             float* to = rf.values.data() + line * iq.samples;
                             for (std::uint32_t k = 0; k < iq.samples; ++k)
                                 to[k] = from[k].x * carrier[k].x - from[k].y * carrier[k].y;
                         });
    return rf;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
