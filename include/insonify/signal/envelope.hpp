#ifndef INSONIFY_SIGNAL_ENVELOPE_HPP
#define INSONIFY_SIGNAL_ENVELOPE_HPP

#include <insonify/core/algorithm.hpp>
#include <insonify/core/error.hpp>
#include <insonify/execution/for_each.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/signal/hilbert.hpp>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Roots of all values, in place.
template <int Width>
void square_roots(float* values, std::size_t count) {
    const std::size_t whole = count - count % Width;
    for (std::size_t i = 0; i < whole; i += Width) store(square_root(load<Width>(values + i)), values + i);
    for (std::size_t i = whole; i < count; ++i) values[i] = std::sqrt(values[i]);
}

/// The amplitude of each sample: |IQ| = sqrt(I^2 + Q^2).
/// @param recycled  lines whose memory is used again
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const iq_lines& iq, scan_lines recycled = {}) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    recycled.reshape(iq.count, iq.samples, iq.depth);
    exec::for_each_block(policy, iq.values.size(), 16384, 0.6F, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            recycled.values[i] = iq.values[i].x * iq.values[i].x + iq.values[i].y * iq.values[i].y;
        square_roots<width>(recycled.values.data() + begin, end - begin);
    });
    return recycled;
}

/// The amplitude of an oscillating signal: sqrt(RF^2 + H(RF)^2), where H is the Hilbert transform.
///
/// Equal to |IQ| of the same echoes, within 1e-3 of the largest where the fractional bandwidth is below 0.8 and the
/// signal is not cut off near by: what lies beyond the end of a line is taken for silence.
/// @param rf  of four samples a cycle at least
/// @throws usage_error  where there are more or fewer values than lines times samples
template <exec::policy Policy>
scan_lines envelope(const Policy& policy, const scan_lines& rf) {
    constexpr int width = exec::is_unsequenced_v<Policy> ? simd_width : 1;
    if (rf.values.size() != static_cast<std::size_t>(rf.count) * rf.samples)
        throw usage_error{"envelope: the lines must have as many values as lines times samples"};
    const hilbert_transform transform{rf.samples};
    scan_lines lines{rf.count, rf.samples, rf.depth};
    exec::for_each_block(
        policy, rf.count, 2, 20 * static_cast<float>(rf.samples), [&](std::size_t first, std::size_t end) {
            const std::size_t n = rf.samples, last = end - 1; // the same line twice where it is the odd one out
            std::vector<float> turned(2 * transform.size());
            float* one = turned.data();
            float* other = one + transform.size();
            std::copy_n(rf.values.data() + first * n, n, one);
            std::copy_n(rf.values.data() + last * n, n, other);
            transform.template apply<width>(one, other);
            for (const std::size_t line : {first, last}) {
                const float* from = rf.values.data() + line * n;
                const float* quarter = line == first ? one : other;
                float* to = lines.values.data() + line * n;
                for (std::size_t i = 0; i < n; ++i) to[i] = from[i] * from[i] + quarter[i] * quarter[i];
                square_roots<width>(to, n);
            }
        });
    return lines;
}

} // namespace insonify::inline INSONIFY_ABI
#endif
