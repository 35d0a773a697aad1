#ifndef INSONIFY_SIGNAL_ENVELOPE_HPP
#define INSONIFY_SIGNAL_ENVELOPE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/fourier.hpp>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Envelope of baseband signals: |IQ| = sqrt(I^2 + Q^2).
/// @param recycled  lines whose memory is reused
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const iq_lines& iq, scan_lines recycled = {}) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    recycled.reshape(iq.count, iq.samples, iq.depth);
    exec::for_each_block(policy, iq.values.size(), 16384, 0.6F, [&](std::size_t begin, std::size_t end) {
        float* const to = recycled.values.data();
        for (std::size_t i = begin; i < end; ++i)
            to[i] = iq.values[i].x * iq.values[i].x + iq.values[i].y * iq.values[i].y;
        detail::in_registers<width>(begin, end, [&](std::size_t i, auto n) { store(sqrt(load<n>(to + i)), to + i); });
    });
    return recycled;
}

/// Envelope of RF signals: sqrt(RF^2 + H(RF)^2), where H is the Hilbert transform.
///
/// Equals |IQ| of the same echoes within 1e-3 of the maximum for fractional bandwidths below 0.8, except near truncated
/// signals: lines are zero beyond their ends.
/// @param rf  at least four samples per cycle
/// @throws usage_error  where the number of values is not lines times samples
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const scan_lines& rf) {
    if (rf.values.size() != static_cast<std::size_t>(rf.count) * rf.samples)
        throw usage_error{"envelope: ",    rf.count, " lines of ", rf.samples, " samples need as many values, not ",
                          rf.values.size()};
    scan_lines lines{rf.count, rf.samples, rf.depth};
    detail::for_each_analytic(policy, rf.values, rf.samples, [&](std::size_t line, std::size_t k, vec2 value) {
        lines.values[line * rf.samples + k] = length(value);
    });
    return lines;
}

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
        throw usage_error{"to_rf: RF needs four samples per cycle; trace and convolve with at least ",
                          static_cast<std::uint32_t>(needed), " samples per line"};
    }

    std::vector<vec2> carrier(iq.samples); // cosine and sine
    for (std::uint32_t k = 0; k < iq.samples; ++k) carrier[k] = detail::turned((k + 0.5) * cycles_per_sample);
    scan_lines rf{iq.count, iq.samples, iq.depth};
    const auto modulate = [&](std::size_t line, std::size_t) {
        const vec2* const from = iq.values.data() + line * iq.samples;
        float* const to = rf.values.data() + line * iq.samples;
        for (std::uint32_t k = 0; k < iq.samples; ++k) to[k] = from[k].x * carrier[k].x - from[k].y * carrier[k].y;
    };
    exec::for_each_block(policy, iq.count, 1, 0.5F * static_cast<float>(iq.samples), modulate);
    return rf;
}

} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
