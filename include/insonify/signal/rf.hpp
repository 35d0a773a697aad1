#ifndef INSONIFY_SIGNAL_RF_HPP
#define INSONIFY_SIGNAL_RF_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/probe/line_grid.hpp>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Modulates baseband signals to the RF signal that a probe receives: RF(z) = Re(IQ(z) exp(+j 4 pi f0 z / c0)).
///
/// Along displayed depth the carrier has 2 f0 / c0 cycles per metre. The envelope is unchanged.
/// @param frequency  f0 of the carrier, hertz
/// @throws usage_error  for fewer than four samples per cycle, lines without samples, or a frequency out of range
template <exec::policy Policy>
scan_lines to_rf(const Policy& policy, const iq_lines& iq, float frequency) {
    if (iq.samples == 0 || iq.values.size() != static_cast<std::size_t>(iq.count) * iq.samples ||
        !is_finite(iq.depth) || !(iq.depth > 0))
        throw usage_error{"to_rf: the lines must have a depth above 0 and a value for every sample"};
    if (!is_finite(frequency) || !(frequency > 0))
        throw usage_error{"to_rf: the frequency must be finite and above 0, such as 5_MHz"};
    const double cycles_per_sample = 2.0 * frequency / display_speed * iq.depth / iq.samples;
    if (cycles_per_sample > 0.25001) {
        const float needed = min(std::ceil(static_cast<float>(4 * cycles_per_sample * iq.samples)), 1e9F);
        throw usage_error{"to_rf: RF needs four samples per cycle; trace and convolve with at least " +
                          std::to_string(static_cast<std::uint32_t>(needed)) + " samples per line"};
    }

    std::vector<vec2> carrier(iq.samples); // cosine and sine
    for (std::uint32_t k = 0; k < iq.samples; ++k) {
        const double cycles = (k + 0.5) * cycles_per_sample;
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

#include <insonify/core/restore_macros.hpp>

#endif
