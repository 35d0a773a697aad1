#ifndef INSONIFY_SIGNAL_ENVELOPE_HPP
#define INSONIFY_SIGNAL_ENVELOPE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/medium.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/execution/simd.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/fourier.hpp>
#include <algorithm>
#include <string>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Hilbert transform: shifts the phase of every frequency of a real signal by -90 degrees, so that cos becomes sin.
///
/// Of two signals in each lane, one as the real and one as the imaginary part, with at least a quarter of zero padding.
class hilbert_transform {
  public:
    explicit hilbert_transform(std::size_t samples) : fourier_{transform_length(samples + samples / 4 + 2)} {}

    /// Size of the buffers of `apply`: the signal, padded with zeros.
    std::size_t size() const { return fourier_.size(); }

    /// In place; overwrites the padding. @param room  as many values, which are overwritten
    void apply(std::vector<complex_batch>& values, std::vector<complex_batch>& room) const {
        fourier_.forward(values, room);
        const lanes<complex_batch::width> scale(1 / static_cast<float>(size()));
        values[0] = values[size() / 2] = {}; // of DC and of the Nyquist frequency it is 0
        for (std::size_t i = 1; i < size() / 2; ++i) {
            const complex_batch positive = values[i], negative = values[size() - i];
            values[i] = {scale * positive.y, -(scale * positive.x)};
            values[size() - i] = {-(scale * negative.y), scale * negative.x};
        }
        fourier_.inverse(values, room);
    }

  private:
    fourier fourier_;
};

/// Square roots, in place.
template <int Width>
void square_roots(float* values, std::size_t count) {
    const std::size_t whole = count - count % Width;
    for (std::size_t i = 0; i < whole; i += Width) store(sqrt(load<Width>(values + i)), values + i);
    for (std::size_t i = whole; i < count; ++i) values[i] = std::sqrt(values[i]);
}

} // namespace insonify::inline INSONIFY_ABI::detail

namespace insonify::inline INSONIFY_ABI {

/// Envelope of baseband signals: |IQ| = sqrt(I^2 + Q^2).
/// @param recycled  lines whose memory is reused
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const iq_lines& iq, scan_lines recycled = {}) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    recycled.reshape(iq.count, iq.samples, iq.depth);
    exec::for_each_block(policy, iq.values.size(), 16384, 0.6F, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            recycled.values[i] = iq.values[i].x * iq.values[i].x + iq.values[i].y * iq.values[i].y;
        detail::square_roots<width>(recycled.values.data() + begin, end - begin);
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
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    if (rf.values.size() != static_cast<std::size_t>(rf.count) * rf.samples)
        throw usage_error{"envelope: " + std::to_string(rf.count) + " lines of " + std::to_string(rf.samples) +
                          " samples need as many values, not " + std::to_string(rf.values.size())};
    const detail::hilbert_transform transform{rf.samples};
    scan_lines lines{rf.count, rf.samples, rf.depth};
    const std::size_t n = rf.samples;
    constexpr std::size_t together = 2 * detail::complex_batch::width;
    exec::for_each_block(policy, rf.count, together, 10 * static_cast<float>(n),
                         [&](std::size_t first, std::size_t end) {
                             std::vector<detail::complex_batch> values(transform.size()), room(transform.size());
                             detail::complex_block block{};
                             const auto part = [&](std::size_t line) -> float& { // two lines in each lane
                                 const std::size_t lane = (line - first) / 2;
                                 return (line - first) % 2 == 0 ? block.x[lane] : block.y[lane];
                             };
                             for (std::size_t i = 0; i < n; ++i) {
                                 for (std::size_t line = first; line < end; ++line)
                                     part(line) = rf.values[line * n + i];
                                 values[i] = block.loaded();
                             }
                             transform.apply(values, room);
                             for (std::size_t i = 0; i < n; ++i) {
                                 block.store_from(values[i]);
                                 for (std::size_t line = first; line < end; ++line) {
                                     const float from = rf.values[line * n + i], quarter = part(line);
                                     lines.values[line * n + i] = from * from + quarter * quarter;
                                 }
                             }
                             detail::square_roots<width>(lines.values.data() + first * n, (end - first) * n);
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
